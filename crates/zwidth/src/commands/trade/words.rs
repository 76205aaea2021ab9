//! The result of a trade in sentences.

use zwidth_dynamics::{NAMED_SOLVERS, RunVerdict};
use zwidth_results::SolverCreep;
use zwidth_trade::Trade;

/// The thesis' method, with either time of switching; the one that chatters more comes first.
const THESIS: [&str; 2] = ["rk4_per_step", "rk4_per_stage"];

/// What a person wants to know of a trade.
pub(super) fn trade_lines(trade: &Trade) -> Vec<String> {
    let mut lines = notes(trade);
    lines.extend(THESIS.iter().filter_map(|solver| thesis(trade, solver)));
    lines.extend(chatters(trade).map(|solver| felt(trade, solver)));
    lines
}

/// How far the yardstick is proven, and what is recommended.
pub(super) fn notes(trade: &Trade) -> Vec<String> {
    let [rad, s] = [(trade.apart_rad, "rad"), (trade.apart_s, "s")].map(|(value, unit)| {
        value.map_or("unknown".to_owned(), |value| format!("{value:.1e} {unit}"))
    });
    let mut lines = vec![format!(
        "Yardstick {}: {} and {} differ by {rad} and {s}.",
        trade.proof.as_str(),
        trade.solvers[0],
        trade.solvers[1],
    )];
    let Some(choice) = &trade.choice else {
        lines.push("Nothing is recommended.".to_owned());
        return lines;
    };
    let (passed, all) = choice.confirmed;
    lines.push(format!(
        "Recommended: {}, {} evaluations; it passes on {passed} of {all} neighbours of the scene.",
        choice.setting.words(),
        choice.evaluations
    ));
    if let Some((setting, why)) = choice.next_cheaper {
        lines.push(format!("Next cheaper: {}; {why}.", setting.words()));
    }
    lines
}

/// Which solvers let the lever creep under half its friction, and how fast at most.
pub(super) fn creep_lines(creeps: &[SolverCreep]) -> Vec<String> {
    // A slower lever stands.
    let least_rad_s = 1e-5_f64.to_radians();
    let mut creeping: Vec<String> = Vec::new();
    let mut standing: Vec<&str> = Vec::new();
    for named in NAMED_SOLVERS {
        let own = creeps.iter().filter(|creep| *creep.solver == *named.name);
        let fastest = own.map(|creep| creep.creep_rad_s.abs()).reduce(f64::max);
        match fastest {
            Some(speed) if speed >= least_rad_s => {
                creeping.push(format!("{} by up to {:.3} °/s", named.label, speed.to_degrees()));
            }
            Some(_) => standing.push(named.label),
            None => {}
        }
    }
    let mut lines = Vec::new();
    if !standing.is_empty() {
        lines.push(format!("Under half its friction the lever stands by {}.", standing.join(", ")));
    }
    if !creeping.is_empty() {
        lines.push(format!("It creeps by {}.", creeping.join(", ")));
    }
    lines
}

/// The thesis' method at the scene's own step.
fn thesis(trade: &Trade, solver: &str) -> Option<String> {
    let own = trade.scene.step_s;
    let cell = trade.cells.iter().find(|cell| {
        cell.setting.solver == solver
            && cell.setting.step_s().is_some_and(|step_s| (step_s / own - 1.0).abs() < 1e-9)
    })?;
    let Some(errors) = cell.errors else {
        return Some(format!("{}: failed.", cell.setting.words()));
    };
    let vibration = errors.felt.vibration_share.map_or("none to compare".to_owned(), |share| {
        format!("{share:.2} times what is felt at {:.0} Hz", errors.felt.frequency_hz)
    });
    let metric = cell.furthest_metric().map_or(String::new(), |(metric, share)| {
        format!(
            " Of the study's metrics it changes {} most, by {share:.2} times what is felt.",
            metric.name
        )
    });
    Some(format!(
        "{}: {}; angle off by up to {:.3}° (its top by {:.3}°), slow force {:.2} times what is felt, vibration {vibration}.{metric}",
        cell.setting.words(),
        cell.judgement.verdict.as_str(),
        errors.theta_rad.largest.to_degrees(),
        errors.peak_rad.to_degrees(),
        errors.felt.force_share,
    ))
}

/// The thesis' method where it chatters at the scene's own step.
pub(super) fn chatters(trade: &Trade) -> Option<&'static str> {
    THESIS.into_iter().find(|solver| {
        trade.cells.iter().any(|cell| {
            cell.setting.solver == *solver
                && cell.judgement.verdict == RunVerdict::NumericalChattering
        })
    })
}

/// Whether what a solver makes can be felt, by step.
pub(super) fn felt(trade: &Trade, solver: &str) -> String {
    let cells = trade.cells.iter().filter(|cell| cell.setting.solver == solver);
    let mut felt = Vec::new();
    let mut unfelt = Vec::new();
    for cell in cells.filter(|c| c.judgement.verdict == RunVerdict::NumericalChattering) {
        let is_felt = cell.errors.is_some_and(|errors| errors.felt.is_felt());
        let steps = if is_felt { &mut felt } else { &mut unfelt };
        steps.extend(cell.setting.step_s());
    }
    let least_s = felt.iter().copied().fold(f64::INFINITY, f64::min);
    // In whole microseconds: more digits are rounding.
    let least_ms = (least_s * 1e6).round() / 1e3;
    let lever_mm = trade.scene.plant.lever_m * 1e3;
    match (felt.is_empty(), unfelt.is_empty()) {
        (true, _) => format!(
            "At the end of a lever of {lever_mm} mm nobody would feel the chattering, at any step."
        ),
        (false, true) => {
            format!(
                "At the end of a lever of {lever_mm} mm a person would feel the chattering at every step."
            )
        }
        (false, false) => format!(
            "At the end of a lever of {lever_mm} mm a person would feel the chattering at steps of {least_ms} ms and more, and not at the shorter ones."
        ),
    }
}
