//! TR-BDF2: trapezoidal rule, then BDF2, as one L-stable step of order 2 for stiff scenes.

use std::f64::consts::{FRAC_1_SQRT_2, SQRT_2};

use zwidth_numerics::expm::Matrix;

use super::adaptive::{self, Tolerances};
use super::embedded::{Attempt, Embedded, Field};
use super::{Grid, Solver, with_length};
use crate::error::Result;
use crate::system::System;
use crate::trajectory::Trajectory;

/// Diagonal weight d = 1 − √2/2 of both implicit stages; the first ends at 2 d.
const DIAGONAL: f64 = 1.0 - FRAC_1_SQRT_2;
/// Weight w = √2/4 of the first two slopes.
const WEIGHT: f64 = SQRT_2 / 4.0;

/// The implicit method, on the same regions and events as the exact solver.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrBdf2 {
    /// What it aims for.
    pub tolerances: Tolerances,
}

impl TrBdf2 {
    fn run_n<const N: usize>(&self, system: &System, grid: &Grid) -> Result<Trajectory> {
        adaptive::run::<N>(system, grid, &self.tolerances, &mut Step { factored: None })
    }
}

impl Solver for TrBdf2 {
    fn name(&self) -> String {
        "tr_bdf2".to_owned()
    }

    fn run(&self, system: &System, grid: &Grid) -> Result<Trajectory> {
        with_length!(system.layout.n, self.run_n(system, grid))
    }
}

struct Step<const N: usize> {
    factored: Option<Factored<N>>,
}

/// The last iteration matrix (1 − d h J)⁻¹, its Jacobian J and step h.
struct Factored<const N: usize> {
    jacobian: Matrix<N>,
    h: f64,
    inverse: Matrix<N>,
}

/// The solution of an implicit stage.
struct Stage<const N: usize> {
    z: [f64; N],
    slope: [f64; N],
    evaluations: u64,
}

impl<const N: usize> Step<N> {
    /// (1 − d h J)⁻¹, kept while h and J stay the same; true if it had to be made.
    fn iteration(&mut self, jacobian: &Matrix<N>, h: f64) -> (Matrix<N>, bool) {
        if let Some(last) = &self.factored
            && last.jacobian == *jacobian
            && last.h.to_bits() == h.to_bits()
        {
            return (last.inverse, false);
        }
        let system = Matrix::<N>::identity().zip(jacobian, |unit, j| unit - DIAGONAL * h * j);
        // Where the matrix is singular the step's error is not a number, and a shorter step is
        // tried.
        let inverse = system.inverse().unwrap_or(Matrix::<N>::ZERO.map(|_| f64::NAN));
        self.factored = Some(Factored { jacobian: *jacobian, h, inverse });
        (inverse, true)
    }
}

impl<const N: usize> Embedded<N> for Step<N> {
    fn power(&self) -> f64 {
        3.0
    }

    fn attempt(&mut self, field: &Field<N>, z: &[f64; N], h: f64) -> Attempt<N> {
        let (inverse, fresh) = self.iteration(&field.jacobian(z), h);
        let first = field.slope(z);
        let start = along(z, &[(DIAGONAL * h, &first)]);
        let guess = along(z, &[(2.0 * DIAGONAL * h, &first)]);
        let middle = solve(field, &inverse, &start, guess, h);
        let start = along(z, &[(WEIGHT * h, &first), (WEIGHT * h, &middle.slope)]);
        let end = solve(field, &inverse, &start, middle.z, h);
        let raw = along(
            &[0.0; N],
            &[
                (h * (WEIGHT - (1.0 - WEIGHT) / 3.0), &first),
                (h * (WEIGHT - (3.0 * WEIGHT + 1.0) / 3.0), &middle.slope),
                (h * (DIAGONAL - DIAGONAL / 3.0), &end.slope),
            ],
        );
        Attempt {
            z: end.z,
            // Through the iteration matrix: the raw estimate is far too large for stiff parts
            // (Hosea & Shampine 1996).
            error: inverse.apply(&raw),
            dense: hermite(z, &first, &end.z, &end.slope, h),
            evaluations: 1 + middle.evaluations + end.evaluations,
            factorisations: u64::from(fresh),
        }
    }
}

/// Solves z = start + d h f(z) by Newton's method with a fixed matrix.
fn solve<const N: usize>(
    field: &Field<N>,
    inverse: &Matrix<N>,
    start: &[f64; N],
    guess: [f64; N],
    h: f64,
) -> Stage<N> {
    /// Affine fields need one; the weight's sine a few.
    const MOST: u64 = 8;
    let mut z = guess;
    let mut slope = field.slope(&z);
    for count in 1..=MOST {
        let residual: [f64; N] = std::array::from_fn(|i| z[i] - start[i] - DIAGONAL * h * slope[i]);
        let change = inverse.apply(&residual);
        for (x, d) in z.iter_mut().zip(&change) {
            *x -= d;
        }
        slope = field.slope(&z);
        let small = change.iter().zip(&z).all(|(d, x)| d.abs() <= 1e-13 * x.abs());
        if small {
            return Stage { z, slope, evaluations: count + 1 };
        }
    }
    Stage { z, slope, evaluations: MOST + 1 }
}

/// z + Σ factor · v.
fn along<const N: usize>(z: &[f64; N], terms: &[(f64, &[f64; N])]) -> [f64; N] {
    std::array::from_fn(|i| z[i] + terms.iter().map(|(factor, v)| factor * v[i]).sum::<f64>())
}

/// The cubic through both ends and their slopes, in powers of the share of the step.
fn hermite<const N: usize>(
    z0: &[f64; N],
    f0: &[f64; N],
    z1: &[f64; N],
    f1: &[f64; N],
    h: f64,
) -> [[f64; N]; 5] {
    let mut out = [[0.0; N]; 5];
    for i in 0..N {
        let rise = z1[i] - z0[i];
        let a = h * f0[i];
        let b = h * f1[i];
        out[0][i] = z0[i];
        out[1][i] = a;
        out[2][i] = 3.0 * rise - 2.0 * a - b;
        out[3][i] = a + b - 2.0 * rise;
    }
    out
}
