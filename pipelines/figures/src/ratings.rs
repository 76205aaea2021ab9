//! Answers on scales of many points: each answer, with median, quartiles and mean.

use crate::likert::shown;
use crate::words::{mark, plain};
use crate::{About, FigureKind};
use serde::Serialize;
use std::collections::BTreeMap;
use zwidth_draw::style::{self, Marker};
use zwidth_draw::{
    Axis, Cell, Direction, Figure, Intervals, Layer, Panel, Points, Range, Reference, dodge,
};
use zwidth_study::{AnswerValue, Environment, EnvironmentId, Mode, Question, QuestionId, Source};
use zwidth_tables::{Table, TableError};

/// The figure [`ratings`].
pub const RATINGS: FigureKind = FigureKind {
    stem: "ratings",
    shows: "answers on scales of many points: each, with median, quartiles and mean",
    drawn_from: "answer",
};

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
pub fn ratings_pages(asked: &[(&Environment, Vec<&Question>)]) -> Vec<RatingsPage> {
    let several = asked.len() > 1;
    let mut wanted = Vec::new();
    for (environment, questions) in asked {
        for question in questions.iter().filter(|q| !q.scale.is_ordinal()) {
            let title = match several {
                true => format!("{}: {}", environment.label, question.text),
                false => question.text.clone(),
            };
            let (environment, question) = (environment.id.clone(), (*question).clone());
            wanted.push(Wanted { title, environment, question });
        }
    }
    wanted.chunks(A_PAGE).map(|page| RatingsPage(page.to_vec())).collect()
}

/// Every answer as a dot, with median, quartiles and mean, one row per mode. `tally` and `answers`
/// are the tables of the stage `likert`.
///
/// # Errors
/// Tables that are not of that stage.
pub fn ratings(
    about: &About,
    RatingsPage(wanted): &RatingsPage,
    [tally, answers]: [&Table; 2],
    sources: &[Source],
) -> Result<Figure, TableError> {
    let columns = COLUMNS.min(wanted.len().max(1));
    let mut panels = Vec::new();
    for (i, wanted) in wanted.iter().enumerate() {
        let cell = Cell::at(i / columns, i % columns);
        panels.push(panel(&about.modes, wanted, cell, [tally, answers])?);
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
    Ok(Figure {
        title: Some(plain(&about.title)),
        description: format!("{}: every answer on scales of many points, by mode.", about.title),
        width_mm: if columns == 1 { 120.0 } else { zwidth_draw::TWO_COLUMNS_MM },
        panels,
        footnotes: notes.iter().map(|note| plain(note)).collect(),
        mark: mark(sources.iter().copied()),
        ..Figure::default()
    })
}

fn panel(
    modes: &[Mode],
    wanted: &Wanted,
    cell: Cell,
    [tally, answers]: [&Table; 2],
) -> Result<Panel, TableError> {
    let scale = &wanted.question.scale;
    let given = scores(answers, wanted)?;
    let shown: Vec<&Mode> = modes.iter().filter(|m| given.contains_key(m.id.as_str())).collect();
    let middle = f64::from(scale.ends_together()) / 2.0;
    let mut layers = vec![Layer::Reference(Reference {
        direction: Direction::Vertical,
        at: middle,
        label: None,
        stroke: style::zero(),
        name: None,
    })];
    for (place, mode) in shown.iter().enumerate() {
        let x = given.get(mode.id.as_str()).cloned().unwrap_or_default();
        let y = beside_each_other(&x).into_iter().map(|aside| place as f64 + aside).collect();
        layers.push(Layer::Points(Points {
            x,
            y,
            colour: style::GREY,
            opacity: 0.6,
            ..Points::default()
        }));
    }
    layers.extend(summaries(tally, wanted, &shown)?);
    let [low, high] = [scale.lowest(), scale.highest()];
    let room = MARGIN * f64::from(high - low);
    let range = Range::Fixed(f64::from(low) - room, f64::from(high) + room);
    let end = |score: i16| worded(&wanted.question, score);
    let label = format!("{} … {}", end(low), end(high));
    let x = Axis { range, ..Axis::new(plain(&label), "") };
    let turned = if wanted.question.reversed { " (reversed)" } else { "" };
    let names = shown.iter().map(|mode| plain(&format!("{}{turned}", mode.label)));
    let y = Axis::categories(names);
    let panel = Panel::new(cell, x, y, layers).titled(plain(&wanted.title));
    Ok(Panel { height_mm: Some(ROW_MM * (shown.len() as f64 + 0.5)), ..panel })
}

/// The answers by mode, as scored, in rising order.
fn scores(answers: &Table, wanted: &Wanted) -> Result<BTreeMap<String, Vec<f64>>, TableError> {
    let [environments, modes, questions] =
        ["environment", "mode", "question"].map(|name| answers.texts(name));
    let (environments, modes, questions) = (environments?, modes?, questions?);
    let values = answers.numbers("answer")?;
    let Wanted { environment, question, .. } = wanted;
    let mut found: BTreeMap<String, Vec<f64>> = BTreeMap::new();
    for row in 0..answers.height() {
        let here = environments[row].as_deref() == Some(environment.as_str())
            && questions[row].as_deref() == Some(question.id.as_str());
        let value = values[row].and_then(|value| AnswerValue::new(value).ok());
        let (true, Some(mode), Some(value)) = (here, &modes[row], value) else { continue };
        let score = question.scale.score(value, question.reversed);
        found.entry(mode.clone()).or_default().push(score.into());
    }
    found.values_mut().for_each(|values| values.sort_by(f64::total_cmp));
    Ok(found)
}

/// Median with quartiles, and the mean, of each mode.
fn summaries(tally: &Table, wanted: &Wanted, modes: &[&Mode]) -> Result<[Layer; 2], TableError> {
    let [environments, of_modes, questions] =
        ["environment", "mode", "question"].map(|name| tally.texts(name));
    let (environments, of_modes, questions) = (environments?, of_modes?, questions?);
    let row_of = |mode: &Mode| {
        (0..tally.height()).find(|row| {
            environments[*row].as_deref() == Some(wanted.environment.as_str())
                && of_modes[*row].as_deref() == Some(mode.id.as_str())
                && questions[*row].as_deref() == Some(wanted.question.id.as_str())
        })
    };
    let rows: Vec<Option<usize>> = modes.iter().map(|mode| row_of(mode)).collect();
    let of = |name: &str| -> Result<Vec<f64>, TableError> {
        let values = tally.floats(name)?;
        Ok(rows.iter().map(|row| row.and_then(|row| values[row]).unwrap_or(f64::NAN)).collect())
    };
    let [low, high] = ["median_low", "median_high"].map(|name| tally.numbers(name));
    let (low, high) = (low?, high?);
    let median = |row: &Option<usize>| {
        let row = (*row)?;
        Some((low[row]? + high[row]?) / 2.0)
    };
    let at: Vec<f64> = (0..modes.len()).map(|place| place as f64 + BELOW).collect();
    let none = vec![f64::NAN; modes.len()];
    let quartiles = Intervals {
        direction: Direction::Horizontal,
        at: at.clone(),
        estimate: rows.iter().map(|row| median(row).unwrap_or(f64::NAN)).collect(),
        low: of("quartile_1")?,
        high: of("quartile_3")?,
        colour: style::INK,
        marker: Marker::Disc,
        name: None,
    };
    let mean = Intervals {
        estimate: of("mean")?,
        low: none.clone(),
        high: none,
        marker: Marker::Diamond,
        colour: style::mode_colour(1),
        ..quartiles.clone()
    };
    Ok([Layer::Intervals(quartiles), Layer::Intervals(mean)])
}

/// A score with the word of the answer that it stands for: of a reversed question that at the other
/// end.
fn worded(question: &Question, score: i16) -> String {
    let given = question.scale.score(score, question.reversed);
    let word = question.scale.word(given).map(|word| format!(" {word}"));
    format!("{}{}", shown(score), word.unwrap_or_default())
}

/// Where equal answers lie so that all of them are seen, in rows: values in order.
fn beside_each_other(values: &[f64]) -> Vec<f64> {
    let equal = values.chunk_by(|a, b| a - b == 0.0);
    equal.flat_map(|of| (0..of.len()).map(|i| dodge(i, of.len()))).collect()
}
