//! The scene's terms in the equations: one row each for the affine part, and one curved force for
//! all of them.

use super::row::{Functional, Row};
use super::{OMEGA, System, THETA};
use crate::scene::terms::{Curve, Term};

impl System {
    /// The force of each of the scene's terms at a state, N, in the order of
    /// [`crate::Terms::iter`].
    pub fn term_forces_n(&self, z: &[f64]) -> impl Iterator<Item = f64> {
        self.terms.iter().zip(self.scene.terms.iter()).map(|(row, term)| {
            let curve = term.curve(&self.scene.plant, z[THETA], z[OMEGA]);
            row.dot(z) + curve.map_or(0.0, |curve| curve.force_n)
        })
    }

    /// The forces of all terms together, N.
    #[inline]
    pub(crate) fn terms_n(&self, z: &[f64]) -> f64 {
        if self.terms.is_empty() { 0.0 } else { self.term_forces_n(z).sum() }
    }

    /// The affine parts of all terms together.
    pub(crate) fn affine_terms(&self) -> Row {
        self.terms.iter().fold(Row::ZERO, |sum, row| sum.plus(*row))
    }

    /// The term that keeps the system from being piecewise affine, if there is one.
    pub(crate) fn nonlinear_term(&self) -> Option<&'static str> {
        if !self.chords.is_empty() {
            return None;
        }
        // A term has a curved part at every state or at none, so the start stands for all.
        let start = &self.scene.start;
        let mut terms = self.scene.terms.iter();
        let nonlinear = terms.find(|term| {
            term.curve(&self.scene.plant, start.theta_rad, start.theta_dot_rad_s).is_some()
        });
        nonlinear.map(Term::name)
    }

    /// The terms' curved force with its derivatives; `None` if no term has one.
    #[inline]
    pub(crate) fn curve(&self, z: &[f64]) -> Option<Curve> {
        if self.curved { self.curves(z) } else { None }
    }

    fn curves(&self, z: &[f64]) -> Option<Curve> {
        let curves =
            self.scene.terms.iter().filter_map(|t| t.curve(&self.scene.plant, z[THETA], z[OMEGA]));
        curves.reduce(|a, b| Curve {
            force_n: a.force_n + b.force_n,
            per_rad_n: a.per_rad_n + b.per_rad_n,
            per_rad_s_n: a.per_rad_s_n + b.per_rad_s_n,
        })
    }

    /// The value of a functional at a state.
    #[inline]
    pub(crate) fn value(&self, functional: &Functional, z: &[f64]) -> f64 {
        let curved = self.curve(z).map_or(0.0, |curve| functional.curved * curve.force_n);
        functional.row.dot(z) + curved
    }
}
