//! The solvers by the names they go by in tables and on the command line.

use crate::SimulateError;
use zwidth_dynamics::{
    DormandPrince, Exact, MoreauJean, Rk4, Solver, Switching, SymplecticEuler, Tolerances, TrBdf2,
};

/// Every solver by name: the exact one, the two adaptive ones, then those of a fixed step.
pub const SOLVERS: [&str; 7] = [
    "exact",
    "dormand_prince",
    "tr_bdf2",
    "moreau_jean",
    "symplectic_euler",
    "rk4_per_stage",
    "rk4_per_step",
];

/// The solver that is used unless another is asked for.
pub const DEFAULT_SOLVER: &str = SOLVERS[0];

/// Relative error a step that the adaptive solvers aim for unless another is asked for; far below
/// what a figure shows.
pub const DEFAULT_TOLERANCE: f64 = 1e-9;

/// The solver of that name. `tolerance` (relative, a step) matters to the adaptive ones; the exact
/// one accounts for the energy too.
///
/// # Errors
/// A name that is not one of [`SOLVERS`].
pub fn solver(name: &str, tolerance: f64) -> Result<Box<dyn Solver>, SimulateError> {
    let tolerances = Tolerances::of(tolerance);
    Ok(match name {
        "exact" => Box::new(Exact { energy: true, ..Exact::default() }),
        "dormand_prince" => Box::new(DormandPrince { tolerances }),
        "tr_bdf2" => Box::new(TrBdf2 { tolerances }),
        "moreau_jean" => Box::new(MoreauJean::default()),
        "symplectic_euler" => Box::new(SymplecticEuler),
        "rk4_per_stage" => Box::new(Rk4 { switching: Switching::PerStage }),
        "rk4_per_step" => Box::new(Rk4 { switching: Switching::PerStep }),
        _ => return Err(SimulateError::NoSolver { name: name.to_owned() }),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_solver_is_found_by_its_own_name() {
        for name in SOLVERS {
            assert_eq!(solver(name, DEFAULT_TOLERANCE).unwrap().name(), name);
        }
    }

    #[test]
    fn an_unknown_name_is_told_with_those_there_are() {
        let error = solver("rk5", DEFAULT_TOLERANCE).err().unwrap().to_string();
        assert!(
            error.contains("'rk5'") && SOLVERS.iter().all(|name| error.contains(name)),
            "{error}"
        );
    }
}
