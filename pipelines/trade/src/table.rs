//! Trades as rows and tables, and the recommended setting as a scene file.

use crate::TradeError;
use crate::cells::Cell;
use crate::trade::{Trade, pareto_front};
use zwidth_dynamics::{FingerLaw, ModelScene};
use zwidth_results::{Gate, Row, TradeChoice, TradeSetting};
use zwidth_tables::{Table, TableError};

/// The definitions of the numbers in the table of settings; they stand with every table.
const DEFINITIONS: [&str; 5] = [
    "Errors are those of the run's own samples (at most 8,000, evenly chosen) against the yardstick at the same times.",
    "The force is the device's on the lever's end: motor, brake, friction, terms and stops; within 50 ms of its jumps nothing is compared.",
    "Shares are of what a person just feels: above 1 it is felt. Slow parts are means over 100 ms; vibration is by third octaves from 10 to 794 Hz, and 0 where it is not above the right one.",
    "Work is evaluations of the right-hand side, and n for each factorisation or exponential of an n × n matrix. It is no time.",
    "An event's error is empty where something else happens than in the yardstick.",
];
pub(crate) const MODEL: &str = "Model runs, not measurements.";

/// Every setting of every trade.
pub fn settings(trades: &[Trade]) -> Vec<TradeSetting> {
    let mut rows = Vec::new();
    for trade in trades {
        let pairs = trade.cells.iter().map(|cell| {
            // NaN keeps a run that failed off the front.
            let error = cell.errors.as_ref().map_or(f64::NAN, |errors| errors.theta_rad.largest);
            (cell.evaluations as f64, error)
        });
        let front = pareto_front(&pairs.collect::<Vec<_>>());
        let cells = trade.cells.iter().enumerate();
        rows.extend(cells.map(|(place, cell)| setting(trade, cell, front.contains(&place))));
    }
    rows
}

fn setting(trade: &Trade, cell: &Cell, on_front: bool) -> TradeSetting {
    let errors = cell.errors.as_ref();
    let felt = errors.map(|errors| errors.felt);
    let vibration = felt.filter(|felt| felt.vibration_share.is_some());
    let ran = errors.is_some();
    let swings = &cell.judgement.swings[0];
    let furthest = cell.furthest_metric();
    let has_metrics = !cell.metrics.is_empty();
    let shares = cell.metrics.iter().filter_map(|metric| metric.felt_share);
    let metrics_felt = shares.filter(|share| *share > 1.0).count();
    let metrics_lost = cell.metrics.iter().filter(|metric| metric.is_lost()).count();
    TradeSetting {
        scene: trade.scene.name.as_str().into(),
        mode: trade.scene.mode.as_str().into(),
        model: model_words(&trade.scene).into(),
        solver: cell.setting.solver.into(),
        step_s: cell.setting.step_s().and_then(finite),
        tolerance: cell.setting.tolerance().and_then(finite),
        verdict: cell.judgement.verdict.as_str().into(),
        gate: cell.gate,
        theta_error_max_rad: errors.and_then(|e| finite(e.theta_rad.largest)),
        theta_error_rms_rad: errors.and_then(|e| finite(e.theta_rad.rms)),
        theta_dot_error_max_rad_s: errors.and_then(|e| finite(e.theta_dot_rad_s.largest)),
        theta_dot_error_rms_rad_s: errors.and_then(|e| finite(e.theta_dot_rad_s.rms)),
        force_error_max_n: errors.and_then(|e| finite(e.force_n.largest)),
        force_error_rms_n: errors.and_then(|e| finite(e.force_n.rms)),
        impulse_error_ns: errors.and_then(|e| finite(e.impulse_ns)),
        event_error_s: errors.and_then(|e| e.event_s).and_then(finite),
        peak_error_rad: errors.and_then(|e| finite(e.peak_rad)),
        felt_force_share: felt.and_then(|felt| finite(felt.force_share)),
        felt_angle_share: felt.and_then(|felt| finite(felt.angle_share)),
        felt_vibration_share: felt.and_then(|felt| felt.vibration_share).and_then(finite),
        vibration_hz: vibration.and_then(|felt| finite(felt.frequency_hz)),
        vibration_m: vibration.and_then(|felt| finite(felt.amplitude_m)),
        reversals: ran.then_some(cell.reversals),
        swings: ran.then_some(swings.count),
        swing_amplitude_rad: ran.then_some(swings.amplitude_rad).and_then(finite),
        creep_rad: ran.then_some(cell.judgement.creep_rad).and_then(finite),
        steps: ran.then_some(cell.work.steps),
        rejected: ran.then_some(cell.work.rejected),
        evaluations: ran.then_some(cell.work.evaluations),
        factorisations: ran.then_some(cell.work.factorisations),
        work: ran.then_some(cell.evaluations),
        on_front,
        metric: furthest.map(|(metric, _)| metric.name.as_str().into()),
        metric_share: furthest.map(|(_, share)| share),
        metrics_felt: has_metrics.then_some(metrics_felt),
        metrics_lost: has_metrics.then_some(metrics_lost),
    }
}

fn finite(number: f64) -> Option<f64> {
    Some(number).filter(|number| number.is_finite())
}

/// The table of [`settings`].
///
/// # Errors
/// None that finished trades can cause.
pub fn settings_table(title: &str, rows: &[TradeSetting]) -> Result<Table, TableError> {
    let table = Table::of_rows(rows)?.called(TradeSetting::NAME, title);
    let table = DEFINITIONS.into_iter().fold(table, |table, note| table.with_note(note));
    Ok(table.with_note(MODEL))
}

/// The finger of a scene, which the models of the thesis differ by.
pub fn model_words(scene: &ModelScene) -> &'static str {
    match scene.finger.map(|finger| finger.law) {
        None => "no finger",
        Some(FingerLaw::Thesis) => "finger as the thesis has it",
        Some(FingerLaw::Consistent) => "finger that keeps energy",
    }
}

/// How well the yardstick of a trade is proven, and what is recommended and why.
pub fn choice(trade: &Trade) -> TradeChoice {
    let choice = trade.choice.as_ref();
    let setting = choice.map(|choice| choice.setting);
    let next_cheaper = choice.and_then(|choice| choice.next_cheaper);
    let [by, against] = trade.solvers;
    TradeChoice {
        scene: trade.scene.name.as_str().into(),
        mode: trade.scene.mode.as_str().into(),
        model: model_words(&trade.scene).into(),
        yardstick: trade.proof,
        by: by.into(),
        against: against.into(),
        apart_rad: trade.apart_rad,
        apart_s: trade.apart_s,
        motion_changes: trade.motion_changes,
        solver: setting.map(|setting| setting.solver.into()),
        step_s: setting.and_then(|setting| setting.step_s()),
        tolerance: setting.and_then(|setting| setting.tolerance()),
        work: choice.map(|choice| choice.evaluations),
        neighbours: choice.map(|choice| choice.confirmed.1),
        passed: choice.map(|choice| choice.confirmed.0),
        next_cheaper: next_cheaper.map(|(setting, _)| setting.words()),
        why_not: next_cheaper.map(|(_, why)| why),
    }
}

/// The table of each [`choice`].
///
/// # Errors
/// None that finished trades can cause.
pub fn choices_table(title: &str, rows: &[TradeChoice]) -> Result<Table, TableError> {
    Ok(Table::of_rows(rows)?.called(TradeChoice::NAME, title).with_note(MODEL))
}

/// The scene with the recommended step, ready for `zwidth simulate`, with the reason above it;
/// `None` where nothing is recommended.
///
/// # Errors
/// A scene that cannot be written as TOML.
pub fn recommended_scene(trade: &Trade) -> Result<Option<String>, TradeError> {
    let Some(choice) = &trade.choice else { return Ok(None) };
    let step_s = choice.setting.step_s().unwrap_or(trade.scene.step_s);
    let scene = ModelScene { step_s, ..trade.scene.clone() };
    let solver = choice.setting.solver;
    let tolerance = choice.setting.tolerance();
    let tolerance = tolerance.map_or(String::new(), |t| format!(" --tolerance {t:e}"));
    let mut lines = vec![
        format!(
            "# {}: the cheapest setting that a person could not tell from the right one.",
            trade.scene.name
        ),
        format!("# Run it with: zwidth simulate THIS_FILE --solver {solver}{tolerance}"),
        format!("# Setting: {}; work {} evaluations.", choice.setting.words(), choice.evaluations),
        format!(
            "# Yardstick: {}, by {} against {}.",
            trade.proof.as_str(),
            trade.solvers[0],
            trade.solvers[1]
        ),
    ];
    lines.push(match choice.confirmed {
        (_, 0) => "# Not confirmed on neighbours of the scene: `zwidth trade` does.".to_owned(),
        (passed, all) => format!("# Confirmed on {passed} of {all} neighbours (each size up to a tenth larger or smaller)."),
    });
    if let Some((setting, why)) = choice.next_cheaper {
        lines.push(format!("# The next cheaper one, {}: {why}.", setting.words()));
    }
    Ok(Some(format!("{}\n{}", lines.join("\n"), scene.to_toml()?)))
}

/// Whether a cell passes every gate, for those who draw.
impl Cell {
    /// Whether a person could not tell the run from the right one.
    pub fn is_good(&self) -> bool {
        self.gate == Gate::Passed
    }
}
