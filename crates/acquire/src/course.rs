//! The progress of a session: how much of each condition is done, and how long the rest will take.

use crate::flow::{Flow, Place};
use crate::view::{Cell, Course};
use zwidth_study::{Kind, ModeId, Study};

/// The conditions of a session, in the study's order, and which of them each place of its order
/// has: that stays as it is while trials are done, and takes long to find for a long session.
pub(crate) struct Conditions {
    cells: Vec<Cell>,
    /// The cell of each place; none where a place is not counted.
    cell_of_place: Vec<Option<usize>>,
}

impl Conditions {
    /// Modes are those of the places, or none where they are hidden.
    pub(crate) fn new(flow: &Flow, modes: Option<&[ModeId]>, study: &Study) -> Self {
        let mut each: Vec<Option<Cell>> = Vec::new();
        for (i, Place { trial, .. }) in flow.places().iter().enumerate() {
            let label = study.environment(&trial.environment).map(|e| e.label.clone());
            let mode = modes.and_then(|modes| study.mode(modes.get(i)?));
            each.push((trial.kind == Kind::Trial).then(|| Cell {
                environment: label.unwrap_or_else(|| trial.environment.to_string()),
                mode: mode.map(|m| m.label.clone()),
                done: 0,
                of: 0,
            }));
        }
        let mut cells: Vec<Cell> = Vec::new();
        for cell in each.iter().flatten() {
            if !cells.contains(cell) {
                cells.push(cell.clone());
            }
        }
        // By the study's order, not by the one drawn.
        cells.sort_by_key(|cell| {
            let environment = study.environments.iter().position(|e| e.label == cell.environment);
            (environment, study.modes.iter().position(|m| Some(&m.label) == cell.mode.as_ref()))
        });
        // They are compared whole, before any is counted: a count makes them differ.
        let cell_of_place: Vec<Option<usize>> = each
            .iter()
            .map(|wanted| cells.iter().position(|cell| Some(cell) == wanted.as_ref()))
            .collect();
        Self { cells, cell_of_place }
    }

    /// What is done of each condition now.
    pub(crate) fn counted(&self, flow: &Flow) -> Vec<Cell> {
        let mut cells = self.cells.clone();
        for (i, (place, cell)) in flow.places().iter().zip(&self.cell_of_place).enumerate() {
            if let Some(cell) = cell {
                cells[*cell].done += usize::from(place.is_settled());
                cells[*cell].of += usize::from(flow.is_needed(i));
            }
        }
        cells
    }
}

/// How long the rest will take: each trial as long as those since the first one took, pauses and
/// questions with them, by the time when the last of them was done (`lasted_s`), so that a trial
/// that runs makes the rest no longer; before any of them is done, as long as is planned.
pub(crate) fn course(
    elapsed_s: f64,
    lasted_s: f64,
    done: usize,
    left: usize,
    planned_s: f64,
) -> Course {
    let each_s = if done > 0 { lasted_s / done as f64 } else { planned_s };
    let since_s = (elapsed_s - lasted_s).clamp(0.0, each_s);
    Course { elapsed_s, left_s: (left > 0).then_some(each_s * left as f64 - since_s) }
}

/// A time in words, no finer than a person would say it.
pub(crate) fn in_words(s: f64) -> String {
    const MINUTE_S: f64 = 60.0;
    // Past the highest number of minutes nobody reads them.
    let minutes = (s / MINUTE_S).round() as u64;
    match minutes {
        _ if s < 1.5 * MINUTE_S => format!("{s:.0} s"),
        0..60 => format!("{minutes} min"),
        _ => format!("{} h {:02} min", minutes / 60, minutes % 60),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flow::Recorded;
    use zwidth_study::{Event, PlannedTrial, template};

    #[test]
    fn a_condition_is_counted_by_what_is_done_and_not_excluded() {
        let study = Study::from_toml(&template(&"demo".parse().unwrap())).unwrap();
        let trial = |trial: u32| PlannedTrial {
            trial,
            repeat: 1,
            kind: if trial == 1 { Kind::Familiarisation } else { Kind::Trial },
            environment: study.environments[usize::from(trial > 4)].id.clone(),
            mode: study.modes[trial as usize % 2].id.clone(),
            samples: true,
            task: None,
        };
        let order: Vec<_> = (1..=6).map(|n| (trial(n), Vec::new())).collect();
        let modes: Vec<ModeId> = order.iter().map(|(t, _)| t.mode.clone()).collect();
        let files: Vec<Recorded> =
            (1..=4).map(|trial| Recorded { trial, complete: true, settled: true }).collect();
        let excluded = Event::Excluded { trial: 3, reason: "x".into() };
        let (flow, _) =
            Flow::begin(order, crate::tasks::Tasks::default(), 5.0, &files, &[excluded]);
        let counts = |modes| -> Vec<(usize, usize)> {
            Conditions::new(&flow, modes, &study)
                .counted(&flow)
                .iter()
                .map(|c| (c.done, c.of))
                .collect()
        };
        assert_eq!(counts(Some(&modes)), [(2, 2), (0, 1), (0, 1), (0, 1)]);
        assert_eq!(counts(None), [(2, 3), (0, 2)]);
        let hidden = Conditions::new(&flow, None, &study).counted(&flow);
        assert!(hidden.iter().all(|c| c.mode.is_none()));
    }

    #[test]
    fn the_rest_takes_as_long_as_the_trials_before_and_what_is_planned_before_the_first() {
        assert_eq!(course(0.0, 0.0, 0, 10, 9.0).left_s, Some(90.0));
        assert_eq!(course(100.0, 100.0, 4, 10, 9.0).left_s, Some(250.0));
        assert_eq!(course(100.0, 100.0, 4, 0, 9.0).left_s, None);
    }

    #[test]
    fn a_trial_that_runs_shortens_the_rest_by_no_more_than_itself() {
        assert_eq!(course(4.0, 0.0, 0, 10, 9.0).left_s, Some(86.0));
        assert_eq!(course(110.0, 100.0, 4, 10, 9.0).left_s, Some(240.0));
        assert_eq!(course(400.0, 100.0, 4, 10, 9.0).left_s, Some(225.0));
    }

    #[test]
    fn a_time_is_told_no_finer_than_a_person_would() {
        for (s, words) in [
            (0.0, "0 s"),
            (42.4, "42 s"),
            (89.0, "89 s"),
            (90.0, "2 min"),
            (3599.0, "1 h 00 min"),
            (7500.0, "2 h 05 min"),
        ] {
            assert_eq!(in_words(s), words, "{s}");
        }
    }
}
