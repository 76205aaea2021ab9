//! The scenes of these tests.

use zwidth_dynamics::ModelScene;

fn scene(text: &str) -> ModelScene {
    ModelScene::from_toml(text).unwrap()
}

/// A lever under half its dry friction: it stands.
pub(crate) fn stick() -> ModelScene {
    scene(
        r#"
        name = "stick under half its friction"
        mode = "active"
        duration_s = 1.0
        step_s = 0.001
        plant = { mass_kg = 0.1, lever_m = 0.045, stops_rad = [-0.8, 0.8] }
        motor = { max_n = 2.0 }
        brake = { max_n = 13.0, law = "coulomb" }
        friction = { static_n = 0.2, kinetic_n = 0.2, viscous_ns_per_rad = 0.0 }
        input.line = { value = 0.1, rate = 0.0 }
        start = { theta_rad = 0.1 }
        environment = { name = "free", zones = [{ demand.force.force_n = 0.0 }] }
        "#,
    )
}

/// A lever that breaks loose at 0.2 s, when the push jumps above its friction, and is pushed against
/// its stop.
pub(crate) fn stop() -> ModelScene {
    scene(
        r#"
        name = "stop under a steady push"
        mode = "active"
        duration_s = 1.0
        step_s = 0.001
        plant = { mass_kg = 0.1, lever_m = 0.045, stops_rad = [-0.8, 0.3] }
        motor = { max_n = 2.0 }
        brake = { max_n = 13.0, law = "coulomb" }
        friction = { static_n = 0.2, kinetic_n = 0.15, viscous_ns_per_rad = 0.05 }
        input.series = { t_s = [0.0, 0.2, 0.2, 1.0], value = [0.1, 0.1, 0.3, 0.3] }
        environment = { name = "free", zones = [{ demand.force.force_n = 0.0 }] }
        "#,
    )
}

/// Rabinowicz: pulled slowly by a spring, the lever sticks until the spring holds the static
/// friction, slips, and sticks again.
pub(crate) fn slip_stick() -> ModelScene {
    scene(
        r#"
        name = "slip and stick"
        mode = "active"
        duration_s = 2.0
        step_s = 0.001
        plant = { mass_kg = 0.05, lever_m = 0.05 }
        motor = { max_n = 2.0 }
        brake = { max_n = 13.0, law = "coulomb" }
        friction = { static_n = 0.5, kinetic_n = 0.2, viscous_ns_per_rad = 0.0 }
        input.line = { value = 0.0, rate = 0.0 }
        pull = { stiffness_n_per_rad = 10.0, displacement = { line = { value = 0.0, rate = 0.2 } } }
        environment = { name = "free", zones = [{ demand.force.force_n = 0.0 }] }
        "#,
    )
}

/// The thesis' Table 3: forward by the brake, rest, backward by the motor.
pub(crate) fn hybrid() -> ModelScene {
    zwidth_dynamics::table3::scene(
        zwidth_dynamics::DriveMode::Hybrid,
        zwidth_dynamics::Input::sine(2.15),
    )
}

/// A brake holds the lever until the user's force is below its let-go threshold, at 0.9 s; then the
/// motor's spring drives it back.
pub(crate) fn let_go() -> ModelScene {
    scene(
        r#"
        name = "brake lets go"
        mode = "hybrid"
        duration_s = 2.0
        step_s = 0.001
        plant = { mass_kg = 0.1, lever_m = 0.045, stops_rad = [-0.8, 0.8] }
        motor = { max_n = 2.0 }
        brake = { max_n = 13.0, law = "coulomb", let_go_n = 0.5 }
        friction = { static_n = 0.05, kinetic_n = 0.05, viscous_ns_per_rad = 0.2 }
        input.series = { t_s = [0.0, 0.1, 0.4, 1.0, 2.0], value = [0.0, 1.5, 1.5, 0.3, 0.0] }
        environment = { name = "spring", zones = [{ demand.spring = { stiffness_n_per_rad = 4.0, damping_ns_per_rad = 0.2, rest_rad = 0.0 } }] }
        "#,
    )
}

/// A spring without damping: θ = 0.2 cos ω t, ω² = K / (M L).
pub(crate) fn spring() -> ModelScene {
    scene(
        r#"
        name = "undamped spring"
        mode = "active"
        duration_s = 1.0
        step_s = 0.001
        plant = { mass_kg = 0.1, lever_m = 0.05 }
        motor = { max_n = 20.0 }
        brake = { max_n = 13.0, law = "coulomb" }
        input.line = { value = 0.0, rate = 0.0 }
        start = { theta_rad = 0.2 }
        environment = { name = "spring", zones = [{ demand.spring = { stiffness_n_per_rad = 4.5, damping_ns_per_rad = 0.0, rest_rad = 0.0 } }] }
        "#,
    )
}

/// A pendulum, which `exact` cannot run.
pub(crate) fn pendulum() -> ModelScene {
    scene(
        r#"
        name = "pendulum"
        mode = "active"
        duration_s = 2.0
        step_s = 0.001
        plant = { mass_kg = 0.1, lever_m = 0.2 }
        motor = { max_n = 2.0 }
        brake = { max_n = 13.0, law = "coulomb" }
        gravity = { mass_kg = 0.1, radius_m = 0.2 }
        input.line = { value = 0.0, rate = 0.0 }
        start = { theta_rad = 0.5 }
        environment = { name = "free", zones = [{ demand.force.force_n = 0.0 }] }
        "#,
    )
}

/// All of them.
pub(crate) fn all() -> [ModelScene; 7] {
    [stick(), stop(), slip_stick(), hybrid(), let_go(), spring(), pendulum()]
}
