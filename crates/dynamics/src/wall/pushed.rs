//! The wall of a real device: dry friction, a motor that saturates, an angle that is counted, a
//! brake beside the motor. Its limit depends on the push.
//!
//! The lever is released at rest, a push deep in the bilateral wall. Below the boundary its swings
//! end in the friction cone; above the boundary they go on. For a large push the boundary is that
//! of the lifted map; for a small push friction stabilises a stiffer wall: about (b + 4 F_c/(π ω
//! A))/(T/2) by the describing function of Coulomb friction, ω² = K/m.

use super::SampledWall;
use super::lifted::stiffest;
use super::measured::Loop;
use crate::error::{Result, finite, not_negative, positive};
use crate::scene::ModelScene;
use crate::scene::actuators::DriveMode;
use crate::scene::friction::Friction;
use crate::scene::plant::Start;
use crate::solve::exact::held::{HeldCommand, HeldScene};

/// A device with a wall, and a push against it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PushedWall {
    /// Lever, controller and wall.
    pub wall: SampledWall,
    /// F_s: dry friction at rest, N; not below that in motion.
    pub static_n: f64,
    /// F_c: dry friction in motion, N.
    pub kinetic_n: f64,
    /// Largest force of the motor, N.
    pub motor_n: f64,
    /// Largest force of the brake, N.
    pub brake_n: f64,
    /// Which actuators render: `hybrid` brakes while the lever goes deeper and drives it back.
    pub mode: DriveMode,
    /// Δ: one count of the position, m; 0 for an angle that is not counted.
    pub count_m: f64,
    /// Where the counts begin, as a share of one: from 0 to below 1.
    pub count_zero: f64,
    /// A: how deep in the wall the lever is let go of, m.
    pub push_m: f64,
}

/// The outcome of a push.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pushed {
    /// Half of the peak-to-peak motion in the run's last sixth, m.
    pub swing_m: f64,
    /// Whether it goes on: more than a tenth of the push, and more than a count.
    pub goes_on: bool,
    /// Whether a command exceeded what an actuator can give.
    pub saturates: bool,
}

impl PushedWall {
    /// The same device with another stiffness, N/m.
    #[must_use]
    pub fn with_stiffness(self, stiffness_n_per_m: f64) -> Self {
        Self { wall: self.wall.with_stiffness(stiffness_n_per_m), ..self }
    }

    /// Every parameter checked.
    ///
    /// # Errors
    /// The first that makes no sense, by name and value.
    pub fn check(&self) -> Result<()> {
        self.wall.check()?;
        not_negative("kinetic_n", self.kinetic_n)?;
        not_negative("static_n", self.static_n)?;
        not_negative("motor_n", self.motor_n)?;
        not_negative("brake_n", self.brake_n)?;
        not_negative("count_m", self.count_m)?;
        finite("count_zero", self.count_zero)?;
        positive("push_m", self.push_m)
    }

    /// One push, followed for so many ticks, exactly from tick to tick.
    ///
    /// # Errors
    /// A parameter that makes no sense, or a run that fails.
    pub fn push(&self, ticks: usize) -> Result<Pushed> {
        self.check()?;
        let scene = HeldScene::new(&self.scene(), 1.0)?;
        let mut run = scene.start(self.wall.period_s)?;
        let mut loops = Loop::new(&self.wall, self.seen_m(self.push_m));
        let mut low = f64::INFINITY;
        let mut high = f64::NEG_INFINITY;
        let mut saturates = false;
        for k in 0..ticks {
            let x = run.theta_rad();
            if 6 * k >= 5 * ticks {
                (low, high) = (low.min(x), high.max(x));
            }
            let demand_n = loops.demand_n(self.seen_m(x));
            let command = self.command(demand_n, loops.filtered_m_s);
            let limit_n = if command.by_motor { self.motor_n } else { self.brake_n };
            saturates |= limit_n < demand_n.abs();
            loops.later.push_back(command);
            loops.go_on(&mut run, k)?;
        }
        let swing_m = 0.5 * (high - low).max(0.0);
        let goes_on = swing_m > 0.1 * self.push_m && swing_m > self.count_m;
        Ok(Pushed { swing_m, goes_on, saturates })
    }

    /// The stiffness K, N/m, up to which from 0 on a push ends at rest, to a share of itself; 0 and
    /// none as [`SampledWall::stiffest_stable`].
    ///
    /// # Errors
    /// A parameter that makes no sense.
    pub fn stiffest(&self, ticks: usize, share: f64) -> Result<Option<f64>> {
        self.check()?;
        Ok(stiffest(self.wall, share, |wall| {
            Self { wall: *wall, ..*self }.push(ticks).is_ok_and(|pushed| !pushed.goes_on)
        }))
    }

    /// A position as the angle's counts show it.
    fn seen_m(&self, x_m: f64) -> f64 {
        if self.count_m <= 0.0 {
            return x_m;
        }
        // The middle of the count that the position lies in.
        ((x_m / self.count_m + self.count_zero).floor() + 0.5 - self.count_zero) * self.count_m
    }

    /// The actuator that gives a demanded force while the lever moves at a velocity, and how much
    /// of it.
    fn command(&self, demand_n: f64, rate_m_s: f64) -> HeldCommand {
        let deeper = demand_n * rate_m_s > 0.0;
        match self.mode {
            DriveMode::Passive | DriveMode::Hybrid if deeper => {
                HeldCommand { by_motor: false, force_n: demand_n.abs().min(self.brake_n) }
            }
            DriveMode::Passive => HeldCommand { by_motor: false, force_n: 0.0 },
            DriveMode::Active | DriveMode::Hybrid => {
                let force_n = demand_n.clamp(-self.motor_n, self.motor_n);
                HeldCommand { by_motor: true, force_n }
            }
        }
    }

    fn scene(&self) -> ModelScene {
        let mut scene = self.wall.scene();
        scene.start = Start { theta_rad: self.push_m, theta_dot_rad_s: 0.0 };
        scene.friction = Some(Friction {
            static_n: self.static_n,
            kinetic_n: self.kinetic_n,
            viscous_ns_per_rad: self.wall.damping_ns_per_m,
        });
        scene.brake.max_n = self.brake_n;
        scene
    }
}
