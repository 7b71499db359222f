//! The example of `FORMAT.md` against the code.

use crate::link::stream::{Frame, received};
use stereo_selfcal::Correspondence;
use stereo_selfcal::link::FrameHeader;

/// The frame that the example describes.
fn example() -> Frame {
    let header = FrameHeader {
        timestamp_us: 1_234_567_890,
        sequence: 7,
        count: 2,
        image_size: [1920, 1200],
        grid_step: 256,
        fraction_bits: 8,
        pyramid_ratio: 77,
        dropped_before: true,
        more_found: false,
    };
    let matches = [
        Correspondence { left: [960.0, 600.0], right: [910.5, 601.25], score: 1.0, grid_step: 1.0 },
        Correspondence {
            left: [83.0, 1199.75],
            right: [12.0, 1198.0],
            score: 21_845.0 / 65_535.0,
            grid_step: 77.0 / 64.0 * 77.0 / 64.0,
        },
    ];
    Frame { header, matches: matches.to_vec() }
}

/// Every byte of the example, in order.
fn bytes_of_the_page() -> Vec<u8> {
    let page = include_str!("../../../src/link/FORMAT.md");
    let example = page.split("## Example").nth(1).unwrap().split("```").nth(1).unwrap();
    let hex = |word: &str| u8::from_str_radix(word, 16).ok().filter(|_| word.len() == 2);
    // The first two lines are the language of the block, `text`, and the names of the columns.
    let lines = example.lines().skip(2);
    lines.flat_map(|line| line.split_whitespace().skip(1).map_while(hex)).collect()
}

#[test]
fn the_example_encodes_to_its_bytes() {
    assert_eq!(example().bytes(), bytes_of_the_page());
}

#[test]
fn the_bytes_of_the_example_decode_to_its_meaning() {
    let (frames, discarded, _) = received(&bytes_of_the_page());
    assert_eq!((frames, discarded), (vec![example()], 0));
}
