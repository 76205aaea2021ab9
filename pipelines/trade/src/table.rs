//! Trades as tables, and the recommended setting as a scene file.

use crate::cells::{Cell, Gate};
use crate::errors::Errors;
use crate::metric_table::metric_columns;
use crate::trade::{Trade, pareto_front};
use crate::{TradeError, WhyNot};
use zwidth_dynamics::{FingerLaw, ModelScene};
use zwidth_tables::{Column, Table, TableError};

/// What each number of the table of settings is; it stands with every table.
const DEFINITIONS: [&str; 5] = [
    "Errors are those of the run's own samples (at most 8,000, evenly chosen) against the yardstick at the same times.",
    "The force is the device's on the lever's end: motor, brake, friction, terms and stops; within 50 ms of its jumps nothing is compared.",
    "Shares are of what a person just feels: above 1 it is felt. Slow parts are means over 100 ms; vibration is by third octaves from 10 to 794 Hz, and 0 where it is not above the right one.",
    "Work is evaluations of the right-hand side, and n for each factorisation or exponential of an n × n matrix. It is no time.",
    "An event's error is empty where something else happens than in the yardstick.",
];

/// Every setting of every trade, a row each.
///
/// # Errors
/// None that finished trades can cause.
pub fn settings_table(name: &str, title: &str, trades: &[Trade]) -> Result<Table, TableError> {
    let rows: Vec<(&Trade, &Cell, bool)> = trades.iter().flat_map(rows).collect();
    let table = Table::new(name, title, columns(&rows))?;
    let table = DEFINITIONS.into_iter().fold(table, |table, note| table.with_note(note));
    Ok(table.with_note("Model runs, not measurements."))
}

/// The cells of a trade, and whether each is on the front of work and error of the angle.
fn rows(trade: &Trade) -> Vec<(&Trade, &Cell, bool)> {
    let pair = |cell: &Cell| {
        let error = cell.errors.as_ref().map_or(f64::NAN, |errors| errors.theta_rad.largest);
        (cell.evaluations as f64, error)
    };
    let front = pareto_front(&trade.cells.iter().map(pair).collect::<Vec<_>>());
    trade.cells.iter().enumerate().map(|(i, cell)| (trade, cell, front.contains(&i))).collect()
}

type Row<'a> = (&'a Trade, &'a Cell, bool);

fn columns(rows: &[Row]) -> Vec<Column> {
    let text = |name, about, get: &dyn Fn(&Row) -> String| {
        Column::text(name, about, rows.iter().map(|row| Some(get(row))))
    };
    let float = |name, unit, about, get: &dyn Fn(&Row) -> Option<f64>| {
        Column::float(name, unit, about, rows.iter().map(|row| get(row).filter(|x| x.is_finite())))
    };
    let error = |name, unit, about, get: fn(&Errors) -> Option<f64>| {
        float(name, unit, about, &|row| row.1.errors.as_ref().and_then(get))
    };
    let count = |name, about, get: &dyn Fn(&Cell) -> u64| {
        let value = |row: &Row| row.1.errors.is_some().then(|| get(row.1) as i64);
        Column::integer(name, "1", about, rows.iter().map(value))
    };
    let tolerance = |row: &Row| row.1.setting.step_s().is_none().then(|| row.1.setting.size());
    let mut columns = vec![
        text("scene", "the scene", &|row| row.0.scene.name.clone()),
        text("mode", "which actuators render", &|row| row.0.scene.mode.as_str().to_owned()),
        text("model", "what stands between the user's force and the lever", &|row| {
            model_words(&row.0.scene).to_owned()
        }),
        text("solver", "the solver", &|row| row.1.setting.solver.to_owned()),
        float("step_s", "s", "its step", &|row| row.1.setting.step_s()),
        float("tolerance", "1", "its relative error per step", &|row| {
            tolerance(row).filter(|t| *t > 0.0)
        }),
        text("verdict", "what the run is worth", &|row| {
            row.1.judgement.verdict.as_str().to_owned()
        }),
        text("gate", "the first bound that it breaks, or passed", &|row| {
            row.1.gate.as_str().to_owned()
        }),
        error("theta_error_max_rad", "rad", "largest error of the angle", |e| {
            Some(e.theta_rad.largest)
        }),
        error("theta_error_rms_rad", "rad", "root mean square of it", |e| Some(e.theta_rad.rms)),
        error("theta_dot_error_max_rad_s", "rad/s", "largest error of the velocity", |e| {
            Some(e.theta_dot_rad_s.largest)
        }),
        error("theta_dot_error_rms_rad_s", "rad/s", "root mean square of it", |e| {
            Some(e.theta_dot_rad_s.rms)
        }),
        error("force_error_max_n", "N", "largest error of the device's force", |e| {
            Some(e.force_n.largest)
        }),
        error("force_error_rms_n", "N", "root mean square of it", |e| Some(e.force_n.rms)),
        error("impulse_error_ns", "N s", "error of its integral over the run", |e| {
            Some(e.impulse_ns)
        }),
        error("event_error_s", "s", "largest error of the times of events", |e| e.event_s),
        error("peak_error_rad", "rad", "error of the largest angle", |e| Some(e.peak_rad)),
        error("felt_force_share", "1", "slow force: error over what is felt", |e| {
            Some(e.felt.force_share)
        }),
        error("felt_angle_share", "1", "slow angle: error over what is felt", |e| {
            Some(e.felt.angle_share)
        }),
        error(
            "felt_vibration_share",
            "1",
            "vibration above the right one, over what is felt",
            |e| e.felt.vibration_share,
        ),
        error("vibration_hz", "Hz", "centre of that third octave", |e| {
            e.felt.vibration_share.map(|_| e.felt.frequency_hz)
        }),
        error("vibration_m", "m", "its amplitude at the lever's end", |e| {
            e.felt.vibration_share.map(|_| e.felt.amplitude_m)
        }),
        count("reversals", "sign changes of the velocity between samples", &|cell| {
            cell.reversals as u64
        }),
        count("swings", "of an oscillation, 0 for fewer than six", &|cell| {
            cell.judgement.swings[0].count as u64
        }),
        float("swing_amplitude_rad", "rad", "median of half a swing's angle", &|row| {
            row.1.errors.is_some().then(|| row.1.judgement.swings[0].amplitude_rad)
        }),
        float(
            "creep_rad",
            "rad",
            "longest way in a stretch in which the lever should stand",
            &|row| row.1.errors.is_some().then_some(row.1.judgement.creep_rad),
        ),
        count("steps", "steps, or exact pieces", &|cell| cell.work.steps),
        count("rejected", "steps rejected", &|cell| cell.work.rejected),
        count("evaluations", "of the right-hand side", &|cell| cell.work.evaluations),
        count("factorisations", "or exponentials", &|cell| cell.work.factorisations),
        count("work", "all of it in evaluations", &|cell| cell.evaluations),
        Column::flag(
            "on_front",
            "no other setting has less work and less error of the angle",
            rows.iter().map(|row| Some(row.2)),
        ),
    ];
    // Scenes without a study have no metrics.
    if rows.iter().any(|row| !row.1.metrics.is_empty()) {
        columns.extend(metric_columns(&rows.iter().map(|row| row.1).collect::<Vec<_>>()));
    }
    columns
}

/// The finger of a scene, which the models of the thesis differ by.
pub fn model_words(scene: &ModelScene) -> &'static str {
    match scene.finger.map(|finger| finger.law) {
        None => "no finger",
        Some(FingerLaw::Thesis) => "finger as the thesis has it",
        Some(FingerLaw::Consistent) => "finger that keeps energy",
    }
}

/// One row per scene: how far its yardstick is proven, and what is recommended and why.
///
/// # Errors
/// None that finished trades can cause.
pub fn summary_table(name: &str, title: &str, trades: &[Trade]) -> Result<Table, TableError> {
    let text = |name, about, get: fn(&Trade) -> Option<String>| {
        Column::text(name, about, trades.iter().map(get))
    };
    let float = |name, unit, about, get: fn(&Trade) -> Option<f64>| {
        Column::float(name, unit, about, trades.iter().map(get))
    };
    let count = |name, about, get: fn(&Trade) -> Option<i64>| {
        Column::integer(name, "1", about, trades.iter().map(get))
    };
    let columns = vec![
        text("scene", "the scene", |t| Some(t.scene.name.clone())),
        text("mode", "which actuators render", |t| Some(t.scene.mode.as_str().to_owned())),
        text("model", "what stands between the user's force and the lever", |t| {
            Some(model_words(&t.scene).to_owned())
        }),
        text("yardstick", "whether two solvers agree to 1e-9 rad and 1e-9 s", |t| {
            Some(t.proof.as_str().to_owned())
        }),
        text("by", "the solver of the yardstick", |t| Some(t.solvers[0].to_owned())),
        text("against", "the one that it is compared with", |t| Some(t.solvers[1].to_owned())),
        float("apart_rad", "rad", "largest difference of their angles", |t| t.apart_rad),
        float("apart_s", "s", "that of their events", |t| t.apart_s),
        count("motion_changes", "how often the lever changes its way of moving", |t| {
            Some(t.motion_changes as i64)
        }),
        text("solver", "the solver that is recommended", |t| {
            t.choice.as_ref().map(|c| c.setting.solver.to_owned())
        }),
        float("step_s", "s", "its step", |t| t.choice.as_ref()?.setting.step_s()),
        float("tolerance", "1", "its tolerance", |t| {
            let setting = t.choice.as_ref()?.setting;
            Some(setting.size()).filter(|size| setting.step_s().is_none() && *size > 0.0)
        }),
        count("work", "its work in evaluations", |t| {
            t.choice.as_ref().map(|c| c.evaluations as i64)
        }),
        count("neighbours", "neighbours of the scene it was tried on", |t| {
            t.choice.as_ref().map(|c| c.confirmed.1 as i64)
        }),
        count("passed", "those of them that it passes on", |t| {
            t.choice.as_ref().map(|c| c.confirmed.0 as i64)
        }),
        text("next_cheaper", "the next cheaper setting", |t| {
            Some(t.choice.as_ref()?.next_cheaper?.0.words())
        }),
        text("why_not", "why it is not recommended", |t| {
            Some(t.choice.as_ref()?.next_cheaper?.1.words())
        }),
    ];
    Ok(Table::new(name, title, columns)?.with_note("Model runs, not measurements."))
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
    let tolerance = Some(choice.setting.size()).filter(|size| *size > 0.0);
    let tolerance = tolerance.filter(|_| choice.setting.step_s().is_none());
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
        lines.push(format!("# The next cheaper one, {}: {}.", setting.words(), WhyNot::words(why)));
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
