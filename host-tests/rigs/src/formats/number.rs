//! Numbers in the form of YAML.

/// The fewest digits that read back to the same bits, always with a point, and a sign in the
/// exponent: YAML 1.1, which Kalibr and ROS read, takes `1e-7` for text.
pub(super) fn number(x: f64) -> String {
    let shortest = format!("{x:?}");
    let Some((digits, exponent)) = shortest.split_once('e') else { return shortest };
    let point = if digits.contains('.') { "" } else { ".0" };
    let sign = if exponent.starts_with('-') { "" } else { "+" };
    format!("{digits}{point}e{sign}{exponent}")
}

/// Numbers separated by commas.
pub(super) fn list(numbers: &[f64]) -> String {
    numbers.iter().map(|&x| number(x)).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn written_numbers_are_floats_of_yaml_1_1_and_read_back_to_their_bits() {
        // The form of YAML 1.1: a point, and a sign in the exponent.
        let numbers = [0.0, -0.0, 1.0, -534.126_673_139_211_6, 1e-7, -2.5e-9, 3e21, 0.1 + 0.2];
        for x in numbers {
            let text = number(x);
            assert!(text.contains('.'), "{text}");
            assert!(!text.contains('e') || text.contains("e+") || text.contains("e-"), "{text}");
            assert_eq!(text.parse::<f64>().unwrap().to_bits(), x.to_bits(), "{text}");
        }
    }
}
