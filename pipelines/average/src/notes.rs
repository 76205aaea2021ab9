//! The notes of an average: where it ends, where repeats end, and how it is aligned.

use crate::{Average, LeftOut};
use zwidth_tables::NoteKind;

/// Which trials are not averaged, and why.
pub(crate) fn not_averaged(name: &str, trials: &[LeftOut]) -> impl Iterator<Item = String> {
    trials.iter().map(move |l| format!("{name}: trial {} is not averaged: {}.", l.trial, l.why))
}

impl Average {
    /// In words: where the average ends and where repeats drop out of it before, by which landmarks
    /// it is aligned, and which trials are not in it.
    pub fn notes(&self) -> Vec<(NoteKind, String)> {
        let name = format!(
            "{} {} {} {}",
            self.participant, self.session, self.condition.environment, self.condition.mode
        );
        let mut notes = Vec::new();
        notes.extend(self.end_note(&name).map(|note| (NoteKind::Extent, note)));
        if !self.landmarks.is_empty() {
            let times: Vec<_> =
                self.landmarks.iter().map(|(l, t)| format!("{l} {t:.3} s")).collect();
            let note = format!(
                "{name}: aligned by the landmarks that all of its repeats pass: {}.",
                times.join(", ")
            );
            notes.push((NoteKind::Alignment, note));
        }
        let left_out = not_averaged(&name, &self.left_out);
        notes.extend(left_out.map(|note| (NoteKind::General, note)));
        notes
    }

    fn end_note(&self, name: &str) -> Option<String> {
        let end = self.t_s.last().copied().unwrap_or(0.0);
        // Even if the longest repeat is in it to its end, others may drop out before.
        let longest = self.repeats.iter().map(|r| r.length_s).fold(0.0, f64::max);
        let drops = self.drops();
        if end >= longest && drops.is_empty() {
            return None;
        }
        let total = self.repeats.len();
        let why = match end < longest {
            true => format!("after that fewer than half of the {total} repeats remain"),
            false => "no repeat lasts longer".to_owned(),
        };
        let drops: Vec<_> = drops.iter().map(|(t, n)| format!("to {n} at {t:.3} s")).collect();
        let jumps = match drops.is_empty() {
            true => String::new(),
            false => format!(
                " The mean may jump where the number of repeats falls: {}.",
                drops.join(", ")
            ),
        };
        Some(format!("{name}: the average ends at {end:.3} s; {why}.{jumps}"))
    }

    /// The times of the grid from which on fewer repeats are averaged than before, and how many.
    pub fn drops(&self) -> Vec<(f64, usize)> {
        let pairs = self.n.windows(2).zip(self.t_s.iter().skip(1));
        pairs.filter(|(n, _)| n[1] < n[0]).map(|(n, t)| (*t, n[1])).collect()
    }
}
