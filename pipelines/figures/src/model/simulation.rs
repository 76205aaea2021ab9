//! Figures 11, 12, 33–35: forces of model runs against angle and time, and their angle. Figure 8:
//! the inputs.

use crate::about::FigureKind;
use crate::extent::ends;
use crate::words::{Words, model_mark, plain, time_axis};
use zwidth_draw::style::{self, Stroke};
use zwidth_draw::{
    Axis, Cell, Direction, Figure, Layer, Line, ONE_COLUMN_MM, Panel, Range, Reference,
    TWO_COLUMNS_MM,
};
use zwidth_results::{ModelRun, ModelSample};
use zwidth_study::Coordinate;

/// Runs of scenes of the model, side by side.
pub const SCENE_RUNS: FigureKind = FigureKind::new(
    "scenes",
    "runs of the model: forces against angle and time, and the angle",
    "scene",
);
/// Their inputs.
pub const SCENE_INPUTS: FigureKind =
    FigureKind::new("scenes", "external force of runs of the model against time", "scene");

/// Height of a panel of forces against angle, mm.
const LOOP_MM: f64 = 58.0;
/// Height of a panel against time, mm.
const TIME_MM: f64 = 28.0;
/// Height of a panel of an input, mm.
const INPUT_MM: f64 = 32.0;
/// Most runs side by side on one page: more would be too narrow to read.
pub const MOST_SIDE_BY_SIDE: usize = 3;

/// Broad, so that the tissue's share on it leaves its edges.
const EXTERNAL: Stroke = Stroke { width_pt: 1.7, ..style::mean(style::INK) };
/// Follows the external force closely and lies over it: thinner, so that both are seen. Not dashed:
/// a loop that is run through twice fills the gaps of its own dashes.
const TISSUE: Stroke = Stroke { width_pt: 0.7, ..style::mean(style::FINGER) };

/// A part of the force: its name, its pen, its values at the samples.
struct Part {
    name: String,
    stroke: Stroke,
    force_n: Vec<f64>,
}

impl Part {
    /// A part that a scene may lack: then it has no values.
    fn of(
        run: &ModelRun,
        name: &str,
        stroke: Stroke,
        get: fn(&ModelSample) -> Option<f64>,
    ) -> Self {
        let force_n = run.samples.iter().filter_map(get).collect();
        Self { name: name.to_owned(), stroke, force_n }
    }

    fn external(run: &ModelRun) -> Self {
        Self::of(run, "external force", EXTERNAL, |sample| Some(sample.force_ex_n))
    }

    fn tissue(run: &ModelRun) -> Self {
        Self::of(run, "finger tissue", TISSUE, |sample| sample.force_tissue_n)
    }

    /// The force at `x`.
    fn line(self, x: Vec<f64>) -> Layer {
        let y = self.force_n;
        let stroke = self.stroke;
        let name = Some(plain(&self.name));
        Layer::Line(Line { x, y, stroke, name, ..Line::default() })
    }
}

/// Model runs, one column per run (at most [`MOST_SIDE_BY_SIDE`] are readable): forces by part against
/// the angle, external and tissue force against time, the angle against time. The axes have room for
/// the runs in `compared`, which other figures show, so that all of them have the same axes.
pub fn simulation(runs: &[&ModelRun], compared: &[&ModelRun]) -> Figure {
    let mut columns = columns(runs);
    if !compared.is_empty() {
        let others = self::columns(compared);
        for row in 0..columns[0].len() {
            let all: Vec<&Line> =
                columns.iter().chain(&others).flat_map(|column| column[row].lines()).collect();
            let x = ends(all.iter().flat_map(|line| line.x.iter().copied()));
            let y = ends(all.iter().flat_map(|line| line.y.iter().copied()));
            for column in &mut columns {
                let panel = &mut column[row];
                hold(&mut panel.x, x);
                hold(&mut panel.y, y);
            }
        }
    }
    let names: Vec<&str> = runs.iter().map(|run| run.scene.as_str()).collect();
    Figure {
        title: (runs.len() == 1).then(|| plain(&names.concat())),
        description: format!(
            "Model run: {}. From top to bottom: forces by part against angle; force of user and tissue against time; \
             angle against time.",
            names.join("; ")
        ),
        width_mm: if runs.len() == 1 { ONE_COLUMN_MM } else { TWO_COLUMNS_MM },
        panels: columns.into_iter().flatten().collect(),
        footnotes: notes(runs),
        mark: model_mark(),
        ..Figure::default()
    }
}

/// The panels of each run, from top to bottom.
fn columns(runs: &[&ModelRun]) -> Vec<[Panel; 3]> {
    let mut columns = Vec::new();
    for (column, run) in runs.iter().enumerate() {
        let zero = Reference::new(Direction::Horizontal, 0.0, style::reference());
        let mut layers = vec![Layer::Reference(zero)];
        layers.extend(parts(run).into_iter().map(|part| part.line(angles(run))));
        let x = words().position_axis().linked("angle");
        let y = Axis::new("*F*", "N").linked("forces");
        let mut loops = Panel::new(Cell::at(0, column), x, y, layers).tall(LOOP_MM);
        if runs.len() > 1 {
            loops.title = Some(plain(&run.scene));
        }
        let mut layers = vec![Part::external(run).line(times(run))];
        layers.extend(acting(Part::tissue(run)).map(|part| part.line(times(run))));
        let y = Axis::new("*F*", "N").linked("force");
        let forces = Panel::new(Cell::at(1, column), time_axis(""), y, layers);
        let line = Line { x: times(run), y: angles(run), ..Line::default() };
        let y = words().position_axis().linked("angle in time");
        let angle = Panel::new(Cell::at(2, column), time_axis("*t*"), y, vec![Layer::Line(line)]);
        columns.push([loops, forces.tall(TIME_MM), angle.tall(TIME_MM)]);
    }
    columns
}

/// Makes room for these values on an axis.
fn hold(axis: &mut Axis, ends: Option<(f64, f64)>) {
    if let Some((low, high)) = ends {
        axis.range = match axis.range {
            // Time ends with the run; `Holding` would add room.
            Range::Tight if high > low => Range::Fixed(low, high),
            _ => Range::Holding(low, high),
        };
    }
}

/// The external force of several runs against time, side by side (Fig. 8), [`MOST_SIDE_BY_SIDE`] in
/// a row.
pub fn inputs(runs: &[&ModelRun]) -> Figure {
    let mut panels = Vec::new();
    for (i, run) in runs.iter().enumerate() {
        let cell = Cell::at(i / MOST_SIDE_BY_SIDE, i % MOST_SIDE_BY_SIDE);
        let Part { force_n: y, stroke, .. } = Part::external(run);
        let layers = vec![Layer::Line(Line { x: times(run), y, stroke, ..Line::default() })];
        let y = Axis::new("*F*_{ex}", "N").linked("input");
        let panel = Panel::new(cell, time_axis("*t*"), y, layers).titled(plain(&run.scene));
        panels.push(panel.tall(INPUT_MM));
    }
    let names: Vec<&str> = runs.iter().map(|run| run.scene.as_str()).collect();
    Figure {
        description: format!("External force against time of the model runs {}.", names.join("; ")),
        panels,
        mark: model_mark(),
        ..Figure::default()
    }
}

/// What holds for all runs once, everything else with the run's name.
fn notes(runs: &[&ModelRun]) -> Vec<String> {
    let mut notes: Vec<String> = Vec::new();
    for run in runs {
        for note in &run.notes {
            let common = runs.iter().all(|other| other.notes.contains(note));
            let note = if common { plain(note) } else { plain(&format!("{}: {note}", run.scene)) };
            if !notes.contains(&note) {
                notes.push(note);
            }
        }
    }
    notes
}

fn words() -> Words {
    Words::new(Coordinate::Rotational)
}

fn times(run: &ModelRun) -> Vec<f64> {
    run.samples.iter().map(|sample| sample.t_s).collect()
}

fn angles(run: &ModelRun) -> Vec<f64> {
    words().positions(run.samples.iter().map(|sample| Some(sample.theta_rad)))
}

/// The parts of a run's force that ever act; the external one in any case. Friction and the scene's
/// terms each have a colour of their own. What arrives of the external force at the lever is between
/// it and the tissue's share, and not drawn.
fn parts(run: &ModelRun) -> Vec<Part> {
    let named = [
        Part::tissue(run),
        Part::of(run, "brake", style::single(style::BRAKE), |s| Some(s.force_brake_n)),
        Part::of(run, "motor", style::single(style::MOTOR), |s| Some(s.force_motor_n)),
        Part::of(run, "stop", style::single(style::GREY), |s| s.force_stop_n),
    ];
    let friction = Part::of(run, "friction", term_pen(0), |s| s.force_friction_n);
    let first = usize::from(!friction.force_n.is_empty());
    let terms = run.terms.iter().enumerate().map(|(i, term)| Part {
        name: term.term().replace('_', " "),
        stroke: term_pen(first + i),
        force_n: term.force_n.clone(),
    });
    let others = named.into_iter().chain([friction]).chain(terms);
    [Part::external(run)].into_iter().chain(others.filter_map(acting)).collect()
}

fn term_pen(index: usize) -> Stroke {
    style::single(style::part_colour(index)).dashed(style::dash(index))
}

/// A part that is not 0 all the time.
fn acting(part: Part) -> Option<Part> {
    part.force_n.iter().any(|force| force.abs() > 0.0).then_some(part)
}

#[cfg(test)]
mod tests {
    use super::*;
    use zwidth_results::{LeverMotion, TermForce};

    fn sample(t_s: f64, theta_rad: f64, force_ex_n: f64) -> ModelSample {
        ModelSample {
            t_s,
            theta_rad,
            theta_dot_rad_s: 0.0,
            finger_m: None,
            force_ex_n,
            force_tip_n: None,
            force_tissue_n: None,
            force_motor_n: 0.0,
            force_brake_n: 0.0,
            force_friction_n: None,
            force_stop_n: None,
            motion: LeverMotion::Forward,
        }
    }

    fn of(scene: &str, notes: &[&str], samples: Vec<ModelSample>) -> ModelRun {
        let notes = notes.iter().map(|note| (*note).to_owned()).collect();
        ModelRun { scene: scene.to_owned(), notes, samples, terms: Vec::new() }
    }

    fn run(scene: &str, finger: bool, note: &str) -> ModelRun {
        let tissue = |force: f64| finger.then_some(force);
        let braked = |sample: ModelSample, brake: f64, force: f64| ModelSample {
            force_brake_n: brake,
            force_tissue_n: tissue(force),
            ..sample
        };
        let samples = vec![
            braked(sample(0.0, 0.0, 1.0), -1.0, 1.0),
            braked(sample(1.0, std::f64::consts::FRAC_PI_4, 2.0), -2.0, 1.5),
        ];
        of(scene, &[note, "for all"], samples)
    }

    #[test]
    fn a_part_that_is_not_there_or_never_acts_is_not_drawn_and_every_run_is_marked() {
        let (with, without) = (run("with", true, "a"), run("without", false, "a"));
        let figure = simulation(&[&with, &without], &[]);
        assert_eq!(
            figure.panels.iter().map(|panel| panel.lines().count()).collect::<Vec<_>>(),
            [3, 2, 1, 2, 1, 1]
        );
        for figure in [figure, simulation(&[&with], &[]), inputs(&[&with, &without])] {
            assert!(figure.mark.unwrap().starts_with("SIMULATION"));
        }
    }

    #[test]
    fn friction_stop_and_every_term_have_lines_named_by_what_they_are() {
        let more = |sample: ModelSample, friction: f64, stop: f64| ModelSample {
            force_tip_n: Some(sample.force_ex_n),
            force_friction_n: Some(friction),
            force_stop_n: Some(stop),
            ..sample
        };
        let samples =
            vec![more(sample(0.0, 0.0, 1.0), 0.1, 0.0), more(sample(1.0, 1.0, 2.0), -0.2, 0.5)];
        let terms = vec![
            TermForce::new("spring_bed", "", vec![0.3, 0.0]),
            TermForce::new("gravity", "", vec![0.0, 0.0]),
        ];
        let figure = simulation(&[&ModelRun { terms, ..of("terms", &[], samples) }], &[]);
        let names = figure.panels[0].lines().filter_map(|line| line.name.as_deref());
        assert_eq!(names.collect::<Vec<_>>(), ["external force", "stop", "friction", "spring bed"]);
    }

    #[test]
    fn figures_that_are_compared_have_the_same_axes() {
        let other = of("longer", &[], vec![sample(0.0, -1.0, 0.0), sample(3.0, 0.5, 7.0)]);
        let one = run("one", true, "a");
        let ranges = |figure: Figure| -> Vec<[Range; 2]> {
            figure.panels.iter().map(|panel| [panel.x.range, panel.y.range]).collect()
        };
        let a = ranges(simulation(&[&one], &[&other]));
        let b = ranges(simulation(&[&other], &[&one]));
        assert_eq!(a, b);
        assert_eq!(a[1], [Range::Fixed(0.0, 3.0), Range::Holding(0.0, 7.0)]);
        assert_ne!(ranges(simulation(&[&one], &[])), a, "alone it fits its own data");
    }

    #[test]
    fn angles_stand_in_degrees() {
        let figure = simulation(&[&run("one", false, "a")], &[]);
        let Layer::Line(line) = &figure.panels[2].layers[0] else { panic!("no line") };
        assert!((line.y[1] - 45.0).abs() < 1e-12);
    }

    #[test]
    fn a_note_that_holds_for_one_run_only_names_it() {
        let (a, b) = (run("A", true, "smooth"), run("B", true, "chattering"));
        assert_eq!(simulation(&[&a, &b], &[]).footnotes, ["A: smooth", "for all", "B: chattering"]);
    }

    #[test]
    fn more_inputs_than_fit_in_a_row_go_on_in_the_next() {
        let one = run("one", false, "a");
        let figure = inputs(&[&one, &one, &one, &one]);
        assert_eq!(figure.panels[3].cell, Cell::at(1, 0));
    }
}
