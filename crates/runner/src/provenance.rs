//! What a file says about its origin: the entries for its footer or metadata, and the one word that
//! identifies its job.

use crate::record::Record;
use std::collections::{BTreeMap, BTreeSet};
use zwidth_store::hex_blake3;

/// Where a result comes from, for the footer of a table or the metadata of a figure: `job`,
/// `stage`, `algorithm_version`, `parameters`, `input <path>` with the hash of each input, and
/// [`ORIGIN`]. No time and no path of the machine is in it, so that the same inputs give the same
/// bytes.
pub type Provenance = BTreeMap<String, String>;

/// The key of the file's origin: `zwidth:<stage>:<version>:<BLAKE3 of all other entries>`.
pub const ORIGIN: &str = "origin";

/// What an origin begins with.
const PREFIX: &str = "zwidth:";
/// Hexadecimal digits of a BLAKE3 hash.
const DIGITS: usize = 64;

/// The provenance of what the job of that name makes.
pub(crate) fn provenance(name: &str, record: &Record) -> Provenance {
    let inputs = record.inputs.iter().map(|(path, hash)| (input_key(path), hash.clone()));
    let own = [
        ("job".to_owned(), name.to_owned()),
        ("stage".to_owned(), record.stage.clone()),
        ("algorithm_version".to_owned(), record.version.to_string()),
        ("parameters".to_owned(), record.parameters.clone()),
        (ORIGIN.to_owned(), record.origin.clone()),
    ];
    own.into_iter().chain(inputs).collect()
}

/// The key of an input's hash.
pub(crate) fn input_key(path: &str) -> String {
    format!("input {path}")
}

/// The origin of what the job of that name makes; the record's own origin and outputs are left out
/// of the digest.
pub(crate) fn origin(name: &str, record: &Record) -> String {
    let mut entries = provenance(name, record);
    entries.remove(ORIGIN);
    let mut text = String::new();
    for (key, value) in entries {
        // Lengths first: no value can pass for the end of its entry.
        text += &format!("{} {} {key} {value}\n", key.len(), value.len());
    }
    format!("{PREFIX}{}:{}:{}", record.stage, record.version, hex_blake3(text.as_bytes()))
}

/// Every origin in a file of any format (SVG, PDF, PNG, Parquet, comments of tables), each once, in
/// order.
pub fn origins(bytes: &[u8]) -> Vec<String> {
    let mut seen = BTreeSet::new();
    let starts = bytes.windows(PREFIX.len()).enumerate().filter(|(_, w)| *w == PREFIX.as_bytes());
    let all = starts.filter_map(|(at, _)| leading_origin(&bytes[at..]));
    all.filter(|origin| seen.insert(origin.clone())).collect()
}

/// The origin that stands at the beginning of `bytes`, if one does.
fn leading_origin(bytes: &[u8]) -> Option<String> {
    let mut end = PREFIX.len();
    for is_part in [u8::is_ascii_lowercase, u8::is_ascii_digit] {
        let part = bytes.get(end..)?.iter().take_while(|byte| is_part(byte)).count();
        end += part;
        (part > 0 && bytes.get(end) == Some(&b':')).then_some(())?;
        end += 1;
    }
    let digest = bytes.get(end..end + DIGITS)?;
    digest.iter().all(u8::is_ascii_hexdigit).then_some(())?;
    String::from_utf8(bytes[..end + DIGITS].to_vec()).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn record() -> Record {
        Record {
            stage: "figures".to_owned(),
            version: 3,
            parameters: "p".to_owned(),
            inputs: [("a".to_owned(), "1".to_owned())].into(),
            ..Record::default()
        }
    }

    #[test]
    fn an_origin_tells_stage_and_version_and_depends_on_everything_that_the_outputs_do() {
        let before = origin("job", &record());
        assert!(before.starts_with("zwidth:figures:3:") && before.len() == 17 + 64, "{before}");
        assert_eq!(
            origin("job", &Record { origin: before.clone(), ..record() }),
            before,
            "but not on itself"
        );
        let changed = [
            Record { parameters: "q".to_owned(), ..record() },
            Record { inputs: [("a".to_owned(), "2".to_owned())].into(), ..record() },
            Record { inputs: [("b".to_owned(), "1".to_owned())].into(), ..record() },
            Record { inputs: BTreeMap::new(), ..record() },
        ];
        assert!(changed.iter().all(|r| origin("job", r) != before));
        assert_ne!(origin("other job", &record()), before);
    }

    #[test]
    fn origins_are_found_between_any_bytes_and_nothing_else_is_taken_for_one() {
        let digest = "0123456789abcdef".repeat(4);
        let whole = format!("zwidth:tables:12:{digest}");
        let text = format!(
            "\u{0}zwidth:zwidth:{whole}--{whole} zwidth:Tables:1:{digest} zwidth:tables::{digest}"
        );
        assert_eq!(origins(text.as_bytes()), std::slice::from_ref(&whole));
        assert!(origins(&whole.as_bytes()[..whole.len() - 1]).is_empty());
        assert!(origins(b"zwidth:").is_empty() && origins(b"").is_empty());
    }
}
