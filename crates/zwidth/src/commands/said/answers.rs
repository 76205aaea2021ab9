//! `zwidth answer --from`: a table of answers to existing trials, all given or none.

use super::given::{NewAnswer, NumberedSession};
use crate::commands::recover::{lock, now, put_in_order_and_tell};
use crate::commands::{join_findings, session, study, sum_up};
use crate::exit::Exit;
use crate::screen::Screen;
use anyhow::Context as _;
use std::collections::{BTreeMap, btree_map::Entry};
use std::path::{Path, PathBuf};
use zwidth_import::{Labels, LateAnswer, LateAnswers};
use zwidth_store::{
    Entered, FirstErrors, Raw, RealFiles, SessionLog, StudyData, TrialEntry, commit_events,
};
use zwidth_study::{
    AnswerValue, Event, ExperimenterId, ParticipantId, QuestionId, SessionId, StudyId, counted,
};

#[derive(Debug, clap::Args)]
pub(crate) struct AnswerArgs {
    /// The study
    pub(crate) study: StudyId,
    /// The participant
    #[arg(long, short, value_name = "P01", required_unless_present = "from")]
    pub(crate) participant: Option<ParticipantId>,
    /// The session; with --from, that of a table without a column of sessions
    #[arg(long, short, value_name = "S01", required_unless_present = "from")]
    pub(crate) session: Option<SessionId>,
    /// Your code, which is kept with it; no name
    #[arg(long, value_name = "E1")]
    pub(crate) by: Option<ExperimenterId>,
    /// The trial's number
    #[arg(long, value_name = "N", required_unless_present = "from")]
    pub(crate) trial: Option<u32>,
    /// The question [default: the only one that is asked after that trial]; with --from, that of a
    /// table without a column of questions
    #[arg(long, value_name = "ID")]
    pub(crate) question: Option<QuestionId>,
    /// The answer, a number of the question's scale
    #[arg(allow_negative_numbers = true, required_unless_present = "from")]
    pub(crate) value: Option<AnswerValue>,
    /// A table of answers (CSV, Excel), one row each, with the columns participant, session, trial
    /// (or environment, mode and repeat), question and answer: all are given, or none
    #[arg(long, value_name = "FILE", conflicts_with_all = ["participant", "trial", "value"])]
    pub(crate) from: Option<PathBuf>,
    /// Check the table and say what would be given; nothing is written
    #[arg(long, requires = "from")]
    pub(crate) dry_run: bool,
}

/// Gives every answer of the table. Each was checked before the first is written.
pub(super) fn from_table(
    root: &Path,
    command: &AnswerArgs,
    table: &Path,
    screen: &Screen,
) -> anyhow::Result<Exit> {
    let answers = LateAnswers::read(table).map_err(|errors| sum_up(&errors))?;
    let layout = study(root, command.study.clone())?;
    let lock = lock(&layout, "an event command")?;
    put_in_order_and_tell(&layout, &lock, screen);
    let data = StudyData::load(&layout).map_err(|findings| join_findings(&findings))?;
    let checked = check(&data, command, &answers).map_err(|errors| sum_up(&errors))?;
    if command.dry_run {
        screen.result(format!(
            "{}; nothing was written (--dry-run)",
            checked.summary("would be given")
        ));
        return Ok(Exit::Fine);
    }
    let utc = now();
    let entered = Entered { utc: &utc, by: command.by.as_ref() };
    let raw = Raw::adds(&RealFiles, &layout, &lock);
    let logs: Vec<(&Path, &[Event])> =
        checked.events.iter().map(|(path, events)| (*path, events.as_slice())).collect();
    commit_events(&raw, &layout, entered, &logs)?;
    screen.result(checked.summary("are given"));
    Ok(Exit::Fine)
}

/// What a table gives.
#[derive(Default)]
struct Checked<'a> {
    /// The answers of each session, by its log.
    events: BTreeMap<&'a Path, Vec<Event>>,
    /// How many count in place of another value.
    replaced: usize,
    /// How many are in the logs already.
    unchanged: usize,
    /// How many rows say something of a sealed trial that cannot be checked.
    unchecked: usize,
    /// Why trials that are answered do not count, with their number.
    but: BTreeMap<String, usize>,
}

impl Checked<'_> {
    /// The counts in a sentence, `verb` after the answers.
    fn summary(&self, verb: &str) -> String {
        let answers: usize = self.events.values().map(Vec::len).sum();
        let sessions = counted(self.events.len(), "sessions");
        let mut text = format!("{} in {sessions} {verb}", counted(answers, "answers"));
        if self.replaced > 0 {
            text += &format!("; {} in place of others, which are kept", self.replaced);
        }
        if self.unchanged > 0 {
            text += &format!("; {} there already, and not given twice", self.unchanged);
        }
        if self.unchecked > 0 {
            text += &format!(
                "; {} of sealed sessions, whose modes and repeats cannot be checked before `zwidth unseal`: give the same \
                 table again then",
                counted(self.unchecked, "rows")
            );
        }
        for (why, n) in &self.but {
            text += &format!("; {} to trials that do not count: {why}", counted(*n, "answers"));
        }
        text
    }
}

/// Every row beside the study: what it gives, or what is wrong with each.
fn check<'a>(
    data: &'a StudyData,
    command: &AnswerArgs,
    answers: &LateAnswers,
) -> Result<Checked<'a>, FirstErrors> {
    let mut checked = Checked::default();
    let mut errors = FirstErrors::default();
    let mut seen: BTreeMap<(&Path, u32, QuestionId), &LateAnswer> = BTreeMap::new();
    let labels = Labels::of(&data.study);
    let mut sessions = Sessions { data, entries: data.by_session(), numbered: BTreeMap::new() };
    for row in &answers.rows {
        let resolved = sessions
            .get(command, row)
            .and_then(|session| resolve(data, &labels, session, command, row));
        let Resolved { log, trial, answer, is_checked } = match resolved {
            Ok(resolved) => resolved,
            Err(error) => {
                errors.push(answers.error(row, &error.to_string()));
                continue;
            }
        };
        let path = log.events_path.as_path();
        match seen.entry((path, trial, answer.question.clone())) {
            Entry::Occupied(first) => {
                let first = answers.place(first.get());
                let what =
                    format!("trial {trial} has an answer to {} in {first} too", answer.question);
                errors.push(answers.error(row, &what));
                continue;
            }
            Entry::Vacant(place) => _ = place.insert(row),
        }
        checked.unchecked += usize::from(!is_checked);
        // The same table is given again after a session of it was unsealed.
        if answer.before == Some(row.value) {
            checked.unchanged += 1;
            continue;
        }
        checked.replaced += usize::from(answer.before.is_some());
        if let Some(why) = answer.but {
            *checked.but.entry(why).or_default() += 1;
        }
        checked.events.entry(path).or_default().push(answer.event);
    }
    errors.none().map(|()| checked)
}

/// The sessions that rows speak of: each is looked up once, however many rows there are.
struct Sessions<'a> {
    data: &'a StudyData,
    entries: BTreeMap<(&'a ParticipantId, &'a SessionId), Vec<&'a TrialEntry>>,
    numbered: BTreeMap<(ParticipantId, SessionId), NumberedSession<'a>>,
}

impl<'a> Sessions<'a> {
    /// The session of a row.
    fn get(
        &mut self,
        command: &AnswerArgs,
        row: &LateAnswer,
    ) -> anyhow::Result<&NumberedSession<'a>> {
        let id = row.of.session.as_ref().or(command.session.as_ref());
        let id = id.context("the table has no column 'session': add it, or name one with -s")?;
        let Self { data, entries, numbered } = self;
        match numbered.entry((row.of.participant.clone(), id.clone())) {
            Entry::Occupied(session) => Ok(session.into_mut()),
            Entry::Vacant(place) => {
                let log = session(data, &row.of.participant, id)?;
                let entries = entries.get(&(&log.record.participant, &log.record.session));
                Ok(place.insert(NumberedSession::new(log, entries.map_or(&[], Vec::as_slice))))
            }
        }
    }
}

/// The session and trial of a row, and its answer.
struct Resolved<'a> {
    log: &'a SessionLog,
    trial: u32,
    answer: NewAnswer,
    /// Whether everything that the row says of its trial could be checked.
    is_checked: bool,
}

fn resolve<'a>(
    data: &'a StudyData,
    labels: &Labels,
    session: &NumberedSession<'a>,
    command: &AnswerArgs,
    row: &LateAnswer,
) -> anyhow::Result<Resolved<'a>> {
    let trials = &session.trials;
    let trial = trials.number(&row.of).map_err(anyhow::Error::msg)?;
    let is_checked =
        trials.check_claims(labels, trial, &row.of.claims).map_err(anyhow::Error::msg)?;
    let question = row.question.as_ref().or(command.question.as_ref());
    let answer = session.answer(data, trial, question, row.value)?;
    Ok(Resolved { log: session.log, trial, answer, is_checked })
}
