//! The link to the matcher: bytes, decoder and drivers, over a bus whose results the compiler cannot predict.

use core::convert::Infallible;
use core::hint::black_box;

use embedded_hal::digital::{self, InputPin};
use embedded_hal::spi::{self, ErrorKind, Operation, SpiDevice};
use embedded_io::{Read, ReadReady};
use stereo_selfcal::depth::Tracks;
use stereo_selfcal::link::{
    Decoder, Encoder, FpgaMatcher, FrameCrc, FrameHeader, FrameSink, MatchRecord, StreamMatcher,
    Tracking,
};
use stereo_selfcal::{Calibrator, Cameras, Config, FactoryCalibration};

use crate::{number, show, solver};

/// Returns any data and any error.
struct Anything;

impl spi::ErrorType for Anything {
    type Error = ErrorKind;
}

impl SpiDevice for Anything {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), ErrorKind> {
        black_box(operations);
        black_box(Ok(()))
    }
}

impl digital::ErrorType for Anything {
    type Error = Infallible;
}

impl InputPin for Anything {
    fn is_high(&mut self) -> Result<bool, Infallible> {
        black_box(Ok(true))
    }

    fn is_low(&mut self) -> Result<bool, Infallible> {
        black_box(Ok(true))
    }
}

impl embedded_io::ErrorType for Anything {
    type Error = embedded_io::ErrorKind;
}

impl Read for Anything {
    fn read(&mut self, buffer: &mut [u8]) -> Result<usize, embedded_io::ErrorKind> {
        black_box(buffer);
        black_box(Ok(0))
    }
}

impl ReadReady for Anything {
    fn read_ready(&mut self) -> Result<bool, embedded_io::ErrorKind> {
        black_box(Ok(true))
    }
}

pub(crate) fn all(config: Config, cameras: Cameras<f32>) {
    let factory = FactoryCalibration::guess(cameras);
    let mut calibrator = Calibrator::<f32, 256>::new(config, &factory);
    bytes();
    decoder(&mut calibrator, &cameras);
    fpga(&mut calibrator);
    stream(&mut calibrator);
}

fn bytes() {
    let bytes = black_box([0; FrameHeader::BYTES]);
    if let Ok(header) = FrameHeader::decode(&bytes) {
        show(header.encode());
        show(header.frame_bytes());
        show(header.grid_step_px(black_box(0)));
        show(header.level_of(number()));
        if let Ok(record) = MatchRecord::encode(&solver::correspondence(), &header) {
            show(record.with_track(black_box(0)).to_bytes());
        }
        let record = MatchRecord::from_bytes(&black_box([0; MatchRecord::BYTES]));
        show((record.decode(&header), record.track()));
    }
    if let Ok(header) = FrameHeader::decode(&bytes)
        && let Ok((mut encoder, start)) = Encoder::begin(header)
    {
        show(start);
        show(encoder.push(&solver::correspondence()));
        show(encoder.push_tracked(&solver::correspondence(), black_box(0)));
        let record = MatchRecord::from_bytes(&black_box([0; MatchRecord::BYTES]));
        show(encoder.push_record(&record));
        show(encoder.missing());
        show(encoder.finish());
    }
    let mut crc = FrameCrc::new(&bytes);
    crc.add(&black_box([0; MatchRecord::BYTES]));
    show(crc.value());
}

fn decoder(calibrator: &mut Calibrator<f32, 256>, cameras: &Cameras<f32>) {
    let mut decoder = if black_box(false) { Decoder::new() } else { Decoder::default() };
    let bytes = black_box([0; 64]);
    let length = black_box(0);
    while black_box(true) {
        let mut piece = bytes.get(..length).unwrap_or_default();
        show(decoder.next(&mut piece));
        show(decoder.feed(&mut piece, calibrator));
        decoder.refuse();
        decoder.note_overrun();
        show(decoder.bytes_wanted());
        show(decoder.counters().plus(decoder.counters()));
    }
    let mut tracks = if black_box(false) { Tracks::new() } else { Tracks::default() };
    let mut sink = Tracking { calibrator, tracks: Some(&mut tracks) };
    while black_box(true) {
        let mut piece = bytes.get(..length).unwrap_or_default();
        show(decoder.feed(&mut piece, &mut sink));
    }
    show(sink.is_busy());
    sink.discard();
    self::tracks(calibrator, cameras, &mut tracks);
    show(calibrator.is_busy());
    show(calibrator.advance_pair());
    calibrator.discard();
    show(calibrator.finish());
}

fn tracks(
    calibrator: &mut Calibrator<f32, 256>,
    cameras: &Cameras<f32>,
    tracks: &mut Tracks<f32, 128>,
) {
    tracks.begin();
    if let Ok(rays) = cameras.rays(&solver::correspondence()) {
        tracks.push(black_box(0), &rays);
    }
    tracks.end();
    show(tracks.quads().len());
    show(calibrator.push_tracks(tracks).map_err(|error| error.code()));
    show(calibrator.advance_tracks(tracks).map(|ended| ended.map_err(|error| error.code())));
    tracks.restart();
}

fn fpga(calibrator: &mut Calibrator<f32, 256>) {
    let mut matcher = FpgaMatcher::new(Anything, Anything);
    while black_box(true) {
        show(matcher.poll(calibrator));
        show(matcher.poll_until(calibrator, || black_box(true)));
        show(matcher.read(calibrator));
        show(matcher.read_until(calibrator, || black_box(true)));
        matcher.note_overrun();
        show(matcher.counters());
    }
    let _ = matcher.release();
}

fn stream(calibrator: &mut Calibrator<f32, 256>) {
    let mut matcher = StreamMatcher::new(Anything);
    while black_box(true) {
        show(matcher.poll(calibrator));
        show(matcher.poll_until(calibrator, || black_box(true)));
        show(matcher.read(calibrator));
        matcher.note_overrun();
        show(matcher.counters());
    }
    let _ = matcher.release();
}
