//! The user's force against position over participants: each one's mean loop thin, the mean over
//! them thick.

use crate::data::mean_curve;
use crate::panels::{axis, on_axis};
use crate::words::{Words, mark, plain};
use crate::{About, FigureKind};
use zwidth_draw::style::{self, Stroke};
use zwidth_draw::{Cell, Direction, Figure, Layer, Line, Panel, Reference};
use zwidth_store::Signal;
use zwidth_study::{Environment, Source};
use zwidth_tables::{Table, TableError};

/// The figure [`mean_loops`].
pub const MEAN_LOOPS: FigureKind = FigureKind {
    stem: "mean_loops",
    shows: "force against position, mean over participants",
    drawn_from: "trial",
};

/// Height of a panel, mm.
const PANEL_MM: f64 = 62.0;
/// Above so many curves of participants the mean would not be seen.
const MOST_THIN: usize = 60;

/// Whether each session's own loop is drawn beside the mean, where a condition has so many: those of
/// more need not be read.
pub fn draws_each(sessions: usize) -> bool {
    sessions <= MOST_THIN
}

/// One mode in one environment.
#[derive(Debug, Clone)]
pub struct ModeOfPeople<'a> {
    /// Index among the study's modes: gives the colour.
    pub index: usize,
    /// The mean over participants, as the stage `average` made it.
    pub mean: &'a Table,
    /// The mean of every session, aligned by landmarks; none where [`draws_each`] says that they are
    /// not drawn.
    pub sessions: &'a [Table],
}

/// One environment in which several participants have means.
#[derive(Debug, Clone)]
pub struct EnvironmentOfPeople<'a> {
    /// The environment.
    pub environment: &'a Environment,
    /// Its modes, in the study's order.
    pub modes: Vec<ModeOfPeople<'a>>,
}

/// One panel per environment, one loop per mode.
///
/// # Errors
/// Tables that are not of the stage `average`.
pub fn mean_loops(
    about: &About,
    environments: &[EnvironmentOfPeople],
    sources: &[Source],
) -> Result<Figure, TableError> {
    let words = Words::new(about.coordinate);
    let has_force =
        |of: &ModeOfPeople| Ok::<_, TableError>(mean_curve(of.mean, Signal::ForceEx)?.is_some());
    let modes = || environments.iter().flat_map(|of| &of.modes);
    let forces = modes().map(has_force).collect::<Result<Vec<bool>, _>>()?;
    let load = if forces.contains(&true) { Signal::ForceEx } else { Signal::TorqueEx };
    let load_word = if load == Signal::TorqueEx { "torque" } else { "force" };
    let sessions: usize = modes().map(|mode| mode.sessions.len()).max().unwrap_or(0);
    let mut panels = Vec::new();
    for (place, of) in environments.iter().enumerate() {
        let (mut thin, mut thick) = (wall(words, of.environment), Vec::new());
        for mode in &of.modes {
            let colour = style::mode_colour(mode.index);
            let each = mode.sessions.iter().filter(|_| draws_each(sessions));
            for session in each {
                thin.extend(curve(words, session, load, style::faint(colour))?.map(Layer::Line));
            }
            let pen = style::mean(colour).dashed(style::dash(mode.index));
            let name = about.modes.get(mode.index).map(|known| named(&known.label, mode.mean));
            let line = curve(words, mode.mean, load, pen)?;
            thick.extend(line.map(|line| Layer::Line(Line { name, ..line })));
        }
        let x = words.position_axis().linked("position");
        let y = axis(words, load).linked("load");
        let cell = Cell::at(place / 2, place % 2);
        let panel = match thick.is_empty() {
            true => Panel::with_note(cell, x, y, "nobody's repeats have a mean"),
            false => Panel::new(cell, x, y, thin.into_iter().chain(thick).collect()),
        };
        let panel = panel.titled(plain(&of.environment.label));
        panels.push(Panel { height_mm: Some(PANEL_MM), ..panel });
    }
    let each = "thin: the mean of each participant's repeats in one session; ";
    let note = format!(
        "Thick: mean over participants of {} and {load_word} at the same phase of the movement; {}n counts \
         participants. What they do at different phases is smoothed in the mean.",
        words.position_word(),
        if sessions > 0 && draws_each(sessions) { each } else { "" }
    );
    Ok(Figure {
        title: Some(plain(&format!(
            "{}: {load_word} against {}, mean over participants",
            about.title,
            words.position_word()
        ))),
        description: format!(
            "Mean {load_word} against mean {} over participants, there and back, one panel per environment, one loop per mode.",
            words.position_word()
        ),
        width_mm: if panels.len() == 1 { 120.0 } else { zwidth_draw::TWO_COLUMNS_MM },
        panels,
        footnotes: vec![plain(&note)],
        mark: mark(sources.iter().copied()),
        ..Figure::default()
    })
}

/// `Hybrid (n = 12)`.
fn named(label: &str, mean: &Table) -> String {
    let n = mean.integers("n").ok().and_then(|n| n.into_iter().flatten().max());
    plain(&n.map_or_else(|| label.to_owned(), |n| format!("{label} (n = {n})")))
}

/// The load against the position, as far as the movement goes.
fn curve(
    words: Words,
    table: &Table,
    load: Signal,
    stroke: Stroke,
) -> Result<Option<Line>, TableError> {
    let (Some(theta), Some(load)) = (mean_curve(table, Signal::Theta)?, mean_curve(table, load)?)
    else {
        return Ok(None);
    };
    let phase = table.floats("phase")?;
    let moving = |values: &[f64]| -> Vec<f64> {
        values.iter().zip(&phase).filter(|(_, phase)| phase.is_some()).map(|(v, _)| *v).collect()
    };
    let x = on_axis(words, Signal::Theta, &moving(&theta.mean));
    Ok(Some(Line { x, y: moving(&load.mean), stroke, ..Line::default() }))
}

/// The line where the wall begins.
fn wall(words: Words, environment: &Environment) -> Vec<Layer> {
    let at = environment.scene.wall_rad();
    let line = at.map(|wall| {
        Layer::Reference(Reference {
            direction: Direction::Vertical,
            at: words.position(wall),
            label: Some(format!("wall {}", words.place(wall))),
            stroke: style::reference(),
            name: None,
        })
    });
    line.into_iter().collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use zwidth_tables::Column;

    /// A loop there and back, and a rest after it that is no movement.
    fn average(scale: f64, signal: &str) -> Table {
        let float = |name: String, values: [Option<f64>; 4]| {
            let column = Column::float("", "1", "", values);
            Column { field: zwidth_tables::Field { name: name.into(), ..column.field }, ..column }
        };
        let course = |values: [f64; 4]| values.map(|v| Some(scale * v));
        let mut columns = vec![
            float("phase".to_owned(), [Some(0.0), Some(2.0), Some(3.0), None]),
            Column::integer("n", "1", "", [Some(3); 4]),
        ];
        for (stem, suffix, values) in [
            ("theta", "rad", [0.0, 0.5, 0.1, 9.0]),
            (signal, if signal == "force_ex" { "n" } else { "nm" }, [0.0, 2.0, 0.5, 9.0]),
        ] {
            for part in ["mean", "ci_low", "ci_high"] {
                columns.push(float(format!("{stem}_{part}_{suffix}"), course(values)));
            }
        }
        Table::new("average", "", columns).unwrap()
    }

    fn drawn(mean: &Table, sessions: &[Table]) -> Figure {
        let study = zwidth_testing::study();
        let modes = vec![ModeOfPeople { index: 0, mean, sessions }];
        let environments = [EnvironmentOfPeople { environment: &study.environments[0], modes }];
        mean_loops(&About::of(&study), &environments, &[Source::Twin]).unwrap()
    }

    fn lines(figure: &Figure) -> Vec<&Line> {
        let layers = figure.panels.iter().flat_map(|panel| &panel.layers);
        layers.filter_map(|l| if let Layer::Line(line) = l { Some(line) } else { None }).collect()
    }

    #[test]
    fn everybodys_loop_is_thin_the_mean_is_named_and_rest_is_not_drawn() {
        let (mean, sessions) =
            (average(1.0, "force_ex"), [average(0.9, "force_ex"), average(1.1, "force_ex")]);
        let figure = drawn(&mean, &sessions);
        let lines = lines(&figure);
        assert_eq!(lines.len(), 3);
        assert_eq!(lines[2].y, [0.0, 2.0, 0.5]);
        assert!((lines[2].x[1] - 0.5_f64.to_degrees()).abs() < 1e-12);
        assert!(lines[2].name.as_deref().is_some_and(|name| name.ends_with("(n = 3)")));
        assert!(lines[0].stroke.width_pt < lines[2].stroke.width_pt && lines[0].name.is_none());
        assert!(figure.mark.is_some());
    }

    #[test]
    fn many_participants_have_no_lines_of_their_own_and_a_torque_stands_for_a_force() {
        let sessions = vec![average(1.0, "torque_ex"); MOST_THIN + 1];
        let mean = average(1.0, "torque_ex");
        assert!(draws_each(MOST_THIN) && !draws_each(sessions.len()));
        let figure = drawn(&mean, &sessions);
        assert_eq!(lines(&figure).len(), 1);
        // As well without having read them.
        assert_eq!(format!("{figure:?}"), format!("{:?}", drawn(&mean, &[])));
        assert!(
            figure.description.starts_with("Mean torque") && !figure.footnotes[0].contains("thin:")
        );
    }
}
