//! The metrics that this stage requests by name. A test of `plan` checks that they exist.

use crate::thesis::statement_metrics;
use zwidth_results::RecordedStability;

/// The word of a trial that did not swing fast.
pub(crate) const SMOOTH: &str = RecordedStability::Smooth.as_str();

/// A constant for each metric, and the list of them all.
macro_rules! needed {
    ($($name:ident = $metric:literal,)*) => {
        $(pub(crate) const $name: &str = $metric;)*
        const NEEDED: &[&str] = &[$($name),*];
    };
}

// What sentences, pros and cons, and the page need, besides the metrics that are compared and
// those that the thesis' statements need.
needed! {
    STABILITY = "recorded_stability",
    STIFFNESS = "stiffness_n_per_rad",
    SATURATION = "saturation_force_n",
    USER_STEP = "discrepancy_user_step_n",
    ACTUATOR_STEP = "discrepancy_actuator_step_n",
    RETURNED = "returned_energy_share",
    PAST_WALL = "wall_past_max_rad",
    RIGIDITY = "wall_rigidity_n_per_rad",
    RIGIDITY_AT_LEAST = "wall_rigidity_at_least",
    HOLD_RIGIDITY = "wall_hold_rigidity_min_n_per_rad",
    CONTACTS = "wall_contacts",
    CONTACTS_ACTIVE = "wall_contacts_active",
    LOOPS = "closed_loops",
    LOOPS_ACTIVE = "closed_loops_active",
    ENERGY = "electrical_energy_j",
    ENERGY_AT_MOST = "electrical_energy_max_j",
    FORCE_PER_POWER = "force_per_power_recorded_n_per_w",
}

/// The metrics that are used, whatever is compared: a third of them, which saves memory if there
/// are many trials.
pub fn metric_columns() -> Vec<&'static str> {
    NEEDED.iter().copied().chain(statement_metrics()).collect()
}
