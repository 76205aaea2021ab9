//! `cargo xtask messages`: every text that a person can be told, with its file and line, so that
//! they can be read one after the other, as a stranger would read them.
//!
//! It finds them in the sources, without a compiler: a string is a message if it is within a call
//! that makes one (`bail!`, `StoreError::new`, `#[error]`, …), or follows a name for one (`what`,
//! `remedy`).

use crate::shell::files;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::{fs, io};

/// Calls whose texts people are told.
const CALLS: &str = "bail! anyhow! context with_context error warn say result StoreError::new Doubt::new \
                     Finding::new ParquetError::General Err ok_or ok_or_else refuse refused unable lost keep";
/// Names of texts that people are told.
const NAMES: [&str; 6] = ["what", "remedy", "problem", "about", "why", "words"];
/// Where the sources are.
const PLACES: [&str; 2] = ["crates", "pipelines"];

/// A text, and where it stands.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Message {
    pub(crate) path: PathBuf,
    pub(crate) line: usize,
    pub(crate) text: String,
}

/// Prints every message.
pub(crate) fn list(root: &Path) -> anyhow::Result<()> {
    for message in messages(root)? {
        println!("{}:{}: {}", message.path.display(), message.line, message.text);
    }
    Ok(())
}

/// Every message of the workspace at `root`, in the order of files and lines.
pub(crate) fn messages(root: &Path) -> io::Result<Vec<Message>> {
    let mut paths = Vec::new();
    for place in PLACES {
        paths.extend(files(&root.join(place))?);
    }
    paths.sort();
    let mut found = Vec::new();
    for path in paths {
        let shown = path.strip_prefix(root).unwrap_or(&path).to_owned();
        if !is_source(&shown) {
            continue;
        }
        for (line, text) in told(without_tests(&fs::read_to_string(&path)?)) {
            found.push(Message { path: shown.clone(), line, text });
        }
    }
    Ok(found)
}

/// Whether it is a source, and not one of tests.
fn is_source(path: &Path) -> bool {
    let is_left_out =
        |part: &OsStr| ["tests", "benches", "target", "testing"].iter().any(|of| part == *of);
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    name.ends_with(".rs") && !name.ends_with("tests.rs") && !path.iter().any(is_left_out)
}

/// A source up to its module of tests, which is its last part.
fn without_tests(source: &str) -> &str {
    let tests = source.find("\n#[cfg(test)]\nmod ").filter(|at| source[*at..].contains('{'));
    tests.map_or(source, |at| &source[..at])
}

/// The messages of a source, with their lines.
fn told(source: &str) -> Vec<(usize, String)> {
    let mut found = Vec::new();
    let mut open: Vec<String> = Vec::new();
    let mut rest = source;
    while let Some(first) = rest.chars().next() {
        let at = source.len() - rest.len();
        let before = &source[..at];
        let taken = if rest.starts_with("//") {
            rest.find('\n').unwrap_or(rest.len())
        } else if let Some((length, text)) = string(rest) {
            if open.iter().any(|call| is_call(call)) || is_named(before) {
                found.push((before.matches('\n').count() + 1, text));
            }
            length
        } else if let Some(length) = character(rest) {
            length
        } else {
            match first {
                '(' | '[' | '{' => open.push(word(before).to_owned()),
                ')' | ']' | '}' => _ = open.pop(),
                _ => {}
            }
            first.len_utf8()
        };
        rest = &rest[taken..];
    }
    found
}

/// The word that a text ends with: `StoreError::new`, `bail!`, or a method's name.
fn word(text: &str) -> &str {
    let is_part = |c: char| c.is_alphanumeric() || "_!:".contains(c);
    let from = text.char_indices().rev().take_while(|(_, c)| is_part(*c)).last();
    let found = from.map_or("", |(at, _)| &text[at..]);
    // An enumeration's own path says nothing: `Self::Err`.
    if is_call(found) { found } else { found.rsplit("Self::").next().unwrap_or(found) }
}

fn is_call(word: &str) -> bool {
    CALLS.split(' ').any(|call| call == word)
}

/// Whether a text ends with a name for a message, as `let what =` and `remedy:` do; what makes a
/// string of it may stand between.
fn is_named(text: &str) -> bool {
    let text = text.trim_end();
    let text = text.strip_suffix("format!(").unwrap_or(text).trim_end();
    let Some(text) = text.strip_suffix(['=', ':']) else { return false };
    NAMES.contains(&word(text.trim_end()))
}

/// The string that a text begins with: its length in the source, and what it says on one line.
fn string(text: &str) -> Option<(usize, String)> {
    let raw = text.strip_prefix('r').map(|rest| rest.len() - rest.trim_start_matches('#').len());
    if let Some(hashes) = raw.filter(|hashes| text[1 + hashes..].starts_with('"')) {
        let from = 2 + hashes;
        let end = text[from..].find(&format!("\"{}", "#".repeat(hashes)))?;
        return Some((from + end + 1 + hashes, text[from..from + end].to_owned()));
    }
    let inner = text.strip_prefix('"')?;
    let mut is_escaped = false;
    let end = inner.find(|c| {
        let ends = c == '"' && !is_escaped;
        is_escaped = c == '\\' && !is_escaped;
        ends
    })?;
    let lines: Vec<&str> = inner[..end].split("\\\n").collect();
    let lines =
        lines.iter().enumerate().map(|(i, line)| if i == 0 { line } else { line.trim_start() });
    Some((end + 2, lines.collect()))
}

/// The length of the character in quotes that a text begins with; a lifetime is none.
fn character(text: &str) -> Option<usize> {
    let inner = text.strip_prefix('\'')?;
    let mut chars = inner.char_indices();
    let (_, first) = chars.next()?;
    if first == '\\' {
        chars.next()?;
        return chars.find(|(_, c)| *c == '\'').map(|(at, _)| at + 2);
    }
    chars.next().filter(|(_, c)| *c == '\'').map(|(at, _)| at + 2)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Words of the program's inside, and ways of saying things that no stranger understands.
    const INSIDE: [&str; 13] = [
        "footer key",
        "has no state",
        "is none",
        "none of its",
        "none that",
        "has no meaning",
        "laid down",
        "passed by",
        "is another than",
        "not written over another",
        "is no number",
        "is no text",
        " a second ",
    ];

    fn workspace() -> &'static Path {
        Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap()
    }

    fn texts(source: &str) -> Vec<String> {
        told(without_tests(source)).into_iter().map(|(_, text)| text).collect()
    }

    #[test]
    fn texts_of_calls_that_tell_people_are_found_and_no_others() {
        let source = r##"
            // bail!("a comment")
            #[error("{path} is missing")]
            fn f<'a>(x: &'a str) -> char {
                let what = format!("it has {n} \"bytes\"");
                let key = "not told";
                if x == '"'.to_string() { bail!("one \
                    line of {}", g("within")); }
                read(x).with_context(|| format!(r#"cannot "read""#))?;
                Error { what: "odd".to_owned(), name: "not told" };
                '\''
            }

#[cfg(test)]
mod tests {
    fn f() { bail!("of a test") }
}
"##;
        assert_eq!(
            texts(source),
            [
                "{path} is missing",
                "it has {n} \\\"bytes\\\"",
                "one line of {}",
                "within",
                "cannot \"read\"",
                "odd"
            ]
        );
    }

    #[test]
    fn a_message_has_the_line_on_which_it_begins() {
        assert_eq!(told("a\nbail!(\n    \"b\"\n)"), [(3, "b".to_owned())]);
    }

    #[test]
    fn no_message_has_a_word_of_the_programs_inside() {
        let messages = messages(workspace()).unwrap();
        assert!(messages.len() > 500, "only {} messages: were they found?", messages.len());
        let odd = |message: &&Message| INSIDE.iter().any(|word| message.text.contains(word));
        let found: Vec<String> = messages
            .iter()
            .filter(odd)
            .map(|m| format!("{}:{}: {}", m.path.display(), m.line, m.text))
            .collect();
        assert!(found.is_empty(), "{}", found.join("\n"));
    }
}
