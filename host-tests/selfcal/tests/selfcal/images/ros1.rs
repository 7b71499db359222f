//! ROS 1 bags, written here by their format: images and calibration, whole and cut short.

use std::fs;
use std::io::{Cursor, Write};

use bzip2::write::BzEncoder;
use image::{GrayImage, ImageFormat};

use crate::call::check;
use crate::images::scene::{SIZE, camera_info, moving};

/// Op codes of records.
const MESSAGE: u8 = 2;
const BAG: u8 = 3;
const CHUNK: u8 = 5;
const CHUNK_INFO: u8 = 6;
const CONNECTION: u8 = 7;

fn u32s(n: usize) -> [u8; 4] {
    u32::try_from(n).unwrap().to_le_bytes()
}

/// Bytes after their length.
fn counted(bytes: &[u8]) -> Vec<u8> {
    [&u32s(bytes.len()), bytes].concat()
}

/// Named fields of a header.
fn fields(of: &[(&str, &[u8])]) -> Vec<u8> {
    of.iter().flat_map(|(name, value)| counted(&[name.as_bytes(), b"=", value].concat())).collect()
}

fn record(op: u8, of: &[(&str, &[u8])], data: &[u8]) -> Vec<u8> {
    let mut header = fields(of);
    header.extend(fields(&[("op", &[op])]));
    [counted(&header), counted(data)].concat()
}

fn connection(id: usize, topic: &str, kind: &str) -> Vec<u8> {
    let data = fields(&[
        ("topic", topic.as_bytes()),
        ("type", format!("sensor_msgs/{kind}").as_bytes()),
        ("md5sum", b"0123456789abcdef0123456789abcdef"),
        ("message_definition", b"none"),
    ]);
    record(CONNECTION, &[("conn", &u32s(id)), ("topic", topic.as_bytes())], &data)
}

fn message(id: usize, seconds: usize, data: &[u8]) -> Vec<u8> {
    let time = [u32s(seconds), u32s(0)].concat();
    record(MESSAGE, &[("conn", &u32s(id)), ("time", &time)], data)
}

/// `std_msgs/Header`, packed.
fn header(seconds: usize, nanoseconds: usize) -> Vec<u8> {
    [&u32s(0)[..], &u32s(seconds), &u32s(nanoseconds), &counted(b"camera")].concat()
}

fn raw(image: &GrayImage, at: (usize, usize)) -> Vec<u8> {
    let [width, height] = [image.width(), image.height()].map(u32::to_le_bytes);
    let size = [&height[..], &width].concat();
    [&header(at.0, at.1)[..], &size, &counted(b"mono8"), &[0], &width, &counted(image.as_raw())]
        .concat()
}

fn compressed(image: &GrayImage, at: (usize, usize)) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    image.write_to(&mut bytes, ImageFormat::Png).unwrap();
    [header(at.0, at.1), counted(b"png"), counted(&bytes.into_inner())].concat()
}

/// `sensor_msgs/CameraInfo` of a rectified camera.
fn info(right: bool) -> Vec<u8> {
    let [width, height] = SIZE.map(u32::to_le_bytes);
    let numbers = |all: &[f64]| all.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
    let [d, k, r, p] = camera_info(right).map(|all| numbers(&all));
    [&header(0, 0), &height[..], &width, &counted(b"plumb_bob"), &u32s(5), &d, &k, &r, &p].concat()
}

/// A chunk, packed by a compression of ROS 1.
fn chunk(compression: &str, content: &[u8]) -> Vec<u8> {
    let packed = match compression {
        "lz4" => {
            let mut out = lz4_flex::frame::FrameEncoder::new(Vec::new());
            out.write_all(content).unwrap();
            out.finish().unwrap()
        }
        "bz2" => {
            let mut out = BzEncoder::new(Vec::new(), bzip2::Compression::fast());
            out.write_all(content).unwrap();
            out.finish().unwrap()
        }
        _ => content.to_vec(),
    };
    let of: [(&str, &[u8]); 2] =
        [("compression", compression.as_bytes()), ("size", &u32s(content.len()))];
    record(CHUNK, &of, &packed)
}

/// A bag with a chunk for each moment: left raw, right compressed and 2 ms late, the right image of moment 2 lost.
pub(crate) fn bag(moments: &[[GrayImage; 2]], compression: &str) -> Vec<u8> {
    let topics = [
        ("/stereo/left/image_raw", "Image"),
        ("/stereo/right/image_raw/compressed", "CompressedImage"),
        ("/stereo/left/camera_info", "CameraInfo"),
        ("/stereo/right/camera_info", "CameraInfo"),
    ];
    let connections: Vec<u8> =
        (0..).zip(topics).flat_map(|(id, (topic, kind))| connection(id, topic, kind)).collect();
    let (mut chunks, mut index) = (Vec::new(), connections.clone());
    for (i, [l, r]) in moments.iter().enumerate() {
        let mut content = Vec::new();
        if i == 0 {
            content.extend(connections.clone());
            content.extend([message(2, 100, &info(false)), message(3, 100, &info(true))].concat());
        }
        content.extend(message(0, 100 + i, &raw(l, (100 + i, 0))));
        if i != 2 {
            content.extend(message(1, 100 + i, &compressed(r, (100 + i, 2_000_000))));
        }
        // The number of messages of each connection.
        let infos = usize::from(i == 0);
        let counts = [1, usize::from(i != 2), infos, infos];
        let counts: Vec<u8> =
            counts.iter().enumerate().flat_map(|(id, n)| [u32s(id), u32s(*n)].concat()).collect();
        index.extend(record(CHUNK_INFO, &[("ver", &u32s(1)), ("count", &u32s(4))], &counts));
        chunks.extend(chunk(compression, &content));
    }
    let magic = b"#ROSBAG V2.0\n";
    // The header of the bag fills 4096 bytes.
    let head = |at: usize, padding: usize| {
        let of: [(&str, &[u8]); 3] = [
            ("index_pos", &u64::try_from(at).unwrap().to_le_bytes()),
            ("conn_count", &u32s(topics.len())),
            ("chunk_count", &u32s(moments.len())),
        ];
        record(BAG, &of, &vec![b' '; padding])
    };
    let padding = 4096 - head(0, 0).len();
    let at = magic.len() + 4096 + chunks.len();
    [&magic[..], &head(at, padding), &chunks, &index].concat()
}

#[test]
fn a_ros_1_bag_gives_its_pairs_and_its_rig_and_cut_short_it_says_what_is_lost() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("whole.bag");
    let moments = moving(4);
    for compression in ["none", "lz4", "bz2"] {
        fs::write(&path, bag(&moments, compression)).unwrap();
        let (json, said) = check(&path, &[]);
        assert_eq!(json["run"]["pairs"], 3, "{compression} {}", said.err);
        assert_eq!(json["skipped"], "1 without a partner", "{}", said.err);
        assert_eq!(json["rig_guessed"], false);
    }
    let bytes = bag(&moments, "none");
    let cut = dir.path().join("cut.bag");
    fs::write(&cut, &bytes[..bytes.len() * 2 / 3]).unwrap();
    let (json, said) = check(&cut, &[]);
    let lost = said.err.contains("cut.bag: the rest is lost") && said.err.contains("reindex");
    assert!(lost, "{}", said.err);
    assert!(json["run"]["pairs"].as_u64().is_some_and(|n| (1..3).contains(&n)), "{json}");
    fs::write(&cut, b"nothing").unwrap();
    let err = check(&cut, &[]).1.err;
    assert!(err.contains("error") && err.contains("cut.bag"), "{err}");
    let old = [b"#ROSBAG V1.2\n", &bytes[13..]].concat();
    fs::write(&cut, old).unwrap();
    assert!(check(&cut, &[]).1.err.contains("rosbag migrate"));
}
