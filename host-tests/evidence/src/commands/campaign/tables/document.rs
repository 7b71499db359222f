//! Tables between two markers of a document.

use anyhow::{Context, Result};

const END: &str = "\n<!-- end -->\n";

/// The text before a table, the table, and the text after it.
fn parts<'a>(text: &'a str, name: &str) -> Result<[&'a str; 3]> {
    let start = format!("<!-- campaign {name} -->\n\n");
    let (before, rest) = text.split_once(&start).with_context(|| format!("no line {start}"))?;
    let (table, _) = rest.split_once(END).with_context(|| format!("no end of table {name}"))?;
    let begin = before.len() + start.len();
    let end = begin + table.len();
    Ok([&text[..begin], table, &text[end..]])
}

/// The lines of a table.
pub(super) fn lines<'a>(text: &'a str, name: &str) -> Result<Vec<&'a str>> {
    Ok(parts(text, name)?[1].lines().collect())
}

/// The text with another table.
pub(super) fn replaced(text: &str, name: &str, lines: &[String]) -> Result<String> {
    let [before, _, after] = parts(text, name)?;
    Ok(format!("{before}{}\n{after}", lines.join("\n")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_is_replaced_and_the_rest_stays() {
        let text = "a\n\n<!-- campaign one -->\n\n| 1 |\n\n<!-- end -->\n\nb\n";
        let lines_of = lines(text, "one").unwrap();
        assert_eq!(lines_of, ["| 1 |"]);
        let other = replaced(text, "one", &["| 2 |".into(), "| 3 |".into()]).unwrap();
        assert_eq!(other, "a\n\n<!-- campaign one -->\n\n| 2 |\n| 3 |\n\n<!-- end -->\n\nb\n");
        assert_eq!(lines(&other, "one").unwrap(), ["| 2 |", "| 3 |"]);
        assert!(replaced(text, "two", &[]).is_err());
    }
}
