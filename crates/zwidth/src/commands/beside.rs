//! `zwidth beside`: streams that another program recorded beside a session, in an XDF file with the session's markers.

use super::recover::{lock, now, put_in_order_and_tell};
use super::{join_findings, one_line, study, sum_up};
use crate::exit::Exit;
use crate::screen::Screen;
use anyhow::{Context as _, bail};
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use zwidth_import::{Beside, Wanted, beside as beside_of_file};
use zwidth_store::{
    BesideEntry, Entered, GivenFile, Raw, RealFiles, SessionLog, StudyData, file_blake3,
    give_beside, withdraw_beside,
};
use zwidth_study::{ExperimenterId, ParticipantId, SessionId, StreamId, StudyId, counted};

#[derive(Debug, clap::Args)]
#[command(group = clap::ArgGroup::new("what").required(true).args(["from", "list", "withdraw"]))]
pub(crate) struct BesideArgs {
    /// The study
    pub(crate) study: StudyId,
    /// A recording of the LabStreamingLayer (.xdf) that has the session's markers in it: each of its other streams is
    /// kept, with the trial of each sample and its time there
    #[arg(long, value_name = "FILE", requires_all = ["participant", "session"])]
    pub(crate) from: Option<PathBuf>,
    /// Whose session
    #[arg(long, short, value_name = "P01", conflicts_with = "list")]
    pub(crate) participant: Option<ParticipantId>,
    /// Which session
    #[arg(long, short, value_name = "S01", conflicts_with = "list")]
    pub(crate) session: Option<SessionId>,
    /// Only this stream, by its name or number in the file, and what it is to be called; may be given again
    /// [default: all]
    #[arg(long, value_name = "NAME[=ID]", requires = "from")]
    pub(crate) stream: Vec<StreamWanted>,
    /// The stream of markers, by its name or number in the file
    #[arg(long, value_name = "NAME", default_value = "zwidth")]
    pub(crate) markers: String,
    /// Your code, which is kept with it; no name
    #[arg(long, value_name = "E1", conflicts_with = "list")]
    pub(crate) by: Option<ExperimenterId>,
    /// Check the recording and say what would be given; nothing is written
    #[arg(long, requires = "from")]
    pub(crate) dry_run: bool,
    /// List the streams that were given
    #[arg(long)]
    pub(crate) list: bool,
    /// Withdraw a stream of the session, with a reason: its tables are kept, and none counts any more
    #[arg(long, num_args = 2, value_names = ["ID", "WHY"], requires_all = ["participant", "session"])]
    pub(crate) withdraw: Option<Vec<String>>,
}

/// A stream as it is asked for: `EMG of the arm=emg`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct StreamWanted(Wanted);

impl FromStr for StreamWanted {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        // A name may have a `=` in it; an id has none.
        let (name, id) = match text.rsplit_once('=') {
            Some((name, id)) => (name, Some(id.parse::<StreamId>().map_err(|e| e.to_string())?)),
            None => (text, None),
        };
        match name.is_empty() {
            true => Err("name the stream: --stream \"EMG of the arm=emg\"".to_owned()),
            false => Ok(Self(Wanted { name: name.to_owned(), id })),
        }
    }
}

pub(crate) fn beside(root: &Path, command: &BesideArgs, screen: &Screen) -> anyhow::Result<Exit> {
    match (&command.from, command.withdraw.as_deref()) {
        (Some(from), _) => give(root, command, from, screen),
        (None, Some([id, reason])) => withdraw(root, command, id, reason, screen),
        _ => list(root, command, screen),
    }
}

/// Gives every stream that is asked for. Each was read whole before anything is written.
fn give(root: &Path, command: &BesideArgs, from: &Path, screen: &Screen) -> anyhow::Result<Exit> {
    let layout = study(root, command.study.clone())?;
    let lock = lock(&layout, "zwidth beside")?;
    put_in_order_and_tell(&layout, &lock, screen);
    let data = StudyData::load(&layout).map_err(|findings| join_findings(&findings))?;
    let log = session_of(&data, command)?;
    let wanted: Vec<Wanted> = command.stream.iter().map(|own| own.0.clone()).collect();
    let Beside { streams, remarks, trials } =
        beside_of_file(from, &log.events, &command.markers, &wanted)?;
    remarks.iter().for_each(|line| screen.result(line));
    let file_blake3 = file_blake3(from)?;
    let given = |id: &StreamId| {
        let own = data.beside.iter().filter(|entry| entry.stream == *id && entry.counts());
        own.filter(|entry| entry.is_of(log)).any(|entry| entry.file_blake3 == file_blake3)
    };
    if let Some(again) = streams.iter().find(|own| given(&own.id)) {
        bail!(
            "the stream {} was given from this file already; withdraw it first if it is to be read in another way",
            again.id
        );
    }
    let (participant, session) = (&log.record.participant, &log.record.session);
    let summary = format!(
        "{} beside {participant} {session}, {} of which begin by its markers",
        counted(streams.len(), "streams"),
        counted(trials, "trials")
    );
    if command.dry_run {
        screen.result(format!("{summary}: would be given; nothing was written (--dry-run)"));
        return Ok(Exit::Fine);
    }
    let utc = now();
    let entered = Entered { utc: &utc, by: command.by.as_ref() };
    let raw = Raw::adds(&RealFiles, &layout, &lock);
    let name = from.file_name().map(|name| name.to_string_lossy()).unwrap_or_default();
    let given = GivenFile { name: &name, blake3: &file_blake3 };
    let paths = give_beside(&raw, &layout, entered, log, &streams, given)
        .map_err(|errors| sum_up(&errors))?;
    screen.result(format!("{summary}: given, and kept as"));
    paths.iter().for_each(|path| screen.result(format!("  {}", path.display())));
    Ok(Exit::Fine)
}

/// The session that is named.
fn session_of<'a>(data: &'a StudyData, command: &BesideArgs) -> anyhow::Result<&'a SessionLog> {
    let (Some(participant), Some(session)) = (&command.participant, &command.session) else {
        bail!("name the session: -p P01 -s S01");
    };
    data.session(participant, session).with_context(|| {
        let name = &command.study;
        format!("{name} has no session {session} of {participant} that can be read: `zwidth list {name}` lists them")
    })
}

fn withdraw(
    root: &Path,
    command: &BesideArgs,
    id: &str,
    reason: &str,
    screen: &Screen,
) -> anyhow::Result<Exit> {
    let id: StreamId = id.parse()?;
    let reason = one_line(reason, "the stream")?;
    let layout = study(root, command.study.clone())?;
    let lock = lock(&layout, "zwidth beside")?;
    put_in_order_and_tell(&layout, &lock, screen);
    let data = StudyData::load(&layout).map_err(|findings| join_findings(&findings))?;
    let log = session_of(&data, command)?;
    let utc = now();
    let entered = Entered { utc: &utc, by: command.by.as_ref() };
    let raw = Raw::adds(&RealFiles, &layout, &lock);
    withdraw_beside(&raw, &layout, entered, log, &id, reason)?;
    screen.result(format!("the stream {id} is withdrawn; its tables are kept"));
    Ok(Exit::Fine)
}

/// A table that was given, as it is listed.
#[derive(Serialize)]
struct Line<'a> {
    participant: &'a str,
    session: &'a str,
    stream: &'a str,
    table: u32,
    path: String,
    file: &'a str,
    file_blake3: &'a str,
    why_not: Option<&'a str>,
}

fn list(root: &Path, command: &BesideArgs, screen: &Screen) -> anyhow::Result<Exit> {
    let layout = study(root, command.study.clone())?;
    let data = StudyData::load(&layout).map_err(|findings| join_findings(&findings))?;
    let line = |entry: &'_ BesideEntry| -> String {
        let BesideEntry { participant, session, stream, table, file, why_not, .. } = entry;
        let why_not =
            why_not.as_ref().map(|why| format!("; does not count: {why}")).unwrap_or_default();
        format!("{participant} {session}  {stream}, table {table} from {file}{why_not}")
    };
    let lines: Vec<Line> = data
        .beside
        .iter()
        .map(|entry| Line {
            participant: entry.participant.as_str(),
            session: entry.session.as_str(),
            stream: entry.stream.as_str(),
            table: entry.table,
            path: layout.shown(&entry.path).to_string_lossy().replace('\\', "/"),
            file: &entry.file,
            file_blake3: &entry.file_blake3,
            why_not: entry.why_not.as_deref(),
        })
        .collect();
    screen.give(&lines, || {
        if lines.is_empty() {
            screen.result(format!("{}: no stream was given beside a session", layout.study()));
        }
        data.beside.iter().for_each(|entry| screen.result(line(entry)));
    })?;
    let tree = layout.beside();
    let unreadable: Vec<_> =
        data.problems.iter().filter(|problem| problem.path.starts_with(&tree)).collect();
    unreadable.iter().for_each(|problem| screen.warn(problem.to_string()));
    Ok(if unreadable.is_empty() { Exit::Fine } else { Exit::Partly })
}
