//! Answers on scales of many points: each answer, with median, quartiles and mean.

use super::answers::beside_each_other;
use super::likert::shown;
use crate::words::{mark, plain};
use crate::{About, FigureKind};
use serde::Serialize;
use std::collections::BTreeMap;
use zwidth_draw::style::{self, Marker};
use zwidth_draw::{Axis, Cell, Direction, Figure, Intervals, Layer, Panel, Range, Reference};
use zwidth_results::{AnswerTally, GivenAnswer};
use zwidth_study::{Environment, EnvironmentId, Mode, ModeId, Question, QuestionId, Source};

/// The figure [`ratings`].
pub const RATINGS: FigureKind = FigureKind::new(
    "ratings",
    "answers on scales of many points: each, with median, quartiles and mean",
    "answer",
);

/// Panels that fit on a page: two columns of four.
const A_PAGE: usize = 8;
/// Panels side by side.
const COLUMNS: usize = 2;
/// Height that a mode takes, mm.
const ROW_MM: f64 = 11.0;
/// How far median and mean lie below the answers, in rows.
const BELOW: f64 = 0.36;
/// Room beyond both ends of a scale, as a share of it.
const MARGIN: f64 = 0.04;

/// The panels of one figure.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RatingsPage(Vec<Wanted>);

/// A panel to be: a question after trials in an environment.
#[derive(Debug, Clone, PartialEq, Serialize)]
struct Wanted {
    title: String,
    environment: EnvironmentId,
    question: Question,
}

impl RatingsPage {
    /// Whether an answer to this question after a trial in this environment is on the page.
    pub fn shows(&self, environment: &EnvironmentId, question: &QuestionId) -> bool {
        self.0.iter().any(|w| w.environment == *environment && w.question.id == *question)
    }
}

/// The pages of the questions with a scale of many points, from those that were answered in each
/// environment.
pub fn ratings_pages(answered: &[(&Environment, Vec<&Question>)]) -> Vec<RatingsPage> {
    let several = answered.len() > 1;
    let mut wanted = Vec::new();
    for (environment, questions) in answered {
        for question in questions.iter().filter(|q| !q.scale.is_ordinal()) {
            let title = match several {
                true => format!("{}: {}", environment.label, question.text),
                false => question.text.clone(),
            };
            let environment = environment.id.clone();
            let question = (*question).clone();
            wanted.push(Wanted { title, environment, question });
        }
    }
    wanted.chunks(A_PAGE).map(|page| RatingsPage(page.to_vec())).collect()
}

/// Every answer as a dot, with median, quartiles and mean, one row per mode.
pub fn ratings(
    about: &About,
    RatingsPage(wanted): &RatingsPage,
    tally: &[AnswerTally],
    answers: &[GivenAnswer],
    sources: &[Source],
) -> Figure {
    let columns = COLUMNS.min(wanted.len().max(1));
    let mut panels = Vec::new();
    for (i, wanted) in wanted.iter().enumerate() {
        let cell = Cell::at(i / columns, i % columns);
        panels.push(panel(&about.modes, wanted, cell, tally, answers));
    }
    let mut notes =
        vec!["Grey: every answer. Black: median with quartiles; diamond: mean.".to_owned()];
    let mut turned = wanted.iter().filter(|w| w.question.reversed).peekable();
    if let Some(first) = turned.peek() {
        let ends = first.question.scale.ends_together();
        notes.push(match turned.all(|w| w.question.scale.ends_together() == ends) {
            true => format!("Reversed: answers are turned round ({ends} − a)."),
            false => "Reversed: answers are turned round (lowest + highest − a).".to_owned(),
        });
    }
    Figure {
        title: Some(plain(&about.title)),
        description: format!("{}: every answer on scales of many points, by mode.", about.title),
        width_mm: if columns == 1 { 120.0 } else { zwidth_draw::TWO_COLUMNS_MM },
        panels,
        footnotes: notes.iter().map(|note| plain(note)).collect(),
        mark: mark(sources.iter().copied()),
        ..Figure::default()
    }
}

fn panel(
    modes: &[Mode],
    wanted: &Wanted,
    cell: Cell,
    tally: &[AnswerTally],
    answers: &[GivenAnswer],
) -> Panel {
    let scale = &wanted.question.scale;
    let scores = scores(answers, wanted);
    let shown: Vec<&Mode> = modes.iter().filter(|mode| scores.contains_key(&mode.id)).collect();
    let middle = f64::from(scale.ends_together()) / 2.0;
    let mut layers =
        vec![Layer::Reference(Reference::new(Direction::Vertical, middle, style::zero()))];
    for (place, mode) in shown.iter().enumerate() {
        layers.push(beside_each_other(scores.get(&mode.id).cloned().unwrap_or_default(), place));
    }
    layers.extend(summaries(tally, wanted, &shown));
    let [low, high] = [scale.lowest(), scale.highest()];
    let room = MARGIN * f64::from(high - low);
    let range = Range::Fixed(f64::from(low) - room, f64::from(high) + room);
    let [first, last] = [low, high].map(|score| worded(&wanted.question, score));
    let label = format!("{first} … {last}");
    let x = Axis { range, ..Axis::new(plain(&label), "") };
    let turned = if wanted.question.reversed { " (reversed)" } else { "" };
    let names = shown.iter().map(|mode| plain(&format!("{}{turned}", mode.label)));
    let y = Axis::categories(names);
    let height_mm = ROW_MM * (shown.len() as f64 + 0.5);
    Panel::new(cell, x, y, layers).titled(plain(&wanted.title)).tall(height_mm)
}

/// The answers by mode, as scored, in rising order.
fn scores<'a>(answers: &'a [GivenAnswer], wanted: &Wanted) -> BTreeMap<&'a ModeId, Vec<f64>> {
    let Wanted { environment, question, .. } = wanted;
    let mut scores: BTreeMap<&ModeId, Vec<f64>> = BTreeMap::new();
    for row in
        answers.iter().filter(|row| row.environment == *environment && row.question == question.id)
    {
        let score = question.scale.score(row.answer, question.reversed);
        scores.entry(&row.mode).or_default().push(score.into());
    }
    scores.values_mut().for_each(|values| values.sort_by(f64::total_cmp));
    scores
}

/// Median with quartiles, and the mean, of each mode.
fn summaries(tally: &[AnswerTally], wanted: &Wanted, modes: &[&Mode]) -> [Layer; 2] {
    let question = Some(&wanted.question.id);
    let rows = modes.iter().map(|mode| {
        tally.iter().find(|row| {
            row.environment == wanted.environment
                && row.mode == mode.id
                && row.question.as_ref() == question
        })
    });
    let rows: Vec<Option<&AnswerTally>> = rows.collect();
    // A mode without a number has no mark.
    let numbers = |pick: fn(&AnswerTally) -> Option<f64>| -> Vec<f64> {
        rows.iter().map(|row| row.and_then(pick).unwrap_or(f64::NAN)).collect()
    };
    let at: Vec<f64> = (0..modes.len()).map(|place| place as f64 + BELOW).collect();
    let none = vec![f64::NAN; modes.len()];
    let median = numbers(|row| Some((row.median_low?.get() + row.median_high?.get()) / 2.0));
    let quartiles = [median, numbers(|row| row.quartile_1), numbers(|row| row.quartile_3)];
    let mean = [numbers(|row| row.mean), none.clone(), none];
    let mean = Intervals {
        marker: Marker::Diamond,
        colour: style::mode_colour(1),
        ..Intervals::new(Direction::Horizontal, at.clone(), mean)
    };
    let quartiles = Intervals::new(Direction::Horizontal, at, quartiles);
    [quartiles, mean].map(Layer::Intervals)
}

/// A score with the word of the answer that it stands for: of a reversed question that at the other
/// end.
fn worded(question: &Question, score: i16) -> String {
    // Turned round once more, a score is the answer.
    let answer = question.scale.score(score, question.reversed);
    let word = question.scale.word(answer).map(|word| format!(" {word}"));
    format!("{}{}", shown(score), word.unwrap_or_default())
}
