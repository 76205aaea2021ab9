//! Stage: what a person reads first: the summary, and the tables of the plan and its results.
//!
//! [`summary_markdown`] turns the results of a run into one page of text, including the sentences
//! of [`findings`]. Rows, with the thesis' number: [`pros_cons`] (1), [`mode_forces`],
//! [`model_facts`] (2, 3), [`components`] and [`device_facts`] (4), [`weight_facts`] (Appendix A),
//! and its statements, [`statements`]. [`methods`] describes in words what was done. [`page_html`]
//! is the summary as a page with the trials in it. No files and no clock: data in, text and tables
//! out.

mod answers;
mod columns;
mod compared;
mod components;
mod curves;
mod design;
mod effects;
mod evidence;
mod findings;
mod gallery;
mod groups;
mod methods;
mod model;
mod page;
mod people;
mod pros_cons;
mod ranges;
mod runs;
mod sessions;
mod survey;
mod thesis;
mod thresholds;
mod trials;
mod weight;

pub use columns::metric_columns;
pub use compared::{
    ComparedMetric, Matrix, MatrixRow, Primaries, contrasts, matrix, primary_first,
};
pub use components::components;
pub use curves::{curve_answers, curve_differences};
pub use design::{device_facts, mode_forces};
pub use effects::{explored_effects, factor_effects};
pub use evidence::{Derived, Known, notes};
pub use findings::{Finding, TrialNames, findings};
pub use gallery::{Asked, Gallery, Shown};
pub use groups::{explored_groups, group_differences};
pub use methods::{MethodsForm, MethodsPart, Recorded, methods};
pub use model::model_facts;
pub use page::{
    Columns, Contents, Course, Estimating, Event, Page, PageHtml, TURNED, TrialValues, Turn,
    condition_script, page_html, single_file, turned_script,
};
pub use pros_cons::pros_cons;
pub use ranges::uneven_ranges;
pub use runs::{laddered, traded};
pub use sessions::{changes, learned};
pub use survey::survey;
pub use thesis::{HOW_JUDGED, Told, replayed, replayed_columns, statements, told};
pub use thresholds::felt_thresholds;
pub use weight::{WEIGHT_NOTES, is_weighed, weight_facts};

use people::{amounts, participants, sources};
use serde::Serialize;
use std::collections::BTreeMap;
use zwidth_results::Sentence;
use zwidth_study::{Source, counted};
use zwidth_tables::{SYNTHETIC, escape_markdown as escape};

/// Version of the tables' form: raised when a table would be another from the same data.
pub const VERSION: u32 = 17;

/// The figure of every difference between modes, from the summary's folder on.
pub(crate) const VERDICTS_FIGURE: &str = "figures/verdicts.png";

/// Stands in a cell of the matrix without a mean.
pub(crate) const NO_MEAN: &str = "–";

/// The heading of the sentences on runs of the model.
pub(crate) const RUNS: &str = "What a run of the model requires";

/// The heading of the sentences on the plan that lies beside the data.
pub(crate) const PLAN: &str = "The deposited plan";

/// The content of the summary.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize)]
pub struct Summary {
    /// The study's title.
    pub title: String,
    /// What the device is called; empty where there is none.
    pub device: String,
    /// Participants with at least one trial that counts.
    pub participants: usize,
    /// Sessions (of all participants together) with at least one trial that counts.
    pub sessions: usize,
    /// Trials that count: neither familiarisation nor superseded, excluded or incomplete.
    pub trials: usize,
    /// Sweeps of actuators and sensors.
    pub sweeps: usize,
    /// How many of these trials and sweeps come from where.
    pub sources: BTreeMap<Source, usize>,
    /// Means by metric, environment and mode.
    pub matrix: Matrix,
    /// What the trials show: sentences, each with a figure or table that shows it.
    pub shown: Vec<Made>,
    /// A sentence on the verdicts of the thesis' statements; empty if no statement was judged.
    pub statements: String,
    /// Those that are judged.
    pub judged: Vec<Told>,
    /// What runs of the model show, each with a figure or table that shows it: speed against
    /// accuracy, and the terms that a condition requires.
    pub runs: Vec<Made>,
    /// The figures, with the one to look at first in front.
    pub figures: Vec<Made>,
    /// The figures that stages of the study's own drew.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub own_figures: Vec<OwnFigure>,
    /// Sessions whose own figures are made on demand alone.
    pub undrawn: usize,
    /// The tables, likewise.
    pub tables: Vec<Made>,
    /// What was recorded and is in no figure or table.
    pub left_out: Vec<Remark>,
    /// What is in them and is to be read with care.
    pub care: Vec<Remark>,
    /// What these data cannot show: whole sentences.
    pub limits: Vec<String>,
    /// What the deposited plan says about them, in whole sentences; empty without a plan.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub plan: Vec<String>,
}

/// A figure that a stage of the study's own drew, kept as the stage left it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct OwnFigure {
    /// Its file, from the summary's folder on, with `/`; the file that says where it comes from is
    /// called the same, with `.json` behind it.
    pub path: String,
    /// What it shows, as study.toml says.
    pub caption: String,
    /// Who drew it: `stage grip of the study: python3 grip.py`.
    pub made_by: String,
    /// Whether simulated data go into it.
    pub simulated: bool,
}

impl OwnFigure {
    /// Its caption: what it shows, who drew it, and whether it shows simulated data.
    pub fn in_words(&self) -> String {
        let caption = self.caption.trim_end_matches('.');
        let mark = if self.simulated { SYNTHETIC } else { "" };
        let by = &self.made_by;
        format!("{caption}. Not drawn by zwidth, but by the {by}. {mark}").trim_end().to_owned()
    }
}

/// What the part is called that shows them.
const OWN_FIGURES: &str = "Figures of the study’s own stages";

/// A figure or a table that was made, or a sentence that one of them shows.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Made {
    /// Its file, from the summary's folder on, with `/`; of checked ids, so that a link needs no
    /// escape.
    pub path: String,
    /// What it shows, one line.
    pub caption: Sentence,
    /// What figures of its kind show; nothing of a table.
    #[serde(skip)]
    pub kind: String,
    /// The question that a sentence answers.
    #[serde(skip)]
    pub question: Asked,
    /// Whether it is a sentence that the page begins with.
    #[serde(skip)]
    pub is_answer: bool,
}

impl Made {
    /// A table, or a sentence that a table or figure shows.
    pub fn new(path: impl Into<String>, caption: impl Into<Sentence>) -> Self {
        Self {
            path: path.into(),
            caption: caption.into(),
            kind: String::new(),
            question: Asked::Else,
            is_answer: false,
        }
    }

    /// Its file's name: `modes.P01.S01.spring.svg`.
    fn name(&self) -> &str {
        self.path.rsplit('/').next().unwrap_or_default()
    }
}

/// Something that was left out, or is to be read with care.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub struct Remark {
    /// What: a trial, a file, a panel, a figure.
    pub what: String,
    /// Why.
    pub why: String,
}

/// The summary in Markdown: what the study is, what was made, what was left out and what to read
/// with care, and why; what it cannot show.
///
/// Simulated data are named as such before anything else. With one participant, the text says that
/// it is about nobody else. All texts are escaped, so they are set unchanged.
pub fn summary_markdown(summary: &Summary) -> String {
    let origins = sources(&summary.sources).map(|origins| {
        let mark = origins.mark.map(|mark| format!("**{mark}** ")).unwrap_or_default();
        (mark + &origins.text).trim_end().to_owned()
    });
    let what = escape(&what_it_is(summary));
    // Whether data are simulated comes before anything else.
    let facts = [origins, Some(what), participants(summary.participants)];
    let mut parts = vec![format!("# {}", escape(&summary.title))];
    parts.extend(facts.into_iter().flatten());
    if let Some(figure) = summary.figures.iter().find(|figure| figure.path == VERDICTS_FIGURE) {
        parts.push(format!("![{}]({})", escape(&figure.caption.to_string()), figure.path));
    }
    let joined = |texts: [Option<String>; 2]| -> String {
        texts.into_iter().flatten().collect::<Vec<_>>().join("\n\n")
    };
    let statements = (!summary.statements.is_empty()).then(|| {
        let judged = bullets(&summary.judged, |told| linked(&told.text(), &told.path));
        joined([Some(escape(&summary.statements)), judged])
    });
    let figures = listed(&summary.figures, "No figure was made.");
    let sections = [
        ("The modes compared", grid(&summary.matrix)),
        ("What the trials show", bullets(&summary.shown, tell)),
        ("The thesis' statements", statements),
        (PLAN, bullets(&summary.plan, |sentence| escape(sentence))),
        (RUNS, bullets(&summary.runs, tell)),
        ("Figures", Some(joined([Some(figures), on_demand(summary.undrawn)]))),
        (
            OWN_FIGURES,
            bullets(&summary.own_figures, |figure| {
                format!("[{}]({})", escape(&figure.in_words()), figure.path)
            }),
        ),
        ("Tables", Some(listed(&summary.tables, "No table was made."))),
        ("Left out", bullets(&summary.left_out, remark).or(Some(nothing(summary).to_owned()))),
        ("Read with care", bullets(&summary.care, remark)),
        ("What these data cannot show", bullets(&summary.limits, |limit| escape(limit))),
    ];
    for (title, body) in sections {
        parts.extend(body.map(|body| format!("## {title}\n\n{body}")));
    }
    parts.join("\n\n") + "\n"
}

/// Where figures of single sessions are, where no run makes them.
pub(crate) fn on_demand(undrawn: usize) -> Option<String> {
    let sessions = counted(undrawn, "sessions");
    (undrawn > 0).then(|| {
        format!(
            "Figures of single sessions (modes, loops, repeats, replay) are made on demand, of {sessions}: `zwidth figure \
             STUDY` lists them, and a run makes those of the sessions that `sessions` in `[figures]` of study.toml names."
        )
    })
}

/// Device, participants, sessions, trials and sweeps, as far as there are any.
fn what_it_is(summary: &Summary) -> String {
    let Summary { participants, sessions, trials, sweeps, .. } = *summary;
    let counted = match amounts([participants, sessions, trials, sweeps], "sweeps").as_slice() {
        [] => "no trial that counts, no sweep".to_owned(),
        amounts => amounts.join(", "),
    };
    let device = (!summary.device.is_empty()).then(|| format!("Device: {}. ", summary.device));
    format!("{}Data: {counted}.", device.unwrap_or_default())
}

/// The matrix as a table, if there is anything in it.
fn grid(matrix: &Matrix) -> Option<String> {
    let line = |cells: &[&str]| {
        let cells: Vec<String> = cells.iter().map(|cell| escape(cell)).collect();
        format!("| {} |", cells.join(" | "))
    };
    let labels = matrix.modes.iter().map(|(_, label)| label.as_str());
    let head: Vec<&str> = ["metric", "environment"].into_iter().chain(labels).collect();
    let mut lines = vec![line(&head), format!("|{}", " --- |".repeat(head.len()))];
    for row in &matrix.rows {
        let means = row.cells.iter().map(|cell| cell.as_deref().unwrap_or(NO_MEAN));
        let cells: Vec<&str> = [row.metric.as_str(), &row.label].into_iter().chain(means).collect();
        lines.push(line(&cells));
    }
    let table = format!("{}\n\n{}", lines.join("\n"), escape(&matrix.caption));
    (!matrix.rows.is_empty()).then_some(table)
}

/// A list of the items, if there are any.
fn bullets<T>(items: &[T], line: impl Fn(&T) -> String) -> Option<String> {
    let lines: Vec<String> = items.iter().map(|item| format!("- {}", line(item))).collect();
    (!lines.is_empty()).then(|| lines.join("\n"))
}

/// More files than these are listed by kind, not one by one.
const MOST_LISTED: usize = 100;

/// Figures or tables; where they are many, those of a kind in one line: how many, the first and the
/// last.
fn listed(files: &[Made], none: &str) -> String {
    if files.len() <= MOST_LISTED {
        return bullets(files, link_to).unwrap_or_else(|| none.to_owned());
    }
    // `modes` of `figures/modes.P01.S01.spring.svg`.
    let kinds = groups(files, |one| one.name().split('.').next().unwrap_or_default());
    let lines = kinds.iter().map(|(kind, of_kind)| match of_kind.as_slice() {
        [first, .., last] => format!(
            "- {}: {} files, from {} to {}",
            escape(kind),
            of_kind.len(),
            link_to(first),
            link_to(last)
        ),
        few => few.iter().map(|one| format!("- {}", link_to(one))).collect(),
    });
    let lines: Vec<String> = lines.collect();
    format!("{} files of {} kinds.\n\n{}", files.len(), kinds.len(), lines.join("\n"))
}

/// Figures or tables by their kind, kinds and those of one in their order.
fn groups<'a>(
    files: impl IntoIterator<Item = &'a Made>,
    kind_of: impl Fn(&'a Made) -> &'a str,
) -> Vec<(&'a str, Vec<&'a Made>)> {
    let mut groups: Vec<(&str, Vec<&Made>)> = Vec::new();
    for file in files {
        match groups.iter_mut().find(|(kind, _)| *kind == kind_of(file)) {
            Some((_, group)) => group.push(file),
            None => groups.push((kind_of(file), vec![file])),
        }
    }
    groups
}

fn link_to(file: &Made) -> String {
    format!("[{}]({})", escape(&file.caption.to_string()), file.path)
}

/// A sentence, and a link to where it is seen.
fn tell(sentence: &Made) -> String {
    linked(&sentence.caption.to_string(), &sentence.path)
}

fn linked(text: &str, path: &str) -> String {
    let what = if path.starts_with("figures/") { "figure" } else { "table" };
    format!("{} ([{what}]({path}))", escape(text))
}

fn remark(remark: &Remark) -> String {
    format!("{}: {}", escape(&remark.what), escape(&remark.why))
}

/// The sentence where nothing was left out; a study without data has nothing to leave out.
fn nothing(summary: &Summary) -> &'static str {
    if summary.trials == 0 && summary.sweeps == 0 {
        "There is no trial that counts and no sweep, so that nothing could be left out."
    } else if summary.tables.is_empty() {
        "No table was made, so that nothing could be left out of one."
    } else {
        "Nothing was left out."
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample() -> Summary {
        Summary {
            title: "A spring, a wall & 3 modes".to_owned(),
            device: "lever_2".to_owned(),
            participants: 2,
            sessions: 4,
            trials: 142,
            sources: BTreeMap::from([(Source::Recorded, 142)]),
            shown: vec![Made::new(
                "tables/conditions.md",
                "In none of 142 trials did the lever swing fast.",
            )],
            statements: "Of 2 statements, 1 is supported.".to_owned(),
            judged: vec![Told {
                statement: "The lever moves".to_owned(),
                source: "§5.3".to_owned(),
                verdict: "supported".to_owned(),
                evidence: "Largest angle: 30°.".to_owned(),
                path: "figures/spring.svg".to_owned(),
            }],
            runs: vec![Made::new(
                "figures/trade.spring_active.png",
                "Spring, active: exact is the cheapest run.",
            )],
            figures: vec![Made::new("figures/spring.svg", "Spring: θ, F, θ̇, mean of six")],
            tables: vec![Made::new("tables/metrics.md", "Metrics, one row per trial")],
            left_out: vec![Remark {
                what: "P01 S01 trial 17".to_owned(),
                why: "excluded: cable caught".to_owned(),
            }],
            limits: vec!["Two participants cannot show an effect after Holm.".to_owned()],
            ..Summary::default()
        }
    }

    #[track_caller]
    fn check(summary: Summary, expect: &[&str]) {
        let text = summary_markdown(&summary);
        for expect in expect {
            assert!(text.contains(expect), "{text}");
        }
    }

    #[test]
    fn the_plan_and_what_is_to_be_read_with_care_have_sections_of_their_own() {
        let plan = ["Not as planned.", "Deviation: alpha was 0.05, is 0.01."].map(str::to_owned);
        let expect = "\n\n## The deposited plan\n\n- Not as planned.\n- Deviation: alpha was 0.05, is 0.01.\n\n## What a";
        check(Summary { plan: plan.to_vec(), ..sample() }, &[expect]);
        let what = "P01 S01 trial 2".to_owned();
        let care = vec![Remark { what, why: "61.0° lies outside".to_owned() }];
        let expect = "\n\n## Read with care\n\n- P01 S01 trial 2: 61.0° lies outside\n\n## What";
        check(Summary { care, ..sample() }, &[expect]);
    }

    #[test]
    fn the_summary_says_what_was_made_and_what_was_not() {
        let expect = "\
# A spring, a wall \\& 3 modes

All data were recorded on the device.

Device: lever\\_2. Data: 2 participants, 4 sessions, 142 trials that count.

## What the trials show

- In none of 142 trials did the lever swing fast. ([table](tables/conditions.md))

## The thesis' statements

Of 2 statements, 1 is supported.

- The lever moves (§5.3): supported. Largest angle: 30°. ([figure](figures/spring.svg))

## What a run of the model requires

- Spring, active: exact is the cheapest run. ([figure](figures/trade.spring_active.png))

## Figures

- [Spring: θ, F, θ̇, mean of six](figures/spring.svg)

## Tables

- [Metrics, one row per trial](tables/metrics.md)

## Left out

- P01 S01 trial 17: excluded: cable caught

## What these data cannot show

- Two participants cannot show an effect after Holm.
";
        assert_eq!(summary_markdown(&sample()), expect);
    }

    #[test]
    fn many_figures_are_counted_by_kind_with_the_first_and_the_last() {
        let figure = |i: usize| {
            let path = format!("figures/modes.P{i:03}.S01.spring.svg");
            Made::new(path, format!("P{i:03} in the spring"))
        };
        let likert = Made::new("figures/likert.svg", "answers");
        let figures: Vec<Made> = (1..=150).map(figure).chain([likert]).collect();
        let expect = [
            "## Figures\n\n151 files of 2 kinds.\n\n- modes: 150 files, from [P001 in",
            " to [P150 in the spring](figures/modes.P150.S01.spring.svg)\n",
            "\n- [answers](figures/likert.svg)\n",
        ];
        check(Summary { figures, ..sample() }, &expect);
    }

    #[test]
    fn one_participant_is_said_to_stand_for_nobody_else() {
        let expect = [
            "1 participant, 1 session, 1 trial that counts.",
            "describes this one participant and nobody else",
        ];
        check(Summary { participants: 1, sessions: 1, trials: 1, ..sample() }, &expect);
    }

    #[test]
    fn simulated_data_are_called_so_before_anything_else() {
        let sources = BTreeMap::from([(Source::Twin, 142)]);
        let text = summary_markdown(&Summary { sources, ..sample() });
        let mark = "**All data are simulated: nothing here was measured.**";
        assert_eq!(text.lines().nth(2), Some(mark));
    }

    #[test]
    fn nothing_was_left_out_is_said_only_where_something_was_made() {
        let said = |summary: Summary| summary_markdown(&summary).contains("Nothing was left out.");
        let whole = Summary { left_out: Vec::new(), ..sample() };
        assert!(said(whole.clone()));
        assert!(!said(Summary { tables: Vec::new(), ..whole.clone() }));
        assert!(!said(Summary { trials: 0, sweeps: 0, ..whole }));
    }

    #[test]
    fn a_run_that_made_nothing_says_so() {
        let text = summary_markdown(&Summary { title: "Empty".to_owned(), ..Summary::default() });
        let expect = "# Empty\n\nData: no trial that counts, no sweep.\n\n## Figures\n\nNo figure was made.\n\n\
                      ## Tables\n\nNo table was made.\n\n## Left out\n\n\
                      There is no trial that counts and no sweep, so that nothing could be left out.\n";
        assert_eq!(text, expect);
    }
}
