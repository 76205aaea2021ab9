//! The boundary as an experiment finds it: the linear loop is simulated, tick by tick, and its
//! swings are examined.

use super::SampledWall;
use super::lifted::stiffest;
use crate::error::Result;
use crate::scene::ModelScene;
use crate::scene::actuators::{Brake, BrakeLaw, DriveMode, Motor};
use crate::scene::environment::Environment;
use crate::scene::finger::{Finger, FingerLaw};
use crate::scene::friction::Friction;
use crate::scene::input::Input;
use crate::scene::plant::{Plant, Start};
use crate::scene::terms::Terms;
use crate::solve::exact::held::{HeldCommand, HeldRun, HeldScene};
use std::collections::VecDeque;

/// Where the lever is let go of, m.
const START_M: f64 = 1e-3;

impl SampledWall {
    /// The stiffness K, N/m, up to which from 0 on swings of the simulated loop do not grow over so
    /// many ticks, to a share of itself; 0 and none as [`SampledWall::stiffest_stable`].
    ///
    /// # Errors
    /// A parameter that makes no sense, or a run that fails.
    pub fn stiffest_measured(&self, ticks: usize, share: f64) -> Result<Option<f64>> {
        // One tick shows what is wrong with the wall itself, which below would pass for growth.
        self.simulated_growth(1)?;
        // A run that fails does so because it grew beyond all bounds.
        Ok(stiffest(*self, share, |wall| {
            wall.simulated_growth(ticks).is_ok_and(|growth| growth <= 1.0)
        }))
    }

    /// What the simulated loop's swings are at the end of so many ticks, over those of its middle:
    /// the largest |x| of the last sixth over that of the sixth that ends with the first half. A
    /// run that is far out is broken off.
    ///
    /// # Errors
    /// A parameter that makes no sense, or a run that fails.
    pub fn simulated_growth(&self, ticks: usize) -> Result<f64> {
        /// Times the start: a swing that has grown so far grows for ever.
        const FAR: f64 = 1e6;
        self.check()?;
        let scene = HeldScene::new(&self.scene(), 1.0)?;
        let mut run = scene.start(self.period_s)?;
        let mut loops = Loop::new(self, START_M);
        let mut middle = 0.0_f64;
        let mut last = 0.0_f64;
        for k in 0..ticks {
            let x = run.theta_rad();
            if x.abs() > FAR * START_M {
                return Ok(f64::INFINITY);
            }
            if 3 * k >= ticks && 2 * k < ticks {
                middle = middle.max(x.abs());
            } else if 6 * k >= 5 * ticks {
                last = last.max(x.abs());
            }
            let force_n = loops.demand_n(x);
            loops.later.push_back(HeldCommand { by_motor: true, force_n });
            loops.go_on(&mut run, k)?;
        }
        // Swings that have died out in the middle are no divisor.
        Ok(last / middle.max(START_M / FAR / FAR))
    }

    /// The lever alone, its finger and the motor's lag; nothing commanded.
    pub(super) fn scene(&self) -> ModelScene {
        /// A force that no command reaches, N: the wall is linear.
        const ENDLESS: f64 = 1e30;
        let friction =
            Friction { static_n: 0.0, kinetic_n: 0.0, viscous_ns_per_rad: self.damping_ns_per_m };
        let finger = self.finger.map(|finger| Finger {
            law: FingerLaw::Consistent,
            mass_kg: finger.mass_kg,
            stiffness_n_per_m: finger.stiffness_n_per_m,
            damping_ns_per_m: finger.damping_ns_per_m,
            length_m: None,
        });
        ModelScene {
            name: "sampled wall".to_owned(),
            mode: DriveMode::Active,
            duration_s: 1.0,
            step_s: self.period_s,
            environment: Environment::free(),
            plant: Plant { mass_kg: self.mass_kg, lever_m: 1.0, stops_rad: None },
            motor: Motor { max_n: ENDLESS, lag_s: self.motor_lag_s },
            brake: Brake {
                max_n: 0.0,
                law: BrakeLaw::Coulomb,
                dead_zone_n: 0.0,
                lag_on_off_s: None,
                let_go_n: None,
            },
            input: Input::constant(0.0),
            start: Start { theta_rad: START_M, theta_dot_rad_s: 0.0 },
            finger,
            friction: Some(friction),
            terms: Terms::default(),
        }
    }
}

/// The controller, and the commands that have not acted yet.
pub(super) struct Loop<'a> {
    wall: &'a SampledWall,
    before_m: f64,
    pub(super) filtered_m_s: f64,
    pub(super) later: VecDeque<HeldCommand>,
}

impl<'a> Loop<'a> {
    /// A controller that has seen a lever at rest.
    pub(super) fn new(wall: &'a SampledWall, x_m: f64) -> Self {
        let nothing = HeldCommand { by_motor: true, force_n: 0.0 };
        let later = VecDeque::from(vec![nothing; wall.delay().0]);
        Self { wall, before_m: x_m, filtered_m_s: 0.0, later }
    }

    /// Holds what is due in tick `k` when it is, and moves the lever to the tick's end.
    pub(super) fn go_on(&mut self, run: &mut HeldRun<'_>, k: usize) -> Result<()> {
        let period_s = self.wall.period_s;
        let rest_s = self.wall.delay().1;
        if rest_s > 0.0 {
            run.advance(k as f64 * period_s + rest_s)?;
        }
        if let Some(command) = self.later.pop_front() {
            run.hold(command)?;
        }
        run.advance((k + 1) as f64 * period_s)
    }

    /// u = K x + B ẋ of a position that was measured.
    pub(super) fn demand_n(&mut self, x_m: f64) -> f64 {
        let (wall, alpha) = (self.wall, self.wall.filter());
        let rate = (x_m - self.before_m) / wall.period_s;
        self.before_m = x_m;
        self.filtered_m_s = alpha * self.filtered_m_s + (1.0 - alpha) * rate;
        wall.stiffness_n_per_m * x_m + wall.wall_damping_ns_per_m * self.filtered_m_s
    }
}
