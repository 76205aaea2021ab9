//! Figures 22 and 23: what came of a command, every sweep, with the first-order fit and the chosen
//! one; below, how far the samples lie off the chosen one.

mod words;

use self::words::{Parameter, about, chosen, parameters, row_of, significant, why_not_calibrated};
use crate::FigureKind;
use crate::data::gaps;
use crate::words::{mark, percent, plain};
use zwidth_draw::style::{self, Colour, Dash};
use zwidth_draw::{Axis, Band, Cell, Direction, Figure, Layer, Line, Panel, Points, Reference};
use zwidth_numerics::branch::{Branch, branches};
use zwidth_store::{Quantity, Sweep};
use zwidth_tables::{Table, TableError};

/// The figure [`characteristic`].
pub const CHARACTERISTIC: FigureKind = FigureKind {
    stem: "characteristic",
    shows: "response to the command, with the chosen fit",
    drawn_from: "sweep",
};

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
/// Steps of the command that such a line has one mean in: about one a printed dot.
const STEPS: f64 = 250.0;

/// Pen of the chosen fit under a mean, pt.
const BROAD_PT: f64 = 2.4;
/// Pen of the mean of the sweeps on it, pt.
const THIN_PT: f64 = 0.6;

/// The stage's tables of one actuator or sensor.
#[derive(Debug, Clone, Copy)]
pub struct Characterised<'a> {
    /// Candidate models.
    pub models: &'a Table,
    /// Their parameters.
    pub parameters: &'a Table,
    /// The chosen curve.
    pub curve: &'a Table,
    /// Level of their intervals.
    pub level: f64,
}

/// The characteristic of one actuator or sensor: all sweeps faint, their mean, the first-order fit
/// with its R², the chosen fit, and where it begins and ends to rise; below, from the chosen fit
/// on, the band for a new response and the samples. Its coefficients stand in their table.
pub fn characteristic(
    actuator: &str,
    sweeps: &[Sweep],
    of: Characterised,
) -> Result<Figure, TableError> {
    let quantity =
        |of: fn(&Sweep) -> &Quantity| sweeps.first().map(of).cloned().unwrap_or_else(nothing);
    let (command, response) = (quantity(|s| &s.command), quantity(|s| &s.response));
    let chosen = chosen(of.models)?;
    let mut layers = samples(sweeps, are_seen(of.models, &chosen, sweeps)?);
    layers.extend(curves(of, &chosen, sweeps.len())?);
    layers.extend(corners(of.parameters, &chosen, &command.unit)?);
    let x = || axis(&command).linked("command");
    let panel = Panel::new(Cell::at(0, 0), x(), axis(&response), layers);
    let off = Axis::new("off the fit", plain(&response.unit));
    let below = residuals(of, sweeps)?.map(|layers| Panel {
        height_mm: Some(RESIDUALS_MM),
        ..Panel::new(Cell::at(1, 0), x(), off, layers)
    });
    let panel = Panel { height_mm: Some(PANEL_MM), ..panel };
    let mut footnotes = about(of.models, &chosen, &response.unit, actuator)?;
    if actuator == "motor" {
        footnotes.extend(why_not_calibrated(of.curve, &command.unit, &response.unit)?);
    }
    Ok(Figure {
        title: Some(format!("Characteristic: {}", plain(&actuator.replace('_', " ")))),
        description: format!(
            "{} against {} of the {actuator}: {} sweeps, the first-order fit, the chosen fit ({chosen}) and its band for \
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
    })
}

fn nothing() -> Quantity {
    Quantity { name: String::new(), unit: String::new() }
}

fn axis(quantity: &Quantity) -> Axis {
    Axis::new(plain(&quantity.name), plain(&quantity.unit))
}

/// Whether samples stand out from under the fits: not if the chosen one misses them by less than
/// half its own width in print. What cannot be seen does not stand in the legend.
fn are_seen(models: &Table, chosen: &str, sweeps: &[Sweep]) -> Result<bool, TableError> {
    let rms = match row_of(models, chosen)? {
        Some(row) => models.floats("rms")?[row],
        None => None,
    };
    let all = crate::extent::ends(sweeps.iter().flat_map(|s| &s.response_values).copied());
    let off_pt = rms.zip(all).map(|(rms, (low, high))| rms / (high - low) * PANEL_PT);
    Ok(off_pt.is_none_or(|off_pt| off_pt.is_nan() || off_pt > BROAD_PT / 2.0))
}

/// All samples as points, or each sweep as a faint line where points would be a blot; named where
/// they are seen.
fn samples(sweeps: &[Sweep], seen: bool) -> Vec<Layer> {
    let n: usize = sweeps.iter().map(|s| s.command_values.len()).sum();
    if n <= MOST_POINTS {
        return vec![points(sweeps, n > MANY_POINTS, seen)];
    }
    let all = sweeps.iter().flat_map(|s| &s.command_values).copied();
    let (low, high) =
        all.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)));
    let line = |(number, sweep): (usize, &Sweep)| {
        let (x, y) =
            step_means(&sweep.command_values, &sweep.response_values, (high - low) / STEPS);
        let name = (number == 0 && seen).then(|| "sweeps".to_owned());
        Layer::Line(Line { x, y, stroke: style::faint(style::GREY), name, ..Line::default() })
    };
    sweeps.iter().enumerate().map(line).collect()
}

fn points(sweeps: &[Sweep], many: bool, seen: bool) -> Layer {
    let all = |values: fn(&Sweep) -> &Vec<f64>| sweeps.iter().flat_map(values).copied().collect();
    Layer::Points(Points {
        x: all(|s| &s.command_values),
        y: all(|s| &s.response_values),
        colour: style::GREY,
        opacity: if many { 0.25 } else { 0.6 },
        diameter_pt: if many { 1.4 } else { style::POINT_PT },
        name: seen.then(|| "samples".to_owned()),
    })
}

/// Means of runs of samples whose commands lie in one step of this width, in the order of
/// recording.
fn step_means(x: &[f64], y: &[f64], step: f64) -> (Vec<f64>, Vec<f64>) {
    let place = |x: f64| libm::floor(x / step) as i64;
    let samples: Vec<(f64, f64)> = x.iter().copied().zip(y.iter().copied()).collect();
    let mean = |run: &[(f64, f64)]| {
        let (sx, sy) = run.iter().fold((0.0, 0.0), |(sx, sy), (x, y)| (sx + x, sy + y));
        (sx / run.len() as f64, sy / run.len() as f64)
    };
    samples.chunk_by(|a, b| place(a.0) == place(b.0)).map(mean).unzip()
}

/// One branch of the chosen curve: a part of the curve's table.
struct Part {
    /// `, up`; nothing of the only one.
    name: String,
    /// Which way of the command it is; none: both.
    way: Option<Branch>,
    rows: core::ops::Range<usize>,
    colour: Colour,
    dash: Dash,
}

/// The branches in the curve's table: one, or up and down.
fn parts(curve: &Table) -> Result<Vec<Part>, TableError> {
    let names = curve.texts("branch")?;
    let mut parts: Vec<Part> = Vec::new();
    for same in names.chunk_by(|a, b| a == b) {
        let start = parts.last().map_or(0, |p| p.rows.end);
        let way = Branch::ALL.into_iter().find(|way| same[0].as_deref() == Some(way.name()));
        let name = way.map(|way| format!(", {}", way.name())).unwrap_or_default();
        let (colour, dash) = (style::direction_colour(parts.len()), style::dash(parts.len()));
        parts.push(Part { name, way, rows: start..start + same.len(), colour, dash });
    }
    Ok(parts)
}

impl Part {
    /// A column of the branch; null becomes a gap.
    fn column(&self, curve: &Table, name: &str) -> Result<Vec<f64>, TableError> {
        Ok(gaps(curve.floats(name)?)[self.rows.clone()].to_vec())
    }

    /// How far a sweep's samples of this branch lie off its fit; which these are is told by the
    /// rule that the fit went by.
    fn residuals(&self, sweep: &Sweep, fit: (&[f64], &[f64])) -> Vec<(f64, f64)> {
        let commands = &sweep.command_values;
        let ways = self.way.map(|way| (way, branches(commands)));
        let mine = |i: &usize| ways.as_ref().is_none_or(|(way, ways)| ways[*i] == *way);
        let off =
            |i: usize| Some((commands[i], sweep.response_values[i] - value_at(fit, commands[i])?));
        (0..commands.len()).filter(mine).filter_map(off).collect()
    }
}

/// The samples off the chosen fit, and the band for a new response on them; `None` where there is
/// no fit.
fn residuals(of: Characterised, sweeps: &[Sweep]) -> Result<Option<Vec<Layer>>, TableError> {
    let zero = Reference {
        direction: Direction::Horizontal,
        at: 0.0,
        label: None,
        stroke: style::zero(),
        name: None,
    };
    let n: usize = sweeps.iter().map(|s| s.command_values.len()).sum();
    let stride = n.div_ceil(MOST_POINTS).max(1);
    let named = (stride > 1).then(|| format!("one sample of {stride}, off the fit"));
    let (mut layers, mut bands) = (vec![Layer::Reference(zero)], Vec::new());
    for part in parts(of.curve)? {
        let (x, fit) = (part.column(of.curve, "command")?, part.column(of.curve, "fit")?);
        let off = |name: &str| -> Result<Vec<f64>, TableError> {
            let values = part.column(of.curve, name)?;
            Ok(values.iter().zip(&fit).map(|(value, fit)| value - fit).collect())
        };
        let (low, high) = (off("prediction_low")?, off("prediction_high")?);
        let name = Some(format!("{} prediction band{}", percent(of.level), part.name));
        let curve = (x.as_slice(), fit.as_slice());
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
    layers.extend(bands);
    Ok(any.then_some(layers))
}

/// The value of a rising curve at `x`, on the straight line between its points; `None` outside.
fn value_at((xs, ys): (&[f64], &[f64]), x: f64) -> Option<f64> {
    let after = xs.partition_point(|at| *at < x).max(1);
    let (x0, x1) = (*xs.get(after - 1)?, *xs.get(after)?);
    let share = (x - x0) / (x1 - x0);
    (0.0..=1.0).contains(&share).then(|| ys[after - 1] + share * (ys[after] - ys[after - 1]))
}

/// Fits, means and the first-order fit, in the order in which they lie over each other: the mean is
/// thin on the broad chosen fit, so that both are seen where they agree. Where the line was chosen
/// it is the first-order fit.
fn curves(of: Characterised, chosen: &str, sweeps: usize) -> Result<Vec<Layer>, TableError> {
    let parts = parts(of.curve)?;
    let line = |y: &str, part: &Part, stroke, name: String| {
        let (x, y) = (part.column(of.curve, "command")?, part.column(of.curve, y)?);
        Ok::<_, TableError>(Layer::Line(Line { x, y, stroke, name: Some(name), ..Line::default() }))
    };
    let first_order = format!("first-order fit{}", r_squared(of.models)?);
    let fit =
        if chosen == "line" { format!("{first_order} (chosen)") } else { "chosen fit".to_owned() };
    let mut layers = Vec::new();
    for part in &parts {
        let usual = style::mean(part.colour).dashed(part.dash);
        let pen = if sweeps > 1 { style::Stroke { width_pt: BROAD_PT, ..usual } } else { usual };
        layers.push(line("fit", part, pen, format!("{fit}{}", part.name))?);
    }
    for part in parts.iter().filter(|_| sweeps > 1) {
        let thin = style::Stroke { width_pt: THIN_PT, ..style::single(style::INK) };
        layers.push(line("mean", part, thin, "mean of the sweeps".to_owned())?);
    }
    if let Some(part) = parts.first().filter(|_| chosen != "line") {
        let dashed = style::Stroke { colour: style::INK, width_pt: 0.9, ..style::reference() };
        layers.push(line("first_order", part, dashed, first_order)?);
    }
    Ok(layers)
}

/// `, R² = 0.9894` of the line.
fn r_squared(models: &Table) -> Result<String, TableError> {
    let r2 = match row_of(models, "line")? {
        Some(row) => models.floats("r2")?[row],
        None => None,
    };
    Ok(r2.map(|r2| format!(", *R*^{{2}} = {r2:.4}")).unwrap_or_default())
}

/// Where the chosen curve begins and ends to rise, where the data can tell.
fn corners(table: &Table, chosen: &str, unit: &str) -> Result<Vec<Layer>, TableError> {
    let corner = |p: &Parameter| {
        let what = match p.symbol.as_str() {
            "x0" => "begins at",
            "x1" => "ends at",
            _ => return None,
        };
        let way = if p.branch == "both" { String::new() } else { format!(" ({})", p.branch) };
        Some(Layer::Reference(Reference {
            direction: Direction::Vertical,
            at: p.estimate,
            label: Some(format!("{what} {} {}{way}", significant(p.estimate), plain(unit))),
            stroke: style::reference().dashed(style::Dash::Dotted),
            name: None,
        }))
    };
    Ok(parameters(table, chosen)?.iter().filter(|p| p.note.is_empty()).filter_map(corner).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;
    use zwidth_study::Source;
    use zwidth_tables::Column;

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

    fn texts(name: &'static str, values: &[&str]) -> Column {
        Column::text(name, "", values.iter().map(|v| Some((*v).to_owned())).collect::<Vec<_>>())
    }

    fn floats(name: &'static str, values: &[f64]) -> Column {
        Column::float(name, "1", "", values.iter().copied().map(Some).collect::<Vec<_>>())
    }

    fn models() -> Table {
        let columns = vec![
            texts("model", &["line", "hinge_up_down"]),
            texts("formula", &["y = a + b x", "y = a + b max(x - x0, 0), up and down apart"]),
            texts("verdict", &["rejected: RMS 1 N", "chosen: RMS 0.1 N"]),
            floats("rms", &[1.0, 0.1]),
            floats("r2", &[0.987_65, 0.999]),
        ];
        Table::new("models", "Models", columns).unwrap()
    }

    fn parameters_of(note: &str) -> Table {
        let (up, down) = (["a", "b", "x0"], ["a", "b", "x0"]);
        let columns = vec![
            texts("model", &[["line"; 2].as_slice(), &["hinge_up_down"; 6]].concat()),
            texts("parameter", &[&["a", "b"][..], &up, &down].concat()),
            texts("branch", &[["both"; 2].as_slice(), &["up"; 3], &["down"; 3]].concat()),
            floats("estimate", &[-1.0, 1.7, 0.0, 2.0, 1.0, 0.0, 2.0, 0.5]),
            floats("ci_low", &[-1.1, 1.6, 0.0, 1.9, 0.9, 0.0, 1.9, 0.4]),
            floats("ci_high", &[-0.9, 1.8, 0.0, 2.1, 1.1, 0.0, 2.1, 0.6]),
            texts("unit", &["N", "N/V", "N", "N/V", "V", "N", "N/V", "V"]),
            texts("note", &["", "", "", "", "", "", "", note]),
        ];
        Table::new("parameters", "Parameters", columns).unwrap()
    }

    fn curve() -> Table {
        let numbers =
            ["command", "mean", "fit", "prediction_low", "prediction_high", "first_order"];
        let mut columns = vec![texts("branch", &["up", "up", "down", "down"])];
        columns.extend(numbers.map(|name| floats(name, &[0.0, 8.0, 0.0, 8.0])));
        Table::new("curve", "Curve", columns).unwrap()
    }

    fn figure(sweeps: &[Sweep], note: &str) -> Figure {
        let (models, parameters, curve) = (models(), parameters_of(note), curve());
        let of =
            Characterised { models: &models, parameters: &parameters, curve: &curve, level: 0.95 };
        characteristic("brake", sweeps, of).unwrap()
    }

    #[test]
    fn a_force_with_friction_in_it_says_why_the_calibration_gives_another() {
        let note = why_not_calibrated(&curve(), "V", "N").unwrap().unwrap();
        assert!(note.contains("8.00 N at 8.00 V") && note.contains("rendering"), "{note}");
        let one_way = curve().rows(&[0, 1]);
        assert_eq!(why_not_calibrated(&one_way, "V", "N").unwrap(), None);
        assert_eq!(why_not_calibrated(&curve(), "V", "counts").unwrap(), None);
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
        let rest =
            ["mean of the sweeps", "mean of the sweeps", "first-order fit, *R*^{2} = 0.9877"];
        assert_eq!(names(&found), [&["samples"][..], &fits, &rest, &bands].concat());
        assert_eq!(
            found.footnotes,
            [
                "Chosen: hinge, y = a + b max(x − x_{0}, 0), up and down apart; RMS 0.100 N. Coefficients: table \
              parameters.brake."
            ]
        );
        assert_eq!(found.mark, None);
        assert!(figure(&sweeps(1, 50, Source::Twin), "").mark.is_some());
    }

    #[test]
    fn samples_off_the_fit_are_those_of_its_own_way_however_often_a_sweep_turns() {
        let part = |way: Option<Branch>| Part {
            name: String::new(),
            way,
            rows: 0..2,
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
        let is_sweep = |layer: &&Layer| matches!(layer, Layer::Line(l) if l.stroke == style::faint(style::GREY));
        let lines: Vec<&Layer> = found.panels[0].layers.iter().filter(is_sweep).collect();
        assert_eq!(lines.len(), 3);
        let Layer::Line(line) = lines[0] else { panic!() };
        assert!(line.x.len() < 260 && names(&found)[0] == "sweeps");
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
        assert_eq!(
            labels("≤ 0.1 V (edge of the data): not identifiable"),
            ["begins at 1.00 V (up)"]
        );
    }

    #[test]
    fn runs_within_a_step_become_their_mean_in_the_order_of_recording() {
        let (x, y) = step_means(&[0.0, 0.5, 1.0, 1.5, 0.5], &[1.0, 3.0, 4.0, 6.0, 9.0], 1.0);
        assert_eq!((x, y), (vec![0.25, 1.25, 0.5], vec![2.0, 5.0, 9.0]));
    }
}
