//! From a key to its line, so that an error can say where.

use crate::StudyError;
use toml::de::{DeTable, DeValue};

/// The line (from 1) of the value at `path`, or of the nearest existing parent.
///
/// `path` is written as in error messages: `environments[1].wall_deg`. Text that is not TOML
/// gives line 1.
pub fn line_of(text: &str, path: &str) -> usize {
    let Ok(table) = DeTable::parse(text) else { return 1 };
    let mut offset = 0;
    let mut here = DeValue::Table(table.into_inner());
    for step in path.replace('[', ".").replace(']', "").split('.') {
        let next = match &here {
            DeValue::Table(t) => t.iter().find(|(k, _)| k.get_ref() == step).map(|(_, v)| v),
            DeValue::Array(a) => step.parse::<usize>().ok().and_then(|i| a.get(i)),
            _ => None,
        };
        // A key that is missing has no line: that of the table in which it is missed.
        let Some(next) = next else { break };
        offset = next.span().start;
        here = next.get_ref().clone();
    }
    line_at(text, offset)
}

/// The line (from 1) that holds byte `offset`.
pub(crate) fn line_at(text: &str, offset: usize) -> usize {
    1 + text.bytes().take(offset).filter(|b| *b == b'\n').count()
}

/// What the TOML reader found wrong in `text` (its grammar, an unknown key, a wrong type), with key
/// and line.
pub fn toml_error(text: &str, error: &toml::de::Error) -> StudyError {
    let line = error.span().map_or(1, |span| line_at(text, span.start));
    // The reader tells a place and no key: the line has it.
    let source = text.lines().nth(line - 1).unwrap_or_default();
    let key = source.split('=').next().unwrap_or_default().trim();
    let key = if key.is_empty() { "(file)" } else { key };
    // Some of the reader's messages say on a second line what was expected.
    let problem = error.message().lines().map(str::trim).collect::<Vec<_>>().join(", ");
    StudyError { line, key: key.to_owned(), problem }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "a = 1\n\n[[list]]\nx = 1\n\n[[list]]\nx = 2\ny = { z = 3 }\n";

    #[test]
    fn a_key_is_found_on_its_line() {
        assert_eq!(line_of(TEXT, "a"), 1);
        assert_eq!(line_of(TEXT, "list[0].x"), 4);
        assert_eq!(line_of(TEXT, "list[1].y.z"), 8);
    }

    #[test]
    fn a_missing_key_gives_the_line_of_its_table() {
        assert_eq!(line_of(TEXT, "list[1].nothing"), 6);
        assert_eq!(line_of("not toml", "a"), 1);
    }

    #[test]
    fn an_error_of_the_toml_reader_gets_its_key_and_line() {
        let error = toml::from_str::<std::collections::BTreeMap<String, u8>>("a = 1\nb = \"x\"\n")
            .unwrap_err();
        let found = toml_error("a = 1\nb = \"x\"\n", &error);
        assert_eq!((found.line, found.key.as_str()), (2, "b"));
        assert!(found.problem.contains("invalid type"), "{found}");
    }
}
