//! The metrics that this stage requests by name. A test of `plan` checks that they exist.

use crate::thesis::statement_metrics;
use zwidth_results::RecordedStability;

pub(crate) const STABILITY: &str = "recorded_stability";
/// The word of a trial that did not swing fast.
pub(crate) const SMOOTH: &str = RecordedStability::Smooth.as_str();
pub(crate) const STIFFNESS: &str = "stiffness_n_per_rad";
pub(crate) const SATURATION: &str = "saturation_force_n";
pub(crate) const USER_STEP: &str = "discrepancy_user_step_n";
pub(crate) const ACTUATOR_STEP: &str = "discrepancy_actuator_step_n";
pub(crate) const RETURNED: &str = "returned_energy_share";
pub(crate) const PAST_WALL: &str = "wall_past_max_rad";
pub(crate) const RIGIDITY: &str = "wall_rigidity_n_per_rad";
pub(crate) const RIGIDITY_AT_LEAST: &str = "wall_rigidity_at_least";
pub(crate) const HOLD_RIGIDITY: &str = "wall_hold_rigidity_min_n_per_rad";
pub(crate) const CONTACTS: &str = "wall_contacts";
pub(crate) const CONTACTS_ACTIVE: &str = "wall_contacts_active";
pub(crate) const LOOPS: &str = "closed_loops";
pub(crate) const LOOPS_ACTIVE: &str = "closed_loops_active";
pub(crate) const ENERGY: &str = "electrical_energy_j";
pub(crate) const ENERGY_AT_MOST: &str = "electrical_energy_max_j";
pub(crate) const FORCE_PER_POWER: &str = "force_per_power_recorded_n_per_w";

/// What sentences, pros and cons, and the page need, besides the metrics that are compared and
/// those that the thesis' statements need.
const NEEDED: [&str; 17] = [
    STABILITY,
    STIFFNESS,
    SATURATION,
    USER_STEP,
    ACTUATOR_STEP,
    RETURNED,
    PAST_WALL,
    RIGIDITY,
    RIGIDITY_AT_LEAST,
    HOLD_RIGIDITY,
    CONTACTS,
    CONTACTS_ACTIVE,
    LOOPS,
    LOOPS_ACTIVE,
    ENERGY,
    ENERGY_AT_MOST,
    FORCE_PER_POWER,
];

/// The metrics that are used, whatever is compared: a third of them, which saves memory if there
/// are many trials.
pub fn metric_columns() -> Vec<&'static str> {
    NEEDED.into_iter().chain(statement_metrics()).collect()
}
