//! `zwidth answer --from`: a table of answers to trials that are there, all given or none.

use super::given::{Given, given};
use crate::args::Answer;
use crate::commands::recover::{lock, now, put_in_order_and_tell};
use crate::commands::{join_findings, session, study, sum_up};
use crate::exit::Exit;
use crate::screen::Screen;
use anyhow::{Context as _, bail};
use std::collections::{BTreeMap, btree_map::Entry};
use std::path::Path;
use zwidth_import::{LateAnswer, LateAnswers, TrialMeant};
use zwidth_store::{Entered, Raw, RealFiles, SessionLog, StoreError, StudyData, commit_events};
use zwidth_study::{Event, Kind, QuestionId};

/// Gives every answer of the table. Each was checked before the first is written.
pub(super) fn from_table(
    root: &Path,
    command: &Answer,
    table: &Path,
    screen: &Screen,
) -> anyhow::Result<Exit> {
    let answers = LateAnswers::read(table).map_err(|errors| join_findings(&errors))?;
    let layout = study(root, command.study.clone())?;
    let lock = lock(&layout, "an event command")?;
    put_in_order_and_tell(&layout, &lock, screen);
    let data = StudyData::load(&layout).map_err(|findings| join_findings(&findings))?;
    let checked = check(&data, command, &answers).map_err(|errors| sum_up(&errors))?;
    if command.dry_run {
        screen
            .result(format!("{}; nothing was written (--dry-run)", checked.told("would be given")));
        return Ok(Exit::Fine);
    }
    let utc = now();
    let entered = Entered { utc: &utc, by: command.by.as_ref() };
    let raw = Raw::adds(&RealFiles, &layout, &lock);
    let logs: Vec<(&Path, &[Event])> =
        checked.events.iter().map(|(path, events)| (*path, events.as_slice())).collect();
    commit_events(&raw, &layout, entered, &logs)?;
    screen.result(checked.told("are given"));
    Ok(Exit::Fine)
}

/// What a table gives.
#[derive(Default)]
struct Checked<'a> {
    /// The answers of each session, by its log.
    events: BTreeMap<&'a Path, Vec<Event>>,
    /// How many count in place of another value.
    replaced: usize,
    /// How many are there already.
    known: usize,
    /// Why trials that are answered do not count, with their number.
    but: BTreeMap<String, usize>,
}

impl Checked<'_> {
    fn told(&self, given: &str) -> String {
        let answers: usize = self.events.values().map(Vec::len).sum();
        let sessions = self.events.len();
        let of = |n: usize, what: &str| format!("{n} {what}{}", if n == 1 { "" } else { "s" });
        let mut told = format!("{} in {} {given}", of(answers, "answer"), of(sessions, "session"));
        if self.replaced > 0 {
            told += &format!("; {} in place of others, which are kept", self.replaced);
        }
        if self.known > 0 {
            told += &format!("; {} there already, and not given twice", self.known);
        }
        for (why, n) in &self.but {
            told += &format!("; {} to trials that do not count: {why}", of(*n, "answer"));
        }
        told
    }
}

/// Every row beside the study: what it gives, or what is wrong with each.
fn check<'a>(
    data: &'a StudyData,
    command: &Answer,
    answers: &LateAnswers,
) -> Result<Checked<'a>, Vec<StoreError>> {
    let (mut checked, mut errors) = (Checked::default(), Vec::new());
    let mut seen: BTreeMap<(&Path, u32, QuestionId), &LateAnswer> = BTreeMap::new();
    for row in &answers.rows {
        let (log, trial, found) = match resolve(data, command, row) {
            Ok(found) => found,
            Err(error) => {
                errors.push(answers.error(row, &error.to_string()));
                continue;
            }
        };
        let path = log.events_path.as_path();
        match seen.entry((path, trial, found.question.clone())) {
            Entry::Occupied(first) => {
                let first = answers.place(first.get());
                let what =
                    format!("trial {trial} has an answer to {} in {first} too", found.question);
                errors.push(answers.error(row, &what));
                continue;
            }
            Entry::Vacant(place) => _ = place.insert(row),
        }
        if found.before == Some(row.value) {
            checked.known += 1;
            continue;
        }
        checked.replaced += usize::from(found.before.is_some());
        if let Some(why) = found.but {
            *checked.but.entry(why).or_default() += 1;
        }
        checked.events.entry(path).or_default().push(found.event);
    }
    if errors.is_empty() { Ok(checked) } else { Err(errors) }
}

/// The session and trial of a row, and its answer.
fn resolve<'a>(
    data: &'a StudyData,
    command: &Answer,
    row: &LateAnswer,
) -> anyhow::Result<(&'a SessionLog, u32, Given)> {
    let of = row.session.as_ref().or(command.session.as_ref());
    let of = of.context("the table has no column 'session': add it, or name one with -s")?;
    let log = session(data, &row.participant, of)?;
    let trial = number(data, log, &row.trial)?;
    let question = row.question.as_ref().or(command.question.as_ref());
    let given = given(data, log, trial, question, row.value)?;
    Ok((log, trial, given))
}

/// The number of the trial meant: of a condition's repeat, the one that no other took the place of.
fn number(data: &StudyData, log: &SessionLog, meant: &TrialMeant) -> anyhow::Result<u32> {
    let (environment, mode, repeat) = match meant {
        TrialMeant::Number(trial) => return Ok(*trial),
        TrialMeant::Repeat { environment, mode, repeat } => (environment, mode, *repeat),
    };
    if log.is_sealed() {
        bail!("the session's modes are sealed: name its trials by number, in a column 'trial'");
    }
    let replaced = |trial: u32| {
        data.trials.iter().any(|entry| {
            entry.meta.trial == trial
                && entry.meta.participant == log.record.participant
                && entry.meta.session == log.record.session
                && entry.superseded_by.is_some()
        })
    };
    let found: Vec<u32> = log
        .trials
        .iter()
        .filter(|t| t.kind == Kind::Trial && t.repeat == repeat)
        .filter(|t| t.environment == *environment && t.mode == *mode)
        .map(|t| t.trial)
        .filter(|trial| !replaced(*trial))
        .collect();
    match found[..] {
        [only] => Ok(only),
        [] => bail!("the session has no trial of {environment}, {mode}, repeat {repeat}"),
        _ => bail!(
            "the session has several trials of {environment}, {mode}, repeat {repeat}: name the one by number, in a \
             column 'trial'"
        ),
    }
}
