//! The interface to QEMU.

use std::ffi::{CStr, c_char, c_int, c_uint, c_void};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicPtr, AtomicU64, Ordering::Relaxed};

use crate::decode::Instruction;
use crate::model;

/// Address of the counter: the last word of flash in `memory.x`.
const COUNTER_ADDRESS: u64 = 0x003f_fffc;

/// The version of QEMU's interface.
#[unsafe(no_mangle)]
#[used]
pub(crate) static qemu_plugin_version: c_int = 1;

/// Without access to registers.
const NO_REGISTERS: c_int = 0;

unsafe extern "C" {
    fn qemu_plugin_register_vcpu_tb_trans_cb(id: u64, callback: extern "C" fn(u64, *mut c_void));
    fn qemu_plugin_register_vcpu_tb_exec_cb(
        block: *mut c_void,
        callback: extern "C" fn(c_uint, *mut c_void),
        flags: c_int,
        data: *mut c_void,
    );
    fn qemu_plugin_tb_n_insns(block: *const c_void) -> usize;
    fn qemu_plugin_tb_get_insn(block: *const c_void, index: usize) -> *mut c_void;
    fn qemu_plugin_insn_vaddr(instruction: *const c_void) -> u64;
    fn qemu_plugin_insn_haddr(instruction: *const c_void) -> *mut c_void;
    fn qemu_plugin_insn_size(instruction: *const c_void) -> usize;
}

/// A translated block.
struct Block {
    start: u64,
    end: u64,
    cycles: u32,
}

/// Options of the command line.
#[derive(Clone, Copy)]
struct Options {
    /// Cycles to fill the pipeline after a branch.
    refill: u32,
    /// Wait states of the flash, for each line of a block.
    wait: u32,
}

static OPTIONS: OnceLock<Options> = OnceLock::new();
/// End of the block before.
static END: AtomicU64 = AtomicU64::new(0);
static COUNTER: AtomicPtr<u32> = AtomicPtr::new(std::ptr::null_mut());

/// QEMU calls this function once, with the options `refill=N` and `wait=N`.
///
/// # Safety
/// `argv` has `argc` strings.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn qemu_plugin_install(
    id: u64,
    _info: *const c_void,
    argc: c_int,
    argv: *const *const c_char,
) -> c_int {
    let count = usize::try_from(argc).unwrap_or_default();
    // SAFETY: the caller's strings.
    let texts = (0..count).map(|i| unsafe { CStr::from_ptr(*argv.add(i)) }.to_str());
    let mut options = Options { refill: 0, wait: 0 };
    for text in texts {
        let option = text.ok().and_then(|text| text.split_once('='));
        match option.map(|(name, value)| (name, value.parse())) {
            Some(("refill", Ok(value))) => options.refill = value,
            Some(("wait", Ok(value))) => options.wait = value,
            _ => return 1,
        }
    }
    let _ = OPTIONS.set(options);
    // SAFETY: QEMU's function, with the name that it gave.
    unsafe { qemu_plugin_register_vcpu_tb_trans_cb(id, translated) };
    0
}

extern "C" fn translated(_: u64, tb: *mut c_void) {
    // SAFETY: QEMU's block and its instructions, valid during this call. An instruction has at least two bytes in memory
    // of the host, and four if it is wide.
    let instructions = unsafe {
        let all = (0..qemu_plugin_tb_n_insns(tb)).map(|i| qemu_plugin_tb_get_insn(tb, i));
        all.map(|at| {
            let halfwords: *const u16 = qemu_plugin_insn_haddr(at).cast();
            let is_wide = qemu_plugin_insn_size(at) == 4;
            let second = if is_wide { halfwords.add(1).read_unaligned() } else { 0 };
            let decoded = Instruction::decode([halfwords.read_unaligned(), second], is_wide);
            (qemu_plugin_insn_vaddr(at), if is_wide { 4 } else { 2 }, halfwords, decoded)
        })
        .collect::<Vec<_>>()
    };
    let (Some(first), Some(last)) = (instructions.first(), instructions.last()) else { return };
    let (start, end) = (first.0, last.0 + last.1);
    if COUNTER.load(Relaxed).is_null() {
        let offset = usize::try_from(COUNTER_ADDRESS - start).unwrap_or_default();
        COUNTER.store(first.2.cast_mut().wrapping_byte_add(offset).cast(), Relaxed);
    }
    let decoded: Vec<_> = instructions.into_iter().map(|(.., decoded)| decoded).collect();
    let wait = OPTIONS.get().map_or(0, |options| options.wait);
    let cycles = model::cycles(&decoded) + wait * model::lines(start, end);
    // QEMU keeps the block until its end.
    let block = Box::leak(Box::new(Block { start, end, cycles }));
    // SAFETY: QEMU's block; the data live as long as QEMU.
    unsafe {
        qemu_plugin_register_vcpu_tb_exec_cb(
            tb,
            executed,
            NO_REGISTERS,
            std::ptr::from_mut(block).cast(),
        );
    }
}

extern "C" fn executed(_: c_uint, data: *mut c_void) {
    // SAFETY: the block of `translated`.
    let block: &Block = unsafe { &*data.cast() };
    let is_reached_by_branch = END.swap(block.end, Relaxed) != block.start;
    let refill = OPTIONS.get().filter(|_| is_reached_by_branch).map_or(0, |options| options.refill);
    let counter = COUNTER.load(Relaxed);
    // SAFETY: a word of the board's flash, aligned. The only processor waits for this call.
    unsafe { counter.write_volatile(counter.read_volatile().wrapping_sub(block.cycles + refill)) };
}
