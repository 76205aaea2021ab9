//! The solvers by their names in tables and on the command line.

use crate::SimulateError;
use zwidth_dynamics::{NAMED_SOLVERS, Solver};

/// Every solver by name.
pub const SOLVERS: [&str; NAMED_SOLVERS.len()] = {
    // A `while`, since neither `for` nor `map` can run in a constant.
    let mut names = [""; NAMED_SOLVERS.len()];
    let mut i = 0;
    while i < names.len() {
        names[i] = NAMED_SOLVERS[i].name;
        i += 1;
    }
    names
};

/// The solver that is used unless another is requested.
pub const DEFAULT_SOLVER: &str = SOLVERS[0];

/// Relative error per step at which the adaptive solvers aim unless another is requested; far below
/// what a figure shows.
pub const DEFAULT_TOLERANCE: f64 = 1e-9;

/// The solver of that name. `tolerance` (relative, per step) matters to the adaptive ones; the
/// exact one accounts for the energy too.
///
/// # Errors
/// A name that is not one of [`SOLVERS`].
pub fn solver(name: &str, tolerance: f64) -> Result<Box<dyn Solver>, SimulateError> {
    let named = NAMED_SOLVERS.into_iter().find(|solver| solver.name == name);
    let named = named.ok_or_else(|| SimulateError::NoSolver { name: name.to_owned() })?;
    Ok((named.make)(tolerance))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_unknown_name_is_told_with_those_there_are() {
        let error = solver("rk5", DEFAULT_TOLERANCE).err().unwrap().to_string();
        assert!(
            error.contains("'rk5'") && SOLVERS.iter().all(|name| error.contains(name)),
            "{error}"
        );
    }
}
