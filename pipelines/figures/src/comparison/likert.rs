//! Figure 30: answers as diverging bars, with their counts in the boxes; for several people, one
//! strip each. Scales of many points are in `ratings`.

use crate::words::{mark, plain};
use crate::{About, FigureKind};
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use zwidth_draw::{Axis, Cell, Figure, Layer, Likert, LikertScale, Panel, Ticks};
use zwidth_results::GivenAnswer;
use zwidth_study::{
    AnswerScale, AnswerValue, Environment, EnvironmentId, Mode, ParticipantId, Question,
    QuestionId, Source,
};

/// The figure of answers by environment or group.
pub const LIKERT: FigureKind = FigureKind::new(
    "likert",
    "answers, diverging bars: counts of one person, a strip a person of several",
    "answer",
);

/// The figure of answers by question.
pub const LIKERT_ITEMS: FigureKind =
    FigureKind::new("likert_items", "answers to each question", "answer");

/// Panels that fit on a page: two columns of six.
const A_PAGE: usize = 12;
/// Height a row of one bar takes, mm.
const ROW_MM: f64 = 7.5;
/// Height a row of many strips takes, mm.
const TALL_ROW_MM: f64 = 14.0;
/// Height a strip takes of a row, mm.
const STRIP_MM: f64 = 1.3;
/// More people than this have one bar together: their strips would be hairlines.
const MOST_STRIPS: usize = 24;
/// Panels side by side in a two-column figure.
const COLUMNS: usize = 2;

/// The panels of one figure.
#[derive(Debug, Clone, PartialEq, Serialize)]
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
#[derive(Debug, Clone, PartialEq, Serialize)]
struct Wanted {
    /// The environment, the group or the question.
    title: String,
    environment: EnvironmentId,
    what: What,
    /// The questions of which answers are counted.
    questions: Vec<Question>,
    /// What was answered.
    scale: AnswerScale,
    /// Whether an answer of it was turned round.
    reversed: bool,
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
        let title = format!("{}: {}", environment.label, question.text);
        Self { title, wording: None, ..Self::named(environment, question) }
    }

    /// A question under the name of its environment.
    fn named(environment: &Environment, question: &Question) -> Self {
        Self {
            title: environment.label.clone(),
            environment: environment.id.clone(),
            what: What::Question(question.id.clone()),
            questions: vec![question.clone()],
            scale: question.scale.clone(),
            reversed: question.reversed,
            wording: Some(question.text.clone()).filter(|text| *text != environment.label),
        }
    }

    /// The questions of a group together; the heading counts those that were turned round.
    fn group(environment: &Environment, group: &str, items: &[&Question]) -> Self {
        let what = What::Group(group.to_owned());
        let questions = items.iter().map(|item| (*item).clone()).collect();
        let scale = items.first().map(|q| q.scale.clone()).unwrap_or_default();
        let reversed = items.iter().filter(|q| q.reversed).count();
        let title = match reversed {
            0 => format!("{}: {group}", environment.label),
            n => format!("{}: {group} ({n} of {} items reversed)", environment.label, items.len()),
        };
        let environment = environment.id.clone();
        Self { title, environment, what, questions, scale, reversed: reversed > 0, wording: None }
    }
}

/// The pages of the overview, from the questions that were answered in each environment: one panel
/// per environment with one question; else one per group, and one per question without a group.
pub fn likert_overview(answered: &[(&Environment, Vec<&Question>)]) -> Vec<LikertPage> {
    pages(answered.iter().flat_map(|(environment, questions)| overview(environment, questions)))
}

/// The pages of every single question, where an environment has several.
pub fn likert_items(answered: &[(&Environment, Vec<&Question>)]) -> Vec<LikertPage> {
    let several = answered.iter().filter(|(_, questions)| questions.len() > 1);
    pages(several.flat_map(|(e, questions)| questions.iter().map(|q| Wanted::item(e, q))))
}

/// A page has one scale, so that one legend holds for all of it.
fn pages(wanted: impl Iterator<Item = Wanted>) -> Vec<LikertPage> {
    let mut by_scale: BTreeMap<AnswerScale, Vec<Wanted>> = BTreeMap::new();
    // Scales of many points have figures of their own, `ratings`.
    for panel in wanted.filter(|w| w.scale.is_ordinal()) {
        by_scale.entry(panel.scale.clone()).or_default().push(panel);
    }
    let pages = by_scale.values().flat_map(|wanted| wanted.chunks(A_PAGE));
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
                let items = questions.iter().filter(|q| q.group.as_deref() == Some(group));
                let items: Vec<&Question> = items.copied().collect();
                wanted.push(Wanted::group(environment, group, &items));
            }
            Some(_) => {}
        }
    }
    wanted
}

/// One panel: a heading, and for each row a label and everybody's counts of the answers, from 1 on.
struct Counted {
    title: String,
    scale: AnswerScale,
    rows: Vec<(String, Vec<Vec<u32>>)>,
}

/// Diverging bars, two panels side by side.
pub fn likert(
    about: &About,
    LikertPage(wanted): &LikertPage,
    answers: &[GivenAnswer],
    sources: &[Source],
) -> Figure {
    let title = &about.title;
    let panels: Vec<Counted> =
        wanted.iter().map(|w| count_rows(&about.modes, answers, w)).collect();
    let columns = COLUMNS.min(panels.len().max(1));
    let strips = panels.iter().flat_map(|panel| &panel.rows).map(|(_, strips)| strips);
    let people = strips.clone().map(Vec::len).max().unwrap_or_default();
    let totals: BTreeSet<u32> = strips.map(|strips| strips.iter().flatten().sum()).collect();
    // Counts can be compared only between bars of equal length.
    let scale = match people <= 1 && totals.len() <= 1 {
        true => LikertScale::Counts,
        false => LikertScale::Percent,
    };
    let drawn =
        panels.iter().enumerate().map(|(i, p)| panel(p, Cell::at(i / columns, i % columns), scale));
    let answered = scale_of(wanted);
    let [first, last] = [answered.lowest(), answered.highest()].map(|answer| match &answered {
        AnswerScale::Numbers(_) => answered.worded(answer),
        named => named.word(answer).unwrap_or_default().to_owned(),
    });
    let middle = match answered.points() % 2 {
        0 => "zero lies between the two halves",
        _ => "the neutral answers straddle zero",
    };
    Figure {
        title: Some(plain(title)),
        description: format!(
            "{title}: answers from {first} to {last}, a row of boxes each; {middle}."
        ),
        width_mm: if columns == 1 { 120.0 } else { zwidth_draw::TWO_COLUMNS_MM },
        panels: drawn.collect(),
        footnotes: footnotes(wanted, people).iter().map(|n| plain(n)).collect(),
        mark: mark(sources.iter().copied()),
        ..Figure::default()
    }
}

/// The one scale of a page.
fn scale_of(page: &[Wanted]) -> AnswerScale {
    page.first().map(|w| w.scale.clone()).unwrap_or_default()
}

/// One row per mode, in the study's order; people by their mean answer, the highest at the top.
fn count_rows(modes: &[Mode], answers: &[GivenAnswer], wanted: &Wanted) -> Counted {
    let scale = &wanted.scale;
    let points: Vec<AnswerValue> = scale.answers().into_iter().map(AnswerValue::from).collect();
    let mut rows = Vec::new();
    for mode in modes {
        let mut counts: BTreeMap<&ParticipantId, Vec<u32>> = BTreeMap::new();
        for row in answers
            .iter()
            .filter(|row| row.environment == wanted.environment && row.mode == mode.id)
        {
            let question = wanted.questions.iter().find(|question| question.id == row.question);
            let Some(question) = question else { continue };
            let scored = question.scale.score(row.answer, question.reversed);
            let Some(place) = points.iter().position(|point| *point == scored) else { continue };
            let own = counts.entry(&row.participant);
            own.or_insert_with(|| vec![0; points.len()])[place] += 1;
        }
        let mut strips: Vec<Vec<u32>> = counts.into_values().collect();
        strips.sort_by(|a, b| mean_place(b).total_cmp(&mean_place(a)));
        if !strips.is_empty() {
            // A group says in its heading how many of its questions were turned round.
            let turned = wanted.reversed && matches!(wanted.what, What::Question(_));
            let row_mark = if turned { " (reversed)" } else { "" };
            rows.push((format!("{}{row_mark}", mode.label), strips));
        }
    }
    // How many answers a bar is of: in the heading where all are of as many.
    let sizes: Vec<String> = rows.iter().map(|(_, strips)| size(strips)).collect();
    let mut title = wanted.title.clone();
    match sizes.split_first() {
        Some((first, others)) if others.iter().all(|other| other == first) => {
            title = format!("{title}: {first} per mode");
        }
        _ => {
            for ((label, _), size) in rows.iter_mut().zip(&sizes) {
                *label += &format!(", {size}");
            }
        }
    }
    for (_, strips) in rows.iter_mut().filter(|(_, strips)| strips.len() > MOST_STRIPS) {
        let all = (0..points.len()).map(|i| strips.iter().map(|counts| counts[i]).sum());
        *strips = vec![all.collect()];
    }
    Counted { title, scale: scale.clone(), rows }
}

/// The mean of a person's answers, counted from 0.
fn mean_place(counts: &[u32]) -> f64 {
    let sum: f64 = counts.iter().enumerate().map(|(i, n)| i as f64 * f64::from(*n)).sum();
    sum / f64::from(counts.iter().sum::<u32>())
}

/// `8 people × 12 answers`, `8 people × 10 to 12 answers`; of one `6 answers`.
fn size(strips: &[Vec<u32>]) -> String {
    let each: BTreeSet<u32> = strips.iter().map(|counts| counts.iter().sum()).collect();
    let answers = match (each.first(), each.last()) {
        (Some(1), Some(1)) => "1\u{a0}answer".to_owned(),
        (Some(least), Some(most)) if least < most => {
            format!("{least}\u{a0}to\u{a0}{most}\u{a0}answers")
        }
        (_, most) => format!("{}\u{a0}answers", most.copied().unwrap_or_default()),
    };
    match strips.len() {
        1 => answers,
        people => format!("{people}\u{a0}people\u{a0}×\u{a0}{answers}"),
    }
}

/// The wording where a panel is named after its environment, and what was reversed.
fn footnotes(wanted: &[Wanted], people: usize) -> Vec<String> {
    let worded = wanted.iter().filter_map(|w| Some((&w.title, w.wording.as_ref()?)));
    let mut notes: Vec<String> =
        worded.map(|(title, wording)| format!("{title}: “{wording}”")).collect();
    if (2..=MOST_STRIPS).contains(&people) {
        notes.push(
            "One strip a person: the shares of their answers after a mode, in the order of their means."
                .to_owned(),
        );
    }
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
    let unit = if scale == LikertScale::Percent { "%" } else { "" };
    let x = Axis { ticks: Ticks::Magnitudes, ..Axis::new(label, unit) }.linked("answers");
    let y = Axis::categories(p.rows.iter().map(|(label, _)| plain(label)));
    let bars = Likert {
        answers: p.scale.answers().into_iter().map(|a| plain(&legend(&p.scale, a))).collect(),
        rows: p.rows.iter().map(|(_, strips)| strips.clone()).collect(),
        scale,
    };
    let panel = Panel::new(cell, x, y, vec![Layer::Likert(bars)]).titled(plain(&p.title));
    let strips = p.rows.iter().map(|(_, strips)| strips.len()).max().unwrap_or(1);
    let row_mm = (STRIP_MM * strips as f64).clamp(ROW_MM, TALL_ROW_MM);
    panel.tall(row_mm * p.rows.len() as f64)
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
