//! The command line.

use core::error::Error;
use core::str::FromStr;

use stereo_selfcal::geometry::RadialTangential;
use stereo_selfcal::{Camera, Intrinsics, Lens};

pub(crate) fn number<N: FromStr>(text: &str) -> Result<N, String> {
    text.trim().parse().map_err(|_| format!("`{text}` is not a number"))
}

/// `--name value` of the command line.
pub(crate) struct Options<'a>(Vec<(&'a str, &'a str)>);

impl<'a> Options<'a> {
    const NAMES: [&'static str; 8] =
        ["focal", "principal", "size", "distortion", "rotation", "translation", "udp", "device"];

    pub(crate) fn read(arguments: &'a [String]) -> Result<Self, String> {
        let mut found = Vec::new();
        for pair in arguments.chunks(2) {
            let [name, value] = pair else {
                return Err(format!("{} has no value", pair.concat()));
            };
            let known = name.strip_prefix("--").filter(|name| {
                let side = name.strip_prefix("left-").or_else(|| name.strip_prefix("right-"));
                match side {
                    Some(own) => Self::NAMES.iter().take(4).any(|known| *known == own),
                    None => Self::NAMES.contains(name),
                }
            });
            let name = known.ok_or_else(|| format!("unknown option {name}"))?;
            found.push((name, value.as_str()));
        }
        Ok(Self(found))
    }

    pub(crate) fn text(&self, name: &str) -> Option<&'a str> {
        self.0.iter().rev().find(|(known, _)| *known == name).map(|(_, value)| *value)
    }

    /// Numbers of an option, separated by commas.
    pub(crate) fn get<N: FromStr, const K: usize>(
        &self,
        name: &str,
    ) -> Result<Option<[N; K]>, String> {
        self.text(name).map(|text| numbers(name, text, ',')).transpose()
    }

    pub(crate) fn camera(&self, side: &str) -> Result<Camera<f32>, Box<dyn Error>> {
        let text = |name| {
            let own = self.text(&format!("{side}-{name}"));
            own.or_else(|| self.text(name)).ok_or_else(|| format!("--{name} is missing"))
        };
        let focal = text("focal")?;
        let focal =
            if focal.contains(',') { numbers("focal", focal, ',')? } else { [number(focal)?; 2] };
        let principal = numbers("principal", text("principal")?, ',')?;
        let size = numbers("size", text("size")?, 'x')?;
        let lens = match text("distortion") {
            Ok(k) => {
                Lens::RadialTangential(RadialTangential::try_new(numbers("distortion", k, ',')?)?)
            }
            Err(_) => Lens::Pinhole,
        };
        let camera = Camera::try_new(Intrinsics { focal, principal, size }, lens);
        Ok(camera.map_err(|error| format!("{side} camera: {error}"))?)
    }
}

fn numbers<N: FromStr, const K: usize>(
    name: &str,
    text: &str,
    separator: char,
) -> Result<[N; K], String> {
    let found = text.split(separator).map(number).collect::<Result<Vec<N>, String>>();
    let found = found.map_err(|error| format!("--{name}: {error}"))?;
    found
        .try_into()
        .map_err(|found: Vec<N>| format!("--{name}: {} numbers, {K} expected", found.len()))
}
