//! Files of a bounded length, which is counted while they are read: a pipe or a device states none.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use anyhow::{Result, ensure};

/// Longest file of a rig, bytes.
const LONGEST: u64 = 4 << 20;

/// The bytes of a rig file.
///
/// # Errors
/// If it cannot be read, or is longer than a rig file.
pub(crate) fn bytes(path: &Path) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    File::open(path)?.take(LONGEST + 1).read_to_end(&mut bytes)?;
    ensure!(
        bytes.len() as u64 <= LONGEST,
        "longer than {} MiB: a rig file is shorter, so give the file of its calibration",
        LONGEST >> 20
    );
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_file_and_a_device_without_end_are_refused() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("flight.mcap");
        File::create(&path).unwrap().set_len(1 << 40).unwrap();
        let mut places = vec![path.as_path()];
        if cfg!(target_os = "linux") {
            // Its stated length is 0.
            places.push(Path::new("/dev/zero"));
        }
        for place in places {
            let why = bytes(place).unwrap_err().to_string();
            assert!(why.contains("a rig file is shorter"), "{why}");
            let rig = crate::read_rig(&[place.to_owned()], crate::formats::Unknowns::default());
            let why = format!("{:#}", rig.unwrap_err());
            assert!(why.contains("a rig file is shorter"), "{why}");
        }
    }
}
