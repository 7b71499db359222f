//! Frames of a matcher over UDP or a device, as JSON lines.

use std::fs::File;
use std::io::{self, Read, Write};
use std::net::UdpSocket;

use serde_json::{Value, json};
use stereo_selfcal::ApplyError;
use stereo_selfcal::link::{Counters, Decoder, Received};

use crate::Rig;
use crate::options::Options;

/// Longer than any datagram.
const PIECE: usize = 65_536;

/// Source of frames.
pub(crate) enum Wire {
    /// Datagrams; a frame may span several.
    Udp(UdpSocket),
    /// A serial device, a pipe or a file.
    Device(File),
}

impl Wire {
    /// The wire of the options; `None` without one.
    ///
    /// # Errors
    /// If both are given, or it cannot be opened.
    pub(crate) fn open(options: &Options) -> io::Result<Option<Self>> {
        let named =
            |name, error: io::Error| io::Error::new(error.kind(), format!("{name}: {error}"));
        match (options.text("udp"), options.text("device")) {
            (None, None) => Ok(None),
            (Some(at), None) => {
                UdpSocket::bind(at).map(|wire| Some(Self::Udp(wire))).map_err(|why| named(at, why))
            }
            (None, Some(path)) => File::open(path)
                .map(|wire| Some(Self::Device(wire)))
                .map_err(|why| named(path, why)),
            (Some(_), Some(_)) => Err(io::Error::other("--udp or --device, not both")),
        }
    }

    /// The next bytes; `None` at the end of a device.
    fn read<'a>(&mut self, room: &'a mut [u8]) -> io::Result<Option<&'a [u8]>> {
        let length = match self {
            Self::Udp(socket) => Some(socket.recv(room)?),
            Self::Device(file) => Some(file.read(room)?).filter(|length| *length > 0),
        };
        Ok(length.and_then(|length| room.get(..length)))
    }
}

/// Takes frames to the end of the wire.
///
/// # Errors
/// If the wire or the output fails.
pub(crate) fn run(rig: &mut Rig, wire: &mut Wire, out: &mut impl Write) -> io::Result<()> {
    let (mut decoder, mut room) = (Decoder::new(), vec![0; PIECE]);
    while let Some(mut bytes) = wire.read(&mut room)? {
        while !bytes.is_empty() {
            match decoder.feed(&mut bytes, rig) {
                Ok(Some(frame)) => {
                    writeln!(out, "{}", end_pair(rig, &frame, decoder.counters()))?;
                    out.flush()?;
                }
                Ok(None) => {}
                Err(why) => eprintln!("companion: frame refused: {why}"),
            }
        }
    }
    Ok(())
}

/// Takes the pair and applies.
fn end_pair(rig: &mut Rig, frame: &Received, link: &Counters) -> Value {
    let outcome = rig.solve_pair().to_string();
    let verdict = rig.verdict().to_string();
    let not_applied = match rig.apply() {
        Ok(_) | Err(ApplyError::NoProposal | ApplyError::NotLocked(_)) => None,
        Err(why) => Some(why.to_string()),
    };
    let in_use = &rig.in_use().extrinsics;
    json!({
        "sequence": frame.header.sequence,
        "timestamp_us": frame.header.timestamp_us,
        "matches": frame.header.count,
        "taken": frame.taken,
        "outcome": outcome,
        "state": rig.state().to_string(),
        "verdict": verdict,
        "not_applied": not_applied,
        "generation": rig.in_use().generation,
        "rotation": in_use.rotation_row_major(),
        "translation": <[f32; 3]>::from(in_use.translation().into_inner()),
        "link": { "good": link.good, "bad": link.bad_crc + link.bad_header, "gaps": link.gaps },
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use stereo_selfcal::link::{Encoder, FrameHeader, MatchRecord};
    use stereo_selfcal::{
        Camera, Cameras, Config, Correspondence, FactoryCalibration, Intrinsics, Lens,
    };

    /// A frame of a side-by-side rig.
    fn frame(sequence: u32) -> Vec<u8> {
        let header = FrameHeader {
            timestamp_us: 5,
            sequence,
            count: 200,
            image_size: [1920, 1200],
            grid_step: 0,
            fraction_bits: 8,
            pyramid_ratio: 64,
            dropped_before: false,
            more_found: false,
        };
        let (mut encoder, start) = Encoder::begin(header).unwrap();
        let mut bytes = start.to_vec();
        let mut random = sequence;
        let mut below = |n: u16| {
            random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let [a, b, ..] = random.to_be_bytes();
            f32::from(u16::from_be_bytes([a, b])) / 65_536.0 * f32::from(n)
        };
        for _ in 0..header.count {
            let (u, v, d) = (300.0 + below(1600), 1.0 + below(1197), 20.0 + below(250));
            let right = [u - d, v + below(1) - 0.5];
            let m = Correspondence { left: [u, v], right, score: 1.0, grid_step: 0.0 };
            bytes.extend(encoder.push_record(&MatchRecord::encode(&m, &header).unwrap()).unwrap());
        }
        bytes.extend(encoder.finish().unwrap());
        bytes
    }

    fn rig() -> Rig {
        let intrinsics =
            Intrinsics { focal: [1400.0; 2], principal: [959.5, 599.5], size: [1920, 1200] };
        let camera = Camera::try_new(intrinsics, Lens::Pinhole).unwrap();
        let cameras = Cameras { left: camera, right: camera };
        Rig::new(Config::robust(), &FactoryCalibration::guess(cameras))
    }

    #[test]
    fn frames_in_json_out() {
        let path = std::env::temp_dir().join(format!("companion-{}", std::process::id()));
        let mut bytes: Vec<u8> = (0..6).flat_map(frame).collect();
        bytes[300] ^= 1;
        std::fs::write(&path, bytes).unwrap();
        let arguments = ["--device".to_owned(), path.to_str().unwrap().to_owned()];
        let mut wire = Wire::open(&Options::read(&arguments).unwrap()).unwrap().unwrap();
        let mut out = Vec::new();
        run(&mut rig(), &mut wire, &mut out).unwrap();
        std::fs::remove_file(path).unwrap();
        let lines: Vec<Value> =
            out.split(|b| *b == b'\n').flat_map(serde_json::from_slice).collect();
        assert_eq!(lines.len(), 5, "the damaged frame is missing");
        let last = lines.last().unwrap();
        assert_eq!((&last["sequence"], &last["link"]["bad"]), (&json!(5), &json!(1)));
        assert_eq!(last["state"], "locked");
        assert!((last["translation"][0].as_f64().unwrap() + 1.0).abs() < 1e-3, "{last}");
    }

    #[test]
    fn datagrams_are_frames() {
        let wire = UdpSocket::bind("127.0.0.1:0").unwrap();
        let (at, sender) = (wire.local_addr().unwrap(), UdpSocket::bind("127.0.0.1:0").unwrap());
        sender.send_to(&frame(0), at).unwrap();
        let mut room = vec![0; PIECE];
        assert_eq!(Wire::Udp(wire).read(&mut room).unwrap().unwrap(), frame(0));
    }

    #[test]
    fn a_wire_that_cannot_be_opened_is_named() {
        let open = |arguments: &[&str]| {
            let arguments: Vec<String> = arguments.iter().map(ToString::to_string).collect();
            Wire::open(&Options::read(&arguments).unwrap()).map(|_| ()).unwrap_err().to_string()
        };
        assert!(open(&["--device", "/none"]).starts_with("/none: "));
        assert!(open(&["--udp", "nowhere"]).starts_with("nowhere: "));
        assert_eq!(open(&["--udp", "a:1", "--device", "b"]), "--udp or --device, not both");
    }
}
