//! Colours of the series, each with a variant for a dark page.
//!
//! The first six are by Okabe and Ito; colour-blind readers can distinguish them too.

use stereo_selfcal::Scalar;

/// Red, green and blue.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Rgb(pub u8, pub u8, pub u8);

impl Rgb {
    /// Black: the colour of the text. A page replaces it by the colour of its own text.
    pub const BLACK: Self = Self(0, 0, 0);
    /// White: the background. A page replaces it by its own background.
    pub const WHITE: Self = Self(255, 255, 255);

    /// `#RRGGBB`.
    pub fn hex(self) -> String {
        let Self(r, g, b) = self;
        format!("#{r:02X}{g:02X}{b:02X}")
    }
}

/// A colour of pictures, on a light page and on a dark one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Color {
    /// On a light page.
    pub light: Rgb,
    /// On a dark page.
    pub dark: Rgb,
}

const fn color(light: [u8; 3], dark: [u8; 3]) -> Color {
    let [r, g, b] = light;
    let [dark_r, dark_g, dark_b] = dark;
    Color { light: Rgb(r, g, b), dark: Rgb(dark_r, dark_g, dark_b) }
}

/// Colours of series, in the order of their use.
pub const SERIES: [Color; 10] = [
    color([0, 114, 178], [86, 170, 230]),
    color([213, 94, 0], [255, 140, 70]),
    color([0, 158, 115], [40, 200, 155]),
    color([204, 121, 167], [232, 160, 204]),
    color([230, 159, 0], [245, 190, 70]),
    color([86, 180, 233], [150, 212, 250]),
    color([130, 90, 60], [196, 152, 120]),
    color([120, 120, 120], [165, 165, 165]),
    color([140, 140, 0], [200, 200, 60]),
    color([110, 70, 180], [170, 140, 235]),
];

/// The colour of a series; the colours repeat.
pub fn series(i: usize) -> Color {
    SERIES[i % SERIES.len()]
}

/// The `viridis` map at equal steps.
const VIRIDIS: [[u8; 3]; 9] = [
    [68, 1, 84],
    [71, 44, 122],
    [59, 81, 139],
    [44, 113, 142],
    [33, 144, 141],
    [39, 173, 129],
    [92, 200, 99],
    [170, 220, 50],
    [253, 231, 37],
];

/// Colour of a share, 0 (dark purple) to 1 (yellow), with uniform steps of lightness.
pub fn viridis(share: f64) -> Rgb {
    let place = share.clamp(0.0, 1.0) * 8.0;
    let below = usize::from(place.to_u16()).min(7);
    let part = place - place.floor().min(7.0);
    let mix = |i: usize| {
        let [a, b] = [VIRIDIS[below][i], VIRIDIS[below + 1][i]].map(f64::from);
        u8::try_from((a + (b - a) * part + 0.5).to_u16()).unwrap_or(u8::MAX)
    };
    Rgb(mix(0), mix(1), mix(2))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_map_has_its_colours_at_the_ends_and_in_the_middle() {
        assert_eq!(
            [0.0, 0.5, 1.0].map(viridis),
            [Rgb(68, 1, 84), Rgb(33, 144, 141), Rgb(253, 231, 37)]
        );
        assert_eq!([-1.0, 2.0, f64::NAN].map(|x| viridis(x).hex().len()), [7; 3]);
    }
}
