//! Error against work of every solver and step on a scene, on axes of logarithms, and what of it a
//! person could feel.

use crate::about::FigureKind;
use crate::extent::ends;
use crate::words::{model_mark, plain};
use zwidth_draw::style::{self, Stroke};
use zwidth_draw::{
    Axis, Cell, Direction, Figure, Layer, Line, Panel, Points, Range, Reference, TWO_COLUMNS_MM,
    Ticks,
};
use zwidth_dynamics::{NAMED_SOLVERS, solver_label};
use zwidth_tables::{Table, TableError};

/// A scene's errors and work.
pub const WORK_PRECISION: FigureKind = FigureKind {
    stem: "trade",
    shows: "speed against accuracy of model runs: error and what could be felt, against work",
    drawn_from: "setting",
};

/// Height of a panel, mm.
const PANEL_MM: f64 = 62.0;
/// Errors below this are drawn at it: rounding, in degrees.
const LEAST_DEG: f64 = 1e-10;
/// Shares of what is felt below this are drawn at it.
const LEAST_SHARE: f64 = 1e-4;
/// Radii of the ring about what is recommended, as shares of a decade of work and of error.
const RING: (f64, f64) = (0.13, 0.4);
/// Diameter of a point whose setting passes every gate, pt.
const GOOD_PT: f64 = 3.4;
/// And of one that does not.
const BAD_PT: f64 = 1.6;

/// The rows of one solver: work and errors as they stand on the axes, before their logarithms.
struct Curve {
    name: String,
    stroke: Stroke,
    work: Vec<f64>,
    error_deg: Vec<f64>,
    felt: Vec<f64>,
    good: Vec<bool>,
}

/// Error of the angle against work with the front that no setting beats, and the most that could be
/// felt against work. `settings` is the stage `trade`'s table of one scene; the axes hold that of
/// all scenes which it is compared with, `beside`; `chosen` names what is recommended, by solver and
/// work.
///
/// # Errors
/// A table that lacks a column.
pub fn work_precision(
    settings: &Table,
    beside: &Table,
    chosen: Option<(&str, u64)>,
    notes: &[String],
) -> Result<Figure, TableError> {
    let (curves, all) = (curves(settings)?, curves(beside)?);
    let mut error = layers(&curves, |curve| &curve.error_deg);
    error.insert(0, front(settings)?);
    let mut felt = layers(&curves, |curve| &curve.felt);
    felt.insert(0, just_felt());
    for (layers, pick) in [(&mut error, error_of as fn(&Curve) -> &Vec<f64>), (&mut felt, felt_of)]
    {
        layers.extend(chosen.and_then(|chosen| ring(&curves, chosen, pick)));
    }
    let powers = |label: &str, unit: &str, pick: fn(&Curve) -> &Vec<f64>, ring: f64| {
        let shown = ends(all.iter().flat_map(|curve| logarithms(pick(curve))));
        // Wherever the ring of one scene lies, the axis is that of the others.
        let range =
            shown.map_or(Range::Auto, |(low, high)| Range::Holding(low - ring, high + ring));
        Axis { ticks: Ticks::Powers, range, ..Axis::new(label, unit) }
    };
    let x = || powers("work, evaluations", "", |curve| &curve.work, RING.0).linked("work");
    let y_error = powers("largest error of *θ*", "°", error_of, RING.1);
    let y_felt = powers("error / what is just felt", "", felt_of, RING.1);
    let panels = vec![
        panel(0, x(), y_error, error, "**a**  error"),
        panel(1, x(), y_felt, felt, "**b**  what could be felt"),
    ];
    Ok(Figure {
        title: Some(plain(settings.title())),
        description: format!(
            "{}. Left: largest error of the angle against work for every solver and step or tolerance, with the front \
             that no setting beats. Right: the largest of slow force, slow angle and vibration over what is just felt, \
             against work. All axes are logarithmic. Large points pass every gate, small ones do not.",
            settings.title()
        ),
        width_mm: TWO_COLUMNS_MM,
        panels,
        footnotes: std::iter::once(
            "Large points: passed (sound verdict, not felt). Small points: not. Ring: recommended. Grey: the front. At \
             the foot of b: 0.0001 or less, which includes no difference at all."
                .to_owned(),
        )
        .chain(notes.iter().map(|note| plain(note)))
        .collect(),
        mark: model_mark(),
        ..Figure::default()
    })
}

/// The same of one scene of a study, on the axes of all its scenes, with what is recommended for it
/// as note.
///
/// # Errors
/// A table that lacks a column.
pub fn work_precision_of(
    scene: &str,
    settings: &Table,
    summary: &Table,
) -> Result<Figure, TableError> {
    let of = |table: &Table| -> Result<Vec<usize>, TableError> {
        let scenes = table.texts("scene")?;
        Ok((0..scenes.len()).filter(|i| scenes[*i].as_deref() == Some(scene)).collect())
    };
    let own = settings.rows(&of(settings)?);
    let title = format!("{scene}: speed against accuracy");
    let (solver, work) = (summary.texts("solver")?, summary.integers("work")?);
    let yardstick = summary.texts("yardstick")?;
    let row = of(summary)?.first().copied();
    let chosen = row.and_then(|i| Some((solver[i].as_deref()?, u64::try_from(work[i]?).ok()?)));
    let proof = row.and_then(|i| yardstick[i].clone()).unwrap_or_default();
    let mut notes = vec![format!("Yardstick: {proof}.")];
    notes.push(match chosen {
        Some((solver, work)) => format!(
            "Cheapest that passes: {}, {work} evaluations; not tried on neighbours of the scene (zwidth trade does).",
            solver_label(solver)
        ),
        None => "Nothing is recommended.".to_owned(),
    });
    let figure = work_precision(&own, settings, chosen, &notes)?;
    Ok(Figure { title: Some(plain(&title)), ..figure })
}

fn error_of(curve: &Curve) -> &Vec<f64> {
    &curve.error_deg
}

fn felt_of(curve: &Curve) -> &Vec<f64> {
    &curve.felt
}

fn panel(column: usize, x: Axis, y: Axis, layers: Vec<Layer>, title: &str) -> Panel {
    let panel = Panel::new(Cell::at(0, column), x, y, layers).titled(title);
    Panel { height_mm: Some(PANEL_MM), ..panel }
}

fn just_felt() -> Layer {
    let (direction, stroke) = (Direction::Horizontal, style::reference());
    let label = Some("just felt".to_owned());
    Layer::Reference(Reference { direction, at: 0.0, label, stroke, name: None })
}

fn curves(table: &Table) -> Result<Vec<Curve>, TableError> {
    let solvers: Vec<String> = table.texts("solver")?.into_iter().flatten().collect();
    let gates: Vec<String> = table.texts("gate")?.into_iter().flatten().collect();
    let work = work(table)?;
    let error = table.floats("theta_error_max_rad")?;
    let shares = ["felt_force_share", "felt_angle_share", "felt_vibration_share"];
    let shares = shares.map(|name| table.floats(name));
    let shares: Vec<Vec<Option<f64>>> = shares.into_iter().collect::<Result<_, _>>()?;
    let most = |i: usize| {
        let known = shares.iter().filter_map(|share| share[i]);
        known.fold(f64::NAN, |most, share| most.max(share).max(LEAST_SHARE))
    };
    let mut curves = Vec::new();
    for (number, named) in NAMED_SOLVERS.into_iter().enumerate() {
        let rows: Vec<usize> = (0..solvers.len()).filter(|i| solvers[*i] == named.name).collect();
        if rows.is_empty() {
            continue;
        }
        let degrees = |i: &usize| error[*i].map_or(f64::NAN, |rad| rad.to_degrees().max(LEAST_DEG));
        curves.push(Curve {
            name: named.label.to_owned(),
            stroke: style::single(style::solver_colour(number)).dashed(style::dash(number)),
            work: rows.iter().map(|i| work[*i]).collect(),
            error_deg: rows.iter().map(degrees).collect(),
            felt: rows.iter().map(|i| most(*i)).collect(),
            good: rows.iter().map(|i| gates[*i] == "passed").collect(),
        });
    }
    Ok(curves)
}

fn work(table: &Table) -> Result<Vec<f64>, TableError> {
    Ok(table.integers("work")?.into_iter().map(|n| n.map_or(f64::NAN, |n| n as f64)).collect())
}

/// Settings that no other beats in work and error of the angle, joined.
fn front(table: &Table) -> Result<Layer, TableError> {
    let (on, work) = (table.flags("on_front")?, work(table)?);
    let error = table.floats("theta_error_max_rad")?;
    let mut pairs: Vec<(f64, f64)> = (0..on.len())
        .filter(|i| on[*i] == Some(true))
        .map(|i| (work[i], error[i].map_or(f64::NAN, |rad| rad.to_degrees().max(LEAST_DEG))))
        .collect();
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (x, y): (Vec<f64>, Vec<f64>) = pairs.into_iter().unzip();
    let stroke = Stroke { width_pt: 3.0, ..style::mean(style::GRID) };
    Ok(Layer::Line(Line { x: logarithms(&x), y: logarithms(&y), stroke, ..Line::default() }))
}

fn layers(curves: &[Curve], pick: fn(&Curve) -> &Vec<f64>) -> Vec<Layer> {
    let of = |curve: &Curve| {
        let (x, y) = (logarithms(&curve.work), logarithms(pick(curve)));
        let colour = curve.stroke.colour;
        let points = |good: bool, diameter_pt: f64| {
            let kept = |values: &[f64]| -> Vec<f64> {
                let pairs = values.iter().zip(&curve.good);
                pairs.filter(|(_, is)| **is == good).map(|(value, _)| *value).collect()
            };
            Layer::Points(Points {
                x: kept(&x),
                y: kept(&y),
                colour,
                diameter_pt,
                ..Points::default()
            })
        };
        let line = Line {
            x: x.clone(),
            y: y.clone(),
            stroke: curve.stroke,
            name: Some(plain(&curve.name)),
            ..Line::default()
        };
        [Layer::Line(line), points(true, GOOD_PT), points(false, BAD_PT)]
    };
    curves.iter().flat_map(of).collect()
}

/// A ring about what is recommended.
fn ring(
    curves: &[Curve],
    (solver, work): (&str, u64),
    pick: fn(&Curve) -> &Vec<f64>,
) -> Option<Layer> {
    let label = NAMED_SOLVERS.into_iter().find(|named| named.name == solver)?.label;
    let curve = curves.iter().find(|curve| curve.name == label)?;
    let is_it = |w: &f64| (*w - work as f64).abs() < 0.5;
    let i = curve.work.iter().position(is_it)?;
    let (x, y) = (libm::log10(curve.work[i]), libm::log10(pick(curve)[i]));
    const CORNERS: u32 = 48;
    let turn = |k: u32| f64::from(k) / f64::from(CORNERS) * std::f64::consts::TAU;
    Some(Layer::Line(Line {
        x: (0..=CORNERS).map(|k| x + RING.0 * libm::cos(turn(k))).collect(),
        y: (0..=CORNERS).map(|k| y + RING.1 * libm::sin(turn(k))).collect(),
        stroke: style::single(style::INK),
        ..Line::default()
    }))
}

/// What an axis of powers of ten takes; what is not above zero has no place on it.
fn logarithms(values: &[f64]) -> Vec<f64> {
    values.iter().map(|&v| if v > 0.0 { libm::log10(v) } else { f64::NAN }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use zwidth_tables::Column;

    fn settings() -> Table {
        let text =
            |name, values: [&str; 3]| Column::text(name, "", values.map(|v| Some(v.to_owned())));
        let float = |name, values: [Option<f64>; 3]| Column::float(name, "", "", values);
        let columns = vec![
            text("scene", ["s", "s", "s"]),
            text("solver", ["exact", "rk4_per_step", "rk4_per_step"]),
            text("gate", ["passed", "verdict", "verdict"]),
            float("theta_error_max_rad", [Some(0.0), Some(1e-2), None]),
            float("felt_force_share", [Some(0.0), Some(3.0), None]),
            float("felt_angle_share", [Some(0.0), Some(0.1), None]),
            float("felt_vibration_share", [Some(0.8), None, None]),
            Column::integer("work", "1", "", [Some(500), Some(2000), None]),
            Column::flag("on_front", "", [Some(true), Some(false), Some(false)]),
        ];
        Table::new("trade", "Trade", columns).unwrap()
    }

    #[test]
    fn a_failed_setting_has_no_point_and_the_largest_share_counts() {
        let curves = curves(&settings()).unwrap();
        let rk4 = &curves[1];
        assert!((rk4.felt[0] - 3.0).abs() < 1e-12, "{:?}", rk4.felt);
        assert!(rk4.felt[1].is_nan() && rk4.work[1].is_nan() && rk4.error_deg[1].is_nan());
        assert!(
            (curves[0].error_deg[0] - LEAST_DEG).abs() < 1e-20,
            "rounding is drawn at the foot"
        );
    }

    #[test]
    fn without_an_error_a_setting_stands_at_the_foot() {
        let zero = |name| Column::float(name, "", "", [Some(0.0), Some(0.0), Some(0.0)]);
        let shares = ["felt_force_share", "felt_angle_share", "felt_vibration_share"];
        let table = settings();
        let is_kept = |column: &&Column| !shares.contains(&column.field.name.as_ref());
        let mut columns: Vec<Column> = table.columns().iter().filter(is_kept).cloned().collect();
        columns.extend(shares.map(zero));
        let table = Table::new("trade", "Trade", columns).unwrap();
        assert_eq!(curves(&table).unwrap()[0].felt, [LEAST_SHARE]);
    }

    #[test]
    fn what_is_recommended_has_a_ring_in_both_panels() {
        let layers = |chosen| -> usize {
            let figure = work_precision(&settings(), &settings(), chosen, &[]).unwrap();
            assert!(zwidth_draw::draw(&figure).is_ok());
            figure.panels.iter().map(|panel| panel.layers.len()).sum()
        };
        assert_eq!(layers(Some(("exact", 500))), layers(None) + 2);
    }

    /// The settings of two scenes: the second takes a thousandfold of the work and of the error.
    #[test]
    fn the_scenes_of_a_study_stand_on_the_same_axes() {
        let (first, scale) = (settings(), [1.0, 1e3]);
        let text = |name: &'static str| {
            let values = first.texts(name).unwrap();
            Column::text(name, "", values.iter().chain(&values).cloned())
        };
        let float = |name: &'static str| {
            let values = first.floats(name).unwrap();
            let scaled = |by: f64| values.iter().map(move |value| value.map(|v| v * by));
            Column::float(name, "", "", scale.into_iter().flat_map(scaled).collect::<Vec<_>>())
        };
        let work = [Some(500), Some(2000), None, Some(500_000), Some(2_000_000), None];
        let on_front = [true, false, false].map(Some);
        let columns = vec![
            Column::text("scene", "", ["s", "s", "s", "t", "t", "t"].map(|s| Some(s.to_owned()))),
            text("solver"),
            text("gate"),
            float("theta_error_max_rad"),
            float("felt_force_share"),
            float("felt_angle_share"),
            float("felt_vibration_share"),
            Column::integer("work", "1", "", work),
            Column::flag("on_front", "", [on_front, on_front].concat()),
        ];
        let both = Table::new("trade", "Trade", columns).unwrap();
        let chosen = vec![
            Column::text("scene", "", ["s", "t"].map(|s| Some(s.to_owned()))),
            Column::text("solver", "", [Some("exact".to_owned()), None]),
            Column::integer("work", "1", "", [Some(500), None]),
            Column::text("yardstick", "", [None::<String>, None]),
        ];
        let summary = Table::new("trade_summary", "Trade", chosen).unwrap();
        let axes = |scene| {
            let figure = work_precision_of(scene, &both, &summary).unwrap();
            assert!(zwidth_draw::draw(&figure).is_ok());
            figure.panels.iter().map(|p| (p.x.range, p.y.range)).collect::<Vec<_>>()
        };
        assert_eq!(axes("s"), axes("t"));
        let Range::Holding(least, most) = axes("s")[0].0 else { panic!("{:?}", axes("s")) };
        assert!((least - (libm::log10(500.0) - RING.0)).abs() < 1e-9, "{least}");
        assert!((most - (libm::log10(2e6) + RING.0)).abs() < 1e-9, "{most}");
    }
}
