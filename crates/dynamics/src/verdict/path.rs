//! θ of a run between its samples: the cubic through both ends and their velocities.

use crate::trajectory::Trajectory;

/// Times, angles and velocities.
pub(super) struct Path {
    t_s: Vec<f64>,
    theta_rad: Vec<f64>,
    theta_dot_rad_s: Vec<f64>,
}

impl Path {
    pub(super) fn of(run: &Trajectory) -> Self {
        Self {
            t_s: run.t_s.clone(),
            theta_rad: run.theta_rad().collect(),
            theta_dot_rad_s: run.theta_dot_rad_s().collect(),
        }
    }

    pub(super) fn end_s(&self) -> f64 {
        self.t_s.last().copied().unwrap_or(0.0)
    }

    /// θ at a time within the run.
    pub(super) fn at(&self, t_s: f64) -> f64 {
        let after = self.t_s.partition_point(|t| *t <= t_s);
        let i = after.clamp(1, self.t_s.len().max(2) - 1);
        let (Some(t1), Some(&b)) = (self.t_s.get(i), self.theta_rad.get(i)) else {
            return self.theta_rad.first().copied().unwrap_or(0.0);
        };
        let a = self.theta_rad[i - 1];
        let h = t1 - self.t_s[i - 1];
        let s = ((t_s - self.t_s[i - 1]) / h).clamp(0.0, 1.0);
        let u = h * self.theta_dot_rad_s[i - 1];
        let v = h * self.theta_dot_rad_s[i];
        let rise = b - a;
        a + s * (u + s * ((3.0 * rise - 2.0 * u - v) + s * (u + v - 2.0 * rise)))
    }

    /// θ at increasing times within the run.
    pub(super) fn along(&self, times_s: impl Iterator<Item = f64>) -> Vec<f64> {
        times_s.map(|t| self.at(t)).collect()
    }

    pub(super) fn largest_rad(&self) -> f64 {
        self.theta_rad.iter().map(|theta| theta.abs()).fold(0.0, f64::max)
    }

    /// Largest θ.
    pub(super) fn highest_rad(&self) -> f64 {
        self.theta_rad.iter().copied().fold(f64::NEG_INFINITY, f64::max)
    }

    /// Largest less smallest θ.
    pub(super) fn range_rad(&self) -> f64 {
        self.highest_rad() - self.theta_rad.iter().copied().fold(f64::INFINITY, f64::min)
    }

    /// Largest difference from another path, at its samples.
    pub(super) fn distance_rad(&self, other: &Path) -> f64 {
        let apart = other.t_s.iter().zip(&other.theta_rad).map(|(t, theta)| self.at(*t) - theta);
        apart.map(f64::abs).fold(0.0, f64::max)
    }

    /// Largest difference of the samples from `from_s` on to what stood there so much earlier.
    pub(super) fn change_rad(&self, from_s: f64, earlier_s: f64) -> f64 {
        let samples = self.t_s.iter().zip(&self.theta_rad).filter(|(t, _)| **t >= from_s);
        samples.map(|(t, theta)| (theta - self.at(t - earlier_s)).abs()).fold(0.0, f64::max)
    }

    /// From when to when the lever stands still: several samples, one after the other, at which θ̇
    /// is 0.
    pub(super) fn stands_s(&self) -> Vec<[f64; 2]> {
        let samples: Vec<(f64, f64)> =
            self.t_s.iter().copied().zip(self.theta_dot_rad_s.iter().copied()).collect();
        samples
            .chunk_by(|a, b| a.1 == 0.0 && b.1 == 0.0)
            .filter(|stretch| stretch.len() > 1)
            .map(|stretch| [stretch[0].0, stretch[stretch.len() - 1].0])
            .collect()
    }

    /// Largest less smallest θ of the samples between two times.
    pub(super) fn way_rad(&self, from_s: f64, to_s: f64) -> f64 {
        let inside = self.t_s.iter().zip(&self.theta_rad);
        let inside = inside.filter(|(t, _)| (from_s..=to_s).contains(*t)).map(|(_, theta)| *theta);
        let [low, high] = inside.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], theta| {
            [low.min(theta), high.max(theta)]
        });
        (high - low).max(0.0)
    }
}
