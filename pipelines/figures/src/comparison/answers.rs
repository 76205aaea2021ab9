//! Answers compared: for each question and environment, how often each participant's answers lie
//! higher in one mode than in another, and the mean over participants with its interval.

use super::compared::or_note;
use crate::words::{mark, percent, plain};
use crate::{About, FigureKind};
use serde::Serialize;
use zwidth_draw::style::{self, Marker};
use zwidth_draw::{
    Axis, Cell, Direction, Figure, Intervals, Layer, Panel, Points, Range, Reference, dodge,
};
use zwidth_results::{AnswerDifference, PersonSuperiority};
use zwidth_study::{
    Contrast, Environment, EnvironmentId, Mode, Question, QuestionId, Source, contrast_label,
};

/// The figure [`answers_compared`].
pub const ANSWERS_COMPARED: FigureKind = FigureKind {
    stem: "answers",
    shows: "answers compared: each participant, and the mean with its interval",
    drawn_from: "answer",
};

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
    let mut layers = vec![Layer::Reference(Reference {
        direction: Direction::Vertical,
        at: 0.5,
        label: None,
        stroke: style::zero(),
        name: None,
    })];
    for (place, row) in rows.iter().enumerate() {
        let own = participants.iter().filter(|person| {
            (&person.environment, &person.question, &person.contrast)
                == (&row.environment, &row.question, &row.contrast)
        });
        let mut x: Vec<f64> = own.map(|person| person.superiority).collect();
        // Equal shares must be neighbours, to be set beside each other.
        x.sort_by(f64::total_cmp);
        let y = beside_each_other(&x).into_iter().map(|aside| place as f64 + aside).collect();
        layers.push(Layer::Points(Points {
            x,
            y,
            colour: style::GREY,
            opacity: 0.6,
            ..Points::default()
        }));
    }
    layers.push(Layer::Intervals(Intervals {
        direction: Direction::Horizontal,
        at: (0..rows.len()).map(|place| place as f64 + BELOW).collect(),
        estimate: rows.iter().map(|row| row.superiority.unwrap_or(f64::NAN)).collect(),
        low: rows.iter().map(|row| row.superiority_ci_low.unwrap_or(f64::NAN)).collect(),
        high: rows.iter().map(|row| row.superiority_ci_high.unwrap_or(f64::NAN)).collect(),
        colour: style::INK,
        marker: Marker::Disc,
        name: None,
    }));
    let x = Axis {
        range: Range::Fixed(-0.04, 1.04),
        ..Axis::new("share of pairs of answers", "").linked("share")
    };
    let names = rows.iter().map(|row| contrast_label(modes, &row.contrast));
    let y = Axis::categories(names.map(|name| plain(&name.replace(Contrast::MINUS, " above "))));
    let height_mm = Some(CONTRAST_MM * (rows.len() as f64 + 0.5));
    Panel { height_mm, ..Panel::new(cell, x, y, layers).titled(plain(title)) }
}

/// Where equal values lie so that all of them are seen, in lines: values in order.
fn beside_each_other(values: &[f64]) -> Vec<f64> {
    // Shares of pairs that are equal may come from other sums.
    let equal = values.chunk_by(|a, b| (a - b).abs() < 1e-9);
    equal.flat_map(|ties| (0..ties.len()).map(|i| dodge(i, ties.len()))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_shares_lie_beside_each_other_and_others_on_the_line() {
        let aside = beside_each_other(&[0.25, 0.5, 0.5, 0.75]);
        assert_eq!((aside[0], aside[3]), (0.0, 0.0));
        assert!(aside[1] < 0.0 && aside[2] > 0.0, "{aside:?}");
    }
}
