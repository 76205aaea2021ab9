//! A sweep: a thousand scenes of other parameters each. From its numbers on every scene is made anew, with all of its
//! matrices. The peer has the setting that is best for all of them, or that of the one scene.

use std::cell::RefCell;
use std::rc::Rc;

use zwidth_dynamics::{Grid, Trajectory};

use crate::dopri::{self, Aim};
use crate::ours;
use crate::scene::{Numbers, SWEPT, Samples, swept};
use crate::tune::{LARGEST_STEPS_S, Run, TOLERANCES, Tuned, error};

/// Largest error of θ over all samples of all scenes that the peer may have, rad.
const TARGET_RAD: f64 = 1e-6;
/// What marks the rows of the sweep among the targets.
const SWEEP: f64 = -TARGET_RAD;
/// Scenes at which a setting is tried before it is tried at all of them.
const FEW: usize = 20;
/// Scenes that are timed together: their shortest time is less often disturbed than that of all.
const PART: usize = 50;

/// The exact solver and the peer, each running the whole sweep; `one` is the peer's setting for the one scene.
pub(crate) fn peers<'a>(
    grid: &'a Grid,
    one: Option<Aim>,
    out: &mut Samples,
) -> Result<Vec<Tuned<'a>>, String> {
    let numbers: Vec<Numbers> = (0..SWEPT).map(swept).collect();
    let room = Rc::new(RefCell::new(ours::room(grid)?));
    let mut references = Vec::new();
    let mut evaluations = 0;
    for numbers in &numbers {
        evaluations += exact(numbers, grid, &mut room.borrow_mut())?;
        references.push(room.borrow().theta_rad().collect::<Vec<f64>>());
    }
    let parts = numbers.chunks(PART).map(|part| {
        let (part, room) = (part.to_vec(), Rc::clone(&room));
        Box::new(move |_: &mut Samples| {
            let mut room = room.borrow_mut();
            part.iter().try_fold(0, |sum, numbers| Ok(sum + exact(numbers, grid, &mut room)?))
        }) as Run<'a>
    });
    let ours = Tuned {
        name: "zwidth exact",
        method: "new parameters",
        target_rad: SWEEP,
        aim: None,
        error_rad: 0.0,
        evaluations: evaluations / u64::from(SWEPT),
        scenes: SWEPT,
        parts: parts.collect(),
    };
    let best = best(&numbers, &references, out);
    let settings = [("DP5(4), best for all", best), ("DP5(4), as for the one scene", one)];
    let peers = settings.into_iter().filter_map(|(method, aim)| {
        let aim = aim?;
        let (evaluations, error_rad) = by_hand(&numbers, &references, aim, f64::INFINITY, out);
        let parts = numbers.chunks(PART).map(|part| {
            let part = part.to_vec();
            Box::new(move |out: &mut Samples| {
                Ok(part.iter().map(|numbers| dopri::run(numbers, aim, out)).sum())
            }) as Run<'a>
        });
        Some(Tuned {
            name: "hand-coded Rust",
            method,
            target_rad: SWEEP,
            aim: Some(aim),
            error_rad,
            evaluations: evaluations / u64::from(SWEPT),
            scenes: SWEPT,
            parts: parts.collect(),
        })
    });
    let peers: Vec<_> = peers.collect();
    Ok(std::iter::once(ours).chain(peers).collect())
}

/// One scene from its numbers to its samples.
fn exact(numbers: &Numbers, grid: &Grid, out: &mut Trajectory) -> Result<u64, String> {
    let system = ours::system(numbers)?;
    ours::exact(ours::prepare(&system)?.as_mut(), grid, out)
}

/// Evaluations of the peer over some scenes, and its largest error; it ends after the first that is above `most_rad`.
fn by_hand(
    numbers: &[Numbers],
    references: &[Vec<f64>],
    aim: Aim,
    most_rad: f64,
    out: &mut Samples,
) -> (u64, f64) {
    let mut evaluations = 0;
    let mut largest: f64 = 0.0;
    for (numbers, reference) in numbers.iter().zip(references) {
        evaluations += dopri::run(numbers, aim, out);
        largest = largest.max(error(out, reference));
        if largest > most_rad {
            break;
        }
    }
    (evaluations, largest)
}

/// Of all settings with the sine in the state whose largest error stays below the target the one with fewest
/// evaluations.
fn best(numbers: &[Numbers], references: &[Vec<f64>], out: &mut Samples) -> Option<Aim> {
    let settings = TOLERANCES.iter().flat_map(|&tolerance| {
        LARGEST_STEPS_S.map(|largest_step_s| Aim { tolerance, largest_step_s, sine_joins: true })
    });
    let reached = settings.filter_map(|aim| {
        let (_, few) = by_hand(&numbers[..FEW], references, aim, TARGET_RAD, out);
        if few > TARGET_RAD {
            return None;
        }
        let (evaluations, error_rad) = by_hand(numbers, references, aim, TARGET_RAD, out);
        (error_rad <= TARGET_RAD).then_some((evaluations, aim))
    });
    reached.min_by_key(|(evaluations, _)| *evaluations).map(|(_, aim)| aim)
}
