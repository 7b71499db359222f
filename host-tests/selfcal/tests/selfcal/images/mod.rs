//! The commands over images and bags, on files that the tests write.

mod as_delivered;
mod bad_input;
mod bags;
mod candidates;
mod damaged_bags;
mod interrupted;
mod knocked;
mod layouts;
mod mcap_bag;
mod ros1;
mod scene;
mod sqlite_bag;
mod topics;
mod unlike_cameras;
