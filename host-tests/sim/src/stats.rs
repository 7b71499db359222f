//! Means and order statistics for tables, pictures and tests.

use stereo_selfcal::geometry::metrics::Deviation;

/// Quantile of some numbers, interpolated linearly between neighbours (Hyndman and Fan, type 7); `None` without a
/// number.
///
/// * `share`: 0 is the least number, 0.5 the median, 1 the largest; clamped to this range.
pub fn quantile(numbers: impl IntoIterator<Item = f64>, share: f64) -> Option<f64> {
    let mut numbers: Vec<f64> = numbers.into_iter().collect();
    numbers.sort_unstable_by(f64::total_cmp);
    let last = numbers.len().checked_sub(1)?;
    let place = share.clamp(0.0, 1.0) * f64::from(u32::try_from(last).ok()?);
    let mut at = 0.0;
    let mut neighbours = numbers.windows(2);
    while let Some(&[below, above]) = neighbours.next() {
        if place < at + 1.0 {
            let part = place - at;
            // 0 times an infinite step is NaN, so a `part` of 0 is a case of its own.
            return Some(if part > 0.0 { below + part * (above - below) } else { below });
        }
        at += 1.0;
    }
    numbers.last().copied()
}

/// The middle number, or the mean of the middle two; `None` without a number.
pub fn median(numbers: impl IntoIterator<Item = f64>) -> Option<f64> {
    quantile(numbers, 0.5)
}

/// Arithmetic mean; `None` without a number.
pub fn mean(numbers: impl IntoIterator<Item = f64>) -> Option<f64> {
    let (mut count, mut sum) = (0.0, 0.0);
    for number in numbers {
        count += 1.0;
        sum += number;
    }
    (count > 0.0).then(|| sum / count)
}

/// Root mean square; `None` without a number.
pub fn rms(numbers: impl IntoIterator<Item = f64>) -> Option<f64> {
    mean(numbers.into_iter().map(|x| x * x)).map(f64::sqrt)
}

/// Geometric mean of positive numbers; `None` without a number.
pub fn geometric_mean(numbers: impl IntoIterator<Item = f64>) -> Option<f64> {
    mean(numbers.into_iter().map(f64::ln)).map(f64::exp)
}

/// Root mean square of deviations, of `t` and of `R` separately, rad; both are NaN without a deviation.
pub fn rms_deviation(all: impl IntoIterator<Item = Deviation<f64>>) -> Deviation<f64> {
    Deviation::root_mean_square(all)
        .unwrap_or(Deviation { translation: f64::NAN, rotation: f64::NAN })
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
        assert_eq!(median([3.0, 1.0, 2.0]), Some(2.0));
        assert_eq!(median([7.0]), Some(7.0));
        assert_eq!(median([]), None);
    }

    #[test]
    fn a_median_beside_an_infinite_number_is_finite() {
        assert_eq!(median([f64::INFINITY, 1.0, 2.0]), Some(2.0));
        assert_eq!(median([f64::INFINITY, 1.0]), Some(f64::INFINITY));
    }

    #[test]
    fn means_are_arithmetic_quadratic_and_geometric() {
        assert_eq!(mean([1.0, 2.0, 6.0]), Some(3.0));
        assert_eq!(rms([1.0, -7.0]), Some(5.0));
        assert!((geometric_mean([0.5, 8.0]).unwrap() - 2.0).abs() < 1e-12);
        assert_eq!([mean([]), rms([]), geometric_mean([])], [None; 3]);
        assert!(rms_deviation([]).rotation.is_nan());
    }
}
