//! The common part of both bag formats: topics, time stamps, calibration.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};
use rigs::data::Meta;
use rigs::formats::{Files, Unknowns, rig_of, rig_of_rectified};

use super::message::{CameraInfo, Encoding, ImageMessage, camera_info};
use super::partners::{Partner, Partners};
use super::{Frame, Item, Take};
use crate::resized::{self, Change};

/// Topics of the left and of the right images; the same topic twice if its pictures show both cameras.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Topics(pub [Topic; 2]);

/// Requested topics of the left and of the right image, and whether one topic has both side by side.
#[derive(Debug, Clone, Default)]
pub struct Wanted {
    /// Topic of the left images.
    pub left: Option<String>,
    /// Topic of the right images.
    pub right: Option<String>,
    /// Whether one topic has pictures of both cameras, left and right halves.
    pub side_by_side: bool,
}

/// A topic of images.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Topic {
    /// Its name.
    pub name: String,
    /// Whether its messages are `CompressedImage`.
    pub compressed: bool,
}

/// Parts of a topic's name that tell its side. The first row that is the only difference between two topics applies.
const SIDES: [[&str; 2]; 26] = [
    ["left", "right"],
    ["Left", "Right"],
    ["LEFT", "RIGHT"],
    ["infra1", "infra2"],
    ["fisheye1", "fisheye2"],
    ["cam0", "cam1"],
    ["cam_0", "cam_1"],
    ["camera0", "camera1"],
    ["camera_0", "camera_1"],
    ["image_0", "image_1"],
    ["image0", "image1"],
    ["image_00", "image_01"],
    ["/0/", "/1/"],
    ["cam1", "cam2"],
    ["cam_1", "cam_2"],
    ["camera1", "camera2"],
    ["camera_1", "camera_2"],
    ["image_2", "image_3"],
    ["/1/", "/2/"],
    ["/l/", "/r/"],
    ["_l/", "_r/"],
    ["_l_", "_r_"],
    ["_L/", "_R/"],
    ["lcam", "rcam"],
    ["CAM_B", "CAM_C"],
    ["upper", "lower"],
];

/// Words in the names of topics whose images are not camera images.
const OTHERS: [&str; 4] = ["depth", "disparity", "confidence", "mask"];

/// Endings of a topic that name its transport.
const TRANSPORTS: [&str; 2] = ["/compressed", "/image_compressed"];

impl Topic {
    /// A topic of images; `None` if the type of its messages is not an image.
    ///
    /// * `message`: type of the messages.
    pub(super) fn of(name: &str, message: &str) -> Option<Self> {
        let compressed = match message {
            "sensor_msgs/msg/Image" | "sensor_msgs/Image" => false,
            "sensor_msgs/msg/CompressedImage" | "sensor_msgs/CompressedImage" => true,
            _ => return None,
        };
        Some(Self { name: name.to_owned(), compressed })
    }

    /// The name without its transport.
    fn stem(&self) -> &str {
        TRANSPORTS.iter().find_map(|ending| self.name.strip_suffix(ending)).unwrap_or(&self.name)
    }

    /// Whether its images are rectified.
    fn is_rectified(&self) -> bool {
        let mut words = self.stem().split(|c: char| !c.is_ascii_alphanumeric());
        words.any(|word| matches!(word.to_lowercase().as_str(), "rect" | "rectified" | "rectify"))
    }

    /// The possible topics of its `camera_info`, the likeliest first.
    fn infos(&self) -> Vec<String> {
        let name = self.stem();
        let (space, _) = name.rsplit_once('/').unwrap_or(("", name));
        let rectified = self.is_rectified().then(|| format!("{space}/camera_info_rect"));
        rectified
            .into_iter()
            .chain([format!("{space}/camera_info"), format!("{name}/camera_info")])
            .collect()
    }
}

impl Topics {
    /// The requested topics, or the only two topics whose names differ by left and right alone ([`SIDES`]).
    pub(super) fn choose(all: &[Topic], wanted: &Wanted) -> Result<Self> {
        let names = |all: &[Topic]| {
            all.iter().map(|topic| topic.name.as_str()).collect::<Vec<_>>().join(", ")
        };
        ensure!(!all.is_empty(), "no topic of images (sensor_msgs Image or CompressedImage)");
        let find = |name: &String| {
            let found = all.iter().find(|topic| topic.name == *name);
            found
                .cloned()
                .with_context(|| format!("no topic {name} of images; there are {}", names(all)))
        };
        let advice = "choose with --left-topic and --right-topic";
        if wanted.side_by_side {
            let one = match (&wanted.left, all) {
                (Some(name), _) => find(name)?,
                (None, [one]) => one.clone(),
                _ => bail!(
                    "which topic has both cameras side by side? --left-topic one of {}",
                    names(all)
                ),
            };
            return Ok(Self([one.clone(), one]));
        }
        let given = [
            wanted.left.as_ref().map(find).transpose()?,
            wanted.right.as_ref().map(find).transpose()?,
        ];
        if let [Some(left), Some(right)] = given {
            ensure!(
                left != right,
                "{}: the same topic left and right; {advice}, or --side-by-side",
                left.name
            );
            return Ok(Self([left, right]));
        }
        let fits = |pair: &[Topic; 2]| {
            pair.iter()
                .zip(&given)
                .all(|(topic, given)| given.as_ref().is_none_or(|given| given == topic))
        };
        let of_given = |topic: &&Topic| given.iter().flatten().any(|given| given == *topic);
        let pictures: Vec<&Topic> = all
            .iter()
            .filter(|topic| {
                of_given(topic)
                    || !OTHERS.iter().any(|word| topic.name.to_lowercase().contains(word))
            })
            .collect();
        let found: Vec<[Topic; 2]> = candidates(&pictures).into_iter().filter(fits).collect();
        match found.as_slice() {
            [one] => Ok(Self(one.clone())),
            [] => bail!("which topics are left and right? {advice} of {}", names(all)),
            several => {
                let pairs: Vec<String> =
                    several.iter().map(|[l, r]| format!("{} with {}", l.name, r.name)).collect();
                bail!("several topics may be left and right ({}): {advice}", pairs.join("; "))
            }
        }
    }

    /// Whether the topic of this name has the left images, and whether it has the right images.
    pub(super) fn is_side(&self, name: &str) -> [bool; 2] {
        self.0.each_ref().map(|topic| topic.name == name)
    }

    /// Whether one topic has both cameras.
    pub(super) fn is_side_by_side(&self) -> bool {
        let [left, right] = &self.0;
        left == right
    }
}

/// Pairs of topics whose names differ only by the words of one row of [`SIDES`]. If a topic is also published
/// compressed, only the uncompressed one counts.
fn candidates(all: &[&Topic]) -> Vec<[Topic; 2]> {
    let mut once: Vec<&Topic> = Vec::new();
    for topic in all {
        match once.iter_mut().find(|other| other.stem() == topic.stem()) {
            Some(other) if other.compressed && !topic.compressed => *other = topic,
            Some(_) => {}
            None => once.push(topic),
        }
    }
    // With a slash at the end, the words `_l/` and `_r/` fit `/stereo_l` as well as `/stereo_l/image`.
    let ended = |topic: &Topic| format!("{}/", topic.stem());
    for [left, right] in SIDES {
        let partner = |topic: &&&Topic| {
            let name = ended(topic);
            let places = name.match_indices(left).map(|(at, _)| at);
            let one = |at: usize| format!("{}{right}{}", &name[..at], &name[at + left.len()..]);
            let names: Vec<String> = places.map(one).chain([name.replace(left, right)]).collect();
            let found = once
                .iter()
                .find(|other| names.contains(&ended(other)) && other.stem() != topic.stem());
            found.map(|other| [(**topic).clone(), (*other).clone()])
        };
        let found: Vec<[Topic; 2]> = once.iter().filter_map(|topic| partner(&topic)).collect();
        if !found.is_empty() {
            return found;
        }
    }
    Vec::new()
}

/// The `camera_info` of a bag's topics. It is decoded on demand, so that an invalid one does no harm if the user gives
/// the rig.
#[derive(Debug, Clone)]
pub struct Infos {
    file: PathBuf,
    topics: Topics,
    /// For each side the topic and its first message.
    messages: [Option<(String, Vec<u8>)>; 2],
    encoding: Encoding,
}

impl Infos {
    /// The `camera_info` of these topics.
    ///
    /// * `all`: the first `camera_info` message of every topic that has them, with the topic's name.
    pub(super) fn of(
        file: &Path,
        topics: &Topics,
        all: &[(String, Vec<u8>)],
        encoding: Encoding,
    ) -> Self {
        let find = |topic: &Topic| {
            let mut names = topic.infos().into_iter();
            names.find_map(|name| all.iter().find(|(topic, _)| *topic == name).cloned())
        };
        Self {
            file: file.to_owned(),
            topics: topics.clone(),
            messages: topics.0.each_ref().map(find),
            encoding,
        }
    }

    /// The rig. For rectified images the camera matrix is in `P`. `None` if a side has no `camera_info`.
    ///
    /// # Errors
    /// Names the topic, the key and the invalid value.
    pub fn rig(&self) -> Result<Option<Meta>> {
        let [Some(left), Some(right)] = &self.messages else { return Ok(None) };
        let read = |(topic, bytes): &(String, Vec<u8>)| -> Result<(PathBuf, CameraInfo)> {
            let name = PathBuf::from(format!("{topic} of {}", self.file.display()));
            let info =
                camera_info(bytes, self.encoding).with_context(|| name.display().to_string())?;
            Ok((name, info))
        };
        let infos = [read(left)?, read(right)?];
        let files = Files::of(
            infos.iter().map(|(name, info)| (name.clone(), info.text.clone())).collect(),
        )?;
        let rectified = self.topics.0.each_ref().map(Topic::is_rectified);
        let meta = match rectified {
            [true, true] => rig_of_rectified(&files)?,
            [false, false] => rig_of(&files, Unknowns::default())?,
            _ => bail!(
                "{} is rectified and {} is not: choose two of a kind with --left-topic and --right-topic",
                self.topics.0[usize::from(rectified[1])].name,
                self.topics.0[usize::from(rectified[0])].name
            ),
        };
        let changes = [0, 1].map(|side| {
            Change::of_info(meta.sizes()[side], infos[side].1.roi, infos[side].1.binning)
        });
        let changes = <[Result<Change>; 2]>::map(changes, |change| change);
        let [a, b] = changes;
        Ok(Some(resized::changed(&meta, [a?, b?])))
    }

    /// Says on which topics `camera_info` is missing.
    #[must_use]
    pub fn missing(&self) -> String {
        let names = self.topics.0.each_ref().map(|topic| topic.infos().remove(0));
        format!("no camera_info on {} and {}", names[0], names[1])
    }
}

/// Pairs the images of a bag as they are read.
pub(super) struct Pairing<'a> {
    topics: &'a Topics,
    partners: Partners<ImageMessage>,
    take: Take<'a>,
    encoding: Encoding,
}

impl<'a> Pairing<'a> {
    pub(super) fn new(
        topics: &'a Topics,
        tolerance_s: f64,
        encoding: Encoding,
        take: Take<'a>,
    ) -> Self {
        Self { topics, partners: Partners::new(tolerance_s), take, encoding }
    }

    /// Adds a message of a topic.
    pub(super) fn push(&mut self, topic: &str, bytes: &[u8]) -> ControlFlow<()> {
        let Some(side) = self.topics.is_side(topic).iter().position(|is| *is) else {
            return ControlFlow::Continue(());
        };
        let compressed = self.topics.0[side].compressed;
        match ImageMessage::new(topic, self.encoding, compressed, bytes.to_vec()) {
            Ok(message) if self.topics.is_side_by_side() => {
                let half = |side| Frame::message(message.clone()).half(side);
                (self.take)(Item::Pair([half(0), half(1)]))
            }
            Ok(message) => {
                let decided = self.partners.push(side, message.stamp, message);
                self.hand_out(decided)
            }
            Err(why) => (self.take)(Item::Skipped(format!("{topic}: {why:#}"))),
        }
    }

    /// Hands out the rest at the end of the bag.
    ///
    /// * `early`: why the bag ended early, if it did.
    pub(super) fn finish(&mut self, early: Option<String>) {
        let rest = self.partners.finish();
        if self.hand_out(rest).is_continue() {
            // This is the last item, so the answer does not matter.
            let _ = early.map(|why| (self.take)(Item::Skipped(why)));
        }
    }

    fn hand_out(&mut self, decided: Vec<Partner<ImageMessage>>) -> ControlFlow<()> {
        for one in decided {
            (self.take)(match one {
                Partner::Pair(pair) => Item::Pair(pair.map(Frame::message)),
                Partner::Alone(_, m) => {
                    Item::Skipped(format!("{} at {:.3} s: no partner in time", m.topic, m.stamp))
                }
            })?;
        }
        ControlFlow::Continue(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn topics_that_drivers_and_data_sets_use_tell_left_and_right() {
        for names in [
            ["/snappy_cam/stereo_l", "/snappy_cam/stereo_r"],
            ["/stereo/0", "/stereo/1"],
            ["/front_L/image_raw", "/front_R/image_raw"],
            ["/lcam_front/image", "/rcam_front/image"],
            ["/oak/left/image_raw", "/oak/right/image_raw"],
            ["/camera/camera/infra1/image_rect_raw", "/camera/camera/infra2/image_rect_raw"],
        ] {
            let topics = names.map(|name| Topic::of(name, "sensor_msgs/msg/Image").unwrap());
            let [left, right] = topics.clone();
            let found = Topics::choose(&[right, left], &Wanted::default()).unwrap();
            assert_eq!(found, Topics(topics), "{names:?}");
        }
    }
}
