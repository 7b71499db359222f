//! Compares the replies of the controller with those of this computer.

use std::fmt;

use firmware_sim::pil::Field;

/// A field that differs.
#[derive(Debug, PartialEq)]
pub(super) struct Difference {
    name: &'static str,
    /// The first number that differs, of this computer and of the controller.
    first: [String; 2],
}

/// Fields that are not bit-identical.
pub(super) fn differences(here: &[Field<'_>], there: &[Field<'_>]) -> Vec<Difference> {
    let both = here.iter().zip(there).filter(|(a, b)| a.bytes != b.bytes);
    both.map(|(a, b)| Difference { name: a.name, first: first(a, b) }).collect()
}

fn first(a: &Field<'_>, b: &Field<'_>) -> [String; 2] {
    let width = if a.floats { 4 } else { a.bytes.len() };
    let mut numbers = a.bytes.chunks(width).zip(b.bytes.chunks(width));
    let differ = numbers.find(|(a, b)| a != b).unwrap_or((a.bytes, b.bytes));
    [differ.0, differ.1].map(|bytes| match bytes.try_into() {
        Ok(bits) if a.floats => {
            let x = f32::from_le_bytes(bits);
            format!("{x:e} ({:#010x})", x.to_bits())
        }
        _ => format!("{bytes:02x?}"),
    })
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [here, there] = &self.first;
        write!(f, "{}: {here} here, {there} on the controller", self.name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_float_that_differs_is_shown_with_its_bits() {
        let bytes = |x: f32| [1.0_f32.to_le_bytes(), x.to_le_bytes()].concat();
        let [a, b] = [bytes(2.0), bytes(f32::from_bits(2.0_f32.to_bits() + 1))];
        let part = |bytes| Field { name: "t", bytes, floats: true };
        assert_eq!(differences(&[part(&a)], &[part(&a)]), []);
        let found = differences(&[part(&a)], &[part(&b)]);
        let shown = "t: 2e0 (0x40000000) here, 2.0000002e0 (0x40000001) on the controller";
        assert_eq!(found[0].to_string(), shown);
    }

    #[test]
    fn zeros_of_either_sign_differ() {
        let [a, b] = [0.0_f32, -0.0].map(f32::to_le_bytes);
        let part = |bytes| Field { name: "t", bytes, floats: true };
        assert_eq!(differences(&[part(&a)], &[part(&b)]).len(), 1);
    }

    #[test]
    fn other_fields_are_shown_byte_by_byte() {
        let part = |bytes| Field { name: "passes", bytes, floats: false };
        let found = differences(&[part(&[4, 0])], &[part(&[5, 0])]);
        assert_eq!(found[0].to_string(), "passes: [04, 00] here, [05, 00] on the controller");
    }
}
