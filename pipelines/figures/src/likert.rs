//! Figure 30: answers as diverging bars, their counts in the boxes. Scales of many points are in
//! `ratings`.

use crate::words::{mark, plain};
use crate::{About, FigureKind};
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use zwidth_draw::{Axis, Cell, Figure, Layer, Likert, LikertScale, Panel, Ticks};
use zwidth_study::{AnswerScale, Environment, EnvironmentId, Mode, Question, QuestionId, Source};
use zwidth_tables::{Table, TableError};

/// The figure of answers by environment or group.
pub const LIKERT: FigureKind = FigureKind {
    stem: "likert",
    shows: "answers, diverging bars with counts",
    drawn_from: "answer",
};

/// The figure of answers by question.
pub const LIKERT_ITEMS: FigureKind =
    FigureKind { stem: "likert_items", shows: "answers to each question", drawn_from: "answer" };

/// Panels that fit on a page: two columns of six.
const A_PAGE: usize = 12;
/// Height a row of bars takes, mm.
const ROW_MM: f64 = 7.5;
/// Panels side by side in a two-column figure.
const COLUMNS: usize = 2;

/// The panels of one figure.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct LikertPage(Vec<Wanted>);

impl LikertPage {
    /// Whether an answer to this question after a trial in this environment is on the page.
    pub fn shows(&self, environment: &EnvironmentId, question: &Question) -> bool {
        self.0.iter().filter(|w| w.environment == *environment).any(|w| match &w.what {
            What::Question(id) => *id == question.id,
            What::Group(group) => question.group.as_ref() == Some(group),
        })
    }
}

/// A panel to be: its heading, and which rows of the tally it shows.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
struct Wanted {
    /// The environment, the group or the question.
    title: String,
    environment: EnvironmentId,
    what: What,
    /// What was answered.
    scale: AnswerScale,
    /// Whether an answer of it was turned round.
    pub(crate) reversed: bool,
    /// The question's wording, where the heading is another.
    wording: Option<String>,
}

#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
enum What {
    Question(QuestionId),
    Group(String),
}

impl Wanted {
    /// A question under its wording.
    fn item(environment: &Environment, question: &Question) -> Self {
        let wording = None;
        Self { title: question.text.clone(), wording, ..Self::named(environment, question) }
    }

    /// A question under the name of its environment.
    fn named(environment: &Environment, question: &Question) -> Self {
        Self {
            title: environment.label.clone(),
            environment: environment.id.clone(),
            what: What::Question(question.id.clone()),
            scale: question.scale.clone(),
            reversed: question.reversed,
            wording: Some(question.text.clone()).filter(|text| *text != environment.label),
        }
    }

    /// The questions of a group together; those that were turned round are counted in its heading.
    fn group(environment: &Environment, group: &str, items: &[&Question]) -> Self {
        let (what, environment) = (What::Group(group.to_owned()), environment.id.clone());
        let scale = items.first().map(|q| q.scale.clone()).unwrap_or_default();
        let reversed = items.iter().filter(|q| q.reversed).count();
        let title = match reversed {
            0 => group.to_owned(),
            n => format!("{group} ({n} of {} items reversed)", items.len()),
        };
        Self { title, environment, what, scale, reversed: reversed > 0, wording: None }
    }

    /// What a row of it is marked with: a question that was turned round says so at each bar.
    fn row_mark(&self) -> &'static str {
        let turned = self.reversed && matches!(self.what, What::Question(_));
        if turned { " (reversed)" } else { "" }
    }
}

/// The pages of the overview, from the questions that were answered in each environment: one panel
/// an environment with one question; else one per group, and one per question without a group.
pub fn likert_overview(asked: &[(&Environment, Vec<&Question>)]) -> Vec<LikertPage> {
    pages(asked.iter().flat_map(|(environment, questions)| overview(environment, questions)))
}

/// The pages of every single question, where an environment has several.
pub fn likert_items(asked: &[(&Environment, Vec<&Question>)]) -> Vec<LikertPage> {
    let several = asked.iter().filter(|(_, questions)| questions.len() > 1);
    pages(several.flat_map(|(e, questions)| questions.iter().map(|q| Wanted::item(e, q))))
}

/// A page has one scale, so that one legend holds for all of it.
fn pages(wanted: impl Iterator<Item = Wanted>) -> Vec<LikertPage> {
    let mut of_scales: BTreeMap<AnswerScale, Vec<Wanted>> = BTreeMap::new();
    let few = wanted.filter(|w| w.scale.is_ordinal());
    few.for_each(|w| of_scales.entry(w.scale.clone()).or_default().push(w));
    let pages = of_scales.values().flat_map(|wanted| wanted.chunks(A_PAGE));
    pages.map(|page| LikertPage(page.to_vec())).collect()
}

fn overview(environment: &Environment, questions: &[&Question]) -> Vec<Wanted> {
    if let [only] = questions {
        return vec![Wanted::named(environment, only)];
    }
    let mut seen = BTreeSet::new();
    let mut wanted = Vec::new();
    for question in questions {
        match question.group.as_deref() {
            None => wanted.push(Wanted::item(environment, question)),
            Some(group) if seen.insert(group) => {
                let is_item = |q: &&&Question| q.group.as_deref() == Some(group);
                let items: Vec<&Question> = questions.iter().filter(is_item).copied().collect();
                wanted.push(Wanted::group(environment, group, &items));
            }
            Some(_) => {}
        }
    }
    wanted
}

/// One panel: a heading, and for each row a label and the counts of the answers, from 1 on.
struct Counted {
    title: String,
    scale: AnswerScale,
    rows: Vec<(String, Vec<u32>)>,
}

/// Diverging bars, two panels side by side. `tally` is the table of the stage `likert`.
///
/// # Errors
/// A tally that lacks a column.
pub fn likert(
    about: &About,
    LikertPage(wanted): &LikertPage,
    tally: &Table,
    sources: &[Source],
) -> Result<Figure, TableError> {
    let title = &about.title;
    let panels =
        wanted.iter().map(|w| count_rows(&about.modes, tally, w)).collect::<Result<Vec<_>, _>>()?;
    let columns = COLUMNS.min(panels.len().max(1));
    let totals = panels.iter().flat_map(|p| &p.rows).map(|(_, counts)| counts.iter().sum::<u32>());
    let (least, most) = totals.fold((u32::MAX, 0), |(a, b), n| (a.min(n), b.max(n)));
    let scale = if least == most { LikertScale::Counts } else { LikertScale::Percent };
    let drawn =
        panels.iter().enumerate().map(|(i, p)| panel(p, Cell::at(i / columns, i % columns), scale));
    Ok(Figure {
        title: Some(plain(title)),
        description: describe(title, &scale_of(wanted)),
        width_mm: if columns == 1 { 120.0 } else { zwidth_draw::TWO_COLUMNS_MM },
        panels: drawn.collect(),
        footnotes: footnotes(wanted).iter().map(|n| plain(n)).collect(),
        mark: mark(sources.iter().copied()),
        ..Figure::default()
    })
}

/// The one scale of a page.
fn scale_of(page: &[Wanted]) -> AnswerScale {
    page.first().map(|w| w.scale.clone()).unwrap_or_default()
}

fn describe(title: &str, scale: &AnswerScale) -> String {
    let [first, last] = [scale.lowest(), scale.highest()].map(|answer| match scale {
        AnswerScale::Numbers(_) => scale.worded(answer),
        named => named.word(answer).unwrap_or_default().to_owned(),
    });
    let middle = match scale.points() % 2 {
        0 => "zero lies between the two halves",
        _ => "the neutral answers straddle zero",
    };
    format!("{title}: number of answers from {first} to {last}, a row of boxes each; {middle}.")
}

/// One row per mode, in the study's order.
fn count_rows(modes: &[Mode], tally: &Table, wanted: &Wanted) -> Result<Counted, TableError> {
    let texts = |column| tally.texts(column);
    let (environments, of_modes) = (texts("environment")?, texts("mode")?);
    let (questions, groups) = (texts("question")?, texts("group")?);
    let counts = (1..=wanted.scale.points()).map(|k| tally.integers(&format!("count_{k}")));
    let counts = counts.collect::<Result<Vec<_>, _>>()?;
    let is_wanted = |row: usize| match &wanted.what {
        What::Question(id) => questions[row].as_deref() == Some(id.as_str()),
        What::Group(group) => {
            questions[row].is_none() && groups[row].as_deref() == Some(group.as_str())
        }
    };
    let row = |mode: &Mode| {
        let found = (0..tally.height()).find(|row| {
            environments[*row].as_deref() == Some(wanted.environment.as_str())
                && of_modes[*row].as_deref() == Some(mode.id.as_str())
                && is_wanted(*row)
        })?;
        let count = |of: &Vec<Option<i64>>| of[found].and_then(|n| n.try_into().ok()).unwrap_or(0);
        let label = format!("{}{}", mode.label, wanted.row_mark());
        Some((label, counts.iter().map(count).collect()))
    };
    let rows = modes.iter().filter_map(row).collect();
    Ok(Counted { title: wanted.title.clone(), scale: wanted.scale.clone(), rows })
}

/// The wording where a panel is named after its environment, and what was reversed.
fn footnotes(wanted: &[Wanted]) -> Vec<String> {
    let worded = wanted.iter().filter_map(|w| Some((&w.title, w.wording.as_ref()?)));
    let mut notes: Vec<String> =
        worded.map(|(title, wording)| format!("{title}: “{wording}”")).collect();
    if wanted.iter().any(|w| w.reversed) {
        notes.push(format!(
            "Reversed: answers are turned round ({} − a), so that right is favourable; what was given is the answer \
             at the other end.",
            scale_of(wanted).ends_together()
        ));
    }
    notes
}

fn panel(p: &Counted, cell: Cell, scale: LikertScale) -> Panel {
    let label = match p.scale {
        AnswerScale::Numbers(_) => "answers, lower ← → higher",
        _ => "answers, against ← → in favour",
    };
    let unit = match scale {
        LikertScale::Counts => "",
        LikertScale::Percent => "%",
    };
    let x = Axis { ticks: Ticks::Magnitudes, ..Axis::new(label, unit) }.linked("answers");
    let y = Axis::categories(p.rows.iter().map(|(label, _)| plain(label)));
    let bars = Likert {
        answers: p.scale.answers().into_iter().map(|a| plain(&legend(&p.scale, a))).collect(),
        rows: p.rows.iter().map(|(_, counts)| counts.clone()).collect(),
        scale,
    };
    let panel = Panel::new(cell, x, y, vec![Layer::Likert(bars)]).titled(plain(&p.title));
    Panel { height_mm: Some(ROW_MM * p.rows.len() as f64), ..panel }
}

/// An answer in the legend: its word, with its number before it on a scale by numbers; the number
/// alone where it has no word.
fn legend(scale: &AnswerScale, answer: i16) -> String {
    let number = shown(answer);
    match (scale, scale.word(answer)) {
        (AnswerScale::Numbers(_), Some(word)) => format!("{number} {word}"),
        (_, Some(word)) => word.to_owned(),
        (_, None) => number,
    }
}

/// A number as it stands in a figure: with a minus sign, not a hyphen.
pub(crate) fn shown(answer: i16) -> String {
    answer.to_string().replace('-', "−")
}
