//! The command `evaluate`: a self-contained page.

use std::fs;
use std::path::Path;

use sim::synth::Scene;

use crate::evidence;

/// Standard output of an evaluation of two methods with one scene a point.
fn evaluate(out: &Path, more: &[&str]) -> String {
    let methods = ["evaluate", "--methods", "robust,paper", "--trials", "1"];
    evidence(&[&methods[..], &["--out", out.to_str().unwrap()], more].concat()).stdout()
}

/// Text between two marks, for every occurrence of the first.
fn between<'a>(text: &'a str, start: &'a str, end: &'a str) -> Vec<&'a str> {
    text.split(start).skip(1).map(|rest| rest.split(end).next().unwrap_or(rest)).collect()
}

#[test]
fn the_page_loads_nothing_and_every_figure_has_its_command() {
    let dir = tempfile::tempdir().unwrap();
    let out = dir.path().join("page");
    let text = evaluate(&out, &[]);
    assert!(text.contains("wins, ") && text.contains("index.html"), "{text}");
    let page = fs::read_to_string(out.join("index.html")).unwrap();
    let figures = between(&page, "<figure", "</figure>");
    // A table of the page is a `<figure>` too.
    assert!(figures.len() >= 15, "{}", figures.len());
    for figure in figures {
        assert!(figure.contains("<code>cargo evidence evaluate --methods robust,paper --trials 1"));
        let caption = between(figure, "<figcaption>", "<span")[0];
        assert!(caption.len() > 40, "{caption}");
        // A figure with data has a table cell, a bar or a broad line.
        let full = ["<td", "<rect", "stroke-width=\"3\""].iter().any(|mark| figure.contains(mark));
        assert!(full, "{caption}");
        let numbers = out.join(between(figure, "href=\"", "\"")[0]);
        let rows = fs::read_to_string(&numbers).unwrap().lines().count();
        assert!(rows > 1, "{}", numbers.display());
    }
    for source in between(&page, "src=\"", "\"").into_iter().chain(between(&page, "href=\"", "\""))
    {
        let inside = ["#", "csv/", "data:"].iter().any(|start| source.starts_with(start));
        assert!(inside, "{source}");
    }
    for tag in ["figure", "table", "section", "svg", "tbody", "ul", "nav", "main"] {
        let [opened, closed] = [format!("<{tag}"), format!("</{tag}>")];
        let opened = page.matches(&opened).count();
        assert_eq!(opened, page.matches(&closed).count(), "{tag}");
    }
}

#[test]
fn further_data_is_compared_and_only_the_folder_of_the_page_is_written() {
    let dir = tempfile::tempdir().unwrap();
    let set = dir.path().join("sets/mine");
    Scene { outliers: 0.2, ..Scene::default() }.dataset(2, 7).unwrap().save(&set).unwrap();
    let [out, data] = ["page", "sets"].map(|name| dir.path().join(name));
    evaluate(&out, &["--data", data.to_str().unwrap()]);
    assert!(fs::read_to_string(out.join("index.html")).unwrap().contains("mine"));
    assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 2);
}

#[test]
fn mistakes_are_named() {
    let dir = tempfile::tempdir().unwrap();
    let failure = |args: &[&str]| {
        let ended = evidence(&[&["evaluate"], args].concat()).inside(dir.path()).ended();
        assert_ne!(ended.status, 0, "{}", ended.out);
        ended.err
    };
    let error = failure(&["--methods", "wizard"]);
    assert!(error.contains("wizard") && error.contains("robust"), "{error}");
    let error = failure(&["--data", "nowhere"]);
    assert!(error.contains("nowhere"), "{error}");
    let error = failure(&["--quick", "--full"]);
    assert!(error.contains("--full"), "{error}");
    assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 0, "nothing is written");
}
