//! The statements of the thesis' §5.3.1–§5.3.3, §5.4, §6.1, §6.2 and §6.2.1, in the order of its
//! text, and of Fig. 24, on which §6.1 rests.

use crate::evidence::Place::{self, Spring, Wall};
use crate::thesis::forces;
use crate::thesis::rule::{Bound, Case, FORCE_JND, From, Quantity, Rule, Statement, Test};
use core::f64::consts::PI;
use zwidth_study::ModeLaw::{self, Active, Hybrid, Passive};

/// The smallest change of a finger joint's angle that can be told: 2.5° (Tan, Srinivasan, Eberman &
/// Cheng 1994, ASME DSC 55-1:353), taken for the lever's angle.
const ANGLE_JND_RAD: f64 = degrees(2.5);
/// From here on a lever that does not move stands still and does not merely turn: a press of 77°
/// that takes 2 s is below 5°/s for 26 ms where it turns. Assumed: no source says from when on
/// people call it standing.
const STANDS_S: f64 = 0.1;

/// From this force on the just noticeable difference is 7 % of it, N (Pang, Tan & Durlach 1991).
const LEAST_FORCE_N: f64 = 2.5;
/// A model misses a velocity from this share of its range on: assumed.
const VELOCITY_MISSED: f64 = 0.1;

const JND: &str = "just noticeable difference of a finger joint's angle (Tan 1994)";
const DIGITS: &str = "the digits that the thesis gives";
const ANGLES: &str = "as read off the thesis' figure, to ±5°";
const ABOVE_NOTHING: &str = "any difference that way round";
const STANDING: &str = "longer than a turn takes (assumed)";
const NOT_STANDING: &str = "no longer than a turn takes (assumed)";
const RETURNED_NOTHING: &str = "a released lever moves on a little";

const fn degrees(degrees: f64) -> f64 {
    degrees * PI / 180.0
}

const fn metric(words: &'static str, column: &'static str, unit: &'static str) -> Quantity {
    Quantity { words, from: From::Metrics, column, less: None, unit }
}

const fn replayed(words: &'static str, column: &'static str, unit: &'static str) -> Quantity {
    Quantity { words, from: From::Replays, column, less: None, unit }
}

const STIFFNESS: Quantity =
    metric("rendered stiffness, compressing", "stiffness_n_per_rad", "N/rad");
const SATURATION: Quantity = metric("force at which it flattens", "saturation_force_n", "N");
const DISCREPANCY: Quantity =
    metric("the user's force discrepancy", "discrepancy_user_mean_n", "N");
const STEP: Quantity =
    metric("the user's force discrepancy, at the reversal", "discrepancy_user_step_n", "N");
const ACTUATORS: Quantity =
    metric("the actuators' force discrepancy", "discrepancy_actuator_mean_n", "N");
const ACTUATORS_STEP: Quantity =
    metric("the actuators' force discrepancy, at the reversal", "discrepancy_actuator_step_n", "N");
const LARGEST_ANGLE: Quantity = metric("largest angle", "theta_max_rad", "rad");
const RETURNED: Quantity = metric("share of the work given back", "returned_energy_share", "1");
const WAY_IN: Quantity =
    Quantity { less: Some("onset_s"), ..metric("time from onset to reversal", "reversal_s", "s") };
const WAY_BACK: Quantity =
    Quantity { less: Some("reversal_s"), ..metric("time from reversal to end", "end_s", "s") };
const PAST: Quantity = metric("largest angle past the wall", "wall_past_max_rad", "rad");
const STILL: Quantity = metric("longest stand past the wall", "wall_still_s", "s");
const RISE: Quantity = metric("rise of the force past the wall", "wall_force_rise_n", "N");
const RETURN_FORCE: Quantity = metric("force where the return begins", "return_force_n", "N");
const RELEASES: Quantity =
    metric("trials in which the brake lets go more than once", "wall_brake_releases", "1");
const PEAK_ERROR: Quantity =
    replayed("largest angle, model less recording", "peak_error_rad", "rad");
const PEAK_TIME_ERROR: Quantity =
    replayed("time of the largest angle, model less recording", "peak_time_error_s", "s");
const VELOCITY_SD: Quantity =
    replayed("SD of the model's velocity over that recorded", "velocity_sd_ratio", "1");
const VELOCITY_ERROR: Quantity =
    replayed("error of the model's velocity over its range", "velocity_nrmse", "1");

const WITHIN_JND: Bound = Bound::Given(-ANGLE_JND_RAD, ANGLE_JND_RAD, JND);
const UNFELT: Bound = Bound::Given(
    -FORCE_JND * LEAST_FORCE_N,
    FORCE_JND * LEAST_FORCE_N,
    "7 % of 2.5 N, the smallest force for which that is the just noticeable difference (Pang 1991)",
);
const POSITIVE: Bound = Bound::Given(0.0, f64::INFINITY, ABOVE_NOTHING);
const NEGATIVE: Bound = Bound::Given(f64::NEG_INFINITY, 0.0, ABOVE_NOTHING);
const NOTHING: Bound = Bound::Given(f64::NEG_INFINITY, 0.01, RETURNED_NOTHING);
const SOMETHING: Bound = Bound::Given(0.01, f64::INFINITY, RETURNED_NOTHING);
const STANDS: Bound = Bound::Given(STANDS_S, f64::INFINITY, STANDING);
const SMOOTH: Test = Test::Every("trials without fast swings", "recorded_stability", "smooth");

const fn of(
    law: ModeLaw,
    place: Place,
    key: &'static str,
    source: &'static str,
    text: &'static str,
    test: Test,
) -> Statement {
    whole(key, source, text, Rule::In((law, place), test))
}

const fn whole(
    key: &'static str,
    source: &'static str,
    text: &'static str,
    rule: Rule,
) -> Statement {
    Statement { key, source, text, rule, printed: false }
}

impl Statement {
    /// The same, whose number is of the thesis' own spring and voltages.
    const fn printed(self) -> Self {
        Self { printed: true, ..self }
    }
}

const ACTIVE_SPRING: Case = (Active, Spring);
const ACTIVE_WALL: Case = (Active, Wall);

#[rustfmt::skip]
pub(crate) const ALL: &[Statement] = &[
    of(Active, Spring, "active_renders", "§5.3.1.1", "The motor renders the spring as long as its force reaches", Test::Mean(STIFFNESS, Bound::Compliance)),
    of(Active, Spring, "active_flattens", "§5.3.1.1", "The motor's force flattens at about 4 N", Test::Mean(SATURATION, Bound::Given(3.5, 4.5, DIGITS))).printed(),
    of(Active, Spring, "active_discrepancy", "§5.3.1.1", "With the motor, too, the user's force on the way in is above that on the way back", Test::Mean(DISCREPANCY, POSITIVE)),
    of(Active, Spring, "active_smooth", "§5.3.1.1", "With the motor the lever moves smoothly", SMOOTH),
    of(Passive, Spring, "passive_renders", "§5.3.1.2", "The brake renders the spring on the way in", Test::Mean(STIFFNESS, Bound::Compliance)),
    of(Passive, Spring, "passive_smooth", "§5.3.1.2", "With the brake the lever moves smoothly", SMOOTH),
    of(Passive, Spring, "passive_covers", "§5.3.1.2", "The brake covers all forces of the spring", Test::Never(SATURATION)),
    of(Passive, Spring, "passive_no_return", "§5.3.1.2", "With the brake there is no way back", Test::Mean(RETURNED, NOTHING)),
    of(Passive, Spring, "passive_stops", "§5.3.1.2", "With the brake the lever stops at about 40°", Test::Mean(LARGEST_ANGLE, Bound::Given(degrees(35.0), degrees(45.0), ANGLES))).printed(),
    of(Hybrid, Spring, "hybrid_like_active", "§5.3.1.3", "The displacement of the hybrid is almost identical to the motor's", Test::Difference(LARGEST_ANGLE, ACTIVE_SPRING, WITHIN_JND)),
    of(Hybrid, Spring, "hybrid_discrepancy", "§5.3.1.3", "At the reversal the force falls by more with the hybrid than with the motor", Test::Difference(STEP, ACTIVE_SPRING, POSITIVE)),
    of(Hybrid, Spring, "hybrid_turns", "§5.3.1.3", "The hybrid turns at about 32°", Test::Mean(LARGEST_ANGLE, Bound::Given(degrees(27.0), degrees(37.0), ANGLES))).printed(),
    of(Hybrid, Spring, "hybrid_slower_return", "§5.3.1.3", "The way back takes longer with the hybrid than with the motor", Test::Difference(WAY_BACK, ACTIVE_SPRING, POSITIVE)),
    of(Hybrid, Spring, "hybrid_earlier_reversal", "§5.3.1.3", "The hybrid turns earlier than the motor", Test::Difference(WAY_IN, ACTIVE_SPRING, NEGATIVE)),
    of(Active, Wall, "active_passes", "§5.3.2.1", "The motor lets the lever past the wall", Test::Mean(PAST, Bound::Given(ANGLE_JND_RAD, f64::INFINITY, JND))),
    whole("motor_force", "§5.3.2.1", "At 16 V the motor gives 4.16 N", Rule::Forces(forces::motor_as_in_the_thesis)),
    of(Active, Wall, "active_never_settles", "§5.3.2.1", "With the motor the velocity never settles at the wall", Test::Mean(STILL, Bound::Given(f64::NEG_INFINITY, STANDS_S, NOT_STANDING))),
    of(Active, Wall, "active_as_without", "§5.3.2.1", "With the motor the displacement is as it is without the wall", Test::Difference(LARGEST_ANGLE, ACTIVE_SPRING, WITHIN_JND)),
    whole("spooling_up", "§5.3.2.1", "A strong enough motor would not feel like a wall either, for it must spool up", Rule::Untold("no motor strong enough to hold the wall was used")),
    of(Passive, Wall, "passive_stands", "§5.3.2.2", "With the brake the lever stands at the wall", Test::Mean(STILL, STANDS)),
    of(Passive, Wall, "passive_force_rises", "§5.3.2.2", "With the brake the force rises at the wall", Test::Mean(RISE, Bound::ForceAtWall)),
    of(Passive, Wall, "passive_holds", "§5.3.2.2", "With the brake the lever does not move on at the wall", Test::Mean(PAST, Bound::Given(f64::NEG_INFINITY, ANGLE_JND_RAD, JND))),
    whole("force_below_brake", "§5.3.2.2", "The force on the wall never exceeds the brake's", Rule::Forces(forces::wall_below_brake)),
    of(Passive, Wall, "passive_no_return_wall", "§5.3.2.2", "With the brake there is no way back from the wall", Test::Mean(RETURNED, NOTHING)),
    of(Hybrid, Wall, "hybrid_stands", "§5.3.2.3", "With the hybrid the lever stands at the wall", Test::Mean(STILL, STANDS)),
    of(Hybrid, Wall, "hybrid_force_rises", "§5.3.2.3", "With the hybrid the force rises at the wall", Test::Mean(RISE, Bound::ForceAtWall)),
    of(Hybrid, Wall, "hybrid_slightly_past", "§5.3.2.3", "With the hybrid the lever goes slightly past the wall", Test::Mean(PAST, Bound::Given(0.0, ANGLE_JND_RAD, JND))),
    of(Hybrid, Wall, "hybrid_return_force", "§5.3.2.3", "The hybrid's return begins when the user's force is below about 2 N", Test::Mean(RETURN_FORCE, Bound::Given(f64::NEG_INFINITY, 2.5, DIGITS))).printed(),
    of(Hybrid, Wall, "hybrid_returns", "§5.3.2.3", "With the hybrid the lever comes back from the wall", Test::Mean(RETURNED, SOMETHING)),
    of(Hybrid, Wall, "hybrid_smooth_wall", "§5.3.2.3", "With the hybrid the lever moves smoothly at the wall", SMOOTH),
    of(Hybrid, Wall, "hybrid_slower_return_wall", "§5.3.2.3", "From the wall, too, the way back takes longer with the hybrid than with the motor", Test::Difference(WAY_BACK, ACTIVE_WALL, POSITIVE)),
    whole("passive_renders_neither", "§5.3.3", "The brake renders neither environment there and back", Rule::All(&["passive_no_return", "passive_no_return_wall"])),
    whole("active_to_some_extent", "§5.3.3", "The motor renders the spring until its force flattens, and not the wall", Rule::All(&["active_renders", "active_flattens", "active_passes"])),
    of(Hybrid, Spring, "hybrid_renders", "§5.3.3", "The hybrid renders the spring on the way in", Test::Mean(STIFFNESS, Bound::Compliance)),
    of(Hybrid, Spring, "hybrid_smooth", "§5.3.3", "With the hybrid nothing swings in the spring", SMOOTH),
    of(Hybrid, Spring, "hybrid_returns_spring", "§5.3.3", "With the hybrid the spring gives work back", Test::Mean(RETURNED, SOMETHING)),
    whole("hybrid_renders_both", "§5.3.3", "The hybrid renders both environments and does not swing", Rule::All(&["hybrid_renders", "hybrid_returns_spring", "hybrid_smooth", "hybrid_stands", "hybrid_slightly_past", "hybrid_returns", "hybrid_smooth_wall"])),
    of(Active, Spring, "active_above_hybrid", "§5.4", "In the spring people rank the motor above the hybrid", Test::Superior(Hybrid)),
    of(Hybrid, Spring, "hybrid_above_passive", "§5.4", "In the spring people rank the hybrid above the brake", Test::Superior(Passive)),
    of(Hybrid, Wall, "hybrid_above_active_wall", "§5.4", "At the wall people rank the hybrid above the motor", Test::Superior(Active)),
    of(Hybrid, Wall, "hybrid_above_passive_wall", "§5.4", "At the wall people rank the hybrid above the brake", Test::Superior(Passive)),
    whole("mechanics_against_perception", "§5.4", "By its mechanics the hybrid is as good as the motor in the spring, by perception it is not", Rule::All(&["hybrid_like_active", "active_above_hybrid"])),
    of(Hybrid, Spring, "hybrid_conveys_spring", "§5.4", "The hybrid conveys the spring", Test::Median { favourable: true }),
    of(Hybrid, Wall, "hybrid_conveys_wall", "§5.4", "The hybrid conveys spring and wall", Test::Median { favourable: true }),
    of(Passive, Spring, "passive_fails_spring", "§5.4", "The brake does not convey the spring", Test::Median { favourable: false }),
    of(Active, Wall, "active_fails_wall", "§5.4", "The motor does not convey spring and wall", Test::Median { favourable: false }),
    of(Passive, Wall, "passive_fails_wall", "§5.4", "The brake does not convey spring and wall", Test::Median { favourable: false }),
    of(Active, Spring, "model_true_active", "§6.1", "Given the recorded force, the model is mostly true to life (motor)", Test::Mean(PEAK_ERROR, WITHIN_JND)),
    of(Passive, Spring, "model_true_passive", "§6.1", "Given the recorded force, the model is mostly true to life (brake)", Test::Mean(PEAK_ERROR, WITHIN_JND)),
    of(Hybrid, Spring, "model_true_hybrid", "§6.1", "Given the recorded force, the model is mostly true to life (hybrid)", Test::Mean(PEAK_ERROR, WITHIN_JND)),
    of(Hybrid, Spring, "model_in_time", "Fig. 24", "The model reaches its largest angle at a similar time", Test::Mean(PEAK_TIME_ERROR, Bound::Given(-0.1, 0.1, "a tenth of a second: assumed"))),
    of(Hybrid, Spring, "model_velocity_varies", "Fig. 24", "The model's velocity varies more than the recorded one", Test::Mean(VELOCITY_SD, Bound::Given(1.0, f64::INFINITY, "more than the recording's"))),
    of(Hybrid, Spring, "model_misses_velocity", "§4.3, Abstract", "The model at times misses the velocity", Test::Some(Quantity { words: "trials whose velocity is off by more than a tenth of its range", ..VELOCITY_ERROR }, VELOCITY_MISSED)),
    whole("model_needs_its_device", "§6.1", "Given other data than the device's, the model may be wrong", Rule::Untold("the model is given this study's own forces alone")),
    of(Hybrid, Wall, "wall_lets_go", "§6.2.1", "Sometimes the brake lets go at the wall and the lever goes on", Test::Some(Quantity { words: "trials that go further past the wall than can be felt", ..PAST }, ANGLE_JND_RAD)),
    of(Hybrid, Wall, "brake_lets_go_again", "§6.2.1", "Sometimes the brake lets go at the wall again and again", Test::Some(RELEASES, 1.0)),
    whole("short_of_brake", "§6.2.1", "At its rated 48 V the motor's 12 N would still be below the brake's force", Rule::Forces(forces::below_brake)),
    whole("short_of_wall", "§6.2.1", "At its rated 48 V the motor's 12 N would still not hold the wall", Rule::Forces(forces::below_wall)),
    of(Active, Spring, "motor_differs_by_nothing", "Appendix B", "A motor alone gives the same force both ways, so that the actuators differ by less than can be felt", Test::Mean(ACTUATORS, UNFELT)),
    of(Hybrid, Spring, "actuators_differ", "Appendix B", "With two actuators of unlike strength the actuators' force falls where the motion turns", Test::Mean(ACTUATORS_STEP, POSITIVE)),
    whole("lighter", "§6.2.1, Appendix A", "A hybrid could weigh less than a motor alone", Rule::Forces(forces::weight)),
];

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn every_statement_has_a_key_of_its_own_and_rests_on_earlier_ones_alone() {
        let mut known = BTreeSet::new();
        for statement in ALL {
            if let Rule::All(parts) = statement.rule {
                assert!(parts.iter().all(|part| known.contains(part)), "{}", statement.key);
            }
            assert!(known.insert(statement.key), "{} stands there twice", statement.key);
        }
    }
}
