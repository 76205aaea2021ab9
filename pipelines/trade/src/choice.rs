//! The cheapest setting whose error a person could not feel.

use crate::cells::{Cell, cell};
use crate::perturb::neighbour;
use crate::setting::Setting;
use rayon::prelude::*;
use zwidth_dynamics::{ModelScene, Reference};
use zwidth_judge::Yardstick;
use zwidth_results::{Gate, Proof, WhyNot};
use zwidth_study::Perception;

/// A setting that is recommended, and why.
#[derive(Debug, Clone, PartialEq)]
pub struct Choice {
    /// The setting.
    pub setting: Setting,
    /// Its work.
    pub evaluations: u64,
    /// On so many of so many neighbours of the scene it passes the gates too.
    pub confirmed: (usize, usize),
    /// The cheaper setting that costs most, and why it is not it.
    pub next_cheaper: Option<(Setting, WhyNot)>,
}

/// Chooses from the cells of each solver, finest first. Nothing is chosen where the right answer is
/// unproven, or no setting passes.
pub(crate) fn choose(
    scene: &ModelScene,
    proof: Proof,
    solvers: &[Vec<Cell>],
    perception: &Perception,
    neighbours: usize,
) -> Option<Choice> {
    if proof == Proof::Unproven {
        return None;
    }
    let mut accepted: Vec<usize> = solvers.iter().map(|cells| accepted(cells)).collect();
    let mut refuted: Vec<(Setting, usize)> = Vec::new();
    loop {
        let candidates =
            (0..solvers.len()).filter_map(|s| Some((s, &solvers[s][accepted[s].checked_sub(1)?])));
        let (s, cell) = candidates.min_by_key(|(_, cell)| cell.evaluations)?;
        let passed = passed_neighbours(scene, cell.setting, perception, neighbours);
        if passed == neighbours {
            return Some(Choice {
                setting: cell.setting,
                evaluations: cell.evaluations,
                confirmed: (passed, neighbours),
                next_cheaper: next_cheaper(solvers, cell, &refuted),
            });
        }
        // The solver's next finer setting takes part instead, which may now be dearer than
        // another's.
        refuted.push((cell.setting, passed));
        accepted[s] -= 1;
    }
}

/// How many settings pass, from the finest on without a gap.
fn accepted(cells: &[Cell]) -> usize {
    cells.iter().take_while(|cell| cell.gate == Gate::Passed).count()
}

/// On how many neighbours of a scene a setting passes the gates.
fn passed_neighbours(
    scene: &ModelScene,
    setting: Setting,
    perception: &Perception,
    neighbours: usize,
) -> usize {
    let passed = (0..neighbours as u64).into_par_iter().filter(|number| {
        let near = neighbour(scene, *number);
        let Ok(yardstick) = Yardstick::alone(&near, perception) else { return false };
        let reference = Reference::of(&yardstick.system);
        let cell = cell(&near, &yardstick, &reference, setting, None, &mut Vec::new());
        cell.is_ok_and(|cell| cell.gate == Gate::Passed)
    });
    passed.count()
}

/// Of all that cost less the one that costs most.
fn next_cheaper(
    solvers: &[Vec<Cell>],
    chosen: &Cell,
    refuted: &[(Setting, usize)],
) -> Option<(Setting, WhyNot)> {
    let cheaper = solvers.iter().flat_map(|cells| cells.iter().map(move |cell| (cells, cell)));
    let ran = cheaper.filter(|(_, cell)| cell.errors.is_some());
    let cheaper = ran.filter(|(_, cell)| cell.evaluations < chosen.evaluations);
    let (cells, cell) = cheaper.max_by_key(|(_, cell)| cell.evaluations)?;
    let refuted = refuted.iter().find(|(setting, _)| *setting == cell.setting);
    let finer = cells.iter().take_while(|c| c.setting != cell.setting);
    let why = match (cell.gate, refuted) {
        (Gate::Passed, Some((_, passed))) => WhyNot::Neighbours(*passed),
        (Gate::Passed, None) => {
            WhyNot::FinerBreaks(finer.map(|c| c.gate).find(|gate| *gate != Gate::Passed)?)
        }
        (gate, _) => WhyNot::Breaks(gate),
    };
    Some((cell.setting, why))
}
