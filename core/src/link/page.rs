//! The page and the code say the same.

extern crate std;

use super::{Decoder, Event, FrameCrc, FrameHeader, Record};
use crate::batch::correspondence::Correspondence;
use std::vec::Vec;

const HEADER: FrameHeader = FrameHeader {
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

fn matches() -> [Correspondence<f32>; 2] {
    [
        Correspondence { left: [960.0, 600.0], right: [910.5, 601.25], score: 1.0, grid_step: 1.0 },
        Correspondence {
            left: [83.0, 1199.75],
            right: [12.0, 1198.0],
            score: 21_845.0 / 65_535.0,
            grid_step: 77.0 / 64.0 * 77.0 / 64.0,
        },
    ]
}

/// Every byte of the example, in the order of the page.
fn of_the_page() -> Vec<u8> {
    let page = include_str!("FORMAT.md");
    let example =
        page.split("## Example").nth(1).and_then(|rest| rest.split("```").nth(1)).unwrap();
    // The first two lines are "```text" and the names of the columns.
    example
        .lines()
        .skip(2)
        .flat_map(|line| line.split_whitespace().skip(1).map_while(hex))
        .collect()
}

fn hex(word: &str) -> Option<u8> {
    u8::from_str_radix(word, 16).ok().filter(|_| word.len() == 2)
}

#[test]
fn what_the_example_means_encodes_to_its_bytes() {
    let header = HEADER.encode().unwrap();
    let records = matches().map(|c| Record::encode(&c, &HEADER).unwrap().to_bytes());
    let mut crc = FrameCrc::new(&header);
    for record in &records {
        crc.add(record);
    }
    let encoded = [&header[..], records.as_flattened(), &crc.value().to_le_bytes()].concat();
    assert_eq!(encoded, of_the_page(), "{encoded:02x?}");
}

#[test]
fn the_bytes_of_the_example_decode_to_what_it_means() {
    let page = of_the_page();
    let mut bytes = page.as_slice();
    let mut decoder = Decoder::new();
    let events: Vec<_> = core::iter::from_fn(|| decoder.next(&mut bytes)).collect();
    let [first, second] = matches().map(Event::Match);
    assert_eq!(events, [Event::Started(HEADER), first, second, Event::Finished(HEADER)]);
}
