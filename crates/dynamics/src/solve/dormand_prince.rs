//! Dormand–Prince 5(4) with dense output and events.

use zwidth_numerics::tableau::{DORMAND_PRINCE as METHOD, DORMAND_PRINCE_DENSE as DENSE};

use super::adaptive::{self, Tolerances};
use super::embedded::{Attempt, Embedded, Field};
use super::{Grid, Solver, with_length};
use crate::error::Result;
use crate::system::System;
use crate::trajectory::Trajectory;

/// The embedded pair of order 5(4), on the same regions and events as the exact solver.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DormandPrince {
    /// What it aims for.
    pub tolerances: Tolerances,
}

impl DormandPrince {
    fn run_n<const N: usize>(&self, system: &System, grid: &Grid) -> Result<Trajectory> {
        adaptive::run::<N>(system, grid, &self.tolerances, &mut Pair)
    }
}

impl Solver for DormandPrince {
    fn name(&self) -> String {
        "dormand_prince".to_owned()
    }

    fn run(&self, system: &System, grid: &Grid) -> Result<Trajectory> {
        with_length!(system.layout.n, self.run_n(system, grid))
    }
}

struct Pair;

impl<const N: usize> Embedded<N> for Pair {
    fn power(&self) -> f64 {
        5.0
    }

    fn attempt(&mut self, field: &Field<N>, z: &[f64; N], h: f64) -> Attempt<N> {
        let mut slopes = [[0.0; N]; 7];
        slopes[0] = field.slope(z);
        let mut end = *z;
        for i in 1..7 {
            end = combined(z, &slopes, &METHOD.a[i], h);
            slopes[i] = field.slope(&end);
        }
        let mut dense = [[0.0; N]; 5];
        dense[0] = *z;
        for power in 0..4 {
            let weights = DENSE.map(|row| row[power]);
            dense[power + 1] = combined(&[0.0; N], &slopes, &weights, h);
        }
        let error = combined(&[0.0; N], &slopes, &METHOD.error, h);
        // The last stage stands at the step's end, with the step's own weights.
        Attempt { z: end, error, dense, evaluations: 7, factorisations: 0 }
    }
}

/// z + h Σ weights · slopes.
fn combined<const N: usize>(
    z: &[f64; N],
    slopes: &[[f64; N]; 7],
    weights: &[f64; 7],
    h: f64,
) -> [f64; N] {
    let mut out = *z;
    for (slope, weight) in slopes.iter().zip(weights).filter(|(_, weight)| **weight != 0.0) {
        for (o, s) in out.iter_mut().zip(slope) {
            *o += h * weight * s;
        }
    }
    out
}
