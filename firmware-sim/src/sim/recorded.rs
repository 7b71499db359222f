//! A data set as the controller's image contains it: the bytes of its frames, and the record of its rig.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result};
use rigs::data::Dataset;
use sim::wire::Sender;
use stereo_selfcal::FactoryCalibration;

pub(super) struct Recorded {
    pub(super) frames: Vec<u8>,
    pub(super) factory: FactoryCalibration<f32>,
}

impl Recorded {
    /// The frames that a matcher would send, and cameras and true extrinsics.
    ///
    /// # Errors
    /// If the data set has an invalid rig, or matches that do not fit the wire.
    pub(super) fn of(set: &Dataset) -> Result<Self> {
        let sender = Sender::of(set)?;
        let frames = (0..).zip(&set.pairs).flat_map(|(i, pair)| sender.frame(i, pair).0).collect();
        Ok(Self { frames, factory: FactoryCalibration::new(set.cameras()?, set.truth()?) })
    }

    /// Writes the files that the build script of the image names.
    ///
    /// # Errors
    /// If the folder or a file cannot be written.
    pub(super) fn write(&self, folder: &Path) -> Result<()> {
        let write = || {
            fs::create_dir_all(folder)?;
            fs::write(folder.join("frames.bin"), &self.frames)?;
            fs::write(folder.join("factory.bin"), self.factory.to_record())
        };
        write().with_context(|| format!("cannot write into {}", folder.display()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use firmware_sim::recording::{FRAMES, factory, pairs};

    #[test]
    fn the_image_has_the_recording_of_the_data_set() {
        let set = Dataset::load(&Dataset::shipped().join("opencv_chess_sift")).unwrap();
        let recorded = Recorded::of(&set).unwrap();
        if std::env::var_os("UPDATE_EXPECT").is_some() {
            recorded.write(&Path::new(env!("CARGO_MANIFEST_DIR")).join("recording")).unwrap();
            return;
        }
        assert!(recorded.frames == FRAMES, "UPDATE_EXPECT=1 writes the frames");
        assert_eq!(factory().map_err(|why| why.to_string()), Ok(recorded.factory));
        assert_eq!(pairs() as usize, set.pairs.len());
    }
}
