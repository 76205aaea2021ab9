//! Numbers from closed forms and from roots of the characteristic polynomial, found independently
//! of this code.

use std::f64::consts::PI;

use super::*;
use crate::scene::actuators::DriveMode;
use crate::solve::named::NAMED_SOLVERS;

/// The simulated device without friction: 0.0972 kg, 2.6 N s/m, 8.3 ms.
fn twin() -> SampledWall {
    SampledWall::bare(0.0972, 2.6, 8.3e-3)
}

/// (wall, K of the lifted map, K of the textbook (b + B)/(T/2 + delay)).
fn known() -> [(SampledWall, f64, f64); 5] {
    let (twin, late) = (twin(), twin().period_s);
    let damped = SampledWall { wall_damping_ns_per_m: 2.0, ..twin };
    [
        (twin, 650.558_729, 626.506_0),
        (SampledWall { delay_s: late, ..twin }, 220.881_445, 208.835_3),
        (SampledWall { delay_s: late, ..damped }, 328.583_824, 369.477_9),
        (damped, 987.680_017, 1_108.433_7),
        (SampledWall { mass_kg: 0.02, ..twin }, 760.727_062, 626.506_0),
    ]
}

fn stiffest(wall: &SampledWall) -> f64 {
    wall.stiffest_stable().unwrap().unwrap()
}

#[test]
fn the_stiffest_stable_wall_is_where_a_root_of_the_characteristic_polynomial_leaves_the_unit_circle()
 {
    for (wall, expect, _) in known() {
        let found = stiffest(&wall);
        assert!((found / expect - 1.0).abs() < 1e-8, "{wall:?}: {found}, not {expect}");
    }
}

/// Jury's conditions on z² + (g₁ K − 1 − e) z + e + g₀ K: without delay and damper it is the last
/// coefficient that reaches 1, at K = (1 − e)/g₀ with g₀ = (φ − e T)/b.
#[test]
fn without_delay_and_damper_jury_s_condition_gives_it_in_closed_form() {
    for (mass_kg, b, period_s) in [(0.0972, 2.6, 8.3e-3), (0.02, 2.6, 8.3e-3), (1.0, 0.3, 1e-3)] {
        let e = libm::exp(-b / mass_kg * period_s);
        let g0 = ((1.0 - e) * mass_kg / b - e * period_s) / b;
        let found = stiffest(&SampledWall::bare(mass_kg, b, period_s));
        assert!((found * g0 / (1.0 - e) - 1.0).abs() < 1e-8, "{found}");
    }
}

#[test]
fn the_textbook_is_safe_for_a_spring_and_unsafe_for_a_damped_wall_that_acts_late() {
    for (wall, exact, expect) in known() {
        let found = Textbook::Delay.stiffest(&wall, None).unwrap();
        assert!((found / expect - 1.0).abs() < 1e-6, "{found}, not {expect}");
        assert_eq!(found > exact, wall.wall_damping_ns_per_m > 0.0);
    }
}

#[test]
fn the_simulated_loop_has_the_boundary_of_the_lifted_map() {
    let finger = RidingFinger { mass_kg: 0.02, stiffness_n_per_m: 584.6, damping_ns_per_m: 1.53 };
    let walls = known().map(|(wall, ..)| wall);
    let more = [
        SampledWall { delay_s: 0.4 * twin().period_s, ..walls[3] },
        SampledWall { delay_s: 1.7 * twin().period_s, ..walls[3] },
        SampledWall { motor_lag_s: Some(2e-3), ..walls[0] },
        SampledWall { velocity_lag_s: Some(0.02), ..walls[2] },
        SampledWall { finger: Some(finger), ..walls[0] },
    ];
    for wall in walls.iter().chain(&more) {
        let measured = wall.stiffest_measured(3000, 1e-3).unwrap().unwrap();
        let exact = stiffest(wall);
        assert!((measured / exact - 1.0).abs() < 5e-3, "{wall:?}: {measured}, not {exact}");
    }
}

#[test]
fn passivity_asks_for_half_a_period_of_stiffness_and_the_wall_s_damping_either_way() {
    for wall_b in [-1.5, 0.0, 0.4, 2.0] {
        let wall =
            SampledWall { stiffness_n_per_m: 300.0, wall_damping_ns_per_m: wall_b, ..twin() };
        let expect = 300.0 * 0.5 * 8.3e-3 + f64::abs(wall_b);
        let found = wall.damping_for_passivity().unwrap();
        assert!((found / expect - 1.0).abs() < 1e-7, "B = {wall_b}: {found}, not {expect}");
    }
}

#[test]
fn each_period_of_delay_asks_for_another_period_of_stiffness() {
    for ticks in 0..4_u32 {
        let delay_s = f64::from(ticks) * 8.3e-3;
        let wall = SampledWall { stiffness_n_per_m: 100.0, delay_s, ..twin() };
        let expect = f64::from(2 * ticks + 1) * 100.0 * 0.5 * 8.3e-3;
        let found = wall.damping_for_passivity().unwrap();
        assert!((found / expect - 1.0).abs() < 1e-7, "{ticks}: {found}, not {expect}");
        let stiffest = wall.stiffest_passive().unwrap();
        assert!((stiffest / (2.6 * 100.0 / expect) - 1.0).abs() < 1e-7, "{stiffest}");
    }
}

#[test]
fn what_is_passive_is_stable() {
    for period_s in [1e-3, 8.3e-3] {
        for wall_b in [0.0, 0.5, 2.0] {
            let wall = SampledWall { wall_damping_ns_per_m: wall_b, period_s, ..twin() };
            assert!(wall.stiffest_passive().unwrap() <= stiffest(&wall) * (1.0 + 1e-9));
        }
    }
}

/// RK4 of λ = −1000/s is stable up to hλ = −2.785294; symplectic Euler of a damped mass up to b h/m
/// = 2.
#[test]
fn a_solver_s_step_is_stable_up_to_its_method_s_limit() {
    let wall = SampledWall { wall_damping_ns_per_m: 0.0, ..SampledWall::bare(0.01, 10.0, 1e-3) };
    for (name, limit) in [("rk4_per_step", 2.785_293_6e-3), ("symplectic_euler", 2e-3)] {
        let named = NAMED_SOLVERS.iter().find(|named| named.name == name).unwrap();
        let solver = (named.make)(1e-9);
        let growth = |step_s: f64| wall.step_growth(solver.as_ref(), step_s).unwrap();
        assert!(growth(0.999 * limit) <= 1.0 + 1e-6, "{name}");
        assert!(growth(1.001 * limit) > 1.0 + 1e-4, "{name}: {}", growth(1.001 * limit));
    }
    let exact = (NAMED_SOLVERS[0].make)(1e-9);
    assert_eq!(wall.step_growth(exact.as_ref(), 1.0), None);
}

#[test]
fn a_wall_that_makes_no_sense_is_named() {
    let late = SampledWall { delay_s: 1.0, ..twin() };
    let error = late.stiffest_stable().unwrap_err().to_string();
    assert!(error.contains("delay_s is 1") && error.contains("25 periods"), "{error}");
    let none = SampledWall { mass_kg: f64::NAN, ..twin() };
    assert!(none.stiffest_stable().unwrap_err().to_string().contains("mass_kg is NaN"));
}

/// The simulated device with its friction, an endless motor and an angle that is not counted.
fn pushed(push_m: f64) -> PushedWall {
    PushedWall {
        wall: SampledWall::bare(0.0972, 2.6, 8.3e-3),
        static_n: 0.2,
        kinetic_n: 0.15,
        motor_n: 1e6,
        brake_n: 13.0,
        mode: DriveMode::Active,
        count_m: 0.0,
        count_zero: 0.0,
        push_m,
    }
}

/// The stiffest wall by the describing function of friction: K T/2 = b + 4 F_c/(π ω A), ω² = K/m,
/// for a spring (B = 0) without delay; good to some tenths.
fn by_describing_function(pushed: &PushedWall) -> f64 {
    const ROUNDS: u32 = 200;
    let (wall, half_s) = (&pushed.wall, 0.5 * pushed.wall.period_s);
    // The right side falls as K rises: the mean of both sides closes in.
    (0..ROUNDS).fold(1.0 / half_s, |k, _| {
        let omega = (k / wall.mass_kg).sqrt();
        let friction = 4.0 * pushed.kinetic_n / (PI * omega * pushed.push_m);
        0.5 * (k + (wall.damping_ns_per_m + friction) / half_s)
    })
}

/// Found apart from this code, piece by piece in closed form between ticks.
#[test]
fn a_small_push_bears_a_stiffer_wall_and_a_large_one_that_of_the_lifted_map() {
    for (push_m, expect) in
        [(0.5e-3, 1542.2), (1e-3, 1148.4), (2e-3, 921.9), (5e-3, 767.7), (20e-3, 681.4)]
    {
        let found = pushed(push_m).stiffest(1500, 1e-4).unwrap().unwrap();
        assert!((found / expect - 1.0).abs() < 2e-3, "{push_m}: {found}, not {expect}");
        let formula = by_describing_function(&pushed(push_m));
        assert!((formula / found - 1.0).abs() < 0.15, "{push_m}: {formula}, not {found}");
    }
}

#[test]
fn a_brake_alone_never_swings_and_a_motor_that_saturates_says_so() {
    let passive = PushedWall { mode: DriveMode::Passive, ..pushed(5e-3) }.with_stiffness(1e5);
    assert!(!passive.push(400).unwrap().goes_on);
    let weak = PushedWall { motor_n: 4.16, ..pushed(5e-3) };
    let run = weak.with_stiffness(900.0).push(400).unwrap();
    assert!(run.saturates && run.goes_on && run.swing_m < 0.1, "{run:?}");
    assert!(!weak.with_stiffness(700.0).push(400).unwrap().saturates);
}
