//! What can be felt: shares of answers with their curves, staircases, and thresholds over people.

use super::compared::or_note;
use crate::words::{logarithms_axis, mark, percent, plain};
use crate::{About, FigureKind};
use std::collections::{BTreeMap, BTreeSet};
use zwidth_draw::style::{self, Stroke};
use zwidth_draw::{
    Axis, Cell, Direction, Figure, Intervals, Layer, Line, Panel, Points, Range, Reference, Text,
    TextPlace,
};
use zwidth_results::{
    FittedShare, LevelMethod, LevelTally, PeopleThreshold, Presentation, PsychometricFit,
};
use zwidth_study::{
    Contrast, Mode, ModeId, ParticipantId, Source, Task, TaskQuantity, contrast_label, ratio_label,
};
use zwidth_tables::{p_value, shown_unit, with_unit};

/// The figure [`psychometric`].
pub const PSYCHOMETRIC: FigureKind = FigureKind::new(
    "psychometric",
    "answers to a task by level, with the curve that is fitted to them",
    "answer",
);

/// The figure [`staircases`].
pub const STAIRCASES: FigureKind =
    FigureKind::new("staircases", "levels of a task over its presentations", "answer");

/// The figure [`thresholds`].
pub const THRESHOLDS: FigureKind =
    FigureKind::new("thresholds", "everybody's thresholds and JNDs by mode", "answer");

/// Height of a panel, mm.
const PANEL_MM: f64 = 50.0;
/// Height of one of differences, mm.
const DIFFERENCE_MM: f64 = 34.0;
/// So many panels stand beside each other.
const COLUMNS: usize = 3;
/// Diameter of a point of one answer, pt; areas are in proportion to the answers.
const ONE_ANSWER_PT: f64 = 1.3;
/// No point is larger, pt.
const LARGEST_PT: f64 = 11.0;
/// How far a mean stands beside what it is the mean of, in categories.
const ASIDE: f64 = 0.16;

/// The levels of a task as they stand on axes: what they are, their unit, and what values are multiplied by.
struct Levels {
    unit: String,
    factor: f64,
    label: &'static str,
}

impl Levels {
    fn of(about: &About, task: &Task) -> Self {
        let (unit, factor) = shown_unit(task.unit(), about.coordinate);
        let unit = if unit == "1" { String::new() } else { unit };
        // The first word of a key says what it is.
        let label = match task.varies.split('_').next() {
            Some("stiffness") => "stiffness",
            Some("force") => "force",
            Some("delay") => "delay",
            Some("damping") => "damping",
            Some("rest" | "wall") => "position",
            Some("mass") => "mass",
            _ => "level",
        };
        Self { unit, factor, label }
    }

    fn axis(&self) -> Axis {
        Axis::new(self.label, self.unit.as_str()).linked("level")
    }

    fn of_value(&self, value: f64) -> f64 {
        value * self.factor
    }

    /// A value with its unit, to three digits.
    fn told(&self, value: f64) -> String {
        with_unit(&to_digits(self.of_value(value)), &self.unit)
    }
}

/// A number to three digits that count, in the plain form of a label.
fn to_digits(value: f64) -> String {
    const DIGITS: i32 = 3;
    if value.abs() < 1e-300 {
        return "0".to_owned();
    }
    let before = libm::floor(libm::log10(value.abs())) as i32 + 1;
    let decimals = usize::try_from((DIGITS - before).max(0)).unwrap_or_default();
    format!("{value:.decimals$}").replace('-', "−")
}

/// What a figure of one person is made of.
#[derive(Debug, Clone, Copy)]
pub struct OfPerson<'a> {
    /// The task.
    pub task: &'a Task,
    /// Participant and session, as figures name them.
    pub who: &'a str,
    /// Where the answers are from.
    pub sources: &'a [Source],
    /// The fits of this person and session.
    pub fits: &'a [PsychometricFit],
}

impl OfPerson<'_> {
    fn figure(&self, about: &About, panels: Vec<Panel>, what: &str, notes: Vec<String>) -> Figure {
        let columns = panels.iter().map(|panel| panel.cell.column + 1).max().unwrap_or(1);
        Figure {
            title: Some(plain(&format!("{}: {}, {}", about.title, self.task.text, self.who))),
            description: format!("{}: {what}, by mode.", self.task.text),
            panels: or_note(panels),
            column_weights: vec![1.0; columns],
            footnotes: notes.iter().map(|note| plain(note)).collect(),
            mark: mark(self.sources.iter().copied()),
            ..Figure::default()
        }
    }

    fn fit(&self, mode: &ModeId) -> Option<&PsychometricFit> {
        self.fits.iter().find(|fit| fit.mode == *mode)
    }
}

/// The place of the `number`-th panel of several, row by row.
fn place(number: usize, of: usize) -> Cell {
    // Four modes are two rows of two.
    let columns = if of == 4 { 2 } else { of.clamp(1, COLUMNS) };
    Cell::at(number / columns, number % columns)
}

/// The modes that a person has answers in.
fn answered<'a>(about: &'a About, fits: &[PsychometricFit]) -> Vec<(usize, &'a Mode)> {
    let modes = about.modes.iter().enumerate();
    modes.filter(|(_, mode)| fits.iter().any(|fit| fit.mode == mode.id)).collect()
}

/// The answers of a person by level, a panel per mode: shares with the area of their trials, the fitted curve, PSE or
/// threshold with its interval, and the JND to either side of it.
pub fn psychometric(
    about: &About,
    of: OfPerson,
    by_level: &[LevelTally],
    curves: &[FittedShare],
) -> Figure {
    let levels = Levels::of(about, of.task);
    let modes = answered(about, of.fits);
    let mut panels = Vec::new();
    let mut intervals = false;
    for (number, (index, mode)) in modes.iter().enumerate() {
        let colour = style::mode_colour(*index);
        let mut layers = Vec::new();
        if let Some(standard) = of.task.standard {
            let at = levels.of_value(standard.value());
            let line = Reference::new(Direction::Vertical, at, style::reference());
            layers.push(Layer::Reference(Reference { label: Some("standard".to_owned()), ..line }));
        }
        let own = curves.iter().filter(|point| point.mode == mode.id);
        let (x, y) = own.map(|point| (levels.of_value(point.level), point.share)).unzip();
        let stroke = style::mean(colour);
        layers.push(Layer::Line(Line { x, y, stroke, ..Line::default() }));
        let fit = of.fit(&mode.id);
        let mut told = Vec::new();
        if let Some(fit) = fit
            && let Some(threshold) = fit.threshold
        {
            let share = middle(fit);
            let ends = [fit.threshold_ci_low, fit.threshold_ci_high]
                .map(|end| vec![end.map_or(f64::NAN, |end| levels.of_value(end))]);
            intervals |= fit.threshold_ci_low.is_some();
            let [low, high] = ends;
            let at = [vec![levels.of_value(threshold)], low, high];
            let marks = Intervals::new(Direction::Horizontal, vec![share], at);
            told.push(format!("{} {}", fit.quantity.in_words(), levels.told(threshold)));
            if let Some(jnd) = fit.jnd {
                // From F = ¼ to F = ¾, which lie a JND to either side of the threshold.
                let [low, high] = quarters(fit);
                let ends = [threshold - jnd, threshold + jnd].map(|end| levels.of_value(end));
                for (end, share) in ends.into_iter().zip([low, high]) {
                    layers.push(Layer::Line(Line {
                        x: vec![end, end],
                        y: vec![share, 0.0],
                        stroke: style::faint(style::GREY),
                        ..Line::default()
                    }));
                }
                let x = ends.to_vec();
                let stroke = style::mean(colour);
                layers.push(Layer::Line(Line { x, y: vec![0.0; 2], stroke, ..Line::default() }));
                told.push(format!("JND {}", levels.told(jnd)));
            }
            layers.push(Layer::Intervals(marks));
        } else if let Some(fit) = fit {
            told.push(fit.verdict.as_str().to_owned());
        }
        let own: Vec<&LevelTally> = by_level.iter().filter(|row| row.mode == mode.id).collect();
        layers.extend(shares(&own, &levels, colour));
        if !told.is_empty() {
            let lines = told.iter().map(|line| plain(line)).collect();
            layers.push(Layer::Text(Text { lines, place: TextPlace::EmptiestCorner }));
        }
        let y =
            Axis::new(share_label(of.task), "").ranged(Range::Fixed(-0.05, 1.05)).linked("share");
        let panel = Panel::new(place(number, modes.len()), levels.axis(), y, layers);
        panels.push(panel.titled(plain(&mode.label)).tall(PANEL_MM));
    }
    let mut notes = vec![
        "Areas of discs: answers at a level. Curve: the psychometric function. On it the threshold; on the axis one JND to \
         either side of it."
            .to_owned(),
    ];
    if intervals {
        notes.push(format!("Whisker: {} interval of the threshold.", percent(about.confidence)));
    }
    of.figure(about, panels, "shares of answers by level with fitted curves", notes)
}

/// What the share of a task is of.
fn share_label(task: &Task) -> &'static str {
    use zwidth_study::Asks;
    match task.asks {
        Asks::MoreOfTwo | Asks::MoreLess | Asks::Set => "share of “more”",
        Asks::OneOfTwo => "share of right answers",
        Asks::YesNo => "share of “yes”",
    }
}

/// ψ at F = ½.
fn middle(fit: &PsychometricFit) -> f64 {
    let (guess, lapse) = (fit.guess.unwrap_or(0.0), fit.lapse.unwrap_or(0.0));
    guess + (1.0 - guess - lapse) / 2.0
}

/// ψ at F = ¼ and F = ¾.
fn quarters(fit: &PsychometricFit) -> [f64; 2] {
    let (guess, lapse) = (fit.guess.unwrap_or(0.0), fit.lapse.unwrap_or(0.0));
    [0.25, 0.75].map(|share| guess + (1.0 - guess - lapse) * share)
}

/// Discs at the shares, their areas in proportion to the answers.
fn shares(own: &[&LevelTally], levels: &Levels, colour: style::Colour) -> Vec<Layer> {
    let mut by_trials: BTreeMap<usize, [Vec<f64>; 2]> = BTreeMap::new();
    for row in own {
        let [x, y] = by_trials.entry(row.trials).or_default();
        x.push(levels.of_value(row.level));
        y.push(row.share);
    }
    let layers = by_trials.into_iter().map(|(trials, [x, y])| {
        let diameter_pt = (ONE_ANSWER_PT * (trials as f64).sqrt()).min(LARGEST_PT);
        Layer::Points(Points { x, y, colour, opacity: 0.75, diameter_pt, name: None })
    });
    layers.collect()
}

/// The levels of a person's presentations one after the other, a panel per mode: answers of more, right or yes filled,
/// others faint; reversals marked, and the threshold as a line.
pub fn staircases(about: &About, of: OfPerson, presentations: &[Presentation]) -> Figure {
    let levels = Levels::of(about, of.task);
    let modes = answered(about, of.fits);
    let mut panels = Vec::new();
    let mut are_several = false;
    for (number, (index, mode)) in modes.iter().enumerate() {
        let colour = style::mode_colour(*index);
        let own: Vec<&Presentation> =
            presentations.iter().filter(|row| row.mode == mode.id).collect();
        let sequences: BTreeSet<usize> = own.iter().map(|row| row.sequence).collect();
        are_several |= sequences.len() > 1;
        let mut layers = Vec::new();
        if let Some(threshold) = of.fit(&mode.id).and_then(|fit| fit.threshold) {
            let at = levels.of_value(threshold);
            let line = Reference::new(Direction::Horizontal, at, style::reference());
            layers.push(Layer::Reference(line));
        }
        for sequence in sequences {
            let of_sequence = || own.iter().filter(|row| row.sequence == sequence);
            let x_and_y = |rows: &mut dyn Iterator<Item = &&Presentation>| -> (Vec<f64>, Vec<f64>) {
                rows.map(|row| (f64::from(row.presentation), levels.of_value(row.level))).unzip()
            };
            let (x, y) = x_and_y(&mut of_sequence());
            let stroke = Stroke { opacity: 0.5, ..style::faint(colour) };
            layers.push(Layer::Line(Line { x, y, stroke, ..Line::default() }));
            for (wanted, opacity) in [(Some(true), 0.9), (Some(false), 0.3), (None, 0.9)] {
                let (x, y) = x_and_y(&mut of_sequence().filter(|row| row.positive == wanted));
                let points = Points { x, y, colour, opacity, ..Points::default() };
                layers.push(Layer::Points(points));
            }
            let (x, y) = x_and_y(&mut of_sequence().filter(|row| row.is_reversal));
            let ink = style::INK;
            layers.push(Layer::Points(Points { x, y, colour: ink, ..Points::default() }));
        }
        let told = of.fit(&mode.id).map(|fit| match fit.threshold {
            Some(threshold) => format!("{} {}", fit.quantity.in_words(), levels.told(threshold)),
            None => fit.verdict.as_str().to_owned(),
        });
        if let Some(line) = told {
            let lines = vec![plain(&line)];
            layers.push(Layer::Text(Text { lines, place: TextPlace::EmptiestCorner }));
        }
        let y = Axis::new(levels.label, levels.unit.as_str()).linked("level");
        let x = Axis::new("presentation", "");
        let panel = Panel::new(place(number, modes.len()), x, y, layers);
        panels.push(panel.titled(plain(&mode.label)).tall(PANEL_MM));
    }
    let method = of.fits.first().map(|fit| fit.method);
    let mut notes = vec![match method {
        Some(LevelMethod::Adjustment) => {
            "Each line: the levels from a start to the one that was right. Dotted line: their mean.".to_owned()
        }
        Some(LevelMethod::Staircase) => {
            "Strong discs: more, right or yes; faint ones: not. Black: reversals. Line across: the mean of the last of them."
                .to_owned()
        }
        _ => "Strong discs: more, right or yes; faint ones: not. Line across: the threshold.".to_owned(),
    }];
    if are_several && method == Some(LevelMethod::Staircase) {
        notes.push("Several staircases take turns.".to_owned());
    }
    of.figure(about, panels, "levels over presentations", notes)
}

/// Everybody's thresholds of a task by mode, and their JNDs: dots of people joined over modes, means with intervals beside
/// them (of JNDs geometric ones); below each the differences between modes, of JNDs the ratios.
pub fn thresholds(
    about: &About,
    task: &Task,
    sources: &[Source],
    fits: &[PsychometricFit],
    over_people: &[PeopleThreshold],
) -> Figure {
    let levels = Levels::of(about, task);
    let mut panels = Vec::new();
    let mut notes = Vec::new();
    for (column, quantity) in task.quantities().into_iter().enumerate() {
        let is_ratio = quantity == TaskQuantity::Jnd;
        let shown = |value: f64| levels.of_value(value);
        let value = |fit: &PsychometricFit| {
            let own = if is_ratio { fit.jnd } else { fit.threshold };
            own.filter(|_| fit.verdict.is_estimated())
        };
        let mut people: BTreeMap<&ParticipantId, Vec<Vec<f64>>> = BTreeMap::new();
        for fit in fits {
            let Some(at) = about.modes.iter().position(|mode| mode.id == fit.mode) else {
                continue;
            };
            let own = people.entry(&fit.participant).or_default();
            own.resize(about.modes.len(), Vec::new());
            own[at].extend(value(fit).map(shown));
        }
        let mut layers = Vec::new();
        // Over a person's sessions as they are compared: JNDs by their logarithms.
        let of_mode = |own: &Vec<f64>| {
            let n = own.len() as f64;
            match is_ratio {
                true => libm::exp(own.iter().map(|jnd| libm::log(*jnd)).sum::<f64>() / n),
                false => own.iter().sum::<f64>() / n,
            }
        };
        for own in people.values() {
            layers.push(Layer::Line(Line {
                x: (0..own.len()).map(|place| place as f64).collect(),
                y: own.iter().map(of_mode).collect(),
                stroke: Stroke { opacity: 0.45, ..style::faint(style::GREY) },
                ..Line::default()
            }));
        }
        let rows = || over_people.iter().filter(|row| row.quantity == quantity);
        for (index, mode) in about.modes.iter().enumerate() {
            let colour = style::mode_colour(index);
            let y: Vec<f64> = people.values().map(|own| of_mode(&own[index])).collect();
            let x = vec![index as f64; y.len()];
            layers.push(Layer::Points(Points { x, y, colour, opacity: 0.55, ..Points::default() }));
            for row in rows().filter(|row| row.mode.as_ref() == Some(&mode.id)) {
                let end = |end: Option<f64>| vec![end.map_or(f64::NAN, shown)];
                let estimate = [vec![shown(row.estimate)], end(row.ci_low), end(row.ci_high)];
                let at = vec![index as f64 + ASIDE];
                let marks = Intervals::new(Direction::Vertical, at, estimate);
                layers.push(Layer::Intervals(Intervals { colour, ..marks }));
            }
        }
        let modes = Axis::categories(about.modes.iter().map(|mode| plain(&mode.label)));
        let y = Axis::new(quantity.in_words(), levels.unit.as_str());
        panels.push(Panel::new(Cell::at(0, column), modes, y, layers).tall(PANEL_MM));
        let contrasts: Vec<&PeopleThreshold> =
            rows().filter(|row| row.contrast.is_some()).collect();
        if !contrasts.is_empty() {
            // Half and twice as much are equally far from alike.
            let number = |value: f64| match is_ratio {
                true => libm::log(value),
                false => levels.of_value(value),
            };
            let names = contrasts.iter().filter_map(|row| {
                let contrast = row.contrast.as_ref()?;
                Some(plain(&compared(about, contrast, is_ratio)))
            });
            let column_of = |read: fn(&PeopleThreshold) -> Option<f64>| -> Vec<f64> {
                contrasts.iter().map(|row| read(row).map_or(f64::NAN, number)).collect()
            };
            let estimates = [
                column_of(|row| Some(row.estimate)),
                column_of(|row| row.ci_low),
                column_of(|row| row.ci_high),
            ];
            let at = (0..contrasts.len()).map(|place| place as f64).collect();
            let marks = Intervals::new(Direction::Vertical, at, estimates);
            // Of differences 0, of ratios 1, whose logarithm is 0.
            let alike = Reference::new(Direction::Horizontal, 0.0, style::zero());
            let layers = vec![Layer::Reference(alike), Layer::Intervals(marks)];
            let y = match is_ratio {
                true => logarithms_axis("ratio of JNDs", ""),
                false => Axis::new("difference", levels.unit.as_str()),
            };
            let x = Axis::categories(names);
            panels.push(Panel::new(Cell::at(1, column), x, y, layers).tall(DIFFERENCE_MM));
            notes.extend(contrasts.iter().filter_map(|row| told(about, row, &levels)));
        }
    }
    let columns = task.quantities().len();
    notes.push(format!(
        "A line joins one person's values. Whiskers: {} intervals, not adjusted.{}",
        percent(about.confidence),
        if task.has_jnd() { " Means of JNDs are geometric." } else { "" }
    ));
    Figure {
        title: Some(plain(&format!("{}: {}", about.title, task.text))),
        description: format!("{}: everybody's thresholds by mode, with intervals.", task.text),
        panels: or_note(panels),
        column_weights: vec![1.0; columns],
        footnotes: notes.iter().map(|note| plain(note)).collect(),
        mark: mark(sources.iter().copied()),
        ..Figure::default()
    }
}

/// The two modes of a difference, or of a ratio: `hybrid − active`, `hybrid / active`.
fn compared(about: &About, contrast: &Contrast, is_ratio: bool) -> String {
    match is_ratio {
        true => ratio_label(&about.modes, contrast),
        false => contrast_label(&about.modes, contrast),
    }
}

/// A difference in words: `JND, hybrid / active: 1.40 times [1.24, 1.57], p = 0.0003`.
fn told(about: &About, row: &PeopleThreshold, levels: &Levels) -> Option<String> {
    let is_ratio = row.quantity == TaskQuantity::Jnd;
    let contrast = compared(about, row.contrast.as_ref()?, is_ratio);
    let number = |value: f64| match is_ratio {
        true => format!("{value:.2}"),
        false => to_digits(levels.of_value(value)),
    };
    let size = match is_ratio {
        true => format!("{} times", number(row.estimate)),
        false => with_unit(&number(row.estimate), &levels.unit),
    };
    let interval = match (row.ci_low, row.ci_high) {
        (Some(low), Some(high)) => format!(" [{}, {}]", number(low), number(high)),
        _ => String::new(),
    };
    let p = row.p_adjusted.map(|p| format!(", p {}", p_value(p))).unwrap_or_default();
    Some(format!("{}, {contrast}: {size}{interval}{p}.", row.quantity.in_words()))
}
