//! The thesis' Table 3: parameters of the simulation model, from a scene.

use zwidth_dynamics::{BrakeLaw, Demand, Input, ModelScene};
use zwidth_results::Fact;

/// Parameters of the model that a scene is, with the thesis' symbols; what the scene lacks (a
/// finger, stops) is left out.
pub fn model_facts(scene: &ModelScene) -> Vec<Fact> {
    let mut facts =
        vec![Fact::new("M_O, mass of the object (spring)", Some(scene.plant.mass_kg), "kg")];
    for zone in &scene.environment.zones {
        if let Demand::Force { force_n } = zone.demand {
            let force = Fact::new("F_O, constant force of the object", Some(force_n), "N");
            facts.push(force.remarked("not in the thesis' table"));
        }
        let Demand::Spring { stiffness_n_per_rad, damping_ns_per_rad, rest_rad } = zone.demand
        else {
            continue;
        };
        facts.extend([
            Fact::new("K_O, stiffness of the object", Some(stiffness_n_per_rad), "N/rad"),
            Fact::new("B_O, damping of the object", Some(damping_ns_per_rad), "N·s/rad"),
            Fact::new("θ_rest, angle of the object at rest", Some(rest_rad.to_degrees()), "°")
                .remarked("not in the thesis' table"),
        ]);
    }
    if let Some(finger) = &scene.finger {
        facts.extend([
            Fact::new("M_F, mass of the finger", Some(finger.mass_kg), "kg"),
            Fact::new("K_F, stiffness of the finger", Some(finger.stiffness_n_per_m), "N/m"),
            Fact::new("B_F, damping of the finger", Some(finger.damping_ns_per_m), "N·s/m"),
            Fact::new("L_F0, length of the finger at rest", finger.length_m.map(|m| m * 1e3), "mm"),
        ]);
    }
    let (largest, shape) = match &scene.input {
        // They go from 0 to twice their amplitude: equations (5) to (7).
        Input::Step { magnitude, .. } => {
            (Some(2.0 * magnitude), "steps between 0 and 2a, equation (5)")
        }
        Input::Ramp { magnitude, .. } => {
            (Some(2.0 * magnitude), "ramps between 0 and 2a, equation (6)")
        }
        Input::Sine { magnitude, .. } => (Some(2.0 * magnitude), "a + a sin(ω t), equation (7)"),
        Input::Line { .. } => (None, "a straight line"),
        Input::Series(_) => (None, "recorded"),
    };
    facts.extend([
        Fact::new("T, length of the simulation", Some(scene.duration_s), "s"),
        Fact::new("h, step", Some(scene.step_s * 1e3), "ms"),
        Fact::new("F_ex, user force, largest", largest, "N").remarked(shape),
    ]);
    if let Some([low, high]) = scene.plant.stops_rad {
        facts.push(Fact::new("θ_min, lower stop", Some(low.to_degrees()), "°"));
        facts.push(Fact::new("θ_max, upper stop", Some(high.to_degrees()), "°"));
    }
    facts.extend([
        Fact::new("L, lever", Some(scene.plant.lever_m), "m").remarked("not in the thesis' table"),
        Fact::new("F_m, largest motor force", Some(scene.motor.max_n), "N")
            .remarked("not in the thesis' table"),
        Fact::new("F_b, largest brake force", Some(scene.brake.max_n), "N").remarked(
            match scene.brake.law {
                BrakeLaw::Coulomb => "not in the thesis' table; set-valued",
                BrakeLaw::Thesis => "not in the thesis' table; on while θ̇ > 0",
            },
        ),
    ]);
    facts
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Table 3 as printed; the thesis' 1.53 kg/s is 1.53 N·s/m.
    #[test]
    fn the_scene_of_the_thesis_gives_the_numbers_of_its_table_3() {
        let text = include_str!("../../../scenes/sine_finger.toml");
        let facts = model_facts(&ModelScene::from_toml(text).unwrap());
        let printed = [
            ("M_O", 0.005, "kg"),
            ("M_F", 0.021, "kg"),
            ("K_O", 4.0, "N/rad"),
            ("B_O", 1.0, "N·s/rad"),
            ("K_F", 584.6, "N/m"),
            ("B_F", 1.53, "N·s/m"),
            ("L_F0", 6.0, "mm"),
            ("T", 4.0, "s"),
            ("h", 8.3, "ms"),
            ("θ_min", -45.0, "°"),
            ("θ_max", 45.0, "°"),
        ];
        for (symbol, value, unit) in printed {
            let begins = format!("{symbol}, ");
            let fact = facts.iter().find(|fact| fact.quantity.starts_with(&begins)).unwrap();
            assert!((fact.value.unwrap() - value).abs() < 1e-12, "{symbol}: {fact:?}");
            assert_eq!(fact.unit.as_deref(), Some(unit), "{symbol}");
        }
    }

    #[test]
    fn a_scene_without_a_finger_has_no_row_of_one() {
        let text = include_str!("../../../scenes/sine.toml");
        let facts = model_facts(&ModelScene::from_toml(text).unwrap());
        assert!(!facts.iter().any(|fact| fact.quantity.contains("finger")));
    }
}
