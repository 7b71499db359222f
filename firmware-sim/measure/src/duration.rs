//! Time estimated from instructions: the emulator counts no cycles.

use crate::table::Row;

/// Frame rates of stereo rigs, Hz.
const FRAME_RATES: [f64; 2] = [20.0, 60.0];

/// Assumed speed of a board's controller.
struct Speed {
    hertz: f64,
    /// Cycles per instruction, with code and data in memory without wait states.
    cycles: f64,
}

/// Milliseconds, and the share of a frame at 20 and 60 Hz. `None` for other units than instructions.
pub(crate) fn estimated(row: &Row) -> Option<(f64, [f64; 2])> {
    let speed = match (row.board.as_str(), row.unit.as_str()) {
        // Most instructions take 1 cycle, loads 2, taken branches 3, square roots and divisions 14.
        ("m4f", "instructions") => Speed { hertz: 168e6, cycles: 1.5 },
        // Dual issue; dependent floating-point instructions issue one per cycle.
        ("m7", "instructions") => Speed { hertz: 480e6, cycles: 1.0 },
        _ => return None,
    };
    #[expect(clippy::cast_precision_loss, reason = "counts are far below 2^52")]
    let seconds = row.value as f64 * speed.cycles / speed.hertz;
    Some((seconds * 1e3, FRAME_RATES.map(|rate| seconds * rate)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table::row;

    #[test]
    fn instructions_of_one_frame_period_are_a_share_of_one() {
        let (ms, [at_20, at_60]) = estimated(&row("update", 5_600_000)).unwrap();
        assert!((ms - 50.0).abs() < 1e-9);
        assert!((at_20 - 1.0).abs() < 1e-12 && (at_60 - 3.0).abs() < 1e-12);
    }

    #[test]
    fn bytes_take_no_time() {
        assert_eq!(estimated(&Row { unit: "bytes".into(), ..row("stack", 5) }), None);
    }
}
