//! The Verilated bench: pins in, pins out.

use std::ffi::c_void;

/// Pins that the simulation drives.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default)]
#[allow(missing_docs, reason = "named as in bench.sv")]
pub struct Inputs {
    pub timestamp: u64,
    /// Left u, left v, right u, right v.
    pub coordinates: [u32; 4],
    pub width: u16,
    pub height: u16,
    pub grid_step: u16,
    pub score: u16,
    pub level: u8,
    pub fraction_bits: u8,
    pub pyramid_ratio: u8,
    pub clk: bool,
    pub rst: bool,
    pub s_valid: bool,
    pub s_first: bool,
    pub s_last: bool,
    pub s_keep: bool,
    pub m_clk: bool,
    pub m_ready: bool,
    pub sink: u8,
    pub sck: bool,
    pub cs_n: bool,
}

/// Pins that the framer drives.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default)]
#[allow(missing_docs, reason = "named as in bench.sv")]
pub struct Outputs {
    pub dropped: u16,
    pub unfinished: u16,
    pub overfull: u16,
    pub out_of_range: u16,
    pub s_ready: bool,
    pub m_valid: bool,
    pub m_data: u8,
    pub m_last: bool,
    pub m_available: bool,
    pub miso: bool,
    pub tx: bool,
}

unsafe extern "C" {
    fn selfcal_small_new() -> *mut c_void;
    fn selfcal_small_drop(model: *mut c_void);
    fn selfcal_small_eval(model: *mut c_void, inputs: *const Inputs, outputs: *mut Outputs);
    fn selfcal_large_new() -> *mut c_void;
    fn selfcal_large_drop(model: *mut c_void);
    fn selfcal_large_eval(model: *mut c_void, inputs: *const Inputs, outputs: *mut Outputs);
}

/// Size of the framer's buffer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Size {
    /// 30 matches.
    Small,
    /// 510 matches.
    Large,
}

impl Size {
    /// Matches of a full frame.
    #[must_use]
    pub const fn matches(self) -> usize {
        match self {
            Self::Small => 30,
            Self::Large => 510,
        }
    }
}

/// One simulated framer.
#[derive(Debug)]
pub struct Model {
    size: Size,
    model: *mut c_void,
}

impl Model {
    /// A framer before its reset.
    #[must_use]
    pub fn new(size: Size) -> Self {
        // SAFETY: no arguments.
        let model = unsafe {
            match size {
                Size::Small => selfcal_small_new(),
                Size::Large => selfcal_large_new(),
            }
        };
        Self { size, model }
    }

    /// Settles the outputs for the inputs; flip-flops see the edges since the last call.
    pub fn eval(&mut self, inputs: &Inputs, outputs: &mut Outputs) {
        // SAFETY: live objects of the layout of shim.cpp.
        unsafe {
            match self.size {
                Size::Small => selfcal_small_eval(self.model, inputs, outputs),
                Size::Large => selfcal_large_eval(self.model, inputs, outputs),
            }
        }
    }
}

impl Drop for Model {
    fn drop(&mut self) {
        // SAFETY: made by `new`, and dropped once.
        unsafe {
            match self.size {
                Size::Small => selfcal_small_drop(self.model),
                Size::Large => selfcal_large_drop(self.model),
            }
        }
    }
}
