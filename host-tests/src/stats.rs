//! Order statistics, with one definition for all tables, pictures and tests.

/// Quantile of some numbers, linear between neighbours (Hyndman and Fan, type 7); `None` without a number.
///
/// * `share`: 0 is the least number, 0.5 the median, 1 the largest.
#[must_use]
pub fn quantile(mut numbers: Vec<f64>, share: f64) -> Option<f64> {
    numbers.sort_unstable_by(f64::total_cmp);
    let last = numbers.len().checked_sub(1)?;
    let place = share.clamp(0.0, 1.0) * f64::from(u32::try_from(last).ok()?);
    let mut at = 0.0;
    let mut neighbours = numbers.windows(2);
    while let Some(&[below, above]) = neighbours.next() {
        if place < at + 1.0 {
            return Some(below + (place - at) * (above - below));
        }
        at += 1.0;
    }
    numbers.last().copied()
}

/// The middle number, or the mean of the middle two; `None` without a number.
#[must_use]
pub fn median(numbers: Vec<f64>) -> Option<f64> {
    quantile(numbers, 0.5)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quantile_lies_between_its_neighbours() {
        let numbers = vec![4.0, 1.0, 3.0, 2.0];
        for (share, expected) in [(0.0, 1.0), (0.5, 2.5), (0.75, 3.25), (1.0, 4.0), (2.0, 4.0)] {
            assert_eq!(quantile(numbers.clone(), share), Some(expected), "{share}");
        }
        assert_eq!(median(vec![3.0, 1.0, 2.0]), Some(2.0));
        assert_eq!(median(vec![7.0]), Some(7.0));
        assert_eq!(median(Vec::new()), None);
    }
}
