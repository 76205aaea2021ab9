//! Error against work of every solver and step on a scene, on logarithmic axes, and which errors a
//! person could feel.

use crate::about::FigureKind;
use crate::extent::ends;
use crate::words::{just_felt, logarithm, logarithms, model_mark, plain, powers_axis};
use zwidth_draw::style::{self, Stroke};
use zwidth_draw::{Cell, Direction, Figure, Layer, Line, Panel, Points, Range, TWO_COLUMNS_MM};
use zwidth_dynamics::{NAMED_SOLVERS, solver_label};
use zwidth_results::{Gate, Row, TradeChoice, TradeSetting};

/// A scene's errors and work.
pub const WORK_PRECISION: FigureKind = FigureKind::new(
    "trade",
    "speed against accuracy of model runs: error and what could be felt, against work",
    "setting",
);

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
/// felt against work. `settings` are those of a scene and of all scenes with which it is compared:
/// the axes cover them all. `choice` says what is recommended for the scene.
pub fn work_precision(
    title: &str,
    scene: &str,
    settings: &[TradeSetting],
    choice: Option<&TradeChoice>,
    notes: &[String],
) -> Figure {
    let own: Vec<&TradeSetting> =
        settings.iter().filter(|setting| *setting.scene == *scene).collect();
    let (curves, all) = (curves(&own), curves(&settings.iter().collect::<Vec<_>>()));
    let mut error = layers(&curves, |curve| &curve.error_deg);
    // Broad and pale, under the points that lie on it.
    error.insert(0, front(&own));
    let mut felt = layers(&curves, |curve| &curve.felt);
    felt.insert(0, just_felt(Direction::Horizontal));
    error.extend(choice.and_then(|choice| ring(&curves, choice, |curve| &curve.error_deg)));
    felt.extend(choice.and_then(|choice| ring(&curves, choice, |curve| &curve.felt)));
    let powers = |label: &str, unit: &str, pick: fn(&Curve) -> &Vec<f64>, ring: f64| {
        let shown = ends(all.iter().flat_map(|curve| logarithms(pick(curve))));
        // Wherever the ring of one scene lies, the axis is that of the others.
        let range =
            shown.map_or(Range::Auto, |(low, high)| Range::Holding(low - ring, high + ring));
        powers_axis(label, unit).ranged(range)
    };
    let x = powers("work, evaluations", "", |curve| &curve.work, RING.0).linked("work");
    let y_error = powers("largest error of *θ*", "°", |curve| &curve.error_deg, RING.1);
    let y_felt = powers("error / what is just felt", "", |curve| &curve.felt, RING.1);
    let error = Panel::new(Cell::at(0, 0), x.clone(), y_error, error).titled("**a**  error");
    let felt = Panel::new(Cell::at(0, 1), x, y_felt, felt).titled("**b**  what could be felt");
    Figure {
        title: Some(plain(title)),
        description: format!(
            "{title}. Left: largest error of the angle against work for every solver and step or tolerance, with the front \
             that no setting beats. Right: the largest of slow force, slow angle and vibration over what is just felt, \
             against work. All axes are logarithmic. Large points pass every gate, small ones do not."
        ),
        width_mm: TWO_COLUMNS_MM,
        panels: vec![error.tall(PANEL_MM), felt.tall(PANEL_MM)],
        footnotes: std::iter::once(
            "Large points: passed (sound verdict, not felt). Small points: not. Ring: recommended. Grey: the front. At \
             the foot of b: 0.0001 or less, which includes no difference at all."
                .to_owned(),
        )
        .chain(notes.iter().map(|note| plain(note)))
        .collect(),
        mark: model_mark(),
        ..Figure::default()
    }
}

/// The same of one scene of a study, on the axes of all its scenes, with what is recommended for it
/// as note.
pub fn work_precision_of(
    scene: &str,
    settings: &[TradeSetting],
    choices: &[TradeChoice],
) -> Figure {
    let choice = choices.iter().find(|choice| *choice.scene == *scene);
    let proof = choice.map_or("", |choice| choice.yardstick.as_str());
    let recommended = choice.and_then(|choice| choice.solver.as_deref().zip(choice.work));
    let recommended = match recommended {
        Some((solver, work)) => format!(
            "Cheapest that passes: {}, {work} evaluations; not tried on neighbours of the scene (zwidth trade does).",
            solver_label(solver)
        ),
        None => "Nothing is recommended.".to_owned(),
    };
    let notes = [format!("Yardstick: {proof}."), recommended];
    let figure = work_precision(TradeSetting::TITLE, scene, settings, choice, &notes);
    Figure { title: Some(plain(&format!("{scene}: speed against accuracy"))), ..figure }
}

fn curves(settings: &[&TradeSetting]) -> Vec<Curve> {
    let mut curves = Vec::new();
    for (number, named) in NAMED_SOLVERS.into_iter().enumerate() {
        let own: Vec<&TradeSetting> =
            settings.iter().copied().filter(|setting| *setting.solver == *named.name).collect();
        if own.is_empty() {
            continue;
        }
        curves.push(Curve {
            name: named.label.to_owned(),
            stroke: style::single(style::solver_colour(number)).dashed(style::dash(number)),
            work: own.iter().map(|setting| work(setting)).collect(),
            error_deg: own.iter().map(|setting| error_deg(setting)).collect(),
            felt: own.iter().map(|setting| most_felt(setting)).collect(),
            good: own.iter().map(|setting| setting.gate == Gate::Passed).collect(),
        });
    }
    curves
}

fn work(setting: &TradeSetting) -> f64 {
    setting.work.map_or(f64::NAN, |work| work as f64)
}

fn error_deg(setting: &TradeSetting) -> f64 {
    setting.theta_error_max_rad.map_or(f64::NAN, |rad| rad.to_degrees().max(LEAST_DEG))
}

/// The largest of the shares of what is felt.
fn most_felt(setting: &TradeSetting) -> f64 {
    let TradeSetting { felt_force_share, felt_angle_share, felt_vibration_share, .. } = setting;
    let shares = [felt_force_share, felt_angle_share, felt_vibration_share].into_iter().flatten();
    // From NaN on, which `max` leaves for any number: without a share there is no point.
    shares.fold(f64::NAN, |most, share| most.max(*share).max(LEAST_SHARE))
}

/// Settings that no other beats in work and error of the angle, joined.
fn front(settings: &[&TradeSetting]) -> Layer {
    let mut on_front: Vec<_> = settings.iter().filter(|setting| setting.on_front).collect();
    // By work, so that the line never runs back.
    on_front.sort_by(|a, b| work(a).total_cmp(&work(b)));
    Layer::Line(Line {
        x: on_front.iter().map(|setting| logarithm(work(setting))).collect(),
        y: on_front.iter().map(|setting| logarithm(error_deg(setting))).collect(),
        stroke: Stroke { width_pt: 3.0, ..style::mean(style::GRID) },
        ..Line::default()
    })
}

fn layers(curves: &[Curve], pick: fn(&Curve) -> &Vec<f64>) -> Vec<Layer> {
    let mut layers = Vec::new();
    for curve in curves {
        let x = logarithms(&curve.work);
        let y = logarithms(pick(curve));
        let stroke = curve.stroke;
        let name = Some(plain(&curve.name));
        let line = Line { x: x.clone(), y: y.clone(), stroke, name, ..Line::default() };
        layers.push(Layer::Line(line));
        for (good, diameter_pt) in [(true, GOOD_PT), (false, BAD_PT)] {
            let [x, y] = [&x, &y].map(|values| {
                let pairs = values.iter().zip(&curve.good);
                pairs.filter(|(_, is)| **is == good).map(|(value, _)| *value).collect()
            });
            let colour = stroke.colour;
            layers.push(Layer::Points(Points { x, y, colour, diameter_pt, ..Points::default() }));
        }
    }
    layers
}

/// A ring about what is recommended.
fn ring(curves: &[Curve], choice: &TradeChoice, pick: fn(&Curve) -> &Vec<f64>) -> Option<Layer> {
    const CORNERS: u32 = 48;
    let (solver, work) = choice.solver.as_deref().zip(choice.work)?;
    let label = NAMED_SOLVERS.into_iter().find(|named| named.name == solver)?.label;
    let curve = curves.iter().find(|curve| curve.name == label)?;
    // Both are whole numbers, one of them held as a float.
    let i = curve.work.iter().position(|w| (*w - work as f64).abs() < 0.5)?;
    let x = libm::log10(curve.work[i]);
    let y = libm::log10(pick(curve)[i]);
    let turns: Vec<f64> =
        (0..=CORNERS).map(|k| f64::from(k) / f64::from(CORNERS) * std::f64::consts::TAU).collect();
    Some(Layer::Line(Line {
        x: turns.iter().map(|turn| x + RING.0 * libm::cos(*turn)).collect(),
        y: turns.iter().map(|turn| y + RING.1 * libm::sin(*turn)).collect(),
        stroke: style::single(style::INK),
        ..Line::default()
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::{trade_choice, trade_setting};

    fn settings() -> Vec<TradeSetting> {
        let exact = TradeSetting {
            gate: Gate::Passed,
            theta_error_max_rad: Some(0.0),
            felt_force_share: Some(0.0),
            felt_angle_share: Some(0.0),
            felt_vibration_share: Some(0.8),
            work: Some(500),
            on_front: true,
            ..trade_setting("exact")
        };
        let coarse = TradeSetting {
            theta_error_max_rad: Some(1e-2),
            felt_force_share: Some(3.0),
            felt_angle_share: Some(0.1),
            work: Some(2000),
            ..trade_setting("rk4_per_step")
        };
        vec![exact, coarse, trade_setting("rk4_per_step")]
    }

    #[test]
    fn a_failed_setting_has_no_point_and_the_largest_share_counts() {
        let settings = settings();
        let curves = curves(&settings.iter().collect::<Vec<_>>());
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
        let zero = Some(0.0);
        let exact = TradeSetting {
            felt_force_share: zero,
            felt_angle_share: zero,
            felt_vibration_share: zero,
            ..trade_setting("exact")
        };
        assert_eq!(curves(&[&exact])[0].felt, [LEAST_SHARE]);
    }

    #[test]
    fn what_is_recommended_has_a_ring_in_both_panels() {
        let settings = settings();
        let layers = |choice: &TradeChoice| -> usize {
            let figure = work_precision_of("s", &settings, std::slice::from_ref(choice));
            assert!(zwidth_draw::draw(&figure).is_ok());
            figure.panels.iter().map(|panel| panel.layers.len()).sum()
        };
        let none = trade_choice();
        let exact = TradeChoice { solver: Some("exact".into()), work: Some(500), ..trade_choice() };
        assert_eq!(layers(&exact), layers(&none) + 2);
    }

    /// The settings of two scenes: the second takes a thousandfold of the work and of the error.
    #[test]
    fn the_scenes_of_a_study_stand_on_the_same_axes() {
        let scaled = |number: Option<f64>| number.map(|number| 1e3 * number);
        let second = settings().into_iter().map(|setting| TradeSetting {
            scene: "t".into(),
            theta_error_max_rad: scaled(setting.theta_error_max_rad),
            felt_force_share: scaled(setting.felt_force_share),
            felt_angle_share: scaled(setting.felt_angle_share),
            felt_vibration_share: scaled(setting.felt_vibration_share),
            work: setting.work.map(|work| 1000 * work),
            ..setting
        });
        let both: Vec<TradeSetting> = settings().into_iter().chain(second).collect();
        let first = TradeChoice { solver: Some("exact".into()), work: Some(500), ..trade_choice() };
        let choices = [first, TradeChoice { scene: "t".into(), ..trade_choice() }];
        let axes = |scene| {
            let figure = work_precision_of(scene, &both, &choices);
            assert!(zwidth_draw::draw(&figure).is_ok());
            figure.panels.iter().map(|p| (p.x.range, p.y.range)).collect::<Vec<_>>()
        };
        assert_eq!(axes("s"), axes("t"));
        let Range::Holding(least, most) = axes("s")[0].0 else { panic!("{:?}", axes("s")) };
        assert!((least - (libm::log10(500.0) - RING.0)).abs() < 1e-9, "{least}");
        assert!((most - (libm::log10(2e6) + RING.0)).abs() < 1e-9, "{most}");
    }
}
