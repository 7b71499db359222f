//! Topics of a bag: which two have the left and the right images.

use anyhow::{Context, Result, bail, ensure};

/// Topics of the left and of the right images; the same topic twice if its pictures show both cameras.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Topics(pub(super) [Topic; 2]);

/// Requested topics of the left and of the right image, and whether one topic has both side by side.
#[derive(Debug, Clone, Default)]
pub struct Wanted {
    /// Topic of the left images.
    pub left: Option<String>,
    /// Topic of the right images.
    pub right: Option<String>,
    /// Whether one topic has pictures of both cameras, left and right halves.
    pub side_by_side: bool,
    /// Begin and end of the pairs of a bag that are read, s after its first image.
    pub window: [Option<f64>; 2],
}

/// A topic of images.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Topic {
    /// Its name.
    pub(super) name: String,
    /// Whether its messages are `CompressedImage`.
    pub(super) compressed: bool,
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
    pub(super) fn is_rectified(&self) -> bool {
        let mut words = self.stem().split(|c: char| !c.is_ascii_alphanumeric());
        words.any(|word| matches!(word.to_lowercase().as_str(), "rect" | "rectified" | "rectify"))
    }

    /// The possible topics of its `camera_info`, the likeliest first.
    pub(super) fn infos(&self) -> Vec<String> {
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
