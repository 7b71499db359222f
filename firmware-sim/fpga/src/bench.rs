//! Test bench of the framer: drives its clocks and its stream of matches, and collects the bytes that it sends.

use std::collections::VecDeque;

use stereo_selfcal::link::FrameHeader;

use crate::model::{Inputs, Model, Outputs, Size};

/// One beat of the stream of matches.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Beat {
    /// Left u, left v, right u, right v: coordinate steps, 25 bits, two's complement.
    pub coordinates: [u32; 4],
    /// Score as on the wire.
    pub score: u16,
    /// Pyramid level.
    pub level: u8,
    /// First beat of a frame.
    pub first: bool,
    /// Last beat of a frame.
    pub last: bool,
    /// Whether the beat carries a match.
    pub keep: bool,
    /// Header of the frame: its timestamp and the fields that are constant in a frame.
    pub header: FrameHeader,
}

const NO_HEADER: FrameHeader = FrameHeader {
    timestamp_us: 0,
    sequence: u32::MAX,
    count: 0,
    image_size: [0; 2],
    grid_step: 0,
    fraction_bits: 0,
    pyramid_ratio: 64,
    dropped_before: false,
    more_found: false,
};

/// Destination of the bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sink {
    /// The stream of bytes.
    Stream = 0,
    /// The SPI peripheral.
    Spi = 1,
    /// The UART.
    Uart = 2,
}

/// The framer, its clocks and its surroundings. Time has arbitrary units.
#[derive(Debug)]
pub struct Bench {
    model: Model,
    /// Pins driven.
    pub inputs: Inputs,
    /// Pins seen.
    pub outputs: Outputs,
    /// Half periods of the clock of the matcher and of the bytes; 0 stops the clock.
    pub half_periods: [u64; 2],
    header: FrameHeader,
    next_edge: [u64; 2],
    now: u64,
    /// Beats not taken yet.
    pub beats: VecDeque<Beat>,
    /// Bytes taken off the stream.
    pub taken: Vec<u8>,
    /// Share of cycles in which the source and the sink of bytes stall, 1/256.
    pub stalls: [u8; 2],
    random: u32,
}

impl Bench {
    /// A framer after its reset.
    #[must_use]
    pub fn new(size: Size, sink: Sink) -> Self {
        let inputs =
            Inputs { cs_n: true, sink: sink as u8, pyramid_ratio: 64, ..Inputs::default() };
        let mut bench = Self {
            model: Model::new(size),
            inputs,
            outputs: Outputs::default(),
            half_periods: [5, 4],
            header: NO_HEADER,
            next_edge: [5, 4],
            now: 0,
            beats: VecDeque::new(),
            taken: Vec::new(),
            stalls: [0; 2],
            random: 1,
        };
        bench.reset();
        bench
    }

    /// Resets the framer; beats that it has not taken are lost.
    pub fn reset(&mut self) {
        self.beats.clear();
        self.inputs.s_valid = false;
        self.inputs.rst = true;
        self.run(100);
        self.inputs.rst = false;
        self.run(100);
    }

    /// Lets time pass.
    pub fn run(&mut self, time: u64) {
        let end = self.now + time;
        self.eval();
        while let Some(edge) = self.edge().filter(|edge| *edge <= end) {
            self.now = edge;
            self.clock();
        }
        self.now = end;
    }

    /// Starts or stops a clock.
    pub fn set_half_period(&mut self, clock: usize, half_period: u64) {
        self.half_periods[clock] = half_period;
        self.next_edge[clock] = self.now + half_period;
    }

    fn edge(&self) -> Option<u64> {
        let running = self.half_periods.iter().zip(self.next_edge).filter(|(half, _)| **half > 0);
        running.map(|(_, edge)| edge).min()
    }

    fn eval(&mut self) {
        self.model.eval(&self.inputs, &mut self.outputs);
    }

    /// Edges of the clocks at this time. Inputs change right after the rising edge of their clock.
    fn clock(&mut self) {
        let due = |clock: usize| self.half_periods[clock] > 0 && self.next_edge[clock] == self.now;
        let due = [due(0), due(1)];
        let before = self.outputs;
        for (clock, due) in due.into_iter().enumerate() {
            if due {
                self.next_edge[clock] += self.half_periods[clock];
            }
        }
        self.inputs.clk ^= due[0];
        self.inputs.m_clk ^= due[1];
        let (rises, byte_rises) = (due[0] && self.inputs.clk, due[1] && self.inputs.m_clk);
        self.eval();
        if rises && self.inputs.s_valid && before.s_ready && !self.inputs.rst {
            self.beats.pop_front();
            self.inputs.s_valid = false;
        }
        if byte_rises && before.m_valid && self.inputs.m_ready && self.inputs.sink == 0 {
            self.taken.push(before.m_data);
        }
        if rises && !self.stalled(0) {
            self.offer();
        }
        if byte_rises {
            self.inputs.m_ready = !self.stalled(1);
        }
        self.eval();
    }

    /// Whether a side stalls in this cycle.
    fn stalled(&mut self, side: usize) -> bool {
        self.random = self.random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        self.random.to_be_bytes()[0] < self.stalls[side]
    }

    /// Offers the next beat, unless a beat is offered already. The header changes once the previous frame is whole.
    fn offer(&mut self) {
        let Some(beat) = self.beats.front().filter(|_| !self.inputs.s_valid) else { return };
        if beat.header != self.header {
            if !self.outputs.s_ready {
                return;
            }
            self.header = beat.header;
        }
        let header = &self.header;
        [self.inputs.width, self.inputs.height] = header.image_size;
        self.inputs.grid_step = header.grid_step;
        self.inputs.fraction_bits = header.fraction_bits;
        self.inputs.pyramid_ratio = header.pyramid_ratio;
        self.inputs.timestamp = header.timestamp_us;
        self.inputs.s_valid = true;
        self.inputs.coordinates = beat.coordinates.map(|steps| steps & 0x1ff_ffff);
        self.inputs.score = beat.score;
        self.inputs.level = beat.level;
        self.inputs.s_first = beat.first;
        self.inputs.s_last = beat.last;
        self.inputs.s_keep = beat.keep;
    }
}
