//! Figures that a stage of the study's own draws: kept as they are, each beside a file that says where
//! it comes from.

use super::parameters::Parameters;
use serde::Serialize;
use std::fs;
use std::path::Path;
use zwidth_runner::{JobError, Making, Provenance};
use zwidth_store::{hex_blake3, read_regular};
use zwidth_tables::SYNTHETIC;

/// The most that a figure may have, bytes (20 MB).
const MOST_BYTES: u64 = 20_000_000;

/// Where a figure comes from: the file beside it.
#[derive(Serialize)]
struct Beside<'a> {
    figure: &'a str,
    blake3: String,
    caption: &'a str,
    made_by: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    mark: Option<&'static str>,
    #[serde(skip_serializing_if = "Provenance::is_empty")]
    provenance: &'a Provenance,
}

/// Takes the figures that study.toml names from the folder in which the program left them: each, and
/// the file beside it, in their order. Second, what else lies there.
///
/// # Errors
/// A figure that is missing, is no regular file, has more than 20 MB, or is not what its ending says.
pub(super) fn take(
    folder: &Path,
    parameters: &Parameters,
    making: &Making,
) -> Result<(Vec<Vec<u8>>, Vec<String>), JobError> {
    let stage = &parameters.stage;
    let mut outputs = Vec::new();
    for figure in &stage.figures {
        let path = folder.join(&figure.file);
        let bytes = read_regular(&path, MOST_BYTES).map_err(|error| {
            format!(
                "out/figures/{} cannot be taken ({error}); let the program write it as a file of at most 20 MB, or \
                 take it out of figures in study.toml",
                figure.file
            )
        })?;
        if !is_what_it_says(&path, &bytes) {
            return Err(format!(
                "out/figures/{} is not what its ending says; let the program write an SVG, PDF or PNG",
                figure.file
            )
            .into());
        }
        let beside = Beside {
            figure: &figure.file,
            blake3: hex_blake3(&bytes),
            caption: &figure.caption,
            made_by: stage.in_words(),
            mark: parameters.simulated.then_some(SYNTHETIC),
            provenance: making.from,
        };
        outputs.push(bytes);
        outputs.push(serde_json::to_vec_pretty(&beside)?);
    }
    let mut care = Vec::new();
    for entry in fs::read_dir(folder)? {
        let name = entry?.file_name().to_string_lossy().into_owned();
        if stage.figures.iter().all(|figure| figure.file != name) {
            care.push(format!(
                "the stage {} left out/figures/{name}, which is not kept; list it in figures in study.toml",
                stage.id
            ));
        }
    }
    care.sort();
    Ok((outputs, care))
}

/// Whether a file begins as files of its ending do.
fn is_what_it_says(path: &Path, bytes: &[u8]) -> bool {
    match path.extension().and_then(|ending| ending.to_str()) {
        Some("png") => bytes.starts_with(b"\x89PNG\r\n\x1a\n"),
        Some("pdf") => bytes.starts_with(b"%PDF-"),
        Some("svg") => std::str::from_utf8(bytes).is_ok_and(begins_with_svg),
        _ => false,
    }
}

/// Whether the first element of a text is `svg`, behind what XML allows before it.
fn begins_with_svg(text: &str) -> bool {
    let mut rest = text.trim_start_matches('\u{feff}');
    loop {
        rest = rest.trim_start();
        // A declaration, a comment, a document type (without declarations of its own).
        let before = [("<?", "?>"), ("<!--", "-->"), ("<!", ">")];
        let Some((_, end)) = before.into_iter().find(|(start, _)| rest.starts_with(start)) else {
            break;
        };
        let Some((_, after)) = rest.split_once(end) else { return false };
        rest = after;
    }
    rest.strip_prefix("<svg").is_some_and(|after| after.starts_with([' ', '\n', '\r', '\t', '>']))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_figure_is_what_its_ending_says_by_its_first_bytes() {
        let is = |name: &str, bytes: &[u8]| is_what_it_says(Path::new(name), bytes);
        assert!(is("a.png", b"\x89PNG\r\n\x1a\nrest") && is("a.pdf", b"%PDF-1.7\n"));
        let svg = "\u{feff}<?xml version=\"1.0\"?>\n<!DOCTYPE svg PUBLIC \"x\" \"y\">\n<!-- a > b -->\n\
                   <svg width=\"1\"/>";
        assert!(is("a.svg", svg.as_bytes()) && is("a.svg", b"<svg>"));
        for (name, bytes) in [
            ("a.png", &b"%PDF-1.7"[..]),
            ("a.pdf", b"<svg>"),
            ("a.svg", b"<html><svg>"),
            ("a.svg", b"<svgs>"),
            ("a.svg", b"<!-- <svg>"),
            ("a.svg", b"\xff<svg>"),
            ("a.svg", b""),
        ] {
            assert!(!is(name, bytes), "{name}");
        }
    }
}
