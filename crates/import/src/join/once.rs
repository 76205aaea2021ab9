//! What recordings use of the files that are joined to them, and whether the rows of a log and the samples of second files are joined once, and all of them.

use super::super::errors::Errors;
use super::super::recording::Recording;
use super::super::table::NO_ROW;
use super::log::LogUse;
use super::second::SecondUse;
use super::times::lasts;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use zwidth_store::StoreError;

/// What was joined to a recording.
#[derive(Debug, Default)]
pub(crate) struct Uses {
    pub(super) log: Option<LogUse>,
    pub(super) seconds: Vec<SecondUse>,
}

impl Uses {
    /// What the file of a trial that begins with a row of the recording says of what was joined to it.
    pub(crate) fn words(&self, row: usize) -> Vec<String> {
        let log = self.log.as_ref().and_then(|log| log.words(row));
        log.into_iter().chain(self.seconds.iter().map(SecondUse::words)).collect()
    }

    /// Checks that no two trials of a recording, which begin with these rows, have one row of the log.
    ///
    /// # Errors
    /// Two have.
    pub(crate) fn check_begins(
        &self,
        recording: &Recording,
        begins: &[usize],
    ) -> Result<(), StoreError> {
        let Some(log) = &self.log else { return Ok(()) };
        let of = |begin: &usize| log.of.get(*begin).copied().unwrap_or(NO_ROW);
        let same =
            begins.windows(2).find(|pair| of(&pair[0]) != NO_ROW && of(&pair[0]) == of(&pair[1]));
        let Some([_, second]) = same else { return Ok(()) };
        let what = format!(
            "the trial has {} of the log {}, which is that of the trial before it too",
            log.log.row_name(of(second) as usize),
            log.log.path.display()
        );
        let remedy = "name in number of [log] what tells the trials of the recording apart, or leave it out: then they are counted";
        Err(recording.row_error(*second, &what, remedy))
    }
}

/// Checks what all recordings of an import use of their files; what is to be told of each recording, by its path.
///
/// # Errors
/// A row of a log without a trial, or of two; the same samples of a second file beside two recordings.
pub(crate) fn check<'a>(
    uses: impl Iterator<Item = (&'a Path, &'a Uses)> + Clone,
) -> Result<BTreeMap<PathBuf, String>, Errors> {
    let mut errors = Errors::default();
    let mut told = BTreeMap::new();
    let mut logs: BTreeMap<&Path, Vec<(&Path, &LogUse)>> = BTreeMap::new();
    for (recording, uses) in uses.clone() {
        if let Some(log) = &uses.log {
            logs.entry(&log.log.path).or_default().push((recording, log));
        }
    }
    for (path, uses) in logs {
        // A row may be that of a trial of any recording that sees it.
        let mut rows: BTreeMap<u32, (&str, Option<&Path>)> = BTreeMap::new();
        for (_, log) in &uses {
            for (row, words) in &log.rows {
                rows.entry(*row).or_insert((words, None));
            }
        }
        for (recording, log) in &uses {
            let mut last = NO_ROW;
            for row in log.of.iter().filter(|row| **row != NO_ROW) {
                // Rows of a trial stand together.
                if *row == last {
                    continue;
                }
                last = *row;
                let Some((words, taken)) = rows.get_mut(row) else { continue };
                if let Some(first) = taken.replace(recording) {
                    let what = format!(
                        "it is the row of two trials ({words}), in {} and in {}",
                        first.display(),
                        recording.display()
                    );
                    let remedy = "name in number of [log] what tells the trials of several recordings apart, or in `where` whose \
                                  row it is";
                    errors.push(log.log.row_error(*row as usize, &what, remedy));
                }
            }
        }
        let log = uses[0].1;
        let without: Vec<(u32, &str)> = rows
            .into_iter()
            .filter(|(_, (_, taken))| taken.is_none())
            .map(|(row, (words, _))| (row, words))
            .collect();
        if log.drops_unmatched && !without.is_empty() {
            let words = format!(
                "{} rows of the log {} have no trial (unmatched)",
                without.len(),
                path.display()
            );
            told.insert(uses[0].0.to_owned(), words);
            continue;
        }
        for (row, words) in without {
            let what = format!("no recording has the trial of this row ({words})");
            let remedy = "give its recording too, leave the row out by `when` in [log], or all such rows by unmatched = \"drop\"";
            errors.push(log.log.row_error(row as usize, &what, remedy));
        }
    }
    let mut seconds: Vec<(&Path, &SecondUse)> = Vec::new();
    for (recording, uses) in uses {
        seconds.extend(uses.seconds.iter().map(|second| (recording, second)));
    }
    seconds.sort_by(|(_, a), (_, b)| {
        (&a.blake3, a.span[0])
            .partial_cmp(&(&b.blake3, b.span[0]))
            .unwrap_or(std::cmp::Ordering::Equal)
    });
    for pair in seconds.windows(2) {
        let [(first, a), (second, b)] = [pair[0], pair[1]];
        if a.blake3 == b.blake3 && b.span[0] < a.span[1] {
            let what = format!(
                "its samples from {} are joined to two recordings, {} and {}",
                lasts([b.span[0], a.span[1].min(b.span[1])]),
                first.display(),
                second.display()
            );
            let remedy = "name in the path of the second file what tells the trials apart ({trial}), or join by times of one clock";
            errors.push(StoreError::new(&b.path, what, remedy));
        }
    }
    errors.none().map(|()| told)
}
