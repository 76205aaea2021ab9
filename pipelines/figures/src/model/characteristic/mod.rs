//! Figures 22 and 23: the response to a command in every sweep, with the first-order fit and the
//! chosen fit; below, how far the samples are from the chosen fit.

mod words;

use self::words::{about, significant, why_not_calibrated};
use crate::FigureKind;
use crate::words::{mark, percent, plain};
use zwidth_draw::style::{self, Colour, Dash, Stroke};
use zwidth_draw::{Axis, Band, Cell, Direction, Figure, Layer, Line, Panel, Points, Reference};
use zwidth_numerics::branch::{Branch, branches};
use zwidth_results::{
    CandidateVerdict, CommandWay, CurveModel, CurvePoint, CurveSymbol, FittedModel, FittedParameter,
};
use zwidth_store::{Quantity, Sweep};

/// The figure [`characteristic`].
pub const CHARACTERISTIC: FigureKind =
    FigureKind::new("characteristic", "response to the command, with the chosen fit", "sweep");

/// Width of the figure, mm.
const WIDTH_MM: f64 = 110.0;
/// Height of its panel, mm.
const PANEL_MM: f64 = 60.0;
/// The same in pt, 1/72 inch.
const PANEL_PT: f64 = PANEL_MM * 72.0 / 25.4;
/// Height of the panel below, mm.
const RESIDUALS_MM: f64 = 22.0;
/// More points than this hide one another: they are drawn smaller and paler.
const MANY_POINTS: usize = 1000;
/// More points than this are no more than a blot: each sweep becomes a faint line of step means.
const MOST_POINTS: usize = 10_000;
/// Steps of the command that such a line has one mean in: about one per printed dot.
const STEPS: f64 = 250.0;

/// Pen of the chosen fit under a mean, pt.
const BROAD_PT: f64 = 2.4;
/// Pen of the mean of the sweeps on it, pt.
const THIN_PT: f64 = 0.6;

/// What the stage found of one actuator or sensor.
#[derive(Debug, Clone, Copy)]
pub struct Characterised<'a> {
    /// Candidate models.
    pub models: &'a [FittedModel],
    /// Their parameters.
    pub parameters: &'a [FittedParameter],
    /// The chosen curve.
    pub curve: &'a [CurvePoint],
    /// Level of their intervals.
    pub level: f64,
}

impl<'a> Characterised<'a> {
    /// The model that was chosen.
    fn chosen(&self) -> Option<&'a FittedModel> {
        self.models.iter().find(|row| row.verdict == CandidateVerdict::Chosen)
    }
}

/// The characteristic of one actuator or sensor: all sweeps faint, their mean, the first-order fit
/// with its R², the chosen fit, and where it begins and ends to rise; below, from the chosen fit
/// on, the band for a new response and the samples. Its coefficients are in their table.
pub fn characteristic(actuator: &str, sweeps: &[Sweep], fitted: Characterised) -> Figure {
    let nothing = || Quantity { name: String::new(), unit: String::new() };
    let command = sweeps.first().map_or_else(nothing, |sweep| sweep.command.clone());
    let response = sweeps.first().map_or_else(nothing, |sweep| sweep.response.clone());
    let chosen = fitted.chosen();
    let mut layers = samples(sweeps, are_seen(chosen, sweeps));
    layers.extend(curves(fitted, sweeps.len()));
    layers.extend(corners(fitted, &command.unit));
    let x = axis(&command).linked("command");
    let panel = Panel::new(Cell::at(0, 0), x.clone(), axis(&response), layers).tall(PANEL_MM);
    let off = Axis::new("off the fit", plain(&response.unit));
    let below = residuals(fitted, sweeps)
        .map(|layers| Panel::new(Cell::at(1, 0), x, off, layers).tall(RESIDUALS_MM));
    let mut footnotes = Vec::new();
    footnotes.extend(chosen.map(|chosen| about(chosen, &response.unit, actuator)));
    if actuator == "motor" {
        footnotes.extend(why_not_calibrated(fitted.curve, &command.unit, &response.unit));
    }
    let name = chosen.map_or("", |chosen| chosen.model.as_str());
    Figure {
        title: Some(format!("Characteristic: {}", plain(&actuator.replace('_', " ")))),
        description: format!(
            "{} against {} of the {actuator}: {} sweeps, the first-order fit, the chosen fit ({name}) and its band for \
             a new response.",
            response.name,
            command.name,
            sweeps.len()
        ),
        width_mm: WIDTH_MM,
        panels: [panel].into_iter().chain(below).collect(),
        footnotes,
        mark: mark(sweeps.iter().map(|s| s.source)),
        ..Figure::default()
    }
}

fn axis(quantity: &Quantity) -> Axis {
    Axis::new(plain(&quantity.name), plain(&quantity.unit))
}

/// Whether samples stand out from under the fits: not if the chosen one misses them by less than
/// half its own width in print. What cannot be seen does not stand in the legend.
fn are_seen(chosen: Option<&FittedModel>, sweeps: &[Sweep]) -> bool {
    let rms = chosen.and_then(|chosen| chosen.rms);
    let all = crate::extent::ends(sweeps.iter().flat_map(|s| &s.response_values).copied());
    let off_pt = rms.zip(all).map(|(rms, (low, high))| rms / (high - low) * PANEL_PT);
    off_pt.is_none_or(|off_pt| off_pt.is_nan() || off_pt > BROAD_PT / 2.0)
}

/// All samples as points, or each sweep as a faint line where points would be a blot; named where
/// they are seen.
fn samples(sweeps: &[Sweep], seen: bool) -> Vec<Layer> {
    let commands = sweeps.iter().flat_map(|s| &s.command_values).copied();
    let n = commands.clone().count();
    if n <= MOST_POINTS {
        let many = n > MANY_POINTS;
        return vec![Layer::Points(Points {
            x: commands.collect(),
            y: sweeps.iter().flat_map(|s| &s.response_values).copied().collect(),
            colour: style::GREY,
            opacity: if many { 0.25 } else { 0.6 },
            diameter_pt: if many { 1.4 } else { style::POINT_PT },
            name: seen.then(|| "samples".to_owned()),
        })];
    }
    let (low, high) =
        commands.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)));
    let mut layers = Vec::new();
    for (number, sweep) in sweeps.iter().enumerate() {
        let (x, y) =
            step_means(&sweep.command_values, &sweep.response_values, (high - low) / STEPS);
        let name = (number == 0 && seen).then(|| "sweeps".to_owned());
        let stroke = style::faint(style::GREY);
        layers.push(Layer::Line(Line { x, y, stroke, name, ..Line::default() }));
    }
    layers
}

/// Means of runs of samples whose commands lie in one step of this width, in the order of
/// recording.
fn step_means(x: &[f64], y: &[f64], step: f64) -> (Vec<f64>, Vec<f64>) {
    let samples: Vec<(f64, f64)> = x.iter().copied().zip(y.iter().copied()).collect();
    let runs = samples
        .chunk_by(|a, b| libm::floor(a.0 / step) as i64 == libm::floor(b.0 / step) as i64)
        .map(|run| {
            let (sx, sy) = run.iter().fold((0.0, 0.0), |(sx, sy), (x, y)| (sx + x, sy + y));
            (sx / run.len() as f64, sy / run.len() as f64)
        });
    runs.unzip()
}

/// One branch of the chosen curve.
struct Part<'a> {
    /// `, up`; nothing of the only one.
    name: String,
    /// Which way of the command it is; none: both.
    way: Option<Branch>,
    points: &'a [CurvePoint],
    colour: Colour,
    dash: Dash,
}

/// The branches of the curve: one, or up and down.
fn parts(curve: &[CurvePoint]) -> Vec<Part<'_>> {
    let mut parts: Vec<Part> = Vec::new();
    for points in curve.chunk_by(|a, b| a.branch == b.branch) {
        let way = match points[0].branch {
            CommandWay::Both => None,
            CommandWay::Up => Some(Branch::Up),
            CommandWay::Down => Some(Branch::Down),
        };
        let name = way.map(|way| format!(", {}", way.name())).unwrap_or_default();
        let colour = style::direction_colour(parts.len());
        let dash = style::dash(parts.len());
        parts.push(Part { name, way, points, colour, dash });
    }
    parts
}

impl Part<'_> {
    /// A number of each point.
    fn column(&self, number: impl Fn(&CurvePoint) -> f64) -> Vec<f64> {
        self.points.iter().map(number).collect()
    }

    /// The same against the command.
    fn line(&self, y: impl Fn(&CurvePoint) -> f64, stroke: Stroke, name: String) -> Layer {
        let x = self.column(|p| p.command);
        let y = self.column(y);
        Layer::Line(Line { x, y, stroke, name: Some(name), ..Line::default() })
    }

    /// How far a sweep's samples of this branch lie off its fit; which these are is told by the
    /// rule that the fit went by.
    fn residuals(&self, sweep: &Sweep, fit: (&[f64], &[f64])) -> Vec<(f64, f64)> {
        let ways = self.way.map(|way| (way, branches(&sweep.command_values)));
        let mut residuals = Vec::new();
        for (i, &command) in sweep.command_values.iter().enumerate() {
            let is_mine = ways.as_ref().is_none_or(|(way, ways)| ways[i] == *way);
            if let Some(fitted) = value_at(fit, command).filter(|_| is_mine) {
                residuals.push((command, sweep.response_values[i] - fitted));
            }
        }
        residuals
    }
}

/// The samples off the chosen fit, and the band for a new response on them; `None` where there is
/// no fit.
fn residuals(fitted: Characterised, sweeps: &[Sweep]) -> Option<Vec<Layer>> {
    let zero = Reference::new(Direction::Horizontal, 0.0, style::zero());
    let n: usize = sweeps.iter().map(|s| s.command_values.len()).sum();
    let stride = n.div_ceil(MOST_POINTS).max(1);
    let named = (stride > 1).then(|| format!("one sample of {stride}, off the fit"));
    let mut layers = vec![Layer::Reference(zero)];
    let mut bands = Vec::new();
    for part in parts(fitted.curve) {
        let x = part.column(|p| p.command);
        let fit = part.column(|p| p.fit);
        let low = part.column(|p| p.prediction_low - p.fit);
        let high = part.column(|p| p.prediction_high - p.fit);
        let name = Some(format!("{} prediction band{}", percent(fitted.level), part.name));
        let curve = (x.as_slice(), fit.as_slice());
        // Every so many: a page holds no more points than can be told from a blot.
        let off = sweeps.iter().flat_map(|sweep| part.residuals(sweep, curve));
        let (at, y) = off.step_by(stride).unzip();
        let (opacity, diameter_pt) = if n > MANY_POINTS { (0.25, 1.2) } else { (0.6, 2.0) };
        let colour = part.colour;
        let points = Points { x: at, y, colour, opacity, diameter_pt, name: named.clone() };
        layers.push(Layer::Points(points));
        bands.push(Layer::Band(Band { x, low, high, colour, name }));
    }
    let any =
        layers.iter().any(|l| matches!(l, Layer::Points(p) if p.y.iter().any(|y| y.is_finite())));
    // Over the samples, which are many: a translucent band would not be seen under them.
    layers.extend(bands);
    any.then_some(layers)
}

/// The value of a rising curve at `x`, on the straight line between its points; `None` outside.
fn value_at((xs, ys): (&[f64], &[f64]), x: f64) -> Option<f64> {
    // At the first point there is none before: it belongs to the first piece.
    let after = xs.partition_point(|at| *at < x).max(1);
    let x0 = *xs.get(after - 1)?;
    let x1 = *xs.get(after)?;
    let share = (x - x0) / (x1 - x0);
    (0.0..=1.0).contains(&share).then(|| ys[after - 1] + share * (ys[after] - ys[after - 1]))
}

/// Fits, means and the first-order fit, in the order in which they lie over each other: the mean is
/// thin on the broad chosen fit, so that both are seen where they agree. Where the line was chosen
/// it is the first-order fit.
fn curves(fitted: Characterised, sweeps: usize) -> Vec<Layer> {
    let parts = parts(fitted.curve);
    let line = fitted.models.iter().find(|row| row.model == CurveModel::Line);
    let r2 = line.and_then(|line| line.r2).map(|r2| format!(", *R*^{{2}} = {r2:.4}"));
    let first_order = format!("first-order fit{}", r2.unwrap_or_default());
    let is_line = fitted.chosen().is_some_and(|chosen| chosen.model == CurveModel::Line);
    let fit = if is_line { format!("{first_order} (chosen)") } else { "chosen fit".to_owned() };
    let mut layers = Vec::new();
    for part in &parts {
        let usual = style::mean(part.colour).dashed(part.dash);
        let pen = if sweeps > 1 { Stroke { width_pt: BROAD_PT, ..usual } } else { usual };
        layers.push(part.line(|p| p.fit, pen, format!("{fit}{}", part.name)));
    }
    for part in parts.iter().filter(|_| sweeps > 1) {
        let thin = Stroke { width_pt: THIN_PT, ..style::single(style::INK) };
        // Without samples near by there is a gap.
        let name = "mean of the sweeps".to_owned();
        layers.push(part.line(|p| p.mean.unwrap_or(f64::NAN), thin, name));
    }
    if let Some(part) = parts.first().filter(|_| !is_line) {
        let dashed = Stroke { colour: style::INK, width_pt: 0.9, ..style::reference() };
        layers.push(part.line(|p| p.first_order, dashed, first_order));
    }
    layers
}

/// Where the chosen curve begins and ends to rise, where the data can tell.
fn corners(fitted: Characterised, unit: &str) -> Vec<Layer> {
    let chosen = fitted.chosen().map(|chosen| chosen.model);
    let own = fitted.parameters.iter().filter(|p| Some(p.model) == chosen);
    let mut corners = Vec::new();
    // A note says why the data cannot tell.
    for p in own.filter(|p| p.note.is_none()) {
        let what = match p.parameter {
            CurveSymbol::X0 => "begins at",
            CurveSymbol::X1 => "ends at",
            _ => continue,
        };
        let way = match p.branch {
            CommandWay::Both => String::new(),
            way => format!(" ({})", way.as_str()),
        };
        let pen = style::reference().dashed(Dash::Dotted);
        let line = Reference::new(Direction::Vertical, p.estimate, pen);
        let label = Some(format!("{what} {} {}{way}", significant(p.estimate), plain(unit)));
        corners.push(Layer::Reference(Reference { label, ..line }));
    }
    corners
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;
    use zwidth_study::Source;

    /// `n` sweeps of `samples` up to 8 V, 2 N/V above 1 V.
    fn sweeps(n: u32, samples: u32, source: Source) -> Vec<Sweep> {
        let command: Vec<f64> =
            (0..samples).map(|i| 8.0 * f64::from(i) / f64::from(samples - 1)).collect();
        let quantity =
            |name: &str, unit: &str| Quantity { name: name.to_owned(), unit: unit.to_owned() };
        let sweep = |sweep| Sweep {
            actuator: "brake".parse().unwrap(),
            sweep,
            source,
            command: quantity("voltage", "V"),
            response: quantity("force", "N"),
            t_s: None,
            response_values: command.iter().map(|x| 2.0 * (x - 1.0).max(0.0)).collect(),
            command_values: command.clone(),
            file: BTreeMap::new(),
        };
        (1..=n).map(sweep).collect()
    }

    fn models() -> Vec<FittedModel> {
        let model = |model, formula: &str, rms, r2, verdict| FittedModel {
            model,
            formula: formula.to_owned(),
            rms: Some(rms),
            left_out_rms: None,
            rms_over_noise: None,
            r2: Some(r2),
            autocorrelation: None,
            aicc: None,
            verdict,
            reason: "".into(),
        };
        let hinge = "y = a + b max(x - x0, 0), up and down apart";
        vec![
            model(CurveModel::Line, "y = a + b x", 1.0, 0.987_65, CandidateVerdict::Rejected),
            model(CurveModel::HingeUpDown, hinge, 0.1, 0.999, CandidateVerdict::Chosen),
        ]
    }

    /// The last one with a note, if it is not empty.
    fn parameters(note: &str) -> Vec<FittedParameter> {
        use CommandWay::{Both, Down, Up};
        use CurveModel::{HingeUpDown, Line};
        use CurveSymbol::{A, B, X0};
        let rows = [
            (Line, A, Both, -1.0),
            (Line, B, Both, 1.7),
            (HingeUpDown, A, Up, 0.0),
            (HingeUpDown, B, Up, 2.0),
            (HingeUpDown, X0, Up, 1.0),
            (HingeUpDown, A, Down, 0.0),
            (HingeUpDown, B, Down, 2.0),
            (HingeUpDown, X0, Down, 0.5),
        ];
        let row = |(model, parameter, branch, estimate)| FittedParameter {
            model,
            parameter,
            branch,
            estimate,
            std_error: None,
            ci_low: None,
            ci_high: None,
            unit: "N".into(),
            note: None,
        };
        let mut rows: Vec<FittedParameter> = rows.into_iter().map(row).collect();
        if let Some(last) = rows.last_mut().filter(|_| !note.is_empty()) {
            last.note = Some(note.into());
        }
        rows
    }

    fn curve() -> Vec<CurvePoint> {
        let point = |branch, at| CurvePoint {
            branch,
            command: at,
            mean: Some(at),
            fit: at,
            ci_low: at,
            ci_high: at,
            prediction_low: at,
            prediction_high: at,
            first_order: at,
        };
        let ways = [CommandWay::Up, CommandWay::Down];
        ways.into_iter().flat_map(|way| [0.0, 8.0].map(|at| point(way, at))).collect()
    }

    fn figure(sweeps: &[Sweep], note: &str) -> Figure {
        let (models, parameters, curve) = (models(), parameters(note), curve());
        let found =
            Characterised { models: &models, parameters: &parameters, curve: &curve, level: 0.95 };
        characteristic("brake", sweeps, found)
    }

    #[test]
    fn a_force_with_friction_in_it_says_why_the_calibration_gives_another() {
        let note = why_not_calibrated(&curve(), "V", "N").unwrap();
        assert!(note.contains("8.00 N at 8.00 V") && note.contains("rendering"), "{note}");
        assert_eq!(why_not_calibrated(&curve()[..2], "V", "N"), None);
        assert_eq!(why_not_calibrated(&curve(), "V", "counts"), None);
    }

    fn names(figure: &Figure) -> Vec<&str> {
        let name = |layer| match layer {
            &Layer::Line(Line { ref name, .. })
            | &Layer::Band(Band { ref name, .. })
            | &Layer::Points(Points { ref name, .. }) => name.as_deref(),
            _ => None,
        };
        figure.panels.iter().flat_map(|panel| &panel.layers).filter_map(name).collect()
    }

    #[test]
    fn it_holds_sweeps_mean_both_fits_and_the_bands() {
        let found = figure(&sweeps(2, 50, Source::Recorded), "");
        let bands = ["95 % prediction band, up", "95 % prediction band, down"];
        let fits = ["chosen fit, up", "chosen fit, down"];
        let mean = "mean of the sweeps";
        let rest = [mean, mean, "first-order fit, *R*^{2} = 0.9877"];
        assert_eq!(names(&found), [&["samples"][..], &fits, &rest, &bands].concat());
        let note = "Chosen: hinge, y = a + b max(x − x_{0}, 0), up and down apart; RMS 0.100 N. Coefficients: \
                    table parameters.brake.";
        assert_eq!(found.footnotes, [note]);
        assert_eq!(found.mark, None);
        assert!(figure(&sweeps(1, 50, Source::Twin), "").mark.is_some());
    }

    #[test]
    fn samples_off_the_fit_are_those_of_its_own_way_however_often_a_sweep_turns() {
        let part = |way: Option<Branch>| Part {
            name: String::new(),
            way,
            points: &[],
            colour: style::INK,
            dash: Dash::Solid,
        };
        let (up, down, both) = (part(Some(Branch::Up)), part(Some(Branch::Down)), part(None));
        let mut sweep = sweeps(1, 2, Source::Recorded).remove(0);
        (sweep.command_values, sweep.response_values) =
            (vec![0.0, 4.0, 8.0, 4.0, 0.0], vec![0.0, 1.0, 8.0, 7.0, 0.5]);
        let fit: (&[f64], &[f64]) = (&[0.0, 8.0], &[0.0, 8.0]);
        assert_eq!(up.residuals(&sweep, fit), [(0.0, 0.0), (4.0, -3.0), (8.0, 0.0)]);
        assert_eq!(down.residuals(&sweep, fit), [(4.0, 3.0), (0.0, 0.5)]);
        assert_eq!(both.residuals(&sweep, fit).len(), 5);
        sweep.command_values.extend([5.0, 2.0]); // up again, and down
        sweep.response_values.extend([5.5, 4.0]);
        let ways = [&up, &down].map(|part| part.residuals(&sweep, fit));
        assert_eq!(ways[0][3..], [(5.0, 0.5)]);
        assert_eq!(ways[1], [(4.0, 3.0), (0.0, 0.5), (2.0, 2.0)]);
        assert_eq!(value_at(fit, 9.0), None, "the fit says nothing beyond its data");
    }

    #[test]
    fn many_samples_become_a_faint_line_a_sweep() {
        let found = figure(&sweeps(3, 6000, Source::Recorded), "");
        let is_sweep = |line: &&Line| line.stroke == style::faint(style::GREY);
        let lines: Vec<&Line> = found.panels[0].lines().filter(is_sweep).collect();
        assert_eq!(lines.len(), 3);
        assert!(lines[0].x.len() < 260 && names(&found)[0] == "sweeps");
    }

    #[test]
    fn breaks_are_marked_where_the_data_can_tell_them() {
        let labels = |note: &str| -> Vec<String> {
            let found = figure(&sweeps(2, 50, Source::Recorded), note);
            let label = |layer: &Layer| match layer {
                Layer::Reference(line) => line.label.clone(),
                _ => None,
            };
            found.panels[0].layers.iter().filter_map(label).collect()
        };
        assert_eq!(labels(""), ["begins at 1.00 V (up)", "begins at 0.500 V (down)"]);
        let note = "≤ 0.1 V (edge of the data): not identifiable";
        assert_eq!(labels(note), ["begins at 1.00 V (up)"]);
    }

    #[test]
    fn runs_within_a_step_become_their_mean_in_the_order_of_recording() {
        let (x, y) = step_means(&[0.0, 0.5, 1.0, 1.5, 0.5], &[1.0, 3.0, 4.0, 6.0, 9.0], 1.0);
        assert_eq!((x, y), (vec![0.25, 1.25, 0.5], vec![2.0, 5.0, 9.0]));
    }
}
