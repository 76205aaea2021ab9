//! Figures 11, 12, 33–35: forces of model runs against angle and time, and their angle. Figure 8:
//! the inputs.

use crate::about::FigureKind;
use crate::data::gaps;
use crate::extent::ends;
use crate::words::{Words, model_mark, plain, time_axis};
use zwidth_draw::style::{self, Stroke};
use zwidth_draw::{
    Axis, Cell, Direction, Figure, Layer, Line, ONE_COLUMN_MM, Panel, Range, Reference,
    TWO_COLUMNS_MM,
};
use zwidth_study::Coordinate;
use zwidth_tables::{Table, TableError};

/// Runs of scenes of the model, side by side.
pub const SCENE_RUNS: FigureKind = FigureKind {
    stem: "scenes",
    shows: "runs of the model: forces against angle and time, and the angle",
    drawn_from: "scene",
};
/// Their inputs.
pub const SCENE_INPUTS: FigureKind = FigureKind {
    stem: "scenes",
    shows: "external force of runs of the model against time",
    drawn_from: "scene",
};

/// Height of a panel of forces against angle, mm.
const LOOP_MM: f64 = 58.0;
/// Height of a panel against time, mm.
const TIME_MM: f64 = 28.0;
/// Height of a panel of an input, mm.
const INPUT_MM: f64 = 32.0;
/// Runs that stand beside each other on one page: more would be too narrow to read.
pub const MOST_SIDE_BY_SIDE: usize = 3;

/// A part of the force: its column, its name, its pen.
type Part<'a> = (&'a str, &'a str, Stroke);

/// Broad, so that the tissue's share on it leaves its edges.
const EXTERNAL: Part<'static> =
    ("force_ex_n", "external force", Stroke { width_pt: 1.7, ..style::mean(style::INK) });
/// Follows the external force closely and lies over it: thinner, so that both are seen. Not dashed:
/// a loop that is run through twice fills the gaps of its own dashes.
const TISSUE: Part<'static> =
    ("force_tissue_n", "finger tissue", Stroke { width_pt: 0.7, ..style::mean(style::FINGER) });
const BRAKE: Part<'static> = ("force_brake_n", "brake", style::single(style::BRAKE));
const MOTOR: Part<'static> = ("force_motor_n", "motor", style::single(style::MOTOR));
const STOP: Part<'static> = ("force_stop_n", "stop", style::single(style::GREY));
/// What arrives of the external force at the lever: between it and the tissue's share, and not
/// drawn.
const TIP: &str = "force_tip_n";

/// Model runs, a column each (at most [`MOST_SIDE_BY_SIDE`] are readable): forces by part against
/// the angle, external and tissue force against time, the angle against time. `runs` are tables of
/// the stage `simulate`, named by their titles; the axes have room for those in `compared`, which
/// other figures show, so that all of them have the same axes.
///
/// # Errors
/// A table that lacks a column.
pub fn simulation(runs: &[&Table], compared: &[&Table]) -> Result<Figure, TableError> {
    let mut columns = columns(runs)?;
    if !compared.is_empty() {
        let others = self::columns(compared)?;
        for row in 0..columns[0].len() {
            let all = || columns.iter().chain(&others).map(|column| &column[row]);
            let x = ends(all().flat_map(|panel| lines(panel).flat_map(|line| line.x.clone())));
            let y = ends(all().flat_map(|panel| lines(panel).flat_map(|line| line.y.clone())));
            for column in &mut columns {
                let panel = &mut column[row];
                hold(&mut panel.x, x);
                hold(&mut panel.y, y);
            }
        }
    }
    let names: Vec<&str> = runs.iter().map(|run| run.title()).collect();
    Ok(Figure {
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
    })
}

/// The panels of each run, from top to bottom.
fn columns(runs: &[&Table]) -> Result<Vec<[Panel; 3]>, TableError> {
    let mut columns = Vec::new();
    for (column, run) in runs.iter().enumerate() {
        let mut loops = loop_panel(run, column)?;
        if runs.len() > 1 {
            loops.title = Some(plain(run.title()));
        }
        columns.push([loops, force_panel(run, column)?, angle_panel(run, column)?]);
    }
    Ok(columns)
}

fn lines(panel: &Panel) -> impl Iterator<Item = &Line> {
    panel.layers.iter().filter_map(|layer| match layer {
        Layer::Line(line) => Some(line),
        _ => None,
    })
}

/// Makes room for these values on an axis.
fn hold(axis: &mut Axis, ends: Option<(f64, f64)>) {
    if let Some((low, high)) = ends {
        axis.range = match axis.range {
            Range::Tight if high > low => Range::Fixed(low, high),
            _ => Range::Holding(low, high),
        };
    }
}

/// The external force of several runs against time, side by side (Fig. 8), [`MOST_SIDE_BY_SIDE`] in
/// a row.
///
/// # Errors
/// A table that lacks a column.
pub fn inputs(runs: &[&Table]) -> Result<Figure, TableError> {
    let panel = |(i, run): (usize, &&Table)| -> Result<Panel, TableError> {
        let cell = Cell::at(i / MOST_SIDE_BY_SIDE, i % MOST_SIDE_BY_SIDE);
        let line = over_time(run, &EXTERNAL)?;
        let layers = vec![Layer::Line(Line { name: None, ..line })];
        let panel =
            Panel::new(cell, time_axis("*t*"), Axis::new("*F*_{ex}", "N").linked("input"), layers);
        Ok(Panel { height_mm: Some(INPUT_MM), ..panel.titled(plain(run.title())) })
    };
    let names: Vec<&str> = runs.iter().map(|run| run.title()).collect();
    Ok(Figure {
        description: format!("External force against time of the model runs {}.", names.join("; ")),
        panels: runs.iter().enumerate().map(panel).collect::<Result<_, _>>()?,
        mark: model_mark(),
        ..Figure::default()
    })
}

/// What holds for all runs once, everything else with the run's name.
fn notes(runs: &[&Table]) -> Vec<String> {
    let mut notes: Vec<String> = Vec::new();
    for run in runs {
        for note in run.notes() {
            let common = runs.iter().all(|other| other.notes().contains(note));
            let note =
                if common { plain(note) } else { plain(&format!("{}: {note}", run.title())) };
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

fn force_axis() -> Axis {
    Axis::new("*F*", "N")
}

fn zero_line() -> Layer {
    let (direction, stroke) = (Direction::Horizontal, style::reference());
    Layer::Reference(Reference { direction, at: 0.0, label: None, stroke, name: None })
}

fn loop_panel(run: &Table, column: usize) -> Result<Panel, TableError> {
    let mut layers = vec![zero_line()];
    for part in acting(run, &parts(run))? {
        let x = words().positions(run.floats("theta_rad")?);
        layers.push(Layer::Line(line(run, &part, x)?));
    }
    let x = words().position_axis().linked("angle");
    let panel = Panel::new(Cell::at(0, column), x, force_axis().linked("forces"), layers);
    Ok(Panel { height_mm: Some(LOOP_MM), ..panel })
}

fn force_panel(run: &Table, column: usize) -> Result<Panel, TableError> {
    let mut layers = Vec::new();
    for part in acting(run, &[EXTERNAL, TISSUE])? {
        layers.push(Layer::Line(over_time(run, &part)?));
    }
    let panel =
        Panel::new(Cell::at(1, column), time_axis(""), force_axis().linked("force"), layers);
    Ok(Panel { height_mm: Some(TIME_MM), ..panel })
}

fn angle_panel(run: &Table, column: usize) -> Result<Panel, TableError> {
    let (x, y) = (gaps(run.floats("t_s")?), words().positions(run.floats("theta_rad")?));
    let line = Layer::Line(Line { x, y, ..Line::default() });
    let axis = words().position_axis().linked("angle in time");
    let panel = Panel::new(Cell::at(2, column), time_axis("*t*"), axis, vec![line]);
    Ok(Panel { height_mm: Some(TIME_MM), ..panel })
}

/// The parts of a run's force: the named ones, then each other one (friction and the scene's terms)
/// by the word in its column's name, in a colour of its own.
fn parts(run: &Table) -> Vec<Part<'_>> {
    let named = [EXTERNAL, TISSUE, BRAKE, MOTOR, STOP];
    let columns = run.fields().map(|field| field.name.as_ref());
    let others =
        columns.filter(|column| *column != TIP && named.iter().all(|part| part.0 != *column));
    let words = others
        .filter_map(|column| Some((column, column.strip_prefix("force_")?.strip_suffix("_n")?)));
    let pen = |i: usize| style::single(style::part_colour(i)).dashed(style::dash(i));
    let others = words.enumerate().map(|(i, (column, word))| (column, word, pen(i)));
    named.into_iter().chain(others).collect()
}

/// The parts that a run has and that ever act; the external force in any case.
fn acting<'a>(run: &Table, parts: &[Part<'a>]) -> Result<Vec<Part<'a>>, TableError> {
    let mut acting = Vec::new();
    for part in parts {
        if part.0 == EXTERNAL.0 || ever_acts(run, part.0)? {
            acting.push(*part);
        }
    }
    Ok(acting)
}

/// Whether a run has a force that is not 0 all the time.
fn ever_acts(run: &Table, column: &str) -> Result<bool, TableError> {
    if !run.fields().any(|field| field.name == column) {
        return Ok(false);
    }
    Ok(run.floats(column)?.into_iter().flatten().any(|force| force.abs() > 0.0))
}

fn over_time(run: &Table, part: &Part) -> Result<Line, TableError> {
    line(run, part, gaps(run.floats("t_s")?))
}

fn line(run: &Table, (column, name, stroke): &Part, x: Vec<f64>) -> Result<Line, TableError> {
    let y = gaps(run.floats(column)?);
    Ok(Line {
        x,
        y,
        stroke: *stroke,
        name: Some(plain(&name.replace('_', " "))),
        ..Line::default()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use zwidth_tables::Column;

    fn run(title: &str, finger: bool, note: &str) -> Table {
        let float = |name, values: [f64; 2]| Column::float(name, "", "", values.map(Some));
        let mut columns = vec![
            float("t_s", [0.0, 1.0]),
            float("theta_rad", [0.0, std::f64::consts::FRAC_PI_4]),
            float("force_ex_n", [1.0, 2.0]),
            float("force_brake_n", [-1.0, -2.0]),
            float("force_motor_n", [0.0, 0.0]),
        ];
        columns.extend(finger.then(|| float("force_tissue_n", [1.0, 1.5])));
        Table::new("trajectory", title, columns).unwrap().with_note(note).with_note("for all")
    }

    #[test]
    fn a_part_that_is_not_there_or_never_acts_is_not_drawn_and_every_run_is_marked() {
        let (with, without) = (run("with", true, "a"), run("without", false, "a"));
        let figure = simulation(&[&with, &without], &[]).unwrap();
        assert_eq!(
            figure.panels.iter().map(|panel| lines(panel).count()).collect::<Vec<_>>(),
            [3, 2, 1, 2, 1, 1]
        );
        for figure in
            [figure, simulation(&[&with], &[]).unwrap(), inputs(&[&with, &without]).unwrap()]
        {
            assert!(figure.mark.unwrap().starts_with("SIMULATION"));
        }
    }

    #[test]
    fn friction_stop_and_every_term_have_lines_named_by_their_columns() {
        let float = |name, values: [f64; 2]| Column::float(name, "", "", values.map(Some));
        let columns = vec![
            float("t_s", [0.0, 1.0]),
            float("theta_rad", [0.0, 1.0]),
            float("force_ex_n", [1.0, 2.0]),
            float("force_tip_n", [1.0, 2.0]),
            float("force_friction_n", [0.1, -0.2]),
            float("force_stop_n", [0.0, 0.5]),
            float("force_spring_bed_n", [0.3, 0.0]),
            float("force_gravity_n", [0.0, 0.0]),
        ];
        let figure =
            simulation(&[&Table::new("trajectory", "terms", columns).unwrap()], &[]).unwrap();
        let names = figure.panels[0].layers.iter().filter_map(|layer| match layer {
            Layer::Line(line) => line.name.clone(),
            _ => None,
        });
        assert_eq!(names.collect::<Vec<_>>(), ["external force", "stop", "friction", "spring bed"]);
    }

    #[test]
    fn figures_that_are_compared_have_the_same_axes() {
        let float = |name, values: [f64; 2]| Column::float(name, "", "", values.map(Some));
        let other = Table::new(
            "trajectory",
            "longer",
            vec![
                float("t_s", [0.0, 3.0]),
                float("theta_rad", [-1.0, 0.5]),
                float("force_ex_n", [0.0, 7.0]),
            ],
        )
        .unwrap();
        let one = run("one", true, "a");
        let ranges = |figure: Figure| -> Vec<[Range; 2]> {
            figure.panels.iter().map(|panel| [panel.x.range, panel.y.range]).collect()
        };
        let a = ranges(simulation(&[&one], &[&other]).unwrap());
        let b = ranges(simulation(&[&other], &[&one]).unwrap());
        assert_eq!(a, b);
        assert_eq!(a[1], [Range::Fixed(0.0, 3.0), Range::Holding(0.0, 7.0)]);
        assert_ne!(ranges(simulation(&[&one], &[]).unwrap()), a, "alone it fits its own data");
    }

    #[test]
    fn angles_stand_in_degrees() {
        let figure = simulation(&[&run("one", false, "a")], &[]).unwrap();
        let Layer::Line(line) = &figure.panels[2].layers[0] else { panic!("no line") };
        assert!((line.y[1] - 45.0).abs() < 1e-12);
    }

    #[test]
    fn a_note_that_holds_for_one_run_only_names_it() {
        let (a, b) = (run("A", true, "smooth"), run("B", true, "chattering"));
        assert_eq!(
            simulation(&[&a, &b], &[]).unwrap().footnotes,
            ["A: smooth", "for all", "B: chattering"]
        );
    }

    #[test]
    fn more_inputs_than_fit_in_a_row_go_on_in_the_next() {
        let one = run("one", false, "a");
        let figure = inputs(&[&one, &one, &one, &one]).unwrap();
        assert_eq!(figure.panels[3].cell, Cell::at(1, 0));
    }
}
