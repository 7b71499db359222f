//! Checks that no rival was weakened: its present figures against those recorded before its settings were varied.

use anyhow::Result;
use serde::Deserialize;

use super::on_recorded::{Quantity, Row};
use super::verdict::of_method;
use rivals::Variant;

/// Errors of each rival with its only settings at that time, the left image turned, as `cargo selfcal evaluate` wrote
/// them, rounded to six digits.
const BEFORE: &str = include_str!("../../golden/rivals_before.csv");

/// Ratio that rounding may cause.
const ROUNDED: f64 = 1.0 + 1e-5;

#[derive(Deserialize)]
struct Before {
    set: String,
    view: String,
    method: String,
    e_t: f64,
    e_theta: f64,
}

/// Number of the rivals' figures that are at least as good as before, and number of the recorded figures that are also
/// measured now.
///
/// # Errors
/// If the record is damaged.
pub fn at_least_as_good(rows: &[Row<'_>], variants: &[Variant]) -> Result<[usize; 2]> {
    let mut counts = [0; 2];
    for before in csv::Reader::from_reader(BEFORE.as_bytes()).into_deserialize() {
        let before: Before = before?;
        let row = rows.iter().find(|row| {
            let of_then = ["-", "left"].contains(&row.seen.camera);
            of_then && row.set.name == before.set && row.seen.view == before.view
        });
        let among = of_method(variants, &before.method);
        let Some(row) = row.filter(|_| !among.is_empty()) else { continue };
        for (quantity, then) in
            [(Quantity::ErrorT, before.e_t), (Quantity::ErrorTheta, before.e_theta)]
        {
            let now = row.least(quantity, &among).map_or(f64::INFINITY, |(_, now)| now);
            counts[0] += usize::from(now <= then * ROUNDED);
            counts[1] += 1;
        }
    }
    Ok(counts)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_record_has_every_rival_that_had_an_estimate() {
        let all: Result<Vec<Before>, _> =
            csv::Reader::from_reader(BEFORE.as_bytes()).into_deserialize().collect();
        let all = all.unwrap();
        assert_eq!(all.len(), 153);
        assert!(all.iter().all(|b| b.e_t > 0.0 && b.e_theta > 0.0));
        assert!(all.iter().all(|b| rivals::by_name(&b.method).is_ok()));
    }
}
