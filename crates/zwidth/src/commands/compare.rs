//! `zwidth compare`: modes, participants, sessions or repeats of a study compared. Missing results
//! of the stage `compare` are made first.

use super::consent::scripts;
use super::hashes_read;
use super::near::did_you_mean;
use super::run::run_with_bars;
use crate::exit::Exit;
use crate::screen::Screen;
use anyhow::{anyhow, bail};
use clap::ValueEnum;
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;
use std::path::Path;
use zwidth_acquire::Unsynced;
use zwidth_figures::{MeasuredBy, VerdictRow};
use zwidth_plan as plan;
use zwidth_results::{NoteKind, Role};
use zwidth_runner::{JobEnd, Options, Results};
use zwidth_store::{RealFiles, StudyData, findings};
use zwidth_study::StudyId;
use zwidth_tables::{Format, Table, TableError, Type, Wording};

/// What can be compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum By {
    /// The modes: means, and differences with their intervals
    Mode,
    /// The participants: each one's differences between modes
    Participant,
    /// The groups of participants: means, differences between groups and between modes within each
    Group,
    /// The sessions: changes from the first to each later one
    Session,
    /// The repeats: the change from one to the next
    Repeat,
    /// The modes by the answers: effects over participants, odds ratios for one person
    Answer,
}

impl From<By> for zwidth_plan::By {
    fn from(by: By) -> Self {
        match by {
            By::Mode => Self::Mode,
            By::Participant => Self::Participant,
            By::Group => Self::Group,
            By::Session => Self::Session,
            By::Repeat => Self::Repeat,
            By::Answer => Self::Answer,
        }
    }
}

#[derive(Debug, clap::Args)]
pub(crate) struct CompareArgs {
    /// The study
    pub(crate) study: StudyId,
    /// What is compared [default: the modes; by the answers in a study without a metric]
    #[arg(long, value_enum)]
    pub(crate) by: Option<By>,
    /// The metric's column in the table of metrics [default: the first primary one, and whole curves that are primary]
    #[arg(long, value_name = "METRIC")]
    pub(crate) metric: Option<String>,
    /// The differences between modes as lmerTest, pbkrtest, emmeans, statsmodels, pingouin and pyfixest print them, and why
    #[arg(long, conflicts_with = "by")]
    pub(crate) peers: bool,
}

pub(crate) fn compare(root: &Path, command: &CompareArgs, screen: &Screen) -> anyhow::Result<Exit> {
    let data = super::load(root, &command.study)?;
    let by = match command.by {
        Some(by) => by,
        None if plan::compared(&data).is_empty() && plan::answers(&data).is_some() => By::Answer,
        None => By::Mode,
    };
    let metric = if by == By::Answer { String::new() } else { metric(&data, command)? };
    if by == By::Answer && plan::answers(&data).is_none() {
        bail!("{} has no answers after several modes to compare", data.layout.study());
    }
    if by == By::Group && data.study.compare.groups.is_none() {
        bail!(
            "{} names no groups: name a column of people in {} (`groups` under [compare], its levels \
             under [[people]]) and everybody's level in participants.csv beside it",
            data.layout.study(),
            data.layout.shown(&data.layout.study_toml()).display()
        );
    }
    if command.peers && by == By::Answer {
        bail!(
            "{} compares answers alone; --peers is of metrics, which are numbers of trials",
            data.layout.study()
        );
    }
    if command.peers && data.study.compare.contrasts.is_empty() {
        bail!(
            "{} compares no two modes; --peers is of differences between modes",
            data.layout.study()
        );
    }
    let mut exit = make(&data, screen)?;
    if command.peers {
        let table = plan::peers(&data, &metric).map_err(|e| anyhow!("{e}"))?;
        if table.height() == 0 {
            screen.warn(format!("there is nothing to compare: nobody has {metric} in two modes"));
            exit = Exit::Partly;
        }
        print(&data, &[table], &LEAST_OF_PEERS, screen)?;
        return Ok(exit);
    }
    let is_all = command.by.is_none() && command.metric.is_none();
    let mut printed = plan::comparison(&data, by.into(), &metric);
    if is_all && data.study.compare.primary.curves().next().is_some() {
        printed.extend(plan::compared_curves(&data));
    }
    let tables = printed.iter().map(plan::Printed::read).collect::<Result<Vec<_>, _>>()?;
    if tables.iter().all(|table| table.height() == 0) {
        let why = match by {
            By::Mode => format!("no trial that counts has a value of {metric}"),
            By::Participant => "no participant took part more than once".to_owned(),
            By::Group => "there is one participant".to_owned(),
            By::Session => "no participant came more than once".to_owned(),
            By::Repeat => "no condition was repeated".to_owned(),
            By::Answer => "no question was answered more than once".to_owned(),
        };
        screen.warn(format!("there is nothing to compare: {why}"));
        exit = Exit::Partly;
    }
    // A table without a row is not shown, and neither would be why it has none.
    for table in tables.iter().filter(|table| table.height() == 0) {
        let why = table.notes_by_kind().filter(|(kind, _)| *kind == NoteKind::LeftOut);
        why.for_each(|(_, note)| screen.warn(format!("{}: {note}", table.title())));
    }
    let width = screen.width();
    if is_all && by == By::Mode && !screen.json {
        let rows = plan::verdicts(&data).map_err(|e| anyhow!("{e}"))?;
        if !rows.is_empty() {
            let lines = verdict_lines(&rows, width.unwrap_or(WIDTH));
            match width {
                Some(_) => screen.result(lines),
                // What follows is Markdown.
                None => screen.file(&format!("```text\n{lines}\n```\n")),
            }
        }
    }
    print(&data, &tables, &LEAST, screen)?;
    Ok(exit)
}

/// Tables for people, or for machines.
fn print(
    data: &StudyData,
    tables: &[Table],
    least: &[&str],
    screen: &Screen,
) -> anyhow::Result<()> {
    if screen.json {
        let listed = tables.iter().map(listing).collect::<Result<Vec<_>, _>>()?;
        return screen.listing(&listed);
    }
    let wording = Wording::of(&data.study);
    let width = screen.width();
    for table in tables.iter().filter(|table| table.height() > 0) {
        if let Some(width) = width {
            screen.result(table.for_terminal(&wording, width, least)? + "\n");
            continue;
        }
        let wanted = [(Format::Markdown, Path::new(table.name()))];
        for bytes in plan::write_table(table, &wanted, &wording, &BTreeMap::new())? {
            screen.file(&String::from_utf8(bytes)?);
        }
    }
    Ok(())
}

/// Characters in a line where the window does not say.
const WIDTH: usize = 120;
/// Characters of a plot, at most and at least.
const PLOT: [usize; 2] = [61, 21];

/// Every difference between modes: a heading per metric, and of each contrast a plot, on one axis
/// for all that are measured by the same, its value and its verdict.
fn verdict_lines(rows: &[VerdictRow], width: usize) -> String {
    let mut place = 0;
    let mut words = 0;
    for row in rows {
        place = place.max(row.place.chars().count());
        words = words.max(format!("{}  {}", row.value, row.judged()).chars().count());
    }
    // Six blanks: two before the place, two on either side of the plot.
    let plot = width.saturating_sub(place + words + 6).clamp(PLOT[1], PLOT[0]);
    let mut lines = Vec::new();
    for of_axis in rows.chunk_by(|a, b| a.by == b.by) {
        let (unit, name) = match of_axis[0].by {
            MeasuredBy::Jnd => {
                ("JND", "just noticeable differences (JND); shaded: below what is felt")
            }
            MeasuredBy::Deviation => ("SD", "standard deviations (SD): what is felt is not known"),
        };
        let all = of_axis.iter().flat_map(|row| {
            let ends = row.ends.into_iter().flatten();
            ends.chain([row.estimate]).chain(row.dots.iter().copied())
        });
        // At least one unit: else a difference that is not felt would fill the axis.
        let most = all.map(f64::abs).fold(1.0, f64::max).ceil();
        lines.push(format!("Differences in {name}"));
        for of_metric in of_axis.chunk_by(|a, b| a.metric == b.metric) {
            let row = &of_metric[0];
            let role = if row.role == Role::Primary { "primary: " } else { "" };
            lines.push(format!("{role}{}{}", row.metric, row.direction()));
            for row in of_metric {
                let drawn = plotted(row, most, plot);
                let value = &row.value;
                lines.push(format!("  {:place$}  {drawn}  {value}  {}", row.place, row.judged()));
            }
        }
        let half = plot / 2;
        let [low, high] = [-most, most].map(|end| format!("{end} {unit}"));
        let gap =
            " ".repeat((half * 2 + 1).saturating_sub(low.chars().count() + high.chars().count()));
        lines.push(format!("  {:place$}  {low}{gap}{high}\n", ""));
    }
    lines.join("\n")
}

/// A row's plot from −most to most: people's dots, the interval, the difference, zero, and the band that is
/// not felt.
fn plotted(row: &VerdictRow, most: f64, width: usize) -> String {
    let half = (width / 2) as f64;
    let at = |value: f64| ((value / most).clamp(-1.0, 1.0) * half + half).round() as usize;
    // An odd number of characters, so that zero has one. What is drawn later lies on top.
    let mut line = vec![' '; 2 * (width / 2) + 1];
    if row.by == MeasuredBy::Jnd {
        line[at(-1.0)..=at(1.0)].fill('░');
    }
    line[at(0.0)] = '│';
    for dot in &row.dots {
        line[at(*dot)] = '·';
    }
    if let Some([low, high]) = row.ends {
        line[at(low)..=at(high)].fill('─');
    }
    line[at(row.estimate)] = '●';
    line.into_iter().collect()
}

/// The columns of a comparison that matter least, the very least first: a narrow window shows them
/// at the end.
const LEAST: [&str; 26] = [
    "unit of analysis",
    "epsilon hf",
    "p hf",
    "epsilon gg",
    "p gg",
    "df modes",
    "df error",
    "df",
    "kendall w",
    "friedman",
    "f",
    "d av",
    "p signed rank",
    "p sign flip",
    "statistic",
    "difference std. error",
    "smallest p adjusted",
    "p sharp null",
    "p value",
    "mean second",
    "mean first",
    "trials with value",
    "trials second",
    "trials first",
    "sessions",
    "trials",
];

/// The same of what other programs print, which differ most in degrees of freedom and p values.
const LEAST_OF_PEERS: [&str; 8] = [
    "why",
    "effect",
    "effect size",
    "left out",
    "trials",
    "statistic",
    "distribution",
    "difference std. error",
];

/// The metric that the command names, or the first.
fn metric(data: &StudyData, command: &CompareArgs) -> anyhow::Result<String> {
    let metrics = plan::compared(data);
    let Some(first) = metrics.first() else {
        let answers = plan::answers(data).map_or("", |_| " (its answers: --by answer)");
        bail!(
            "{} has no metric to compare: it takes recorded trials that count, of two modes{answers}",
            data.layout.study()
        );
    };
    let Some(wanted) = &command.metric else { return Ok(first.clone()) };
    match metrics.iter().find(|metric| *metric == wanted) {
        Some(metric) => Ok(metric.clone()),
        None if plan::is_metric(&data.study, wanted) => bail!(
            "--metric {wanted}: {} does not compare it yet (it compares {}); if its trials have it, \
             add it to `metrics` under [compare] in {}",
            data.layout.study(),
            metrics.join(", "),
            data.layout.shown(&data.layout.study_toml()).display()
        ),
        None => bail!(
            "--metric {wanted}: {} does not compare it{} (it compares {})",
            data.layout.study(),
            did_you_mean(wanted, metrics.iter().map(String::as_str)),
            metrics.join(", ")
        ),
    }
}

/// Makes what is missing of the stage.
pub(super) fn make(data: &StudyData, screen: &Screen) -> anyhow::Result<Exit> {
    let findings = findings(&RealFiles, data);
    let jobs = plan::jobs(data, &findings);
    let only = Some("compare".to_owned());
    // The study's files were hashed when they were loaded: not a second time.
    let options = Options {
        only,
        known: hashes_read(data),
        scripts: scripts(&data.layout)?,
        ..Options::default()
    };
    let results = Results::new(&data.layout, &Unsynced);
    let done = run_with_bars(&jobs, &results, &options, screen)?;
    let mut exit = Exit::Fine;
    let read_with_care =
        findings.left_out.iter().chain(&findings.with_care).map(ToString::to_string);
    let mut read_with_care: Vec<String> = read_with_care.collect();
    for report in done.reports {
        read_with_care.extend(report.care);
        if let JobEnd::Failed(why) | JobEnd::Blocked(why) = report.verdict {
            screen.warn(format!("{} could not be made: {why}", report.name));
            exit = Exit::Partly;
        }
    }
    if let Some((first, others)) = read_with_care.split_first() {
        let others = match others.len() {
            0 => String::new(),
            n => format!(
                "; likewise {n} others (`zwidth verify {}` lists them)",
                data.layout.study()
            ),
        };
        screen.warn(format!("read with care: {first}{others}"));
        exit = Exit::Partly;
    }
    Ok(exit)
}

/// A table for machines: its notes, and a row as an object, in SI units.
pub(super) fn listing(table: &Table) -> Result<Value, TableError> {
    let mut rows = vec![Map::new(); table.height()];
    for field in table.fields() {
        let name: &str = &field.name;
        let values: Vec<Value> = match field.kind {
            Type::Float => table.floats(name)?.into_iter().map(|v| json!(v)).collect(),
            Type::Integer => table.integers(name)?.into_iter().map(|v| json!(v)).collect(),
            Type::Text => table.texts(name)?.into_iter().map(|v| json!(v)).collect(),
            Type::Flag => table.flags(name)?.into_iter().map(|v| json!(v)).collect(),
        };
        for (row, value) in rows.iter_mut().zip(values) {
            row.insert(name.to_owned(), value);
        }
    }
    Ok(json!({
        "table": table.name(),
        "title": table.title(),
        "rows": rows,
        "notes": table.notes(),
    }))
}
