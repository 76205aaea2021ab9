//! Answers compared: for each question and environment, how often each participant's answers lie
//! higher in one mode than in another, and the mean over participants with its interval.

use super::compared::or_note;
use crate::words::{mark, percent, plain};
use crate::{About, FigureKind};
use serde::Serialize;
use zwidth_draw::style;
use zwidth_draw::{
    Axis, Cell, Direction, Figure, Intervals, Layer, Panel, Points, Range, Reference, dodge,
};
use zwidth_results::{AnswerDifference, PersonSuperiority};
use zwidth_study::{
    Contrast, Environment, EnvironmentId, Mode, Question, QuestionId, Source, contrast_label,
};

/// The figure [`answers_compared`].
pub const ANSWERS_COMPARED: FigureKind = FigureKind::new(
    "answers",
    "answers compared: each participant, and the mean with its interval",
    "answer",
);

/// Panels that fit on a page: two columns of six.
const A_PAGE: usize = 12;
/// Panels side by side.
const COLUMNS: usize = 2;
/// Height that one contrast's line takes, mm.
const CONTRAST_MM: f64 = 11.0;
/// How far the mean lies below the participants, in lines.
const BELOW: f64 = 0.36;

/// The panels of one figure: a heading and what it shows.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct AnswersPage(Vec<(String, EnvironmentId, QuestionId)>);

impl AnswersPage {
    /// Whether an answer to this question after a trial in this environment is on the page.
    pub fn shows(&self, environment: &EnvironmentId, question: &QuestionId) -> bool {
        self.0.iter().any(|(_, e, q)| e == environment && q == question)
    }
}

/// The pages of the answers compared: one panel per environment and question, under the name of the
/// environment, with the question's wording if it has several. Answers to a reversed question are
/// recoded, and its heading says so.
pub fn answers_pages(answered: &[(&Environment, Vec<&Question>)]) -> Vec<AnswersPage> {
    let panels: Vec<_> = answered
        .iter()
        .flat_map(|(environment, questions)| {
            questions.iter().map(|question| {
                let title = match questions.len() {
                    1 => environment.label.clone(),
                    _ => format!("{}: {}", environment.label, question.text),
                };
                let turned = if question.reversed { " (turned round)" } else { "" };
                (format!("{title}{turned}"), environment.id.clone(), question.id.clone())
            })
        })
        .collect();
    panels.chunks(A_PAGE).map(|page| AnswersPage(page.to_vec())).collect()
}

/// Answers compared: dots are participants' P(A > B) + ½ P(A = B), whiskers the interval of their
/// mean.
pub fn answers_compared(
    about: &About,
    AnswersPage(wanted): &AnswersPage,
    contrasts: &[AnswerDifference],
    participants: &[PersonSuperiority],
    sources: &[Source],
) -> Figure {
    let mut panels = Vec::new();
    for (title, environment, question) in wanted {
        // Where nobody answered in both modes there is nothing to draw.
        let rows = contrasts.iter().filter(|row| {
            (&row.environment, &row.question) == (environment, question)
                && row.superiority.is_some()
        });
        let rows: Vec<&AnswerDifference> = rows.collect();
        if !rows.is_empty() {
            let cell = Cell::at(panels.len() / COLUMNS, panels.len() % COLUMNS);
            panels.push(panel(title, cell, &rows, participants, &about.modes));
        }
    }
    Figure {
        title: Some(plain(&format!("{}: answers compared", about.title))),
        description: "How often answers lie higher in one mode than in another: each participant, \
                      and the mean with its interval."
            .to_owned(),
        panels: or_note(panels),
        footnotes: vec![plain(&format!(
            "Share of pairs in which the answer in the first mode is higher, ties counting half; at ½ neither \
             is. Dots: people. Black: their mean with its {} interval, not adjusted.",
            percent(about.confidence)
        ))],
        mark: mark(sources.iter().copied()),
        ..Figure::default()
    }
}

/// One question in one environment: a line per contrast.
fn panel(
    title: &str,
    cell: Cell,
    rows: &[&AnswerDifference],
    participants: &[PersonSuperiority],
    modes: &[Mode],
) -> Panel {
    let mut layers =
        vec![Layer::Reference(Reference::new(Direction::Vertical, 0.5, style::zero()))];
    for (place, row) in rows.iter().enumerate() {
        let own = participants.iter().filter(|person| {
            (&person.environment, &person.question, &person.contrast)
                == (&row.environment, &row.question, &row.contrast)
        });
        let mut x: Vec<f64> = own.map(|person| person.superiority).collect();
        // Equal shares must be neighbours, to be set beside each other.
        x.sort_by(f64::total_cmp);
        layers.push(beside_each_other(x, place));
    }
    let numbers = |pick: fn(&AnswerDifference) -> Option<f64>| -> Vec<f64> {
        rows.iter().map(|row| pick(row).unwrap_or(f64::NAN)).collect()
    };
    layers.push(Layer::Intervals(Intervals::new(
        Direction::Horizontal,
        (0..rows.len()).map(|place| place as f64 + BELOW).collect(),
        [
            numbers(|row| row.superiority),
            numbers(|row| row.superiority_ci_low),
            numbers(|row| row.superiority_ci_high),
        ],
    )));
    let x = Axis {
        range: Range::Fixed(-0.04, 1.04),
        ..Axis::new("share of pairs of answers", "").linked("share")
    };
    let names = rows.iter().map(|row| contrast_label(modes, &row.contrast));
    let y = Axis::categories(names.map(|name| plain(&name.replace(Contrast::MINUS, " above "))));
    let height_mm = CONTRAST_MM * (rows.len() as f64 + 0.5);
    Panel::new(cell, x, y, layers).titled(plain(title)).tall(height_mm)
}

/// Values in order as grey points of a row, equal ones beside each other so that all are seen.
pub(super) fn beside_each_other(x: Vec<f64>, row: usize) -> Layer {
    // Shares of pairs that are equal may come from other sums.
    let equal = x.chunk_by(|a, b| (a - b).abs() < 1e-9);
    let aside = equal.flat_map(|ties| (0..ties.len()).map(|i| dodge(i, ties.len())));
    let y = aside.map(|aside| row as f64 + aside).collect();
    Layer::Points(Points { x, y, colour: style::GREY, opacity: 0.6, ..Points::default() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_shares_lie_beside_each_other_and_others_on_the_line() {
        let points = beside_each_other(vec![0.25, 0.5, 0.5, 0.75], 0);
        let Layer::Points(Points { y, .. }) = points else { panic!("{points:?}") };
        assert_eq!((y[0], y[3]), (0.0, 0.0));
        assert!(y[1] < 0.0 && y[2] > 0.0, "{y:?}");
    }
}
