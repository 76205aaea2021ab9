//! `zwidth list`: studies, sessions, trials, and what is missing.

use super::{join_findings, nameless, studies};
use crate::exit::Exit;
use crate::screen::Screen;
use rayon::prelude::*;
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::Path;
use zwidth_acquire::left_to_do;
use zwidth_store::{GAPS, JOINED, LOST, Layout, SessionLog, StudyData, TrialEntry};
use zwidth_study::{Channel, Kind, StudyId, counted};

#[derive(Serialize)]
struct Listing {
    study: String,
    title: String,
    /// Version of the form of its trial files.
    schema: u32,
    /// What is recorded per sample besides what every study records.
    channels: Vec<Channel>,
    sessions: Vec<Session>,
    sweeps: BTreeMap<String, usize>,
    /// How many trials have a value of each metric that another program computed.
    metrics: BTreeMap<String, usize>,
    unreadable: Vec<String>,
}

#[derive(Serialize)]
struct Session {
    participant: String,
    session: String,
    source: &'static str,
    /// Modes are codes, and nothing counts, until it is unsealed.
    sealed: bool,
    /// Those that nothing but a seal keeps from counting.
    trials: usize,
    trials_that_count: usize,
    familiarisation: usize,
    /// Trials of the order that are still to be done.
    to_go: usize,
    left_out: Vec<String>,
    /// What an import could not read of recordings.
    lost: Vec<String>,
    /// Samples that recordings lack between their first and their last.
    gaps: Vec<String>,
    /// Files that were joined to recordings, by their hashes.
    joined: Vec<String>,
    missing: Vec<String>,
}

pub(crate) fn list(root: &Path, study: Option<StudyId>, screen: &Screen) -> anyhow::Result<Exit> {
    let named: Vec<StudyId> = study.into_iter().collect();
    let nameless = nameless(root, &named);
    nameless.iter().for_each(|finding| screen.warn(finding.to_string()));
    let layouts = studies(root, named)?;
    let mut listings = Vec::new();
    let mut unreadable = !nameless.is_empty();
    for layout in &layouts {
        match listing(layout) {
            Ok(listing) => listings.push(listing),
            Err(error) if layouts.len() > 1 => {
                screen.error(&error);
                unreadable = true;
            }
            Err(error) => return Err(error),
        }
    }
    screen.give(&listings, || listings.iter().for_each(|l| screen.result(text(l))))?;
    let complete = !unreadable && listings.iter().all(|l| l.unreadable.is_empty());
    Ok(if complete { Exit::Fine } else { Exit::Partly })
}

fn listing(layout: &Layout) -> anyhow::Result<Listing> {
    let data = StudyData::load(layout).map_err(|findings| join_findings(&findings))?;
    let mut sweeps = BTreeMap::new();
    for sweep in &data.sweeps {
        *sweeps.entry(sweep.actuator.to_string()).or_default() += 1;
    }
    let trials = data.by_session();
    let sessions = data.sessions.par_iter().map(|log| {
        let id = (&log.record.participant, &log.record.session);
        session(&data, log, trials.get(&id).map_or(&[], Vec::as_slice))
    });
    let metrics = data.outside.iter().filter(|own| own.counts());
    Ok(Listing {
        study: layout.study().to_string(),
        title: data.study.title.clone(),
        schema: data.study.schema.number(),
        channels: data.study.channels.clone(),
        sessions: sessions.collect(),
        sweeps,
        metrics: metrics.map(|own| (own.metric.column.to_string(), own.rows)).collect(),
        unreadable: data.problems.iter().map(ToString::to_string).collect(),
    })
}

fn session(data: &StudyData, log: &SessionLog, trials: &[&TrialEntry]) -> Session {
    let sealed = log.is_sealed();
    // A sealed trial that nothing else keeps out will count.
    let counts = |t: &&&TrialEntry| t.why_left_out().is_none();
    let left_out = trials.iter().filter(|t| t.meta.kind == Kind::Trial && !counts(t));
    Session {
        participant: log.record.participant.to_string(),
        session: log.record.session.to_string(),
        source: log.record.source.as_str(),
        sealed,
        trials: trials.iter().filter(counts).count(),
        trials_that_count: trials.iter().filter(|t| t.counts()).count(),
        familiarisation: trials.iter().filter(|t| t.meta.kind == Kind::Familiarisation).count(),
        to_go: left_to_do(trials.iter().copied(), log, &data.study, None),
        left_out: left_out
            .filter_map(|t| Some(format!("trial {}: {}", t.meta.trial, t.why_not()?)))
            .collect(),
        lost: in_footers(trials, LOST),
        gaps: in_footers(trials, GAPS),
        joined: in_footers(trials, JOINED),
        // The conditions of a sealed session's trials are not known.
        missing: if sealed { Vec::new() } else { missing(data, trials) },
    }
}

/// What the files of trials say of themselves under a key of their footers.
fn in_footers(trials: &[&TrialEntry], key: &str) -> Vec<String> {
    trials
        .iter()
        .filter_map(|t| Some(format!("trial {}: {}", t.meta.trial, t.said.file.get(key)?)))
        .collect()
}

/// Conditions with fewer repeats than the design wants, for sessions that have samples at all.
fn missing(data: &StudyData, trials: &[&TrialEntry]) -> Vec<String> {
    let repeats = data.study.design.repeats as usize;
    // A session of answers alone lacks no trial.
    if trials.is_empty() {
        return Vec::new();
    }
    let mut lines = Vec::new();
    for c in data.study.conditions() {
        let n = trials.iter().filter(|t| t.counts() && t.meta.condition() == c).count();
        if n < repeats {
            lines.push(format!("{} × {}: {n} of {repeats}", c.environment, c.mode));
        }
    }
    lines
}

fn text(l: &Listing) -> String {
    let mut lines = vec![format!("{}  {}", l.study, l.title)];
    for s in &l.sessions {
        let masked = if s.sealed { ", sealed" } else { "" };
        lines.push(format!(
            "  {} {}  {} trials, {} familiarisation ({}{masked})",
            s.participant, s.session, s.trials, s.familiarisation, s.source
        ));
        let session = format!("{} -p {} -s {}", l.study, s.participant, s.session);
        if s.to_go > 0 {
            lines.push(format!(
                "    unfinished: {} trials to go; `zwidth acquire {session}`",
                s.to_go
            ));
        } else if s.sealed {
            lines.push(format!("    sealed: `zwidth unseal {session}`"));
        }
        lines.extend(s.left_out.iter().map(|t| format!("    left out: {t}")));
        lines.extend(s.lost.iter().map(|t| format!("    lost: {t}")));
        lines.extend(s.gaps.iter().map(|t| format!("    gaps: {t}")));
        lines.extend(s.joined.iter().map(|t| format!("    joined: {t}")));
        lines.extend(s.missing.iter().map(|t| format!("    missing: {t}")));
    }
    lines.extend(
        l.channels
            .iter()
            .map(|c| format!("  channel {} ({}): {}", c.id.as_str(), c.unit, c.description)),
    );
    lines.extend(l.sweeps.iter().map(|(actuator, n)| format!("  {actuator}  {n} sweeps")));
    lines.extend(l.metrics.iter().map(|(column, n)| {
        format!("  metric {column} of another program, {}", counted(*n, "trials"))
    }));
    lines.extend(l.unreadable.iter().map(|e| format!("  unreadable: {e}")));
    lines.join("\n")
}
