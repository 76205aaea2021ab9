//! The footer of a trial's file, read strictly.

use crate::disk::regular::open_end;
use crate::disk::stamp::Stamp;
use crate::form::json::from_json;
use crate::form::opened::{DAMAGED, ParquetFile, opened_before, version};
use crate::form::seen::{Seen, Signals};
use crate::form::write::{CHANNELS, DIGEST, FOOTER_DIGEST, VERSION};
use crate::{Files, MOST_RECORDING, RealFiles, Signal, StoreError, TrialFile};
use std::collections::BTreeMap;
use std::path::Path;
use std::str::FromStr;
use zwidth_study::{
    AnswerScale, Channel, IdError, Kind, MOST_CHANNELS, Presented, Schema, Source, Status,
    TaskLevel, TrialForm, TrialMeta,
};

/// What a trial file says about itself, without its samples.
#[derive(Debug, Clone, PartialEq)]
pub struct TrialFooter {
    /// The trial's metadata.
    pub meta: TrialMeta,
    /// The remaining footer keys.
    pub file: TrialFile,
    /// Which columns the file has.
    pub form: TrialForm,
    /// The signals that were recorded, in file order.
    pub signals: Vec<Signal>,
    /// Number of samples.
    pub rows: usize,
    /// BLAKE3 of the whole file, hexadecimal.
    pub blake3: String,
}

/// Reads what a trial file says about itself, without its samples. Participant and session come
/// from the path.
pub fn read_footer(path: &Path) -> Result<TrialFooter, StoreError> {
    read_footer_from(&RealFiles, path)
}

pub(crate) fn read_footer_from(files: &dyn Files, path: &Path) -> Result<TrialFooter, StoreError> {
    let opened = ParquetFile::open_recording(files, path)?;
    let blake3 = opened.blake3()?;
    footer_of(path, &opened.footer, opened.rows, blake3)
}

/// The same of the real disk, where the hash of a file that was seen before is known: of that the
/// end alone is read.
pub(crate) fn read_footer_seen(seen: &Seen, path: &Path) -> Result<TrialFooter, StoreError> {
    if let Some(blake3) = seen.unchanged_hash(path) {
        let content = open_end(path, MOST_RECORDING);
        let content = content.map_err(|e| StoreError::io(path, "read", &e))?;
        let (footer, rows) = opened_before(path, &content)?;
        return footer_of(path, &footer, rows, blake3);
    }
    let begun = Stamp::settled(path);
    let footer = read_footer(path)?;
    seen.read(path, begun, &footer.blake3);
    Ok(footer)
}

fn footer_of(
    path: &Path,
    footer: &BTreeMap<String, String>,
    rows: usize,
    blake3: String,
) -> Result<TrialFooter, StoreError> {
    let form = form_of(path, footer)?;
    let recorded = recorded(footer);
    let signals = Signal::all().filter(|signal| recorded.has(Signals::of(&[*signal]))).collect();
    let meta = meta_from(path, footer, &form)?;
    let file = rest_of(footer, &OF_TRIAL);
    Ok(TrialFooter { meta, file, form, signals, rows, blake3 })
}

/// The signals that a file has: a column that is null throughout has no digest.
pub(crate) fn recorded(footer: &BTreeMap<String, String>) -> Signals {
    let from = footer.range(DIGEST.to_owned()..);
    let names = from.map_while(|(key, _)| key.strip_prefix(DIGEST));
    let signals = names.filter_map(|name| Signal::all().find(|s| s.column().name == name));
    Signals::of(&signals.collect::<Vec<_>>())
}

/// Which columns a trial's file has, by its footer.
pub(crate) fn form_of(
    path: &Path,
    footer: &BTreeMap<String, String>,
) -> Result<TrialForm, StoreError> {
    let schema = version(path, footer)?.ok_or_else(|| {
        let what = "its form is that of sweeps, or of trials of a version that was never released";
        StoreError::new(path, what, DAMAGED)
    })?;
    let channels: Result<Vec<Channel>, String> = match footer.get(CHANNELS) {
        Some(text) => from_json(text).map_err(|e| e.to_string()),
        None => Ok(Vec::new()),
    };
    let channels = channels.and_then(|channels| match channels.len() {
        n if n > MOST_CHANNELS => Err(format!("it has {n}, and at most {MOST_CHANNELS} are read")),
        _ => Ok(channels),
    });
    let channels = channels.map_err(|why| {
        let what = format!("its metadata '{CHANNELS}' do not list channels: {why}");
        StoreError::new(path, what, DAMAGED)
    })?;
    Ok(TrialForm { schema, likert: footer.contains_key("likert"), channels })
}

/// The trial's metadata in a footer.
pub(crate) fn meta_from(
    path: &Path,
    footer: &BTreeMap<String, String>,
    form: &TrialForm,
) -> Result<TrialMeta, StoreError> {
    let kind = required(path, footer, "kind", DAMAGED)?;
    let status = required(path, footer, "status", DAMAGED)?;
    let source = required(path, footer, "source", DAMAGED)?;
    let likert = if form.likert { required(path, footer, "likert", DAMAGED)? } else { "" };
    let environment = required(path, footer, "environment", DAMAGED)?;
    let mode = required(path, footer, "mode", DAMAGED)?;
    let [trial, repeat] = ["trial", "repeat"].map(|key| {
        let text = required(path, footer, key, DAMAGED)?;
        text.parse().map_err(|_| bad_value(path, key, text))
    });
    Ok(TrialMeta {
        participant: from_path(path, "participant")?,
        session: from_path(path, "session")?,
        trial: trial?,
        repeat: repeat?,
        kind: Kind::from_word(kind).ok_or_else(|| bad_value(path, "kind", kind))?,
        status: Status::from_word(status).ok_or_else(|| bad_value(path, "status", status))?,
        environment: environment
            .parse()
            .map_err(|_| bad_value(path, "environment", environment))?,
        mode: mode.parse().map_err(|_| bad_value(path, "mode", mode))?,
        // Which scale the question has, the footer does not say: the widest one holds.
        likert: match likert {
            "" => None,
            text => Some(
                text.parse()
                    .ok()
                    .filter(|v| (1..=i16::from(AnswerScale::most_points())).contains(v))
                    .ok_or_else(|| bad_value(path, "likert", text))?,
            ),
        },
        source: Source::from_word(source).ok_or_else(|| bad_value(path, "source", source))?,
        presented: presented(path, footer, form)?,
    })
}

/// What a trial of a task presented, by its footer.
fn presented(
    path: &Path,
    footer: &BTreeMap<String, String>,
    form: &TrialForm,
) -> Result<Option<Presented>, StoreError> {
    if form.schema < Schema::Three || !footer.contains_key("task") {
        return Ok(None);
    }
    let [task, interval, level] =
        ["task", "interval", "level"].map(|key| required(path, footer, key, DAMAGED));
    let (task, interval, level) = (task?, interval?, level?);
    // A level is the number that was written, and no other near it.
    let read = |text: &str| {
        let level = text.parse().ok().and_then(TaskLevel::nearest)?;
        (level.value().to_string() == text).then_some(level)
    };
    Ok(Some(Presented {
        task: task.parse().map_err(|_| bad_value(path, "task", task))?,
        interval: interval
            .parse()
            .ok()
            .filter(|interval| *interval > 0)
            .ok_or_else(|| bad_value(path, "interval", interval))?,
        level: match level {
            "" => None,
            text => Some(read(text).ok_or_else(|| bad_value(path, "level", text))?),
        },
    }))
}

/// The value of a key that a footer must have.
pub(crate) fn required<'f>(
    path: &Path,
    footer: &'f BTreeMap<String, String>,
    key: &str,
    remedy: &str,
) -> Result<&'f str, StoreError> {
    footer
        .get(key)
        .map(String::as_str)
        .ok_or_else(|| StoreError::new(path, format!("its metadata '{key}' are missing"), remedy))
}

fn bad_value(path: &Path, key: &str, value: &str) -> StoreError {
    StoreError::new(path, format!("its metadata '{key}' have the value '{value}'"), DAMAGED)
}

/// The keys of a footer that hold the trial's metadata.
pub(crate) const OF_TRIAL: [&str; 12] = [
    "trial",
    "repeat",
    "kind",
    "status",
    "environment",
    "mode",
    "likert",
    "source",
    "task",
    "interval",
    "level",
    CHANNELS,
];

/// The entries of a footer besides those of every file, and `own` ones.
pub(crate) fn rest_of(footer: &BTreeMap<String, String>, own: &[&str]) -> TrialFile {
    let rest = footer.iter().filter(|(key, _)| {
        let key = key.as_str();
        !key.starts_with(DIGEST)
            && ![VERSION, FOOTER_DIGEST, "units"].contains(&key)
            && !own.contains(&key)
    });
    rest.map(|(key, value)| (key.clone(), value.clone())).collect()
}

/// The id in a Hive partition folder (`key=value`) of a path.
pub(crate) fn from_path<T: FromStr<Err = IdError>>(
    path: &Path,
    key: &str,
) -> Result<T, StoreError> {
    let prefix = format!("{key}=");
    // The innermost counts: the data may themselves lie below such a folder.
    let mut parts = path.iter().rev().filter_map(|part| part.to_str());
    let id = parts.find_map(|part| part.strip_prefix(&prefix)).ok_or_else(|| {
        let what = format!("the path has no folder '{key}=…'");
        StoreError::new(path, what, "move the file to where the layout wants it")
    })?;
    id.parse().map_err(|e: IdError| StoreError::new(path, e.to_string(), "rename the folder"))
}

#[cfg(test)]
#[cfg(unix)]
mod tests {
    use super::*;
    use crate::form::codec::tests::said_to_be;
    use crate::form::read::tests::{with_other_entries, written};
    use parquet::basic::CompressionCodec;

    /// Nothing of a file that was hashed before is read but its end.
    #[test]
    fn a_footer_that_was_read_before_says_the_same_without_the_columns_being_looked_at() {
        let (_folder, _, path) = written();
        let footer = read_footer(&path).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        let changed = said_to_be(&bytes, CompressionCodec::BROTLI);
        for (bytes, seen_before) in [(&bytes, true), (&changed, true), (&changed, false)] {
            std::fs::write(&path, bytes).unwrap();
            let seen = Seen::default();
            if seen_before {
                seen.written(&path, &footer.blake3);
                assert_eq!(read_footer_seen(&seen, &path).unwrap(), footer);
            } else {
                assert!(read_footer_seen(&seen, &path).unwrap_err().what.contains("Brotli"));
            }
        }
        let other = with_other_entries(&bytes, |entries| {
            entries.insert("kind".to_owned(), "no kind".to_owned());
        });
        std::fs::write(&path, other).unwrap();
        let seen = Seen::default();
        seen.written(&path, &footer.blake3);
        assert!(read_footer_seen(&seen, &path).unwrap_err().what.contains("'kind'"));
    }
}
