//! Where the energy went: work by part, stored energy, and the remainder.

use crate::scene::environment::Demand;
use crate::system::region::{Contact, Motion, Region, Side};
use crate::system::row::Row;
use crate::system::{OMEGA, System};

/// Work done on lever and finger over a run, J; a part that takes energy out is negative.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct EnergyBalance {
    /// The user, ∫ F_ex (L θ̇ + ẋ2) dt.
    pub external_j: f64,
    /// The motor.
    pub motor_j: f64,
    /// The brake.
    pub brake_j: f64,
    /// Dry and viscous friction.
    pub friction_j: f64,
    /// The scene's terms together: weight, moved spring, …
    pub terms_j: f64,
    /// Damping of the finger's tissue.
    pub tissue_j: f64,
    /// Impacts on stops and of the bottoming finger.
    pub impacts_j: f64,
    /// Change of what lever and finger hold, as motion and in the tissue's spring.
    pub stored_j: f64,
}

impl EnergyBalance {
    fn works(&self) -> [f64; 7] {
        [
            self.external_j,
            self.motor_j,
            self.brake_j,
            self.friction_j,
            self.terms_j,
            self.tissue_j,
            self.impacts_j,
        ]
    }

    /// Work that is not accounted for; rounding, unless the finger's law is `thesis`.
    pub fn residual_j(&self) -> f64 {
        self.works().iter().sum::<f64>() - self.stored_j
    }

    /// Sum of the sizes of all terms: what residuals are compared with.
    pub fn summed_j(&self) -> f64 {
        self.works().iter().map(|work| work.abs()).sum::<f64>() + self.stored_j.abs()
    }
}

/// Number of parts with a power: all of the balance's works but the impacts.
pub(crate) const PARTS: usize = 6;

impl System {
    /// Force and velocity of each part in a region, in the order of the balance; power is their
    /// product.
    pub(crate) fn powers(&self, region: &Region) -> [(Row, Row); PARTS] {
        let side = if region.motion == Motion::Forward { Side::Up } else { Side::Down };
        let forces = self.lever_forces(region, side);
        let dry = self.scene.friction.map_or(0.0, |friction| friction.kinetic_n);
        let friction = forces.viscous.plus(self.constant(-side.sign() * dry));
        let brake = forces.signed_brake.plus(forces.level.times(-side.sign()));
        let lever = match region.motion {
            Motion::Rest => Row::ZERO,
            _ => Row::entry(OMEGA, self.scene.plant.lever_m),
        };
        // A finger on its rigid stop moves with the lever: it has no velocity of its own.
        let soft = self.layout.finger.filter(|_| region.contact == Contact::Free);
        let finger = soft.map_or(Row::ZERO, |at| Row::entry(at + 1, 1.0));
        let damping = self.scene.finger.map_or(0.0, |finger| finger.damping_ns_per_m);
        [
            (Row::entry(self.layout.force, 1.0), lever.plus(finger)),
            (forces.motor, lever),
            (brake, lever),
            (friction, lever),
            (self.affine_terms().plus(forces.chords), lever),
            (finger.times(-damping), finger),
        ]
    }

    /// Where the spring of a region rests, rad; 0 where there is none.
    pub(crate) fn rest_rad(&self, region: &Region) -> f64 {
        match self.scene.environment.zones[usize::from(region.zone_up)].demand {
            Demand::Spring { rest_rad, .. } => rest_rad,
            Demand::Force { .. } | Demand::Full | Demand::FullUp => 0.0,
        }
    }

    /// What lever and finger hold: ½ M_O (L θ̇)² + ½ M_F (L θ̇ + ẋ2)² + ½ K_F x2², J.
    pub(crate) fn stored_j(&self, z: &[f64]) -> f64 {
        let lever = self.scene.plant.lever_m * z[OMEGA];
        let own = 0.5 * self.scene.plant.mass_kg * lever * lever;
        let (Some(finger), Some(at)) = (self.scene.finger, self.layout.finger) else { return own };
        let tip = lever + z[at + 1];
        own + 0.5 * finger.mass_kg * tip * tip + 0.5 * finger.stiffness_n_per_m * z[at] * z[at]
    }
}

#[cfg(test)]
mod tests {
    use super::PARTS;
    use crate::scene::actuators::DriveMode;
    use crate::scene::input::Input;
    use crate::scene::table3;
    use crate::system::OMEGA;
    use crate::trajectory::Trajectory;
    use crate::{Exact, Grid, Solver, System};

    /// The works of a sampled run by the trapezoidal rule, in the order of the balance, and what is
    /// stored: an independent computation, which knows nothing of the exact integrals.
    fn sampled(run: &Trajectory, system: &System) -> ([f64; PARTS], f64) {
        let finger = system.scene.finger;
        let powers = |i: usize| {
            let (forces, z) = (run.forces(system, i), run.state(i));
            let lever = system.scene.plant.lever_m * z[OMEGA];
            let tip = system.layout.finger.map_or(0.0, |at| z[at + 1]);
            [
                forces.external_n * (lever + tip),
                forces.motor_n * lever,
                forces.brake_n * lever,
                forces.friction_n * lever,
                forces.terms_n * lever,
                -finger.map_or(0.0, |finger| finger.damping_ns_per_m) * tip * tip,
            ]
        };
        let mut works = [0.0; PARTS];
        for i in 1..run.len() {
            let half_s = 0.5 * (run.t_s[i] - run.t_s[i - 1]);
            let (before, after) = (powers(i - 1), powers(i));
            for (work, (a, b)) in works.iter_mut().zip(before.iter().zip(after)) {
                *work += half_s * (a + b);
            }
        }
        let stored_j = |i: usize| system.stored_j(run.state(i));
        (works, stored_j(run.len() - 1) - stored_j(0))
    }

    #[test]
    fn the_sampled_balance_comes_close_to_the_exact_one() {
        let scene = table3::with_finger(table3::scene(DriveMode::Hybrid, Input::sine(2.15)));
        let system = System::new(scene).unwrap();
        let solver = Exact { energy: true, ..Exact::default() };
        let run = solver.run(&system, &Grid::filling(4.0, 1e-4)).unwrap();
        let exact = run.energy.unwrap();
        let ([external_j, motor_j, brake_j, .., tissue_j], stored_j) = sampled(&run, &system);
        let pairs = [
            (external_j, exact.external_j),
            (motor_j, exact.motor_j),
            (brake_j, exact.brake_j),
            (tissue_j, exact.tissue_j),
            (stored_j, exact.stored_j),
        ];
        let close = pairs.iter().all(|(a, b)| (a - b).abs() < 1e-4 * exact.summed_j());
        assert!(close, "{pairs:?}");
    }
}
