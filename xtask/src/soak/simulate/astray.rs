//! A life on a disk that misdirects a sector: one sector of a write of the session lands at another
//! place of the same file, or in another file, and its own place stays as it was.
//!
//! Every file that then differs from what was written must be found: by the life itself, which ends
//! with an error, by `recover` or by `verify`, each of which names the file. Nothing damaged counts
//! as a trial, and no trial that was reported as recorded disappears without a message.

use super::life::{BEGIN, Desk};
use super::world::{Draw, Trouble};
use anyhow::{Context as _, bail, ensure};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use zwidth_store::{
    Files as _, Signal, StudyData, hex_blake3, read_trial_from, recover, verify_kept,
};
use zwidth_study::{Event, Study};

/// A sector goes astray of one of so many writes: those of a whole session.
const MOST_WRITES: u64 = 90;

impl Desk {
    /// One such life after `lives` others; how it is counted. The error is damage of which nothing
    /// was told.
    pub(super) fn astray(&mut self, lives: u64) -> anyhow::Result<&'static str> {
        let mut draw = Draw::new(self.seed, 40);
        self.disk.misdirect_in(draw.below(MOST_WRITES), draw.below(1 << 32));
        let (outcome, _) = self.life(lives, &Trouble::none(), true)?;
        if outcome.is_ok() && self.disk.damaged().is_empty() {
            self.settle()?;
            return Ok("a sector astray that was written over or free, or none");
        }
        let layout = self.plan.layout.clone();
        let mut named = BTreeSet::new();
        for found in recover(&self.disk, &layout, BEGIN) {
            named.insert(found.map_or_else(|error| error.path, |recovered| recovered.path));
        }
        named.extend(verify_kept(&self.disk, &layout).into_iter().map(|finding| finding.path));
        let damaged = self.disk.damaged();
        if let Some(path) = damaged.iter().find(|path| !self.is_told(path, &named)) {
            bail!("{} is damaged, and nothing says so", path.display());
        }
        for (path, hash) in self.recorded()? {
            let is_there = self.disk.read(&path, u64::MAX).is_ok_and(|b| hex_blake3(&b) == hash);
            let log = layout.events(&self.plan.participant, &self.plan.session);
            let is_found = is_there || self.is_told(&path, &named) || named.contains(&log);
            ensure!(is_found, "{} is gone or changed, and nothing says so", path.display());
        }
        if let Ok(data) = StudyData::load_from(&self.disk, &layout)
            && let Some(trial) = data.counting().find(|t| damaged.contains(&t.path.to_path_buf()))
        {
            bail!("{} is damaged and counts", trial.path.display());
        }
        Ok("a sector astray that was found")
    }

    /// Whether somebody is told of a damaged file, or is told when it is needed.
    fn is_told(&self, path: &Path, named: &BTreeSet<PathBuf>) -> bool {
        let text = |bytes: Vec<u8>| String::from_utf8_lossy(&bytes).into_owned();
        let zwidth_acquire::Plan { layout, participant, session, keys, .. } = &self.plan;
        if path == layout.study_toml() {
            // What differs in comments alone is no damage to a study.
            let [is, was] = [self.disk.read(path, u64::MAX).ok(), self.disk.meant(path)]
                .map(|bytes| Study::from_toml(&text(bytes.unwrap_or_default())).ok());
            return named.contains(path) || is == was;
        }
        // Of a session's own files the first that is damaged is told, and the session is left out.
        let log = layout.events(participant, session);
        let head = log.with_extension("head");
        let own = [
            layout.session(participant, session),
            layout.study_copy(participant, session),
            log,
            head,
        ];
        let is_own_told = own.iter().any(|path| named.contains(path));
        // The hash of a trial's whole file is in the log. Without that its values, which have digests
        // of their own, are still checked; the indexes of its pages, which no reader of ours uses, are
        // not.
        let trials = layout.trial(participant, session, 1).parent().map(Path::to_owned);
        let waits = trials.is_some_and(|trials| path.starts_with(trials))
            && read_trial_from(&self.disk, path, Signal::all()).is_ok();
        // Seals are held against the commitment when they are opened, and the seed of an order that
        // was drawn is in no result.
        named.contains(path)
            || (waits || own.iter().any(|own| own == path)) && is_own_told
            || path.starts_with(keys)
    }

    /// The trials that the log called recorded when it was written, with their hashes, and those
    /// that were finished in lives before.
    fn recorded(&self) -> anyhow::Result<Vec<(PathBuf, String)>> {
        let zwidth_acquire::Plan { layout, participant, session, .. } = &self.plan;
        let log = self.disk.meant(&layout.events(participant, session)).unwrap_or_default();
        let mut recorded: Vec<_> =
            self.finished.iter().map(|(path, hash)| (path.clone(), hash.clone())).collect();
        for line in String::from_utf8_lossy(&log).lines() {
            let line: serde_json::Value =
                serde_json::from_str(line).context("a line of the log")?;
            let event: Event =
                serde_json::from_value(line["what"].clone()).context("an event of the log")?;
            if let Event::Recorded { trial, blake3 } = event {
                recorded.push((layout.trial(participant, session, trial), blake3));
            }
        }
        Ok(recorded)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::soak::simulate::With;

    /// What a reader without checks would take: bytes of the right length that nobody wrote there.
    #[test]
    fn sectors_go_astray_in_files_of_every_kind_at_their_full_length_and_are_found() {
        let mut kinds = BTreeSet::new();
        for seed in 0..120 {
            let mut desk = Desk::new(With::Mock, seed).unwrap();
            let word = desk.astray(0).unwrap_or_else(|why| panic!("seed {seed}: {why:#}"));
            if word != "a sector astray that was found" {
                continue;
            }
            for path in desk.disk.damaged() {
                let is = desk.disk.read(&path, u64::MAX).unwrap();
                assert_eq!(is.len(), desk.disk.meant(&path).unwrap().len());
                assert_ne!(Some(is), desk.disk.meant(&path));
                kinds.insert(path.extension().map(std::ffi::OsStr::to_owned));
            }
        }
        for kind in ["parquet", "jsonl", "json", "toml"] {
            assert!(kinds.contains(&Some(kind.into())), "{kind}: {kinds:?}");
        }
    }
}
