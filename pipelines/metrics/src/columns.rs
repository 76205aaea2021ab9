//! The columns of the metrics: name, unit, meaning, and where each stands in a row.

use crate::{PlantMetrics, TrialMetrics};
use zwidth_numerics::spectrum::BandPower;
use zwidth_results::{ConditionTrials, RecordedStability, Row as _, TrialKey};
use zwidth_store::Signal;
use zwidth_study::{
    Better, CURRENT_BRAKE, CURRENT_MOTOR, MetricId, OutsideMetric, OwnMetric, REFERENCE, Scene,
    Score, Study, TrialPart,
};

/// Version of the algorithms here: a change of any number they give, or a further metric, raises it.
pub const VERSION: u32 = 22;

/// Where a value stands in a row.
pub(crate) enum Get<R> {
    Float(fn(&R) -> Option<f64>),
    Count(fn(&R) -> Option<i64>),
    Flag(fn(&R) -> Option<bool>),
    Word(fn(&R) -> Option<&'static str>),
}

/// A column of rows `R`.
pub(crate) struct Spec<R = TrialMetrics> {
    pub(crate) name: &'static str,
    pub(crate) unit: &'static str,
    pub(crate) description: &'static str,
    pub(crate) get: Get<R>,
    /// Whether the table of conditions has its mean and its deviation.
    pub(crate) summarised: bool,
}

const fn float<R>(
    name: &'static str,
    unit: &'static str,
    description: &'static str,
    get: fn(&R) -> Option<f64>,
) -> Spec<R> {
    Spec { name, unit, description, get: Get::Float(get), summarised: false }
}

/// A number with mean and deviation in the table of conditions.
const fn averaged<R>(
    name: &'static str,
    unit: &'static str,
    description: &'static str,
    get: fn(&R) -> Option<f64>,
) -> Spec<R> {
    Spec { name, unit, description, get: Get::Float(get), summarised: true }
}

const fn count<R>(
    name: &'static str,
    description: &'static str,
    get: fn(&R) -> Option<i64>,
) -> Spec<R> {
    Spec { name, unit: "1", description, get: Get::Count(get), summarised: false }
}

const fn flag<R>(
    name: &'static str,
    description: &'static str,
    get: fn(&R) -> Option<bool>,
) -> Spec<R> {
    Spec { name, unit: "1", description, get: Get::Flag(get), summarised: false }
}

const fn word<R>(
    name: &'static str,
    description: &'static str,
    get: fn(&R) -> Option<&'static str>,
) -> Spec<R> {
    Spec { name, unit: "1", description, get: Get::Word(get), summarised: false }
}

/// Every metric, in the order of the table; `docs/analysis.md` defines each by its name. Below, one
/// line is one column.
pub(crate) const GROUPS: [&[Spec]; 9] =
    [MOVEMENT, FORCE, COMPLIANCE, DISCREPANCY, SPRING, WALL, STABILITY, ELECTRICITY, STEP];

/// Those that rest on the plant, likewise.
pub(crate) const PLANT_GROUPS: [&[Spec<PlantMetrics>]; 2] = [ACTUATORS, ENERGY];

/// A study's own metrics, but for those whose name is taken: what is told of those ([`taken`]) is that
/// they are left out.
pub fn own(study: &Study) -> impl Iterator<Item = &OwnMetric> {
    study.metrics.iter().filter(|own| !is_taken(own.id.as_str()))
}

fn own_of<'a>(study: &'a Study, metric: &str) -> Option<&'a OwnMetric> {
    own(study).find(|own| own.id.as_str() == metric)
}

/// A study's own metrics whose names tables have for something else.
pub fn taken(study: &Study) -> impl Iterator<Item = &MetricId> {
    study.metrics.iter().map(|own| &own.id).filter(|id| is_taken(id.as_str()))
}

/// The metrics that other programs computed, but for those whose columns the study has by a rule of its own.
pub fn outside(study: &Study) -> impl Iterator<Item = &OutsideMetric> {
    study.outside().filter(|outside| own_of(study, outside.column.as_str()).is_none())
}

fn outside_of<'a>(study: &'a Study, metric: &str) -> Option<&'a OutsideMetric> {
    outside(study).find(|outside| outside.column.as_str() == metric)
}

/// Whether tables of metrics have a column of that name anyhow.
pub(crate) fn is_taken(name: &str) -> bool {
    let of_trial = GROUPS.into_iter().flatten().map(|spec| spec.name);
    let of_plant = PLANT_GROUPS.into_iter().flatten().map(|spec| spec.name);
    let (trial, condition) = (TrialKey::fields(), ConditionTrials::fields());
    let mut keys = trial.iter().chain(&condition).map(|field| &*field.name);
    of_trial.chain(of_plant).any(|taken| taken == name) || keys.any(|taken| taken == name)
}

/// The scores of a study, by the metrics as which they are compared.
pub fn scores(study: &Study) -> impl Iterator<Item = (MetricId, &Score)> {
    study.scores.iter().filter_map(|score| Some((score.metric().ok()?, score)))
}

/// The score that is compared as that metric.
pub fn score_of<'a>(study: &'a Study, metric: &str) -> Option<&'a Score> {
    let id = metric.strip_prefix("score_")?;
    study.scores.iter().find(|score| score.id.as_str() == id)
}

/// Whether a study has a metric of that name that is a number with a unit.
pub fn is_number(study: &Study, metric: &str) -> bool {
    names(study).any(|name| name == metric)
}

/// The names of all metrics that can be compared: zwidth's in the order of the table, the study's own, those of other
/// programs, scores, and what tasks tell.
pub fn names(study: &Study) -> impl Iterator<Item = String> {
    let of_trials = numbers().map(|(name, _)| name).chain(own(study).map(|own| own.id.as_str()));
    let of_trials = of_trials.chain(outside(study).map(|outside| outside.column.as_str()));
    let of_answers = scores(study).map(|(metric, _)| metric);
    let of_answers = of_answers.chain(study.task_metrics().map(|(metric, ..)| metric));
    of_trials.map(str::to_owned).chain(of_answers.map(|metric| metric.to_string()))
}

/// Whether a metric is made of answers, and not of the samples of trials: a score, or what can be felt by a task.
pub fn is_of_answers(study: &Study, metric: &str) -> bool {
    score_of(study, metric).is_some() || study.task_metric(metric).is_some()
}

/// Whether a metric rests on the plant that all trials together identify.
pub fn is_of_plant(metric: &str) -> bool {
    PLANT_GROUPS.into_iter().flatten().any(|spec| spec.name == metric)
}

/// What a metric measures, in words; `None` if there is none of that name that is a number.
pub fn in_words(study: &Study, metric: &str) -> Option<String> {
    if let Some(own) = own_of(study, metric) {
        return Some(format!("{}: {}", own.label, own.rule()));
    }
    if let Some(outside) = outside_of(study, metric) {
        return Some(outside.in_words());
    }
    if let Some(score) = score_of(study, metric) {
        return Some(score.in_words());
    }
    if let Some((task, quantity)) = study.task_metric(metric) {
        return Some(task.metric_in_words(quantity));
    }
    let of_trial = GROUPS.into_iter().flatten().map(|spec| (spec.name, spec.description));
    let of_plant = PLANT_GROUPS.into_iter().flatten().map(|spec| (spec.name, spec.description));
    let found = of_trial.chain(of_plant).find(|(name, _)| *name == metric);
    found.map(|(_, words)| words.to_owned())
}

/// Whether a metric describes something that a person could feel ([`zwidth_study::is_felt`]).
pub fn is_felt(own: &[OwnMetric], metric: &str) -> bool {
    match own.iter().find(|own| own.id.as_str() == metric) {
        Some(own) => own.is_felt(),
        None => zwidth_study::is_felt(metric),
    }
}

/// Errors, swings, wear: the lower, the better.
const LOWER_IS_BETTER: [&str; 16] = [
    "discrepancy_user_mean_n",
    "discrepancy_user_max_n",
    "discrepancy_user_step_n",
    "discrepancy_actuator_mean_n",
    "discrepancy_actuator_max_n",
    "discrepancy_actuator_step_n",
    "force_rms_error_n",
    "wall_past_max_rad",
    "wall_depth_m",
    "oscillation_amplitude_rad",
    "force_band_rms_n",
    "electrical_energy_j",
    "electrical_energy_max_j",
    "step_rise_s",
    "step_overshoot_share",
    "step_settling_s",
];

/// Smoothness, rigidity of a wall, force for its power: the higher, the better.
const HIGHER_IS_BETTER: [&str; 7] = [
    "sparc_forward",
    "sparc_backward",
    "wall_rigidity_n_per_rad",
    "wall_hold_rigidity_min_n_per_rad",
    "wall_stiffness_n_per_rad",
    "force_per_power_n_per_w",
    "force_per_power_recorded_n_per_w",
];

/// Which values of a metric are better; of one of zwidth's, where that does not depend on what a study wants.
pub fn better(study: &Study, metric: &str) -> Better {
    if let Some(own) = own_of(study, metric) {
        return own.better;
    }
    if let Some(outside) = outside_of(study, metric) {
        return outside.better;
    }
    if let Some(score) = score_of(study, metric) {
        return score.better();
    }
    match metric {
        _ if LOWER_IS_BETTER.contains(&metric) => Better::Lower,
        _ if HIGHER_IS_BETTER.contains(&metric) => Better::Higher,
        _ => Better::Neither,
    }
}

/// The names of all metrics of zwidth's that are numbers with a unit, and whether each is summarised.
pub(crate) fn numbers() -> impl Iterator<Item = (&'static str, bool)> {
    let of_trial = GROUPS.into_iter().flatten().filter_map(number);
    of_trial.chain(PLANT_GROUPS.into_iter().flatten().filter_map(number))
}

fn number<R>(spec: &Spec<R>) -> Option<(&'static str, bool)> {
    matches!(spec.get, Get::Float(_)).then_some((spec.name, spec.summarised))
}

/// The commanded value of a metric that measures how well the environment is rendered, in the
/// metric's unit: a spring's stiffness, in N/rad.
pub fn commanded(metric: &str, scene: &Scene) -> Option<f64> {
    let spring = scene.spring().filter(|_| metric == "stiffness_n_per_rad")?;
    Some(spring.stiffness_n_per_rad)
}

/// The metrics that rest on recorded currents.
const OF_CURRENTS: [&str; 2] = ["electrical_energy_j", "force_per_power_recorded_n_per_w"];

/// The metrics that rest on the lever's length: energies, powers and ways of the finger.
const OF_LEVER: [&str; 5] = [
    "loop_area_j",
    "wall_depth_m",
    "wall_energy_j",
    "force_per_power_n_per_w",
    "force_per_power_recorded_n_per_w",
];

/// Whether the metric needs the lever's length.
pub fn needs_lever(metric: &str) -> bool {
    OF_LEVER.contains(&metric) || is_in(ACTUATORS, metric)
}

fn is_in<R>(group: &[Spec<R>], metric: &str) -> bool {
    group.iter().any(|spec| spec.name == metric)
}

/// Whether a study's trials in such a scene, recorded with such signals, can have that metric at all.
pub fn is_possible(study: &Study, metric: &str, scene: &Scene, signals: &[Signal]) -> bool {
    let channels = &study.channels;
    let has = |needed: &[Signal]| needed.iter().all(|signal| signals.contains(signal));
    if let Some(own) = own_of(study, metric) {
        let of = &own.of;
        let is_recorded = match Signal::from_name(of) {
            Some(signal) => signals.contains(&signal),
            None => channels.iter().any(|channel| channel.id.as_str() == of),
        };
        let has_part = match own.over {
            TrialPart::Recording => true,
            TrialPart::PastWall => scene.wall_rad().is_some() && has(&[Signal::Theta]),
            TrialPart::Movement | TrialPart::Compression | TrialPart::Decompression => {
                has(&[Signal::Theta])
            }
        };
        return is_recorded && has_part;
    }
    // Which trials it is of, the program that computes it decides.
    if OutsideMetric::is_named(metric) {
        return true;
    }
    if is_in(ACTUATORS, metric) {
        scene.spring().is_some() && has(&[Signal::Theta, Signal::ForceEx])
    } else if is_in(ENERGY, metric) {
        has(&[Signal::Theta, Signal::ForceEx])
    } else if is_in(ELECTRICITY, metric) {
        let currents = [CURRENT_MOTOR, CURRENT_BRAKE];
        let current = channels.iter().any(|channel| currents.contains(&channel.id.as_str()));
        let voltage = has(&[Signal::VoltageMotor]) || has(&[Signal::VoltageBrake]);
        voltage && (current || !OF_CURRENTS.contains(&metric))
    } else if is_in(FORCE, metric) {
        has(&[Signal::ForceEx])
    } else if is_in(STEP, metric) {
        has(&[Signal::Theta]) && channels.iter().any(|channel| channel.id.as_str() == REFERENCE)
    } else if metric == "force_rms_error_n" {
        // Before the group of the spring, to which it belongs: it needs one signal more than the
        // rest.
        scene.spring().is_some() && has(&[Signal::Theta, Signal::ForceEx, Signal::ForceCmd])
    } else if is_in(DISCREPANCY, metric) || is_in(SPRING, metric) {
        scene.spring().is_some() && has(&[Signal::Theta, Signal::ForceEx])
    } else if is_in(WALL, metric) {
        scene.wall_rad().is_some() && has(&[Signal::Theta])
    } else {
        is_in(MOVEMENT, metric) || is_in(COMPLIANCE, metric) || is_in(STABILITY, metric)
    }
}

#[rustfmt::skip]
const MOVEMENT: &[Spec] = &[
    float("recording_s", "s", "length of the recording", |r| r.movement.recording_s),
    float("onset_s", "s", "first time above the onset's velocity", |r| r.movement.onset_s),
    float("reversal_s", "s", "first time of the largest angle between onset and end", |r| r.movement.reversal_s),
    float("end_s", "s", "first time below the offset's velocity after the last above the onset's", |r| r.movement.end_s),
    averaged("duration_s", "s", "duration, from onset to end", |r| r.movement.duration_s),
    averaged("theta_max_rad", "rad", "largest angle", |r| r.movement.theta_max_rad),
    float("path_rad", "rad", "path length: every way forward and back, onset to end", |r| r.movement.path_rad),
    float("velocity_forward_mean_rad_s", "rad/s", "mean speed, onset to reversal", |r| r.movement.velocity_forward_mean_rad_s),
    float("velocity_forward_peak_rad_s", "rad/s", "largest speed, onset to reversal", |r| r.movement.velocity_forward_peak_rad_s),
    float("velocity_backward_mean_rad_s", "rad/s", "mean speed, reversal to end", |r| r.movement.velocity_backward_mean_rad_s),
    float("velocity_backward_peak_rad_s", "rad/s", "largest speed, reversal to end", |r| r.movement.velocity_backward_peak_rad_s),
    averaged("sparc_forward", "1", "smoothness (spectral arc length) of the speed, onset to reversal", |r| r.movement.sparc_forward),
    averaged("sparc_backward", "1", "smoothness (spectral arc length) of the speed, reversal to end", |r| r.movement.sparc_backward),
    count("work_space_hits_low", "arrivals at the work space's lower end", |r| r.movement.work_space_hits_low),
    count("work_space_hits_high", "arrivals at the work space's upper end", |r| r.movement.work_space_hits_high),
];

#[rustfmt::skip]
const FORCE: &[Spec] = &[
    averaged("force_mean_n", "N", "the user's force, mean over the recording", |r| r.force.mean_n),
    averaged("force_largest_n", "N", "the user's force of the largest magnitude in the recording", |r| r.force.largest_n),
    float("force_rms_n", "N", "the user's force, root of its mean square over the recording", |r| r.force.rms_n),
    float("force_peak_s", "s", "time from the movement's onset to the user's force of the largest magnitude in it", |r| r.force.peak_s),
];

#[rustfmt::skip]
const COMPLIANCE: &[Spec] = &[
    count("movements_forward", "ways forward of more than a tenth of the angles travelled", |r| r.compliance.movements_forward),
    count("movements_backward", "ways back of more than a tenth of the angles travelled", |r| r.compliance.movements_backward),
    flag("protocol_one_movement", "whether there is one way forward and one back", |r| r.compliance.one_movement),
    flag("protocol_in_time", "whether the movement takes no longer than a trial may", |r| r.compliance.in_time),
    flag("protocol_inside", "whether the lever stays within the work space", |r| r.compliance.inside_work_space),
    flag("protocol_met", "whether all three hold", |r| r.compliance.met),
];

#[rustfmt::skip]
const DISCREPANCY: &[Spec] = &[
    averaged("discrepancy_user_mean_n", "N", "the user's force discrepancy, mean over the angle", |r| r.discrepancy.mean_n),
    float("discrepancy_user_mean_ci_low_n", "N", "lower end of its interval within this trial", |r| r.discrepancy.mean_ci_low_n),
    float("discrepancy_user_mean_ci_high_n", "N", "upper end of its interval within this trial", |r| r.discrepancy.mean_ci_high_n),
    float("discrepancy_user_max_n", "N", "the user's force discrepancy, largest", |r| r.discrepancy.max_n),
    averaged("discrepancy_user_step_n", "N", "the user's force discrepancy, at the reversal", |r| r.discrepancy.step_n),
    float("discrepancy_user_step_ci_low_n", "N", "lower end of its interval within this trial", |r| r.discrepancy.step_ci_low_n),
    float("discrepancy_user_step_ci_high_n", "N", "upper end of its interval within this trial", |r| r.discrepancy.step_ci_high_n),
    averaged("loop_area_j", "J", "the user's net work on the device, from onset to end", |r| r.discrepancy.loop_area_j),
    float("loop_area_ci_low_j", "J", "lower end of its interval within this trial", |r| r.discrepancy.loop_area_ci_low_j),
    float("loop_area_ci_high_j", "J", "upper end of its interval within this trial", |r| r.discrepancy.loop_area_ci_high_j),
];

#[rustfmt::skip]
const SPRING: &[Spec] = &[
    averaged("stiffness_n_per_rad", "N/rad", "rendered stiffness: slope of force on angle in compression, below saturation", |r| r.spring.stiffness_n_per_rad),
    float("stiffness_std_error_n_per_rad", "N/rad", "its standard error (Newey-West, a tenth of the samples)", |r| r.spring.stiffness_std_error_n_per_rad),
    float("stiffness_ci_low_n_per_rad", "N/rad", "lower end of its interval within this trial", |r| r.spring.stiffness_ci_low_n_per_rad),
    float("stiffness_ci_high_n_per_rad", "N/rad", "upper end of its interval within this trial", |r| r.spring.stiffness_ci_high_n_per_rad),
    float("stiffness_error_n_per_rad", "N/rad", "rendered minus commanded stiffness", |r| r.spring.stiffness_error_n_per_rad),
    float("force_at_rest_n", "N", "the line's force at the spring's rest", |r| r.spring.force_at_rest_n),
    float("stiffness_r2", "1", "R² of the line", |r| r.spring.r2),
    count("stiffness_samples", "samples of the line", |r| r.spring.samples),
    averaged("saturation_force_n", "N", "force at which the spring saturates", |r| r.spring.saturation.force_n),
    float("saturation_force_ci_low_n", "N", "lower end of its interval within this trial", |r| r.spring.saturation.force_ci_low_n),
    float("saturation_force_ci_high_n", "N", "upper end of its interval within this trial", |r| r.spring.saturation.force_ci_high_n),
    float("saturation_theta_rad", "rad", "angle from which on the spring saturates", |r| r.spring.saturation.theta_rad),
    float("saturation_theta_ci_low_rad", "rad", "lower end of its interval within this trial", |r| r.spring.saturation.theta_ci_low_rad),
    float("saturation_theta_ci_high_rad", "rad", "upper end of its interval within this trial", |r| r.spring.saturation.theta_ci_high_rad),
    averaged("force_rms_error_n", "N", "RMS of user force minus commanded force in compression", |r| r.spring.force_rms_error_n),
    averaged("return_force_n", "N", "force where the lever begins to return", |r| r.spring.return_force_n),
    averaged("returned_energy_share", "1", "work given back over work put in", |r| r.spring.returned_energy_share),
];

#[rustfmt::skip]
const WALL: &[Spec] = &[
    flag("wall_reached", "whether the wall was passed", |r| r.wall.reached),
    averaged("wall_past_max_rad", "rad", "largest angle past the wall", |r| r.wall.past_max_rad),
    float("wall_depth_m", "m", "largest depth past the wall, at the lever", |r| r.wall.past_max_m),
    averaged("wall_dwell_s", "s", "time past the wall", |r| r.wall.dwell_s),
    float("wall_impulse_n_s", "N·s", "impulse of the user's force past the wall", |r| r.wall.impulse_n_s),
    float("wall_energy_j", "J", "energy the wall takes from the user", |r| r.wall.energy_j),
    float("wall_impact_velocity_rad_s", "rad/s", "velocity where the wall is first passed", |r| r.wall.impact_velocity_rad_s),
    count("wall_rebounds", "passings of the wall after a retreat from it", |r| r.wall.rebounds),
    count("wall_brake_releases", "times the brake goes off past the wall", |r| r.wall.brake_releases),
    averaged("wall_still_s", "s", "longest time past the wall below the offset's velocity", |r| r.wall.still_s),
    float("wall_force_max_n", "N", "largest force past the wall", |r| r.wall.force_max_n),
    averaged("wall_force_rise_n", "N", "largest force past the wall less that where it is first passed", |r| r.wall.force_rise_n),
    averaged("wall_rigidity_n_per_rad", "N/rad", "growth of the force past the wall over what the lever moves past it", |r| r.wall.rigidity_n_per_rad),
    flag("wall_rigidity_at_least", "whether that is a lower bound: the lever moved by no more than a step of its sensor", |r| r.wall.rigidity_at_least),
    averaged("wall_hold_rigidity_min_n_per_rad", "N/rad", "at least: growth of the force while the lever is held past the wall over a step of its sensor", |r| r.wall.hold_rigidity_min_n_per_rad),
    float("wall_stiffness_n_per_rad", "N/rad", "slope of force on angle past the wall, on the way in", |r| r.wall.stiffness_n_per_rad),
    float("wall_stiffness_ci_low_n_per_rad", "N/rad", "lower end of its interval within this trial", |r| r.wall.stiffness_ci_low_n_per_rad),
    float("wall_stiffness_ci_high_n_per_rad", "N/rad", "upper end of its interval within this trial", |r| r.wall.stiffness_ci_high_n_per_rad),
];

#[rustfmt::skip]
const STABILITY: &[Spec] = &[
    count("motor_switches", "times the motor goes on or off", |r| r.stability.motor_switches),
    count("brake_switches", "times the brake goes on or off", |r| r.stability.brake_switches),
    count("actuator_switches", "changes of the set of actuators that are on", |r| r.stability.actuator_switches),
    count("reversals", "turns of the lever between onset and end", |r| r.stability.swings.reversals),
    count("fast_swings", "turns within a tenth of a second of the one before", |r| r.stability.swings.fast),
    word("recorded_stability", "smooth or oscillating, by the count of fast swings; what causes an oscillation a recording cannot tell", |r| {
        r.stability.swings.verdict.map(RecordedStability::as_str)
    }),
    float("oscillation_hz", "Hz", "frequency of the fast swings", |r| r.stability.swings.frequency_hz),
    float("oscillation_amplitude_rad", "rad", "median angle of the fast swings, turn to turn", |r| r.stability.swings.amplitude_rad),
    float("force_band_rms_n", "N", "root of the force's power from 5 Hz to the top of its band", |r| rms(r.stability.force_band)),
    float("force_band_dominant_hz", "Hz", "where that power is highest", |r| r.stability.force_band?.dominant_hz),
    float("force_band_top_hz", "Hz", "top of the force's band: 50 Hz or below the sensor's Nyquist frequency", |r| top(r.stability.force_band)),
    float("velocity_band_rms_rad_s", "rad/s", "root of the velocity's power from 5 Hz to the top of its band", |r| rms(r.stability.velocity_band)),
    float("velocity_band_dominant_hz", "Hz", "where that power is highest", |r| r.stability.velocity_band?.dominant_hz),
    float("velocity_band_top_hz", "Hz", "top of the velocity's band: 50 Hz or below the Nyquist frequency of the samples", |r| top(r.stability.velocity_band)),
];

#[rustfmt::skip]
const ELECTRICITY: &[Spec] = &[
    averaged("electrical_energy_j", "J", "electrical energy of the trial, from recorded currents", |r| r.electricity.taken_j),
    averaged("electrical_energy_max_j", "J", "electrical energy of the trial, at most: from voltages, resistances and motion", |r| r.electricity.bound_j),
    averaged("force_per_power_recorded_n_per_w", "N/W", "commanded force over time per electrical energy, from recorded currents", |r| r.electricity.force_per_power_recorded_n_per_w),
    averaged("force_per_power_n_per_w", "N/W", "commanded force over time per electrical energy, at least", |r| r.electricity.force_per_power_n_per_w),
];

#[rustfmt::skip]
const STEP: &[Spec] = &[
    float("step_rad", "rad", "step of the set-point", |r| r.step.step_rad),
    averaged("step_rise_s", "s", "rise time (10 % to 90 %) after a step of the set-point", |r| r.step.rise_s),
    averaged("step_overshoot_share", "1", "overshoot after a step of the set-point, as a share of the way", |r| r.step.overshoot_share),
    averaged("step_settling_s", "s", "settling time (2 %) after a step of the set-point", |r| r.step.settling_s),
    averaged("step_steady_error_rad", "rad", "steady error after a step of the set-point", |r| r.step.steady_error_rad),
];

#[rustfmt::skip]
const ACTUATORS: &[Spec<PlantMetrics>] = &[
    averaged("discrepancy_actuator_mean_n", "N", "the actuators' force discrepancy, mean over the angle", |r| r.discrepancy.mean_n),
    float("discrepancy_actuator_mean_ci_low_n", "N", "lower end of its interval within this trial", |r| r.discrepancy.mean_ci_low_n),
    float("discrepancy_actuator_mean_ci_high_n", "N", "upper end of its interval within this trial", |r| r.discrepancy.mean_ci_high_n),
    float("discrepancy_actuator_max_n", "N", "the actuators' force discrepancy, largest", |r| r.discrepancy.max_n),
    averaged("discrepancy_actuator_step_n", "N", "the actuators' force discrepancy, at the reversal", |r| r.discrepancy.step_n),
    float("discrepancy_actuator_step_ci_low_n", "N", "lower end of its interval within this trial", |r| r.discrepancy.step_ci_low_n),
    float("discrepancy_actuator_step_ci_high_n", "N", "upper end of its interval within this trial", |r| r.discrepancy.step_ci_high_n),
];

#[rustfmt::skip]
const ENERGY: &[Spec<PlantMetrics>] = &[
    count("wall_contacts", "contacts with the wall", |r| r.energy.wall_contacts),
    count("wall_contacts_active", "of them those in which the wall gave more than it had got", |r| r.energy.wall_contacts_active),
    averaged("wall_contact_energy_min_j", "J", "lowest energy observer of a contact: below 0 the wall has given", |r| r.energy.wall_contact_energy_min_j),
    count("closed_loops", "closed loops of the angle", |r| r.energy.closed_loops),
    count("closed_loops_active", "of them those over which the device gave more than it had got", |r| r.energy.closed_loops_active),
    averaged("closed_loop_energy_min_j", "J", "lowest energy observer of a closed loop: below 0 the device has given", |r| r.energy.closed_loop_energy_min_j),
];

fn rms(band: Option<BandPower>) -> Option<f64> {
    band.map(|b| b.power.sqrt())
}

fn top(band: Option<BandPower>) -> Option<f64> {
    band.map(|b| b.top_hz)
}
