//! The thesis' method: classical Runge–Kutta of order 4 on the switching right-hand side.

use zwidth_numerics::expm::Matrix;
use zwidth_numerics::tableau::RK4;

use super::fixed::{self, Reader};
use super::{Grid, Solver, Switching, with_length};
use crate::error::Result;
use crate::system::linear::LinearPart;
use crate::system::row::MOST;
use crate::system::{OMEGA, System};
use crate::trajectory::Trajectory;

/// RK4 with the grid's step. The thesis does not say whether it switched per stage or per step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Rk4 {
    /// When the sign of θ̇ is tested.
    pub switching: Switching,
}

impl Rk4 {
    fn run_n<const N: usize>(&self, system: &System, grid: &Grid) -> Result<Trajectory> {
        fixed::run::<N>(system, grid, RK4.b.len() as u64, |reader, z, t, h| {
            step(self.switching, system, reader, z, t, h);
        })
    }
}

impl Solver for Rk4 {
    fn name(&self) -> String {
        match self.switching {
            Switching::PerStage => "rk4_per_stage".to_owned(),
            Switching::PerStep => "rk4_per_step".to_owned(),
        }
    }

    /// The first five terms of exp(h A).
    fn amplification(&self, linear: &LinearPart, h: f64) -> Option<Matrix<MOST>> {
        let scaled = linear.a.map(|x| x * h);
        let identity = Matrix::<MOST>::identity();
        let mut sum = identity;
        for k in (1..=RK4.order).rev() {
            sum = identity.zip(&scaled.product(&sum), |unit, x| unit + x / f64::from(k));
        }
        Some(sum)
    }

    fn run(&self, system: &System, grid: &Grid) -> Result<Trajectory> {
        with_length!(system.layout.n, self.run_n(system, grid))
    }
}

fn step<const N: usize>(
    switching: Switching,
    system: &System,
    reader: &mut Reader,
    z: &mut [f64; N],
    t: f64,
    h: f64,
) {
    let at_start = reader.law(z[OMEGA]);
    let mut slopes = [[0.0; N]; 4];
    for i in 0..4 {
        let mut stage = combined(z, &slopes, &RK4.a[i], h);
        reader.read(t + RK4.c[i] * h, &mut stage);
        let law = match switching {
            Switching::PerStep => at_start,
            Switching::PerStage => reader.law(stage[OMEGA]),
        };
        system.slope(&stage, law, &mut slopes[i]);
    }
    *z = combined(z, &slopes, &RK4.b, h);
}

/// z + h Σ weights · slopes.
fn combined<const N: usize>(
    z: &[f64; N],
    slopes: &[[f64; N]; 4],
    weights: &[f64; 4],
    h: f64,
) -> [f64; N] {
    std::array::from_fn(|k| z[k] + h * (0..4).map(|i| weights[i] * slopes[i][k]).sum::<f64>())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::actuators::DriveMode;
    use crate::scene::input::Input;
    use crate::scene::table3;

    fn check(switching: Switching, h: f64, reversals: usize, max_deg: f64) {
        let system = System::new(table3::scene(DriveMode::Hybrid, Input::sine(2.15))).unwrap();
        let run = Rk4 { switching }.run(&system, &Grid::filling(4.0, h)).unwrap();
        let max = run.theta_rad().fold(f64::MIN, f64::max).to_degrees();
        assert_eq!(run.reversals(), reversals, "{switching:?} {h}: max {max}");
        assert!((max - max_deg).abs() < 5e-4, "{switching:?} {h}: {max} instead of {max_deg}");
    }

    #[test]
    fn switching_on_the_sign_chatters_per_stage() {
        check(Switching::PerStage, 8.3e-3, 2, 15.171);
        check(Switching::PerStage, 0.83e-3, 22, 14.629);
        check(Switching::PerStage, 0.05e-3, 436, 14.423);
    }

    #[test]
    fn switching_on_the_sign_chatters_more_once_a_step() {
        check(Switching::PerStep, 8.3e-3, 38, 17.937);
        check(Switching::PerStep, 0.83e-3, 268, 14.926);
        check(Switching::PerStep, 0.05e-3, 4014, 14.441);
    }
}
