//! Flash store through its public API, under loss of power and bit rot.

mod cuts;
mod faults;
mod faulty;
mod garbage;
mod limits;
mod model;
mod persistence;
mod policy;
mod rig;
mod rot;
