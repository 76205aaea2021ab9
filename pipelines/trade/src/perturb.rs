//! Neighbours of a scene: each of its sizes up to a tenth larger or smaller.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use zwidth_dynamics::{Demand, Input, ModelScene};

/// Largest change, as a share.
const SHARE: f64 = 0.1;
/// Key of the numbers; neighbour `i` takes stream `i`.
const SEED: u64 = 0x0074_7261_6465;

/// Neighbour `number` of a scene. Masses, stiffnesses, dampings, limits, lags and forces are
/// multiplied by numbers between 0.9 and 1.1, each by its own; angles and times stay.
pub fn neighbour(scene: &ModelScene, number: u64) -> ModelScene {
    let mut rng = ChaCha8Rng::seed_from_u64(SEED);
    rng.set_stream(number);
    // In a fixed order: each value takes the stream's next number, so a new one belongs at the end.
    let mut by = |value: &mut f64| {
        let unit = (rng.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
        *value *= 1.0 + SHARE * (2.0 * unit - 1.0);
    };
    let mut near = scene.clone();
    by(&mut near.plant.mass_kg);
    for zone in &mut near.environment.zones {
        match &mut zone.demand {
            Demand::Spring { stiffness_n_per_rad, damping_ns_per_rad, .. } => {
                by(stiffness_n_per_rad);
                by(damping_ns_per_rad);
            }
            Demand::Force { force_n } => by(force_n),
            Demand::Full | Demand::FullUp => {}
        }
    }
    by(&mut near.motor.max_n);
    by(&mut near.brake.max_n);
    near.motor.lag_s.iter_mut().for_each(&mut by);
    near.brake.lag_on_off_s.iter_mut().flatten().for_each(&mut by);
    input(&mut near.input, &mut by);
    if let Some(friction) = &mut near.friction {
        let mut both = 1.0;
        by(&mut both);
        // By one number: the static level may not fall below the kinetic one.
        friction.static_n *= both;
        friction.kinetic_n *= both;
        by(&mut friction.viscous_ns_per_rad);
    }
    if let Some(finger) = &mut near.finger {
        by(&mut finger.mass_kg);
        by(&mut finger.stiffness_n_per_m);
        by(&mut finger.damping_ns_per_m);
    }
    near
}

fn input(input: &mut Input, by: &mut impl FnMut(&mut f64)) {
    match input {
        Input::Line { value, .. } => by(value),
        Input::Step { magnitude, .. }
        | Input::Ramp { magnitude, .. }
        | Input::Sine { magnitude, .. } => by(magnitude),
        Input::Series(series) => {
            let mut all = 1.0;
            by(&mut all);
            series.value.iter_mut().for_each(|value| *value *= all);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use zwidth_dynamics::{DriveMode, System, table3};

    #[test]
    fn neighbours_are_within_a_tenth_all_different_and_the_same_every_time() {
        let scene = table3::with_finger(table3::scene(DriveMode::Hybrid, Input::sine(2.15)));
        let masses: Vec<f64> = (0..50).map(|i| neighbour(&scene, i).plant.mass_kg).collect();
        assert!(masses.iter().all(|m| (m / scene.plant.mass_kg - 1.0).abs() <= SHARE));
        assert!(masses.windows(2).all(|pair| (pair[0] - pair[1]).abs() > 1e-12));
        assert_eq!(neighbour(&scene, 7), neighbour(&scene, 7));
        assert!((0..50).all(|i| System::new(neighbour(&scene, i)).is_ok()));
    }
}
