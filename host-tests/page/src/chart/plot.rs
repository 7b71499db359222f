//! A part of a picture with an axis in each direction.

use super::axis::Axis;
use super::palette::Rgb;
use super::svg::{Anchor, Point, Style, Svg};

/// Opacities of the lines of the grid and of the border.
const GRID: f64 = 0.13;
const BORDER: f64 = 0.5;

/// Distance of the labels of ticks from the border, px.
const GAP: f64 = 6.0;

/// Draws values into a rectangle of a picture.
#[derive(Debug)]
pub struct Plot<'a> {
    svg: &'a mut Svg,
    /// Left and right border, px.
    across: Point,
    /// Position of the smallest and of the largest value, px: bottom and top, or top and bottom.
    upwards: Point,
    axes: [Axis; 2],
}

impl<'a> Plot<'a> {
    /// A plot between the top left and the bottom right corner, px.
    pub fn new(
        svg: &'a mut Svg,
        [[left, top], [right, bottom]]: [Point; 2],
        axes: [Axis; 2],
    ) -> Self {
        Self { svg, across: [left, right], upwards: [bottom, top], axes }
    }

    /// The plot with values that grow downwards.
    pub fn downwards(mut self) -> Self {
        self.upwards.reverse();
        self
    }

    /// Position of a value in the picture, px.
    pub fn place(&self, [x, y]: Point) -> Point {
        let [x_axis, y_axis] = &self.axes;
        [x_axis.place(x, self.across), y_axis.place(y, self.upwards)]
    }

    /// A border, and lines at the ticks of the vertical axis and, for `columns`, of the horizontal one.
    pub fn frame(&mut self, columns: bool) {
        let Self { svg, across, upwards, axes: [x_axis, y_axis] } = self;
        let grid = Style::line(Rgb::BLACK, 1.0).opacity(GRID);
        for (tick, _) in x_axis.ticks().iter().filter(|_| columns) {
            let x = x_axis.place(*tick, *across);
            svg.path(upwards.map(|y| [x, y]), grid);
        }
        for (tick, _) in y_axis.ticks() {
            let y = y_axis.place(*tick, *upwards);
            svg.path(across.map(|x| [x, y]), grid);
        }
        let corners = [[across[0], upwards[0]], [across[1], upwards[1]]];
        svg.rectangle(corners, Style::line(Rgb::BLACK, 1.0).opacity(BORDER));
    }

    /// Labels of the ticks of the horizontal axis, and the name of the axis below them.
    ///
    /// * `size`: font size, px.
    pub fn label_x(&mut self, name: &str, size: f64) {
        let bottom = self.upwards[0].max(self.upwards[1]);
        let row = bottom + GAP + size / 2.0;
        for (tick, words) in self.axes[0].ticks() {
            self.svg.text(
                [self.axes[0].place(*tick, self.across), row],
                size,
                Anchor::Middle,
                words,
            );
        }
        let middle = f64::midpoint(self.across[0], self.across[1]);
        self.svg.text([middle, row + 1.4 * size], size, Anchor::Middle, name);
    }

    /// Labels of the ticks of the vertical axis, and the name of the axis.
    ///
    /// * `size`: font size, px.
    /// * `aside`: distance of the name from the left border, px.
    pub fn label_y(&mut self, name: &str, size: f64, aside: f64) {
        let left = self.across[0];
        for (tick, words) in self.axes[1].ticks() {
            let y = self.axes[1].place(*tick, self.upwards);
            self.svg.text([left - GAP, y], size, Anchor::End, words);
        }
        let middle = f64::midpoint(self.upwards[0], self.upwards[1]);
        self.svg.text_upwards([left - aside, middle], size, name);
    }

    /// A line through values.
    pub fn line(&mut self, values: impl IntoIterator<Item = Point>, style: Style) {
        let points: Vec<Point> = values.into_iter().map(|value| self.place(value)).collect();
        self.svg.path(points, style);
    }

    /// A polygon with its corners at values.
    pub fn shape(&mut self, values: impl IntoIterator<Item = Point>, style: Style) {
        let points: Vec<Point> = values.into_iter().map(|value| self.place(value)).collect();
        self.svg.polygon(points, style);
    }

    /// The area between values and the start of the vertical axis.
    pub fn band(&mut self, values: &[Point], style: Style) {
        let floor = self.axes[1].floor();
        let ends = values.first().zip(values.last());
        let below = ends.map(|([first, _], [last, _])| [[*last, floor], [*first, floor]]);
        self.shape(values.iter().copied().chain(below.into_iter().flatten()), style);
    }

    /// A rectangle between two opposite corners.
    pub fn rectangle(&mut self, corners: [Point; 2], style: Style) {
        self.svg.rectangle(corners.map(|value| self.place(value)), style);
    }

    /// Dots at values; `radius` in px.
    pub fn dots(&mut self, values: impl IntoIterator<Item = Point>, radius: f64, style: Style) {
        values.into_iter().for_each(|value| self.svg.circle(self.place(value), radius, style));
    }

    /// A diagonal cross at a value; its ends are `half` px from its middle in x and in y.
    pub fn cross(&mut self, value: Point, half: f64, style: Style) {
        self.svg.cross(self.place(value), half, style);
    }
}
