//! What moves between two ticks: lever, finger and motor under a held command u.

use super::SampledWall;
use zwidth_numerics::expm::{Ladder, Matrix};

/// Entries: x, ẋ, x2, ẋ2, the motor's force, u.
pub(super) const ENTRIES: usize = 6;
pub(super) const X: usize = 0;
pub(super) const V: usize = 1;
pub(super) const X2: usize = 2;
pub(super) const V2: usize = 3;
const MOTOR: usize = 4;
pub(super) const U: usize = 5;

impl SampledWall {
    /// m ẍ = F − b ẋ + K_F x2 + B_F ẋ2, M_F (ẍ2 + ẍ) = −K_F x2 − B_F ẋ2, τ Ḟ = −u − F, u̇ = 0;
    /// without a lag F = −u.
    pub(super) fn plant(&self) -> Matrix<ENTRIES> {
        let mut rows = [[0.0; ENTRIES]; ENTRIES];
        let m = self.mass_kg;
        rows[X][V] = 1.0;
        rows[V][V] = -self.damping_ns_per_m / m;
        match self.motor_lag_s {
            Some(lag) => {
                rows[V][MOTOR] = 1.0 / m;
                (rows[MOTOR][MOTOR], rows[MOTOR][U]) = (-1.0 / lag, -1.0 / lag);
            }
            None => rows[V][U] = -1.0 / m,
        }
        if let Some(finger) = self.finger {
            (rows[V][X2], rows[V][V2]) =
                (finger.stiffness_n_per_m / m, finger.damping_ns_per_m / m);
            rows[X2][V2] = 1.0;
            rows[V2] = rows[V].map(|x| -x);
            rows[V2][X2] -= finger.stiffness_n_per_m / finger.mass_kg;
            rows[V2][V2] -= finger.damping_ns_per_m / finger.mass_kg;
        }
        Matrix::from_fn(|i, j| rows[i][j])
    }

    /// The entries that this wall's plant has, but for the command.
    pub(super) fn entries(&self) -> Vec<usize> {
        let finger = self.finger.map_or(&[][..], |_| &[X2, V2]);
        let motor = self.motor_lag_s.map_or(&[][..], |_| &[MOTOR]);
        [&[X, V], finger, motor].concat()
    }
}

/// The plant's flow over a time, s.
pub(super) fn flow(plant: Matrix<ENTRIES>, time_s: f64) -> Matrix<ENTRIES> {
    if time_s > 0.0 {
        Ladder::<ENTRIES>::new(plant, time_s).flow(time_s)
    } else {
        Matrix::identity()
    }
}
