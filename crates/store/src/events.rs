//! The event log of a session: one JSON object a line, chained by checksums, only ever appended to.

use crate::{Files, StoreError, hex_blake3};
use serde::{Deserialize, Serialize};
use std::path::Path;
use zwidth_study::Event;

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Line {
    /// When it was written, UTC, RFC 3339.
    utc: String,
    #[serde(rename = "what")]
    event: Event,
    /// BLAKE3 over the previous line's digest, the time and the event: a changed or missing line shows.
    blake3: String,
}

fn digest(previous: &str, utc: &str, event: &Event) -> Result<String, serde_json::Error> {
    Ok(hex_blake3(format!("{previous}\n{utc}\n{}", serde_json::to_string(event)?).as_bytes()))
}

/// Appends events, all or none, in one synced write. `utc` is the time in RFC 3339.
pub fn append_events(files: &dyn Files, path: &Path, utc: &str, events: &[Event]) -> Result<(), StoreError> {
    let mut previous = if path.exists() { read_lines(path)?.pop().map(|l| l.blake3) } else { None };
    let mut text = String::new();
    for event in events {
        let chained = digest(previous.as_deref().unwrap_or_default(), utc, event);
        let blake3 = chained.map_err(|e| StoreError::new(path, e.to_string(), "please report this"))?;
        let line = Line { utc: utc.to_owned(), event: event.clone(), blake3: blake3.clone() };
        let json = serde_json::to_string(&line);
        text += &json.map_err(|e| StoreError::new(path, e.to_string(), "please report this"))?;
        text.push('\n');
        previous = Some(blake3);
    }
    let folder = path.parent().unwrap_or_else(|| Path::new("."));
    files
        .create_folders(folder)
        .and_then(|()| files.append_synced(path, text.as_bytes()))
        .map_err(|e| StoreError::io(path, "append to", &e))
}

/// The events of a log, in order. A missing log has none.
///
/// # Errors
/// A line that is not JSON, an unknown event, or a checksum that does not follow from the line before.
pub fn read_events(path: &Path) -> Result<Vec<Event>, StoreError> {
    if !path.exists() {
        return Ok(Vec::new());
    }
    Ok(read_lines(path)?.into_iter().map(|line| line.event).collect())
}

fn read_lines(path: &Path) -> Result<Vec<Line>, StoreError> {
    let text = std::fs::read_to_string(path).map_err(|e| StoreError::io(path, "read", &e))?;
    let mut previous = String::new();
    let mut lines = Vec::new();
    for (row, json) in text.lines().enumerate() {
        let error = |what: String| {
            let remedy = "restore the log from a copy; if its last line was cut by a crash, remove that line";
            StoreError::new(path, what, remedy).row0(row)
        };
        let line: Line =
            serde_json::from_str(json).map_err(|e| error(format!("not a readable event: {e}")))?;
        let expected = digest(&previous, &line.utc, &line.event).map_err(|e| error(e.to_string()))?;
        if line.blake3 != expected {
            return Err(error("the checksum does not match: a line was changed or is missing".to_owned()));
        }
        previous.clone_from(&line.blake3);
        lines.push(line);
    }
    Ok(lines)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::RealFiles;
    use std::fs;

    const UTC: &str = "2026-01-01T00:00:00Z";

    fn log(folder: &Path) -> std::path::PathBuf {
        let path = folder.join("P01_S01.events.jsonl");
        let excluded = Event::Excluded { trial: 2, reason: "the phone rang".into() };
        append_events(&RealFiles, &path, UTC, &[Event::Superseded { trial: 1, by: 7 }, excluded]).unwrap();
        append_events(&RealFiles, &path, UTC, &[Event::Unsealed]).unwrap();
        path
    }

    #[test]
    fn events_come_back_in_order() {
        let folder = tempfile::tempdir().unwrap();
        let events = read_events(&log(folder.path())).unwrap();
        assert_eq!(events.len(), 3);
        assert_eq!(events[2], Event::Unsealed);
    }

    #[test]
    fn a_changed_a_missing_and_a_cut_line_are_noticed() {
        let folder = tempfile::tempdir().unwrap();
        let path = log(folder.path());
        let text = fs::read_to_string(&path).unwrap();
        let second_missing =
            text.lines().enumerate().filter(|(i, _)| *i != 1).map(|(_, l)| l).collect::<Vec<_>>();
        for (bad, row) in [
            (text.replace("phone", "clock"), 2),
            (second_missing.join("\n"), 2),
            (text[..text.len() - 9].to_owned(), 3),
        ] {
            fs::write(&path, bad).unwrap();
            assert_eq!(read_events(&path).unwrap_err().row, Some(row));
        }
    }

    #[test]
    fn a_missing_log_has_no_events() {
        assert_eq!(read_events(Path::new("/nonexistent/x.jsonl")), Ok(vec![]));
    }
}
