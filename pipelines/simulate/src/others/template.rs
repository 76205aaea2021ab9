//! Texts whose lines depend on what a scene has.
//!
//! A line of a template is `parts|text`: the text is written if the scene has all of the parts
//! named before the bar, and lacks those with a `!`. `@name@` in the text is a value of the scene.

use super::parts::Parts;

/// The lines of a template that a scene asks for, with its values.
pub(super) fn filled(template: &str, parts: &Parts) -> String {
    let mut text = String::new();
    for line in template.lines().filter(|line| !line.trim().is_empty()) {
        let (asked, rest) = line.split_once('|').unwrap_or_default();
        if holds_all(asked, parts) {
            text.push_str(&with_values(rest, parts));
            text.push('\n');
        }
    }
    text
}

/// Whether a scene has all parts that are asked for, and lacks those with a `!`.
pub(super) fn holds_all(asked: &str, parts: &Parts) -> bool {
    asked.split_whitespace().all(|part| match part.strip_prefix('!') {
        Some(part) => !parts.has(part),
        None => parts.has(part),
    })
}

/// In one pass, so that a value that looks like a name is not taken for one.
fn with_values(line: &str, parts: &Parts) -> String {
    let mut text = String::new();
    let mut rest = line;
    while let Some((before, after)) = rest.split_once('@') {
        text.push_str(before);
        match after.split_once('@').and_then(|(name, end)| Some((parts.value(name)?, end))) {
            Some((value, end)) => {
                text.push_str(value);
                rest = end;
            }
            None => {
                text.push('@');
                rest = after;
            }
        }
    }
    text + rest
}
