//! SVG pictures: lines, areas, marks and words at pixels.

use std::fmt::Write as _;

use super::palette::Rgb;

/// A position or a size, px: x to the right, y down.
pub type Point = [f64; 2];

/// Colour, opacity, and style of the outline.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Style {
    color: Rgb,
    opacity: f64,
    /// Width of the line, px; `None` fills the shape.
    stroke: Option<f64>,
    /// Lengths of dashes and of the gaps between them, px.
    dashes: Option<Point>,
}

/// Horizontal place of a text relative to its point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Anchor {
    /// The text starts at the point.
    Start,
    /// The point is in the middle of the text.
    Middle,
    /// The text ends at the point.
    End,
}

impl Anchor {
    fn name(self) -> &'static str {
        match self {
            Self::Start => "start",
            Self::Middle => "middle",
            Self::End => "end",
        }
    }
}

/// A picture under construction.
#[derive(Debug, Clone, PartialEq)]
pub struct Svg {
    size: Point,
    body: String,
}

impl Style {
    /// A filled shape.
    pub const fn filled(color: Rgb) -> Self {
        Self { color, opacity: 1.0, stroke: None, dashes: None }
    }

    /// A line of a width, px.
    pub const fn line(color: Rgb, width: f64) -> Self {
        Self { color, opacity: 1.0, stroke: Some(width), dashes: None }
    }

    /// The style with an opacity, 0 to 1.
    pub const fn opacity(self, opacity: f64) -> Self {
        Self { opacity, ..self }
    }

    /// The style with dashes and gaps of these lengths, px.
    pub const fn dashed(self, dash: f64, gap: f64) -> Self {
        Self { dashes: Some([dash, gap]), ..self }
    }

    fn attributes(self) -> String {
        let color = self.color.hex();
        let (kind, rest) = match self.stroke {
            None => ("fill", String::new()),
            Some(width) => ("stroke", format!(" stroke-width=\"{}\" fill=\"none\"", Px(width))),
        };
        let mut text = format!("{kind}=\"{color}\"{rest}");
        if self.opacity < 1.0 {
            let _ = write!(text, " {kind}-opacity=\"{}\"", Px(self.opacity));
        }
        if let Some([dash, gap]) = self.dashes {
            let _ = write!(text, " stroke-dasharray=\"{},{}\"", Px(dash), Px(gap));
        }
        text
    }
}

impl Svg {
    /// An empty, transparent picture of a size, px.
    pub fn new(size: Point) -> Self {
        Self { size, body: String::new() }
    }

    /// The picture with a white background.
    pub fn on_white(mut self) -> Self {
        self.rectangle([[0.0; 2], self.size], Style::filled(Rgb::WHITE));
        self
    }

    /// Width and height, px.
    pub fn size(&self) -> Point {
        self.size
    }

    /// A line through points.
    pub fn path(&mut self, points: impl IntoIterator<Item = Point>, style: Style) {
        self.points("polyline", points, style);
    }

    /// A closed shape.
    pub fn polygon(&mut self, points: impl IntoIterator<Item = Point>, style: Style) {
        self.points("polygon", points, style);
    }

    fn points(&mut self, tag: &str, points: impl IntoIterator<Item = Point>, style: Style) {
        let points: Vec<String> =
            points.into_iter().map(|[x, y]| format!("{},{}", Px(x), Px(y))).collect();
        if !points.is_empty() {
            self.tag(format_args!(
                "<{tag} points=\"{}\" {}/>",
                points.join(" "),
                style.attributes()
            ));
        }
    }

    /// A rectangle between two opposite corners.
    pub fn rectangle(&mut self, [[a, b], [c, d]]: [Point; 2], style: Style) {
        self.tag(format_args!(
            "<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" {}/>",
            Px(a.min(c)),
            Px(b.min(d)),
            Px((a - c).abs()),
            Px((b - d).abs()),
            style.attributes()
        ));
    }

    /// A circle of a radius, px.
    pub fn circle(&mut self, [x, y]: Point, radius: f64, style: Style) {
        self.tag(format_args!(
            "<circle cx=\"{}\" cy=\"{}\" r=\"{}\" {}/>",
            Px(x),
            Px(y),
            Px(radius),
            style.attributes()
        ));
    }

    /// A diagonal cross; its ends are `half` px from its middle in x and in y.
    pub fn cross(&mut self, [x, y]: Point, half: f64, style: Style) {
        for sign in [-1.0, 1.0] {
            self.path([[x - half, y - sign * half], [x + half, y + sign * half]], style);
        }
    }

    /// Words of a size, px, vertically centred on a point.
    pub fn text(&mut self, at: Point, size: f64, anchor: Anchor, words: &str) {
        self.words(at, size, anchor, "", words);
    }

    /// Words of a size, px, centred on a point, and read from bottom to top.
    pub fn text_upwards(&mut self, [x, y]: Point, size: f64, words: &str) {
        let turn = format!(" transform=\"rotate(-90 {} {})\"", Px(x), Px(y));
        self.words([x, y], size, Anchor::Middle, &turn, words);
    }

    fn words(&mut self, [x, y]: Point, size: f64, anchor: Anchor, turn: &str, words: &str) {
        if words.is_empty() {
            return;
        }
        // Some viewers do not support `dominant-baseline`.
        let baseline = y + 0.35 * size;
        self.tag(format_args!(
            "<text x=\"{}\" y=\"{}\" font-size=\"{}\" text-anchor=\"{}\" fill=\"{}\"{turn}>{}</text>",
            Px(x),
            Px(baseline),
            Px(size),
            anchor.name(),
            Rgb::BLACK.hex(),
            escaped(words)
        ));
    }

    fn tag(&mut self, tag: std::fmt::Arguments<'_>) {
        let _ = writeln!(self.body, "{tag}");
    }

    /// The text of the file.
    pub fn finish(self) -> String {
        let [width, height] = self.size.map(Px);
        format!(
            "<svg width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\" \
             xmlns=\"http://www.w3.org/2000/svg\" font-family=\"sans-serif\">\n{}</svg>\n",
            self.body
        )
    }
}

/// A number with at most two decimals.
struct Px(f64);

impl std::fmt::Display for Px {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        // Adding 0 turns -0 into 0.
        write!(f, "{}", (self.0 * 100.0).round() / 100.0 + 0.0)
    }
}

fn escaped(words: &str) -> String {
    words.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shapes_and_words_are_written_with_short_numbers_and_escaped() {
        let mut svg = Svg::new([30.0, 20.0]);
        svg.path(
            [[0.0, -0.001], [1.0 / 3.0, 2.0]],
            Style::line(Rgb(0, 114, 178), 2.0).dashed(5.0, 3.0),
        );
        svg.polygon([[0.0; 2]; 3], Style::filled(Rgb::BLACK).opacity(0.5));
        svg.text([1.0, 2.0], 10.0, Anchor::End, "a < b & c");
        let text = svg.finish();
        for part in [
            "<svg width=\"30\" height=\"20\" viewBox=\"0 0 30 20\"",
            "<polyline points=\"0,0 0.33,2\" stroke=\"#0072B2\" stroke-width=\"2\" fill=\"none\" \
             stroke-dasharray=\"5,3\"/>",
            "fill=\"#000000\" fill-opacity=\"0.5\"",
            "text-anchor=\"end\"",
            ">a &lt; b &amp; c</text>",
        ] {
            assert!(text.contains(part), "{part} is not in\n{text}");
        }
        assert!(text.ends_with("</svg>\n"));
    }

    #[test]
    fn a_line_without_points_is_not_drawn() {
        let empty = Svg::new([1.0, 1.0]);
        let mut svg = empty.clone();
        svg.path([], Style::line(Rgb::BLACK, 1.0));
        assert_eq!(svg, empty);
    }
}
