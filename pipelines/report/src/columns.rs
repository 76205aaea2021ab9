//! Which columns of the table of metrics this stage looks at.

use crate::thesis::asked_metrics;

/// What sentences, pros and cons, and the page look at, besides the metrics that are compared and
/// those that the thesis' statements ask of trials.
const LOOKED_AT: [&str; 24] = [
    "participant",
    "session",
    "environment",
    "mode",
    "repeat",
    "trial",
    "source",
    "recorded_stability",
    "stiffness_n_per_rad",
    "saturation_force_n",
    "discrepancy_user_step_n",
    "discrepancy_actuator_step_n",
    "returned_energy_share",
    "wall_past_max_rad",
    "wall_rigidity_n_per_rad",
    "wall_rigidity_at_least",
    "wall_hold_rigidity_min_n_per_rad",
    "wall_contacts",
    "wall_contacts_active",
    "closed_loops",
    "closed_loops_active",
    "electrical_energy_j",
    "electrical_energy_max_j",
    "force_per_power_recorded_n_per_w",
];

/// The columns of the table of metrics that are looked at, whatever is compared: a third of them, and
/// so much less memory where there are many trials.
pub fn metric_columns() -> Vec<&'static str> {
    LOOKED_AT.into_iter().chain(asked_metrics()).collect()
}
