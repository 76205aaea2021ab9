//! What a person reads in the pages: links lead somewhere, and the glossary has each term once.

use crate::folders::{files, workspace};
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// Folders with pages; those at the root are read besides.
const PLACES: [&str; 8] =
    ["benches", "crates", "docs", "firmware", "pipelines", "scenes", "studies", "tests"];
/// Folders with what was built or installed, and pages of others.
const BUILT: [&str; 3] = ["target", "node_modules", "venv"];
/// The words of the data model, which the glossary must have.
const MODEL: [&str; 14] = [
    "calibration",
    "condition",
    "environment",
    "mode",
    "participant",
    "repeat",
    "replay",
    "scene",
    "session",
    "stage",
    "study",
    "sweep",
    "trial",
    "twin",
];
/// The pages, by their place in the workspace.
fn pages() -> BTreeMap<PathBuf, String> {
    let root = workspace();
    let mut paths: Vec<PathBuf> =
        PLACES.iter().flat_map(|place| files(&root.join(place), "md")).collect();
    let at_root = fs::read_dir(root).unwrap().map(|entry| entry.unwrap().path());
    paths.extend(at_root.filter(|path| path.extension().is_some_and(|e| e == "md")));
    let is_ours = |path: &PathBuf| {
        let place = path.strip_prefix(root).unwrap();
        !place.iter().any(|part| BUILT.iter().any(|built| part == *built))
    };
    paths.retain(is_ours);
    let text = |path: PathBuf| (path.clone(), fs::read_to_string(path).unwrap());
    paths.into_iter().map(text).collect()
}

/// A page without its blocks of code.
fn without_blocks(text: &str) -> String {
    let parts = text.split("```").step_by(2);
    parts.collect::<Vec<_>>().join("\n")
}

/// A page without its blocks and its spans of code.
fn prose(text: &str) -> String {
    without_blocks(text).split('`').step_by(2).collect()
}

/// Where the links of a page lead.
fn links(text: &str) -> Vec<String> {
    let prose = prose(text);
    let targets = prose.split("](").skip(1);
    targets.filter_map(|rest| Some(rest.split_once(')')?.0.to_owned())).collect()
}

/// The anchor of a heading, as it is made where the pages are shown.
fn anchor(heading: &str) -> String {
    let kept = heading.trim().to_lowercase();
    let kept = kept.chars().filter(|c| c.is_alphanumeric() || " -_".contains(*c));
    kept.map(|c| if c == ' ' { '-' } else { c }).collect()
}

fn anchors(text: &str) -> Vec<String> {
    let text = without_blocks(text);
    let headings = text.lines().filter(|line| line.starts_with('#'));
    headings.map(|line| anchor(line.trim_start_matches('#'))).collect()
}

/// What is wrong with a link of the page at `path`, if anything is.
fn broken(path: &Path, link: &str) -> Option<String> {
    if link.contains("://") || link.starts_with("mailto:") {
        return None;
    }
    let (file, heading) = link.split_once('#').unwrap_or((link, ""));
    let target = if file.is_empty() { path.to_owned() } else { path.parent()?.join(file) };
    if !target.exists() {
        return Some(format!("{}: there is no {file}", path.display()));
    }
    let text = if heading.is_empty() { String::new() } else { fs::read_to_string(target).unwrap() };
    let is_there = heading.is_empty() || anchors(&text).iter().any(|anchor| anchor == heading);
    (!is_there).then(|| format!("{}: no heading makes {link}", path.display()))
}

/// The terms of the glossary, in its order.
fn terms(glossary: &str) -> Vec<&str> {
    let entries = glossary.lines().filter_map(|line| line.strip_prefix("* **"));
    entries.map(|entry| entry.split_once("**: ").unwrap().0).collect()
}

/// In lower case, with one blank between words.
fn flat(text: &str) -> String {
    text.to_lowercase().split_whitespace().collect::<Vec<_>>().join(" ")
}

#[test]
fn every_link_of_a_page_leads_somewhere() {
    let mut wrong = Vec::new();
    let mut followed = 0;
    for (path, text) in pages() {
        let links = links(&text);
        followed += links.len();
        wrong.extend(links.iter().filter_map(|link| broken(&path, link)));
    }
    assert!(followed > 100, "only {followed} links: were they found?");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn a_link_to_nowhere_is_found_and_code_is_no_link() {
    let page = workspace().join("docs/README.md");
    assert_eq!(broken(&page, "first-hour.md"), None);
    assert_eq!(broken(&page, "first-hour.md#1-install"), None);
    assert!(broken(&page, "no-such-page.md").is_some());
    assert!(broken(&page, "first-hour.md#no-such-heading").is_some());
    assert_eq!(
        links("[a](b.md) `[c](d.md)`\n```\n[e](f.md)\n```\n[g](h.md#i)"),
        ["b.md", "h.md#i"]
    );
    assert_eq!(anchor(" A trial's columns: `t_s`"), "a-trials-columns-t_s");
}

#[test]
fn the_glossary_has_each_term_once_in_order_and_each_is_used() {
    let pages = pages();
    let path = workspace().join("docs/glossary.md");
    let terms = terms(&pages[&path]);
    let sorted = |mut terms: Vec<String>| {
        terms.sort();
        terms.dedup();
        terms
    };
    let lower: Vec<String> = terms.iter().map(|term| term.to_lowercase()).collect();
    assert_eq!(lower, sorted(lower.clone()), "in the order of the alphabet, each once");
    for term in MODEL {
        assert!(terms.contains(&term), "the glossary lacks {term}");
    }
    let is_of_docs = |page: &PathBuf| page.starts_with(workspace().join("docs")) && *page != path;
    let docs: Vec<String> =
        pages.iter().filter(|(page, _)| is_of_docs(page)).map(|(_, text)| flat(text)).collect();
    for term in lower {
        assert!(docs.iter().any(|text| text.contains(&term)), "no page of docs uses {term}");
    }
}
