//! `zwidth metric`: values of a metric that another program computed, one per trial, in a table.

use super::recover::{lock, now, put_in_order_and_tell};
use super::{join_findings, one_line, study, sum_up};
use crate::exit::Exit;
use crate::screen::Screen;
use anyhow::{Context as _, bail};
use clap::builder::PossibleValuesParser;
use clap::builder::TypedValueParser as _;
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use zwidth_import::{StudyTrials, outside_values};
use zwidth_results::OutsideValue;
use zwidth_store::{
    Entered, GivenFile, OutsideEntry, OutsideRow, Raw, RealFiles, StudyData, TrialEntry,
    file_blake3, give_metric, next_table, withdraw_metric,
};
use zwidth_study::{Better, ExperimenterId, MetricId, OutsideMetric, SessionId, StudyId, counted};

#[derive(Debug, clap::Args)]
#[command(group = clap::ArgGroup::new("what").required(true).args(["from", "list", "withdraw"]))]
pub(crate) struct MetricArgs {
    /// The study
    pub(crate) study: StudyId,
    /// A table of values (any format that an import reads), one row each, with the columns participant,
    /// session, trial (or environment, mode and repeat) and value: all are given, or none
    #[arg(long, value_name = "FILE", requires_all = ["id", "unit", "label"])]
    pub(crate) from: Option<PathBuf>,
    /// What the metric is called: the column of tables is own_, this and its unit
    #[arg(long, value_name = "ID", requires = "from")]
    pub(crate) id: Option<MetricId>,
    /// Its unit: N, N·m, rad/s, %, or 1 for a pure number
    #[arg(long, requires = "from")]
    pub(crate) unit: Option<String>,
    /// What people call it
    #[arg(long, value_name = "TEXT", requires = "from")]
    pub(crate) label: Option<String>,
    /// Which values are better [default: neither]
    #[arg(long, requires = "from", value_parser = better())]
    pub(crate) better: Option<Better>,
    /// The program that computed it, with its version
    #[arg(long, value_name = "NAME", requires = "from")]
    pub(crate) program: Option<String>,
    /// The session of a table without a column of sessions
    #[arg(long, short, value_name = "S01", requires = "from")]
    pub(crate) session: Option<SessionId>,
    /// Your code, which is kept with it; no name
    #[arg(long, value_name = "E1", conflicts_with = "list")]
    pub(crate) by: Option<ExperimenterId>,
    /// Check the table and say what would be given; nothing is written
    #[arg(long, requires = "from")]
    pub(crate) dry_run: bool,
    /// List the tables that were given
    #[arg(long)]
    pub(crate) list: bool,
    /// Withdraw a metric, with a reason: none of its tables counts any more, and all are kept
    #[arg(long, num_args = 2, value_names = ["ID", "WHY"])]
    pub(crate) withdraw: Option<Vec<String>>,
}

fn better() -> impl clap::builder::TypedValueParser<Value = Better> {
    PossibleValuesParser::new(Better::ALL.map(Better::as_str))
        .map(|word| Better::from_word(&word).unwrap_or(Better::Neither))
}

pub(crate) fn metric(root: &Path, command: &MetricArgs, screen: &Screen) -> anyhow::Result<Exit> {
    match (&command.from, command.withdraw.as_deref()) {
        (Some(from), _) => give(root, command, from, screen),
        (None, Some([id, reason])) => withdraw(root, command, id, reason, screen),
        _ => list(root, command, screen),
    }
}

/// Gives every value of the table. Each was checked before anything is written.
fn give(root: &Path, command: &MetricArgs, from: &Path, screen: &Screen) -> anyhow::Result<Exit> {
    let metric = declared(command)?;
    let layout = study(root, command.study.clone())?;
    let lock = lock(&layout, "zwidth metric")?;
    put_in_order_and_tell(&layout, &lock, screen);
    let data = StudyData::load(&layout).map_err(|findings| join_findings(&findings))?;
    if let Some(own) = data.study.metrics.iter().find(|own| own.id == metric.column) {
        bail!("study.toml has a metric {} by a rule already: choose another --id", own.id);
    }
    if let Some((stage, own)) =
        data.study.from_stages.iter().find(|(_, own)| own.column == metric.column)
    {
        bail!("the stage {stage} of study.toml gives {} already: choose another --id", own.column);
    }
    let counting = data.outside.iter().filter(|own| own.counts());
    let same =
        |own: &&OutsideEntry| own.metric.column == metric.column && own.metric.id != metric.id;
    if let Some(own) = counting.clone().find(same) {
        bail!(
            "the metric {} has the column {} already: choose another --id, or withdraw it",
            own.metric.id,
            metric.column
        );
    }
    let table = next_table(&RealFiles, &layout, &metric)?;
    let file_blake3 = file_blake3(from)?;
    if let Some(own) =
        counting.clone().find(|own| own.metric == metric && own.file_blake3 == file_blake3)
    {
        let number = own.table;
        screen.result(format!(
            "table {number} of {} is of this file, and is not given twice",
            metric.column
        ));
        return Ok(Exit::Fine);
    }
    let trials = StudyTrials::of(&data);
    let mut values =
        outside_values(from, std::slice::from_ref(&metric), &trials, command.session.as_ref())
            .map_err(|errors| sum_up(&errors))?;
    let values = values.pop().context("the table has no values")?;
    let summary = summary(&data, &values);
    let column = &metric.column;
    if command.dry_run {
        screen.result(format!(
            "table {table} of {column} would be given: {summary}; nothing was written (--dry-run)"
        ));
        return Ok(Exit::Fine);
    }
    let rows = with_recordings(&data, values)?;
    let utc = now();
    let entered = Entered { utc: &utc, by: command.by.as_ref() };
    let raw = Raw::adds(&RealFiles, &layout, &lock);
    let name = from.file_name().map(|name| name.to_string_lossy()).unwrap_or_default();
    let given = GivenFile { name: &name, blake3: &file_blake3 };
    let path = give_metric(&raw, &layout, entered, &metric, &rows, given)
        .map_err(|errors| sum_up(&errors))?;
    screen.result(format!(
        "table {table} of {column} is given: {summary}; it is kept as {}; `zwidth run {}` takes it in",
        path.display(),
        command.study
    ));
    Ok(Exit::Fine)
}

/// The metric as the arguments declare it.
fn declared(command: &MetricArgs) -> anyhow::Result<OutsideMetric> {
    let (Some(id), Some(unit), Some(label)) = (&command.id, &command.unit, &command.label) else {
        bail!("name the metric: --id grip_peak --unit N --label \"largest grip\"");
    };
    let metric = OutsideMetric::new(id.clone(), unit, label).map_err(anyhow::Error::msg)?;
    let program = command.program.as_ref().map(|program| program.trim().to_owned());
    if program.iter().any(|program| program.is_empty() || program.chars().any(char::is_control)) {
        bail!("--program must be one line of text, such as \"grip.py 1.2\"");
    }
    let better = command.better.unwrap_or(Better::Neither);
    Ok(OutsideMetric { better, program, ..metric })
}

/// The values, each with the hash of the recording that it is of.
fn with_recordings(data: &StudyData, values: Vec<OutsideValue>) -> anyhow::Result<Vec<OutsideRow>> {
    let recordings = by_name(data);
    let rows = values.into_iter().map(|OutsideValue { participant, session, trial, value }| {
        let entry = recordings.get(&(participant.as_str(), session.as_str(), trial));
        let entry = entry.with_context(|| format!("trial {trial} has no recording"))?;
        let recording = entry.blake3.clone();
        Ok(OutsideRow { participant, session, trial, value, recording })
    });
    rows.collect()
}

/// The trials of a study by participant, session and number.
fn by_name(data: &StudyData) -> BTreeMap<(&str, &str, u32), &TrialEntry> {
    let trials = data.trials.iter().map(|entry| {
        let meta = &entry.meta;
        ((meta.participant.as_str(), meta.session.as_str(), meta.trial), entry)
    });
    trials.collect()
}

/// What a table gives, in words.
fn summary(data: &StudyData, values: &[OutsideValue]) -> String {
    let known = by_name(data);
    let name = |own: &OutsideValue| -> Option<&TrialEntry> {
        known.get(&(own.participant.as_str(), own.session.as_str(), own.trial)).copied()
    };
    let with_value = values.iter().filter(|own| own.value.is_some()).count();
    let mut text = format!("{} of trials", counted(with_value, "values"));
    if with_value < values.len() {
        text += &format!(", {} without one", counted(values.len() - with_value, "trials"));
    }
    let mut but: BTreeMap<String, usize> = BTreeMap::new();
    for why in values.iter().filter_map(|own| name(own)?.why_not()) {
        *but.entry(why).or_default() += 1;
    }
    for (why, n) in but {
        text += &format!("; {} that do not count: {why}", counted(n, "trials"));
    }
    let counting = data.counting().count();
    let named = values.iter().filter(|own| name(own).is_some_and(TrialEntry::counts)).count();
    if named < counting {
        text += &format!("; {} that count have no row in it", counted(counting - named, "trials"));
    }
    text
}

fn withdraw(
    root: &Path,
    command: &MetricArgs,
    id: &str,
    reason: &str,
    screen: &Screen,
) -> anyhow::Result<Exit> {
    let id: MetricId = id.parse()?;
    let reason = one_line(reason, "the metric")?;
    let layout = study(root, command.study.clone())?;
    let lock = lock(&layout, "zwidth metric")?;
    put_in_order_and_tell(&layout, &lock, screen);
    let utc = now();
    let entered = Entered { utc: &utc, by: command.by.as_ref() };
    let raw = Raw::adds(&RealFiles, &layout, &lock);
    withdraw_metric(&raw, &layout, entered, &id, reason)?;
    screen.result(format!("the metric {id} is withdrawn; its tables are kept"));
    Ok(Exit::Fine)
}

/// A table that was given, as it is listed.
#[derive(Serialize)]
struct Line<'a> {
    column: &'a str,
    id: &'a str,
    unit: &'a str,
    label: &'a str,
    better: Better,
    table: u32,
    trials: usize,
    program: Option<&'a str>,
    file: &'a str,
    file_blake3: &'a str,
    utc: &'a str,
    by: Option<&'a ExperimenterId>,
    why_not: Option<&'a str>,
}

fn list(root: &Path, command: &MetricArgs, screen: &Screen) -> anyhow::Result<Exit> {
    let layout = study(root, command.study.clone())?;
    let data = StudyData::load(&layout).map_err(|findings| join_findings(&findings))?;
    let mut lines: Vec<Line> = data.outside.iter().map(line).collect();
    for own in lines.iter_mut().filter(|own| own.why_not.is_none()) {
        let of_stages = &data.study.from_stages;
        if of_stages.iter().any(|(_, given)| given.column.as_str() == own.column) {
            own.why_not = Some("a stage of study.toml gives this column");
        }
    }
    screen.give(&lines, || {
        if lines.is_empty() {
            screen.result(format!("{}: no metric of another program was given", layout.study()));
        }
        lines.iter().for_each(|line| screen.result(text(line)));
    })?;
    let own = layout.own();
    let unreadable: Vec<_> = data
        .problems
        .iter()
        .filter(|problem| problem.path.starts_with(&own) || problem.path == layout.own_events())
        .collect();
    unreadable.iter().for_each(|problem| screen.warn(problem.to_string()));
    Ok(if unreadable.is_empty() { Exit::Fine } else { Exit::Partly })
}

fn line(entry: &OutsideEntry) -> Line<'_> {
    let OutsideMetric { id, column, unit, label, better, program } = &entry.metric;
    Line {
        column: column.as_str(),
        id: id.as_str(),
        unit,
        label,
        better: *better,
        table: entry.table,
        trials: entry.rows,
        program: program.as_deref(),
        file: &entry.file,
        file_blake3: &entry.file_blake3,
        utc: &entry.utc,
        by: entry.by.as_ref(),
        why_not: entry.why_not.as_deref(),
    }
}

fn text(line: &Line) -> String {
    let by = line.by.map(|by| format!(" by {by}")).unwrap_or_default();
    let program =
        line.program.map(|program| format!(", computed by {program}")).unwrap_or_default();
    let why_not = line.why_not.map(|why| format!("; does not count: {why}")).unwrap_or_default();
    let trials = counted(line.trials, "trials");
    format!(
        "{}  {} ({}), table {} of {trials} from {}{program}; given {}{by}{why_not}",
        line.column, line.label, line.unit, line.table, line.file, line.utc
    )
}
