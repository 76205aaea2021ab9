//! The trade of a study's setup: its trials on the simulated device with another loop or other
//! sensors.

use super::super::device::{Bench, bench};
use super::super::output::Output;
use crate::devices::twin;
use crate::text::read_beside;
use anyhow::anyhow;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use zwidth_device::{Device as _, Twin};
use zwidth_plan::{OtherSetups, Rehearsal, rehearsal, rehearsed, rehearsed_trials};
use zwidth_runner::JobError;
use zwidth_store::StudyData;
use zwidth_study::{ParticipantId, SessionId, Source};
use zwidth_trade::{VERSION, twin_summary_table, twin_table};

/// What the files are called.
pub(super) const STEM: &str = "trade_twin";
/// What simulated people are drawn from where no session says what its own were.
const SEED: u64 = 1;

/// A study whose trials are simulated again.
pub(super) struct Study {
    pub(super) data: StudyData,
    pub(super) folder: PathBuf,
    /// Its name, for messages.
    pub(super) name: String,
}

impl Study {
    /// How many trials are simulated.
    pub(super) fn trials(&self) -> usize {
        rehearsed_trials(&self.data)
    }

    /// The seed of a session's simulated person: its own, where it was simulated, so that the
    /// intents are those of its recordings.
    fn seed(&self, participant: &ParticipantId, session: &SessionId) -> u64 {
        let records = self.data.sessions.iter().map(|session| &session.record);
        let mut own = records.filter(|r| r.participant == *participant && r.session == *session);
        own.next().and_then(|record| record.seed).unwrap_or(SEED)
    }
}

/// The files that were written, none where nothing changed, and what they say in sentences; of a
/// scene also its yardstick and what is recommended.
#[derive(Default)]
pub(super) struct Written {
    pub(super) files: Vec<PathBuf>,
    pub(super) lines: Vec<String>,
    pub(super) yardstick: Option<&'static str>,
    pub(super) recommended: Option<String>,
}

/// Whether the files of this name were made from this key.
pub(super) fn is_made(folder: &Path, name: &str, key: &str) -> bool {
    // The key alone is not enough: somebody may have removed the figures.
    let is_there = folder.join(format!("{name}.png")).exists();
    is_there
        && read_beside(&folder.join(format!("{name}.json")))
            .is_ok_and(|previous| previous.is_some_and(|previous| previous == key))
}

/// Simulates a study's trials at every setup, unless nothing changed since; none where no condition
/// has an angle and a force.
pub(super) fn setups(
    root: &Path,
    study: &Study,
    fresh: bool,
    progress: &(dyn Fn() + Sync),
) -> anyhow::Result<Option<Written>> {
    let Some(rehearsal) = rehearsal(&study.data) else { return Ok(None) };
    let bench = bench(root, study.data.layout.study().clone(), None)?;
    let twin_of = |participant: &ParticipantId, session: &SessionId| -> Result<Twin, JobError> {
        let seed = study.seed(participant, session);
        Ok(twin(&bench, seed, participant, session, false)?)
    };
    let key = key(study, &rehearsal, &bench, &twin_of)?;
    if !fresh && is_made(&study.folder, STEM, &key) {
        return Ok(Some(Written::default()));
    }
    let setups =
        rehearsed(&study.data, &twin_of, progress).map_err(|e| anyhow!("{}: {e}", study.name))?;
    let Some(setups) = setups else { return Ok(None) };
    let table = twin_table(&setups.shifts)?;
    let made_from = [("study", study.name.clone()), ("source", "twin, not measured".to_owned())];
    let mut output = Output::new(&study.folder, made_from);
    output.table(STEM, &table)?;
    let short = twin_summary_table(&setups.summary, &setups.stops)?;
    output.table(&format!("{STEM}.summary"), &short)?;
    let lines = words(&setups);
    let shifts = std::iter::once(Ok(setups.shifts));
    let figure = zwidth_figures::less(table.title(), table.notes(), shifts, &[Source::Twin])?;
    output.figure(STEM, figure)?;
    // Last: a run that is cut off before leaves no key, and is done again.
    output.text(STEM, "json", &key)?;
    Ok(Some(Written { files: output.files, lines, ..Written::default() }))
}

/// All that its files depend on, as text.
fn key(
    study: &Study,
    rehearsal: &Rehearsal,
    bench: &Bench,
    twin_of: &dyn Fn(&ParticipantId, &SessionId) -> Result<Twin, JobError>,
) -> anyhow::Result<String> {
    let sessions = study.data.sessions.iter().map(|session| &session.record);
    let seeds: BTreeSet<String> = sessions
        .clone()
        .map(|r| {
            format!("{} {} {}", r.participant, r.session, study.seed(&r.participant, &r.session))
        })
        .collect();
    let device = sessions.take(1).find_map(|r| twin_of(&r.participant, &r.session).ok());
    let key = serde_json::json!({
        "version": [VERSION, zwidth_figures::VERSION],
        "software": env!("CARGO_PKG_VERSION"),
        "device": device.map(|twin| twin.capabilities().name.clone()),
        "twin": bench.twin,
        "study": String::from_utf8_lossy(&bench.study_toml),
        "calibrations": study.data.sessions.iter().map(|s| &s.record.calibration).collect::<Vec<_>>(),
        "seeds": seeds,
        "asked": rehearsal,
    });
    Ok(format!("{key:#}\n"))
}

/// One line per setup: what it changes most; and why safety stopped trials.
fn words(setups: &OtherSetups) -> Vec<String> {
    let lines = setups.summary.iter().map(|row| {
        let most = row.metric.as_ref().zip(row.median_share);
        let most = most.map_or(String::new(), |(metric, share)| {
            format!("; {metric} most, by {share:.1} times what is just felt in the median trial")
        });
        let stopped = match row.stopped {
            0 => String::new(),
            n => format!("; safety stops {n} trials"),
        };
        format!(
            "{}: {} of {} metrics change by more than is just felt{most}{stopped}.",
            row.setup, row.felt, row.metrics
        )
    });
    let stops = setups.stops.iter().map(|stop| stop.why.clone());
    lines.chain(stops).collect()
}
