//! Figure 24, reality against simulation: forces, position and velocity against time of one
//! recorded trial per mode, and those of the model driven by its external force.

use crate::extent::without_excess;
use crate::words::{Words, keep_together, mark, plain, time_axis};
use crate::{About, FigureKind};
use zwidth_draw::style::{self, Dash, Stroke};
use zwidth_draw::{Axis, Cell, Direction, Figure, Layer, Line, Panel, Range, Reference};
use zwidth_results::{CourseSample, CourseSeries};
use zwidth_study::{Environment, Mode, Source};

/// The figure [`replay`].
pub const REPLAY: FigureKind =
    FigureKind::new("replay", "recorded trials and the model given their external force", "trial");

/// Height of a panel, mm.
const PANEL_MM: f64 = 32.0;

/// Motion and forces against time: all as long as `t_s`; what there is not is empty.
#[derive(Debug, Clone, PartialEq, Default)]
struct Motion {
    /// Time, s.
    t_s: Vec<f64>,
    /// θ, rad.
    theta_rad: Vec<f64>,
    /// θ̇, rad/s.
    theta_dot_rad_s: Vec<f64>,
    /// F_ex, N.
    force_ex_n: Vec<f64>,
    /// Force of the actuators against the user, N.
    feedback_n: Vec<f64>,
}

/// One trial, and the models that were given its external force.
#[derive(Debug, Clone, PartialEq)]
struct Replayed {
    /// The mode's name, and which trial it is.
    title: String,
    /// Where the trial comes from.
    source: Source,
    /// What was recorded.
    recorded: Motion,
    /// The model with the parameters chosen by eye.
    by_eye: Motion,
    /// The model with those that were fitted, if they were.
    fitted: Option<Motion>,
}

/// The figure of one environment of one session, one column per trial. `courses` are those of its
/// typical trials; `notes`, which describe their models, go below the figure.
pub fn replay(
    about: &About,
    environment: &Environment,
    who: &str,
    courses: &[CourseSample],
    notes: &[String],
) -> Figure {
    let trials: Vec<Replayed> =
        about.modes.iter().filter_map(|mode| replayed(courses, mode)).collect();
    figure(about, environment, who, &trials, notes)
}

/// A mode's trial and its models; `None` if it has no trial.
fn replayed(courses: &[CourseSample], mode: &Mode) -> Option<Replayed> {
    let mut own = courses.iter().filter(|row| row.mode == mode.id);
    let first = own.find(|row| row.series == CourseSeries::Recorded)?;
    let [recorded, by_eye, fitted] =
        [CourseSeries::Recorded, CourseSeries::ByEye, CourseSeries::Fitted].map(|series| {
            motion(courses.iter().filter(|row| row.mode == mode.id && row.series == series))
        });
    let fitted = Some(fitted).filter(|motion| !motion.t_s.is_empty());
    let title = format!("{}, trial {}", mode.label, first.trial);
    Some(Replayed { title, source: first.source, recorded, by_eye, fitted })
}

fn motion<'c>(rows: impl Iterator<Item = &'c CourseSample>) -> Motion {
    let mut motion = Motion::default();
    for row in rows {
        motion.t_s.push(row.t_s);
        motion.theta_rad.push(row.theta_rad);
        motion.theta_dot_rad_s.push(row.theta_dot_rad_s);
        motion.force_ex_n.push(row.force_ex_n);
        motion.feedback_n.extend(row.feedback_n);
    }
    motion
}

fn figure(
    about: &About,
    environment: &Environment,
    who: &str,
    trials: &[Replayed],
    notes: &[String],
) -> Figure {
    let words = Words::new(about.coordinate);
    let wall_rad = environment.scene.wall_rad();
    let mut acting: Vec<f64> = Vec::new();
    for trial in trials {
        acting.extend(models(trial).flat_map(|(motion, _, _)| &motion.feedback_n));
        acting.extend(&trial.recorded.force_ex_n);
    }
    let commanded = trials.iter().flat_map(|trial| trial.recorded.feedback_n.iter().copied());
    // One axis for all columns, so that the forces of the modes can be compared.
    let cut = without_excess(acting, commanded);
    let mut panels = Vec::new();
    for (column, trial) in trials.iter().enumerate() {
        let force = Axis::new("*F*", "N").linked("force");
        let force = force.ranged(cut.map_or(Range::Auto, |(range, _)| range));
        let position = words.position_axis().linked("position");
        let velocity = words.velocity_axis().linked("velocity");
        let at_wall = wall_rad.map(|wall| words.position(wall));
        let angles = motions(words, trial, at_wall, |motion| &motion.theta_rad);
        let speeds = motions(words, trial, Some(0.0), |motion| &motion.theta_dot_rad_s);
        let panel = |row: usize, time: &str, y: Axis, layers: Vec<Layer>| {
            Panel::new(Cell::at(row, column), time_axis(time), y, layers).tall(PANEL_MM)
        };
        panels.push(panel(0, "", force, forces(trial)).titled(plain(&trial.title)));
        panels.push(panel(1, "", position, angles));
        panels.push(panel(2, "time", velocity, speeds));
    }
    let wall =
        wall_rad.map(|_| format!("Dashed line across the {}: the wall.", words.position_word()));
    let beyond = cut.map(|(_, most)| format!(" Commanded were up to {most:.1} N."));
    let own = "Forces: recorded is the user's, which the model is given; a model's is the feedback that acts, so that a \
               brake that holds the lever gives no more than it must.";
    Figure {
        title: Some(plain(&format!(
            "{}: {}, reality against model ({})",
            about.title,
            environment.label,
            keep_together(who)
        ))),
        description: format!(
            "{who}, environment {}: forces, {} and velocity against time of one recorded trial a mode, and of the \
             model that was given its external force.",
            environment.label,
            words.position_word(),
        ),
        panels,
        footnotes: std::iter::once(own.to_owned() + &beyond.unwrap_or_default())
            .chain(wall)
            .chain(notes.iter().map(|n| plain(n)))
            .collect(),
        mark: mark(trials.iter().map(|t| t.source)),
        ..Figure::default()
    }
}

/// Broad and pale, so that a model that lies on it is seen.
pub(crate) const RECORDED: Stroke =
    Stroke { width_pt: 2.4, opacity: 0.35, ..style::mean(style::INK) };

/// The models with their pens and names; what was chosen by eye is dashed.
fn models(trial: &Replayed) -> impl Iterator<Item = (&Motion, Stroke, &'static str)> {
    let by_eye = style::single(style::environment_colour(2)).dashed(Dash::Dashed);
    let fitted = style::single(style::environment_colour(5));
    let fitted = trial.fitted.iter().map(move |motion| (motion, fitted, "model, fitted"));
    [(&trial.by_eye, by_eye, "model, by eye")].into_iter().chain(fitted)
}

fn forces(trial: &Replayed) -> Vec<Layer> {
    let line = |motion: &Motion, y: &[f64], stroke, name: &str| {
        let x = motion.t_s.clone();
        let y = y.to_vec();
        let name = Some(name.to_owned());
        (!y.is_empty()).then_some(Layer::Line(Line { x, y, stroke, name, ..Line::default() }))
    };
    let recorded = &trial.recorded;
    let mut layers = vec![level(0.0)];
    layers.extend(line(recorded, &recorded.force_ex_n, RECORDED, "recorded"));
    layers.extend(
        models(trial).filter_map(|(motion, pen, name)| line(motion, &motion.feedback_n, pen, name)),
    );
    // Last, so that its dots are seen on every curve.
    let commanded = &recorded.feedback_n;
    layers.extend(line(recorded, commanded, style::commanded(), "feedback commanded"));
    layers
}

/// The recording and the models on it, with a line across where there is a level.
fn motions(
    words: Words,
    trial: &Replayed,
    level_at: Option<f64>,
    pick: fn(&Motion) -> &Vec<f64>,
) -> Vec<Layer> {
    let recorded = [(&trial.recorded, RECORDED, "recorded")];
    let lines = recorded.into_iter().chain(models(trial)).map(|(motion, stroke, name)| {
        let x = motion.t_s.clone();
        let y = words.positions(pick(motion).iter().copied().map(Some));
        let name = Some(name.to_owned());
        Layer::Line(Line { x, y, stroke, name, ..Line::default() })
    });
    level_at.map(level).into_iter().chain(lines).collect()
}

/// A line across at a value.
fn level(at: f64) -> Layer {
    Layer::Reference(Reference::new(Direction::Horizontal, at, style::reference()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn moved(by: f64) -> Motion {
        let t_s: Vec<f64> = (0..50).map(|i| f64::from(i) / 10.0).collect();
        let y: Vec<f64> = t_s.iter().map(|t| by + libm::sin(*t)).collect();
        Motion {
            t_s,
            theta_rad: y.clone(),
            theta_dot_rad_s: y.clone(),
            force_ex_n: y.clone(),
            feedback_n: y,
        }
    }

    fn drawn(fitted: bool) -> Figure {
        let study = zwidth_testing::study();
        let trial = Replayed {
            title: "Hybrid, trial 4".to_owned(),
            source: Source::Twin,
            recorded: moved(0.0),
            by_eye: moved(0.3),
            fitted: fitted.then(|| moved(0.1)),
        };
        figure(&About::of(&study), &study.environments[0], "P01 S01", &[trial.clone(), trial], &[])
    }

    fn names(panel: &Panel) -> Vec<&str> {
        panel.lines().filter_map(|line| line.name.as_deref()).collect()
    }

    #[test]
    fn each_trial_is_a_column_of_force_position_and_velocity() {
        let figure = drawn(true);
        assert_eq!(figure.panels.len(), 6);
        assert_eq!(names(&figure.panels[0]).len(), 4);
        assert_eq!(names(&figure.panels[4]), ["recorded", "model, by eye", "model, fitted"]);
        assert!(figure.mark.as_deref().unwrap().starts_with("SYNTHETIC"));
        assert!(zwidth_draw::draw(&figure).is_ok());
    }

    #[test]
    fn without_a_fit_there_is_no_curve_of_it() {
        assert!(drawn(false).panels.iter().all(|p| !names(p).contains(&"model, fitted")));
    }
}
