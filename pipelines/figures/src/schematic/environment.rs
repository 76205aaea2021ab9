//! Figures 26 and 27: what an environment renders, drawn to the angles of the study: device,
//! spring, wall.

use crate::FigureKind;
use crate::schematic::sketch::{self, Lever, UPRIGHT_MM, ground, over, panel};
use crate::words::{Words, plain};
use serde::Serialize;
use zwidth_draw::style::{self, Stroke};
use zwidth_draw::{Cell, Figure, LegendPlace, ONE_COLUMN_MM};
use zwidth_study::{Coordinate, Environment, Spring, Study};

/// The figure [`environment`].
pub const ENVIRONMENT: FigureKind =
    FigureKind::new("environment", "device, spring and wall at the study's own angles", "trial");

/// Corners of the drawing, mm.
const CORNERS: [(f64, f64); 2] = [(-41.7, -9.0), (41.7, 41.0)];
// Distances from the axis, in lengths of the lever.
/// The spring.
const SPRING: f64 = 0.68;
/// The arrow of θ.
const THETA: f64 = 0.42;
/// The arrow of the device's torque.
const TORQUE: f64 = 0.22;
/// Both ends of what the spring stands against.
const STOP: (f64, f64) = (0.56, 0.8);
/// Both ends of the wall: the lever's tip runs into it, the spring does not.
const WALL: (f64, f64) = (0.8, 1.12);

/// An environment, and the device that renders it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Placement {
    /// What is rendered.
    pub environment: Environment,
    /// What the coordinate is called.
    pub coordinate: Coordinate,
    /// Lever length L, m.
    pub lever_m: Option<f64>,
    /// Work space, lower end, rad.
    pub theta_min_rad: Option<f64>,
    /// Work space, upper end, rad.
    pub theta_max_rad: Option<f64>,
}

impl Placement {
    /// An environment of a study.
    pub fn of(study: &Study, environment: &Environment) -> Self {
        let device = &study.device;
        Self {
            environment: environment.clone(),
            coordinate: study.coordinate,
            lever_m: device.lever_m,
            theta_min_rad: device.theta_min_rad,
            theta_max_rad: device.theta_max_rad,
        }
    }
}

/// The device and what it renders, as far as it is a lever between stops on a spring; `None`
/// otherwise.
///
/// Angles are true; θ = 0 is upright, and θ > 0 compresses. Lengths are in lengths of the lever.
/// What the drawing shows is commanded, not measured.
pub fn environment(placement: &Placement) -> Option<Figure> {
    let Placement { coordinate, environment, .. } = placement;
    let low = placement.theta_min_rad?;
    let high = placement.theta_max_rad?;
    let spring = environment.scene.spring().filter(|_| *coordinate == Coordinate::Rotational)?;
    let wall = environment.scene.wall_rad();
    let words = Words::new(*coordinate);
    let lever = Lever::between(UPRIGHT_MM, low, high);
    let mut layers = lever.work_space(words, low, high);
    // The spring lies between the lever and the end of the work space.
    layers.push(sketch::spring(
        &lever.arc(SPRING, lever.theta_rad, high),
        style::mean(style::FINGER),
    ));
    let stiffness = format!("*K* = {} N/rad", number(spring.stiffness_n_per_rad));
    layers.push(over(stiffness, lever.at(0.7, high + 0.48)));
    layers.extend(lever.rest(spring.rest_rad));
    layers.extend(ground(&lever.ray(STOP, high), style::mean(style::INK)));
    if let Some(theta) = wall {
        let pen = Stroke { width_pt: 1.8, ..style::mean(style::MARK) };
        layers.extend(ground(&lever.ray(WALL, theta), pen));
        let name = format!("wall {}", words.signed_place(theta));
        layers.push(over(name, lever.at(WALL.1 + 0.12, theta)));
    }
    layers.extend(lever.push());
    layers.extend(lever.torque(TORQUE));
    layers.extend(lever.angle(THETA));
    layers.extend(lever.bar());
    layers.push(over("motor and brake", (0.0, -8.1)));
    Some(Figure {
        title: Some(plain(&environment.label)),
        description: format!(
            "Environment {}: the lever between its stops, the virtual spring{}.",
            environment.label,
            if wall.is_some() { " and the virtual wall" } else { "" }
        ),
        width_mm: ONE_COLUMN_MM,
        panels: vec![panel(Cell::at(0, 0), CORNERS[0], CORNERS[1], layers)],
        legend: LegendPlace::Hidden,
        footnotes: footnotes(placement.lever_m, words, spring, environment, high),
        ..Figure::default()
    })
}

/// What is drawn, in numbers.
fn footnotes(
    lever_m: Option<f64>,
    words: Words,
    spring: Spring,
    environment: &Environment,
    high: f64,
) -> Vec<String> {
    let force = |theta_rad: f64| spring.stiffness_n_per_rad * (theta_rad - spring.rest_rad);
    let lever = lever_m.map(|l| format!("Lever {} mm. ", number(l * 1e3)));
    let mut notes = vec![format!(
        "{}Spring: {} N/rad, at rest at {}, {} N at {}.",
        lever.unwrap_or_default(),
        number(spring.stiffness_n_per_rad),
        words.signed_place(spring.rest_rad),
        number(force(high)),
        words.signed_place(high),
    )];
    notes.extend(environment.scene.wall_rad().map(|at| {
        format!(
            "Wall: from {} on (where the spring has {} N) each actuator in use gets its full voltage.",
            words.signed_place(at),
            number(force(at))
        )
    }));
    if environment.delay_s > 0.0 {
        notes.push(format!("Rendered {} ms late.", number(environment.delay_s * 1e3)));
    }
    notes
}

/// To two decimals, without idle zeros.
fn number(value: f64) -> String {
    format!("{}", (value * 100.0).round() / 100.0).replace('-', "−")
}

#[cfg(test)]
mod tests {
    use super::*;
    use zwidth_draw::Layer;
    use zwidth_study::Scene;

    fn drawn(study: &Study) -> Figure {
        environment(&Placement::of(study, &study.environments[1])).unwrap()
    }

    fn texts(figure: &Figure) -> Vec<String> {
        let words =
            |layer: &Layer| if let Layer::Text(t) = layer { Some(t.lines.join(" ")) } else { None };
        figure.panels[0].layers.iter().filter_map(words).collect()
    }

    /// Angles from upright of the ends of every line that begins on the axis.
    fn radii_deg(figure: &Figure) -> Vec<f64> {
        let lines = figure.panels[0].lines().filter(|l| l.x[0] == 0.0 && l.y[0] == 0.0);
        let ends = lines.filter_map(|l| Some((*l.x.last()?, *l.y.last()?)));
        ends.map(|(x, y)| libm::atan2(x, y).to_degrees()).collect()
    }

    #[test]
    fn the_drawing_stands_at_the_study_s_own_angles() {
        let mut study = zwidth_testing::study();
        let labels = texts(&drawn(&study));
        for label in ["−45°", "45°", "0°", "wall 26.6°", "*K* = 4 N/rad"] {
            assert!(labels.iter().any(|l| l == label), "{label} is not in {labels:?}");
        }
        study.environments[1].scene =
            Scene::Spring(Spring { stiffness_n_per_rad: 3.0, rest_rad: -0.5 });
        let figure = drawn(&study);
        assert!(!texts(&figure).iter().any(|l| l.starts_with("wall")));
        assert!(radii_deg(&figure).iter().any(|deg| (deg + 0.5_f64.to_degrees()).abs() < 1e-9));
    }

    #[test]
    fn the_footnotes_say_what_the_spring_has_at_the_wall() {
        let notes = drawn(&zwidth_testing::study()).footnotes;
        // 4 N/rad from −45° on: 4 · 71.6° = 5.00 N at the wall, 4 · 90° = 6.28 N at the upper stop.
        assert!(notes[0].contains("at rest at −45°, 6.28 N at 45°"), "{notes:?}");
        assert!(notes[1].contains("from 26.6° on (where the spring has 5 N)"), "{notes:?}");
    }

    #[test]
    fn a_slide_free_motion_and_a_device_without_stops_are_not_drawn() {
        let drawn = |change: fn(&mut Study)| {
            let mut study = zwidth_testing::study();
            change(&mut study);
            environment(&Placement::of(&study, &study.environments[0])).is_some()
        };
        assert!(drawn(|_| ()));
        assert!(!drawn(|s| s.coordinate = Coordinate::Linear { lever_m: 1.0 }));
        assert!(!drawn(|s| s.environments[0].scene = Scene::Free));
        assert!(!drawn(|s| s.device.theta_max_rad = None));
    }
}
