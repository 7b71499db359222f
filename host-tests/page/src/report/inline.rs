//! Charts fitted into a page.
//!
//! Charts have fixed colours and a fixed size. In a page, black becomes the colour of the text and white that of the
//! page; series get other colours on a dark page; the picture shrinks with the page.

use crate::chart::palette::SERIES;

/// An SVG picture for a page.
///
/// * `label`: description for screen readers.
///
/// Empty for text that is not an SVG picture.
pub fn inline(svg: &str, label: &str) -> String {
    let Some((_, picture)) = svg.split_once("<svg ") else { return String::new() };
    let Some((attributes, body)) = picture.split_once('>') else { return String::new() };
    let of = |name: &str| {
        let (_, rest) = attributes.split_once(&format!("{name}=\""))?;
        Some(rest.split_once('"')?.0)
    };
    let [width, height] = ["width", "height"].map(|name| of(name).unwrap_or("100"));
    let whole = format!("0 0 {width} {height}");
    let label = maud::html! { (label) }.into_string();
    format!(
        "<svg viewBox=\"{}\" role=\"img\" aria-label=\"{label}\" style=\"max-width:calc(1.2*{width}px)\">{}",
        of("viewBox").unwrap_or(&whole),
        recolored(body.trim_end())
    )
}

/// Name of the colour of a series in the style sheet of the page.
pub(super) fn variable(i: usize) -> String {
    format!("--s{i}")
}

fn recolored(body: &str) -> String {
    let fixed = [("#000000", "currentColor".to_owned()), ("#FFFFFF", "var(--page)".to_owned())];
    let series = SERIES.iter().enumerate();
    let series = series.map(|(i, color)| (color.light.hex(), format!("var({})", variable(i))));
    let fixed = fixed.into_iter().map(|(from, to)| (from.to_owned(), to));
    fixed.chain(series).fold(body.to_owned(), |body, (from, to)| body.replace(&from, &to))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_takes_its_colours_and_its_width_from_the_page() {
        let svg = "<?xml?>\n<svg width=\"30\" height=\"20\" viewBox=\"0 0 30 20\" xmlns=\"x\">\n\
                   <rect fill=\"#FFFFFF\"/><g stroke=\"#000000\" fill=\"#0072B2\"/></svg>\n";
        let inlined = inline(svg, "a < b");
        assert_eq!(
            inlined,
            "<svg viewBox=\"0 0 30 20\" role=\"img\" aria-label=\"a &lt; b\" \
             style=\"max-width:calc(1.2*30px)\">\n<rect fill=\"var(--page)\"/>\
             <g stroke=\"currentColor\" fill=\"var(--s0)\"/></svg>"
        );
    }

    #[test]
    fn text_that_is_not_a_picture_gives_nothing() {
        assert_eq!(inline("", "none"), "");
        assert_eq!(inline("<svg width", "cut off"), "");
    }
}
