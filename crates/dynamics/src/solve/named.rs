//! The solvers by their names in tables and on the command line: the one list.

use super::adaptive::Tolerances;
use super::dormand_prince::DormandPrince;
use super::exact::Exact;
use super::moreau_jean::MoreauJean;
use super::rk4::Rk4;
use super::symplectic_euler::SymplecticEuler;
use super::tr_bdf2::TrBdf2;
use super::{Solver, Switching};

/// A solver, ready to be chosen by name.
pub struct NamedSolver {
    /// Its name in tables and on the command line, which is [`Solver::name`].
    pub name: &'static str,
    /// Its name in figures.
    pub label: &'static str,
    /// Where it comes from.
    pub citation: &'static str,
    /// Makes it. The relative error per step matters to the adaptive ones alone; the exact one
    /// accounts for the energy too.
    pub make: fn(f64) -> Box<dyn Solver>,
}

/// Of both Runge–Kutta methods.
const KUTTA: &str = "W. Kutta, Z. Math. Phys. 46 (1901) 435-453";

/// Every solver: the exact one, the two adaptive ones, then those of a fixed step.
pub const NAMED_SOLVERS: [NamedSolver; 7] = [
    NamedSolver {
        name: "exact",
        label: "exact",
        citation: "E. Sontag, IEEE Trans. Autom. Control 26 (1981) 346-358; A. F. Filippov (1988); N. Higham, SIAM J. \
                   Matrix Anal. Appl. 26 (2005) 1179-1193",
        make: |_| Box::new(Exact { energy: true, ..Exact::default() }),
    },
    NamedSolver {
        name: "dormand_prince",
        label: "Dormand–Prince",
        citation: "J. R. Dormand & P. J. Prince, J. Comput. Appl. Math. 6 (1980) 19-26; L. F. Shampine, Math. Comp. 46 \
                   (1986) 135-150",
        make: |tolerance| Box::new(DormandPrince { tolerances: Tolerances::of(tolerance) }),
    },
    NamedSolver {
        name: "tr_bdf2",
        label: "TR-BDF2",
        citation: "R. E. Bank et al., IEEE Trans. Electron Devices 32 (1985) 1992-2007; M. E. Hosea & L. F. Shampine, \
                   Appl. Numer. Math. 20 (1996) 21-37",
        make: |tolerance| Box::new(TrBdf2 { tolerances: Tolerances::of(tolerance) }),
    },
    NamedSolver {
        name: "moreau_jean",
        label: "Moreau–Jean",
        citation: "M. Jean, Comput. Methods Appl. Mech. Eng. 177 (1999) 235-257; V. Acary & B. Brogliato, Numerical \
                   Methods for Nonsmooth Dynamical Systems (2008), 10.1",
        make: |_| Box::new(MoreauJean::default()),
    },
    NamedSolver {
        name: "symplectic_euler",
        label: "symplectic Euler",
        citation: "Hairer, Lubich & Wanner, Geometric Numerical Integration, 2nd ed. (2006), I.1.2",
        make: |_| Box::new(SymplecticEuler),
    },
    NamedSolver {
        name: "rk4_per_stage",
        label: "RK4, switched per stage",
        citation: KUTTA,
        make: |_| Box::new(Rk4 { switching: Switching::PerStage }),
    },
    NamedSolver {
        name: "rk4_per_step",
        label: "RK4, switched per step",
        citation: KUTTA,
        make: |_| Box::new(Rk4 { switching: Switching::PerStep }),
    },
];

/// The readable name of the solver with that name; the name itself if there is no such solver.
pub fn solver_label(name: &str) -> &str {
    NAMED_SOLVERS.iter().find(|named| named.name == name).map_or(name, |named| named.label)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_solver_has_words_and_a_name_that_none_has_stays_itself() {
        assert_eq!(solver_label("rk4_per_step"), "RK4, switched per step");
        assert_eq!(solver_label("other"), "other");
    }

    #[test]
    fn every_solver_goes_by_the_name_that_it_gives_itself_and_names_its_source() {
        for solver in NAMED_SOLVERS {
            assert!(!solver.name.is_empty() && !solver.citation.is_empty());
            assert_eq!((solver.make)(1e-9).name(), solver.name);
        }
    }
}
