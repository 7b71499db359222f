//! Writer of bags of SQLite, as `ros2 bag record` of Humble makes them.

use std::path::Path;

use image::GrayImage;
use rusqlite::{Connection, params};

use crate::images::mcap_bag::{info, raw_image};

/// Writes the moments, a second apart, with the calibrations of both cameras before them.
pub(crate) fn write(path: &Path, moments: &[[GrayImage; 2]]) {
    let bag = Connection::open(path).unwrap();
    bag.execute_batch(
        "PRAGMA page_size = 1024;
         CREATE TABLE topics (id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL,
             serialization_format TEXT NOT NULL, offered_qos_profiles TEXT NOT NULL);
         CREATE TABLE messages (id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL,
             data BLOB NOT NULL);
         CREATE INDEX timestamp_idx ON messages (timestamp ASC);",
    )
    .unwrap();
    let topic = |id: i64, name: &str, kind: &str| {
        let kind = format!("sensor_msgs/msg/{kind}");
        let values = params![id, name, kind];
        bag.execute("INSERT INTO topics VALUES (?1, ?2, ?3, 'cdr', '')", values).unwrap();
    };
    let message = |topic: i64, at: u32, bytes: &[u8]| {
        let values = params![topic, i64::from(at) * 1_000_000_000, bytes];
        let into = "INSERT INTO messages (topic_id, timestamp, data) VALUES (?1, ?2, ?3)";
        bag.execute(into, values).unwrap();
    };
    for (n, side) in [(1, "left"), (2, "right")] {
        topic(n, &format!("/stereo/{side}/image_raw"), "Image");
        let infos = format!("/stereo/{side}/camera_info");
        topic(n + 2, &infos, "CameraInfo");
        message(n + 2, 100, &info(&infos, n == 2).message());
    }
    for (at, pair) in (100..).zip(moments) {
        for (n, image) in (1..).zip(pair) {
            let pixels = (image.as_raw().clone(), image.width());
            message(n, at, &raw_image(image, (at, 0), "mono8", pixels));
        }
    }
}
