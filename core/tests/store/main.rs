//! The flash store through its public API, on flash that loses power and rots.

#[allow(dead_code, reason = "shared with the fuzz harness of the host tests")]
mod flash;

mod cuts;
mod garbage;
mod limits;
mod model;
mod rig;
mod rot;
