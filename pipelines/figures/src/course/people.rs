//! The user's force against position over participants: each participant's mean loop is thin, the
//! mean over them thick.

use crate::course::data::{AT_THE_ANGLE, mean_loop_of};
use crate::course::panels::{axis, on_axis, recorded_word, wall_line};
use crate::words::{Words, mark, plain};
use crate::{About, FigureKind};
use zwidth_draw::style::{self, Stroke};
use zwidth_draw::{Cell, Direction, Figure, Layer, Line, Panel};
use zwidth_results::ParticipantsLoopPoint;
use zwidth_store::Signal;
use zwidth_study::{Environment, Source};
use zwidth_tables::{Table, TableError};

/// The figure [`mean_loops`].
pub const MEAN_LOOPS: FigureKind =
    FigureKind::new("mean_loops", "force against position, mean over participants", "trial");

/// Height of a panel, mm.
const PANEL_MM: f64 = 62.0;
/// Above so many curves of participants the mean would not be seen.
const MOST_THIN: usize = 60;

/// Whether each session's own loop is drawn beside the mean, if a condition has this many: with
/// more sessions the loops need not be read.
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
    /// The mean of every session; none where [`draws_each`] says that they are not drawn.
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
    let modes: Vec<&ModeOfPeople> = environments.iter().flat_map(|people| &people.modes).collect();
    let mut has_force = false;
    for mode in &modes {
        has_force |= mean_loop_of(mode.mean, Signal::ForceEx)?.is_some();
    }
    let load = if has_force { Signal::ForceEx } else { Signal::TorqueEx };
    let load_word = recorded_word(words, load);
    let sessions: usize = modes.iter().map(|mode| mode.sessions.len()).max().unwrap_or(0);
    let mut panels = Vec::new();
    for (place, people) in environments.iter().enumerate() {
        let wall = wall_line(people.environment, words, Direction::Vertical);
        let mut thin = Vec::from_iter(wall);
        let mut thick = Vec::new();
        for mode in &people.modes {
            let colour = style::mode_colour(mode.index);
            let each = mode.sessions.iter().filter(|_| draws_each(sessions));
            for session in each {
                thin.extend(curve(words, session, load, style::faint(colour))?.map(Layer::Line));
            }
            let pen = style::mean(colour).dashed(style::dash(mode.index));
            let name = about.modes.get(mode.index).map(|own| named(&own.label, mode.mean));
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
        panels.push(panel.titled(plain(&people.environment.label)).tall(PANEL_MM));
    }
    let each = "; thin: the mean of one person's repeats in one session, as far as they go";
    let note = format!(
        "Thick: mean {load_word} over people, {AT_THE_ANGLE}{}.",
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

/// `Hybrid (12 people, 24 sessions)`: not everybody may have come equally often.
fn named(label: &str, mean: &Table) -> String {
    // Where nobody has a loop there is no point to say of how many it is.
    let points: Vec<ParticipantsLoopPoint> = mean.to_rows().unwrap_or_default();
    plain(&match points.first().map(|point| (point.n, point.sessions)) {
        Some((n, sessions)) if sessions == n => format!("{label} ({n} people)"),
        Some((n, sessions)) => format!("{label} ({n} people, {sessions} sessions)"),
        None => label.to_owned(),
    })
}

/// The load at each position.
fn curve(
    words: Words,
    table: &Table,
    load: Signal,
    stroke: Stroke,
) -> Result<Option<Line>, TableError> {
    let Some([theta, y]) = mean_loop_of(table, load)? else { return Ok(None) };
    Ok(Some(Line { x: on_axis(words, Signal::Theta, &theta), y, stroke, ..Line::default() }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use zwidth_tables::Column;

    /// A loop there and back that is held at its turn, of two people in three sessions.
    fn average(scale: f64, signal: &str) -> Table {
        let float = |name: String, values: [f64; 4]| {
            let column = Column::float("", "1", "", values.map(Some));
            Column { field: zwidth_tables::Field { name: name.into(), ..column.field }, ..column }
        };
        let name = format!("{signal}_mean_{}", if signal == "force_ex" { "n" } else { "nm" });
        let columns = vec![
            Column::text("branch", "", ["in", "in", "held", "out"].map(Some)),
            float("theta_rad".to_owned(), [0.0, 0.5, 0.5, 0.4]),
            Column::integer("n", "1", "", [Some(2); 4]),
            Column::integer("sessions", "1", "", [Some(3); 4]),
            float(name, [0.0, 2.0 * scale, scale, 0.5 * scale]),
        ];
        Table::new("loop", "", columns).unwrap()
    }

    fn drawn(mean: &Table, sessions: &[Table]) -> Figure {
        let study = zwidth_testing::study();
        let modes = vec![ModeOfPeople { index: 0, mean, sessions }];
        let environments = [EnvironmentOfPeople { environment: &study.environments[0], modes }];
        mean_loops(&About::of(&study), &environments, &[Source::Twin]).unwrap()
    }

    fn lines(figure: &Figure) -> Vec<&Line> {
        figure.panels.iter().flat_map(Panel::lines).collect()
    }

    #[test]
    fn everybodys_loop_is_thin_and_the_mean_says_of_whom_it_is() {
        let [mean, one, other] = [1.0, 0.9, 1.1].map(|scale| average(scale, "force_ex"));
        let sessions = [one, other];
        let figure = drawn(&mean, &sessions);
        let lines = lines(&figure);
        assert_eq!(lines.len(), 3);
        // Nothing connects the turn with a way back that begins elsewhere.
        assert_eq!(lines[2].y[..3], [0.0, 2.0, 1.0]);
        assert!(lines[2].y[3].is_nan() && (lines[2].y[4] - 0.5).abs() < 1e-12);
        assert!((lines[2].x[1] - 0.5_f64.to_degrees()).abs() < 1e-12);
        let name = lines[2].name.as_deref().unwrap();
        assert!(name.ends_with("(2 people, 3 sessions)"), "{name}");
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
