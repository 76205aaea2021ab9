//! A run as rows: its samples with the forces by part, and its events.

use crate::Run;
use zwidth_dynamics::{Motion, RunVerdict};
use zwidth_results::{LeverMotion, ModelEvent, ModelRun, ModelSample, TermForce};

/// The samples of a run: time, state, forces by part, and how the lever moves.
pub fn model_run(run: &Run) -> ModelRun {
    let trajectory = &run.trajectory;
    let scene = run.system.scene();
    let has_finger = scene.finger.is_some();
    let has_stops = scene.plant.stops_rad.is_some();
    let finger_m: Vec<f64> = trajectory.finger_m().collect();
    let state = trajectory.theta_rad().zip(trajectory.theta_dot_rad_s()).enumerate();
    let samples = state.map(|(i, (theta_rad, theta_dot_rad_s))| {
        let forces = trajectory.forces(&run.system, i);
        ModelSample {
            t_s: trajectory.t_s[i],
            theta_rad,
            theta_dot_rad_s,
            finger_m: finger_m.get(i).copied().filter(|_| has_finger),
            force_ex_n: forces.external_n,
            force_tip_n: has_finger.then_some(forces.tip_n),
            force_tissue_n: has_finger.then_some(forces.tissue_n),
            force_motor_n: forces.motor_n,
            force_brake_n: forces.brake_n,
            force_friction_n: scene.friction.as_ref().map(|_| forces.friction_n),
            force_stop_n: has_stops.then_some(forces.stop_n),
            motion: lever_motion(trajectory.regions[usize::from(trajectory.region[i])].motion),
        }
    });
    // The force of each of the scene's terms: sample by sample, since a state gives the forces of
    // all terms at once; then a column per term.
    let rows: Vec<Vec<f64>> = (0..trajectory.len())
        .map(|i| run.system.term_forces_n(trajectory.state(i)).collect())
        .collect();
    let terms = scene.terms.iter().enumerate().map(|(k, term)| {
        TermForce::new(term.name(), term.about(), rows.iter().map(|row| row[k]).collect())
    });
    ModelRun {
        scene: scene.name.clone(),
        notes: notes(run).to_vec(),
        samples: samples.collect(),
        terms: terms.collect(),
    }
}

/// The notes that belong to a run's numbers.
fn notes(run: &Run) -> [String; 2] {
    let step_ms = run.system.scene().step_s * 1e3;
    let verdict = run.judgement.verdict;
    let meaning = match verdict {
        RunVerdict::Smooth | RunVerdict::Failed => "",
        RunVerdict::Forced => " (it repeats with the input)",
        RunVerdict::Transient => " (an oscillation of the model that dies out)",
        RunVerdict::Growing => " (an oscillation that grows in the model itself)",
        RunVerdict::FreeUndamped => " (nothing drives the oscillation and nothing damps it)",
        RunVerdict::NumericalChattering => {
            " (the swings are the method's: the model does not have them)"
        }
        RunVerdict::NumericalCreep => " (the method moves a lever that stands still in the model)",
        RunVerdict::LimitCycle => " (the model keeps the swings up by itself)",
        RunVerdict::UnstableStep => " (outside of the method's stability region)",
        RunVerdict::DependsOnRestRule => " (the model does not say what is commanded there)",
        RunVerdict::CannotTell => " (the model's motion is not known)",
    };
    [
        format!(
            "A model run, not a measurement: solver {}, a sample every {step_ms} ms, verdict {}{meaning}.",
            run.solver,
            verdict.as_str()
        ),
        "Forces on the lever's end; above 0 they push into the object (+θ).".to_owned(),
    ]
}

/// The events of a run, in order of time. None of solvers that do not look for events.
pub fn model_events(run: &Run) -> Vec<ModelEvent> {
    let has_finger = run.system.scene().finger.is_some();
    let events = run.trajectory.events.iter().map(|event| ModelEvent {
        t_s: event.t_s,
        event: event.kind.as_str().to_owned(),
        theta_rad: event.theta_rad,
        motion: lever_motion(event.region.motion),
        tissue: has_finger.then(|| event.region.contact.as_str().to_owned()),
    });
    events.collect()
}

fn lever_motion(motion: Motion) -> LeverMotion {
    match motion {
        Motion::Forward => LeverMotion::Forward,
        Motion::Backward => LeverMotion::Backward,
        Motion::Rest => LeverMotion::Rest,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenes::{run, sticking};
    use zwidth_dynamics::{Gravity, Input, ModelScene, Pull, table3};
    use zwidth_tables::Table;

    #[test]
    fn the_forces_by_part_balance_while_the_lever_rests() {
        let run = model_run(&run(sticking(), "exact"));
        let rests = run.samples.iter().filter(|sample| sample.motion == LeverMotion::Rest);
        assert!(rests.clone().count() > 20, "{}", rests.count());
        for sample in rests {
            let stop_n = sample.force_stop_n.unwrap_or_default();
            let acting_n = sample.force_motor_n + sample.force_brake_n + stop_n;
            assert!((sample.force_ex_n + acting_n).abs() < 1e-12, "{sample:?}");
        }
    }

    #[test]
    fn a_part_that_the_scene_lacks_has_no_column() {
        let names = |scene| {
            let table = Table::of_run(&model_run(&run(scene, "exact"))).unwrap();
            table.fields().map(|f| f.name.to_string()).collect::<Vec<_>>()
        };
        let bare = names(sticking());
        assert!(
            !bare.iter().any(|n| n.contains("tissue") || n == "finger_m" || n.contains("gravity"))
        );
        assert!(names(table3::with_finger(sticking())).contains(&"force_tissue_n".to_owned()));
    }

    #[test]
    fn each_term_has_a_column_of_its_own() {
        let mut scene = ModelScene { duration_s: 0.5, ..sticking() };
        scene.terms.set(Pull { stiffness_n_per_rad: 2.0, displacement: Input::constant(0.1) });
        scene.terms.set(Gravity { mass_kg: 0.02, radius_m: 0.04 });
        let run = model_run(&run(scene, "dormand_prince"));
        let term = |name: &str| run.terms.iter().find(|term| term.term() == name).unwrap();
        let (pull, gravity) = (term("pull"), term("gravity"));
        for (i, ModelSample { theta_rad, .. }) in run.samples.iter().enumerate() {
            assert!((pull.force_n[i] - 2.0 * (0.1 - theta_rad)).abs() < 1e-12);
            assert!((gravity.force_n[i] - 0.02 * 9.80665 * 0.04 * theta_rad.sin()).abs() < 1e-12);
        }
    }

    #[test]
    fn the_events_tell_the_story_of_the_sticking_lever() {
        let events = model_events(&run(sticking(), "exact"));
        let mut motions: Vec<&str> = events.iter().map(|event| event.motion.as_str()).collect();
        motions.dedup();
        assert_eq!(motions, ["forward", "rest", "backward", "forward"]);
    }
}
