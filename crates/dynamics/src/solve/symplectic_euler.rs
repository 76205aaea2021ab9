//! Symplectic (semi-implicit) Euler: velocities first, then angles with the new velocities.

use zwidth_numerics::expm::Matrix;

use super::fixed::{self, Reader};
use super::{Grid, Solver, with_length};
use crate::error::Result;
use crate::system::linear::LinearPart;
use crate::system::row::MOST;
use crate::system::{OMEGA, System, THETA};
use crate::trajectory::Trajectory;

/// Symplectic Euler with the grid's step, switching on the sign of θ̇ once per step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SymplecticEuler;

impl SymplecticEuler {
    fn run_n<const N: usize>(&self, system: &System, grid: &Grid) -> Result<Trajectory> {
        fixed::run::<N>(system, grid, 1, |reader, z, _, h| step(system, reader, z, h))
    }
}

impl Solver for SymplecticEuler {
    fn name(&self) -> String {
        "symplectic_euler".to_owned()
    }

    /// (1 + h P) (1 + h V) with the rows of positions P and of velocities V.
    fn amplification(&self, linear: &LinearPart, h: f64) -> Option<Matrix<MOST>> {
        let identity = Matrix::<MOST>::identity();
        let [first, second] = [true, false].map(|velocities| {
            let rows = Matrix::<MOST>::from_fn(|i, j| {
                if linear.velocities[i] == velocities { h * linear.a.at(i, j) } else { 0.0 }
            });
            identity.zip(&rows, |unit, x| unit + x)
        });
        Some(second.product(&first))
    }

    fn run(&self, system: &System, grid: &Grid) -> Result<Trajectory> {
        with_length!(system.layout.n, self.run_n(system, grid))
    }
}

fn step<const N: usize>(system: &System, reader: &Reader, z: &mut [f64; N], h: f64) {
    let mut slope = [0.0; N];
    system.slope(z, reader.law(z[OMEGA]), &mut slope);
    let layout = &system.layout;
    z[OMEGA] += h * slope[OMEGA];
    z[THETA] += h * z[OMEGA];
    if let Some(at) = layout.finger {
        z[at + 1] += h * slope[at + 1];
        z[at] += h * z[at + 1];
    }
    for at in [layout.motor, layout.brake].into_iter().flatten() {
        z[at] += h * slope[at];
    }
}
