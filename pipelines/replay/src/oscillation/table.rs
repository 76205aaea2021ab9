//! Oscillations as a table.

use super::judge::Oscillation;
use super::recorded::RecordedSwings;
use zwidth_study::TrialMeta;
use zwidth_tables::{Column, Table, TableError};

/// One row per trial: whether it oscillates, where that comes from, and what the answer rests on.
///
/// # Errors
/// None that oscillations can cause.
pub fn oscillations_table(
    name: &str,
    rows: &[(TrialMeta, Oscillation)],
) -> Result<Table, TableError> {
    let text = |name, about, get: fn(&(TrialMeta, Oscillation)) -> Option<String>| {
        Column::text(name, about, rows.iter().map(get))
    };
    let float = |name, unit, about, get: &dyn Fn(&Oscillation) -> Option<f64>| {
        Column::float(name, unit, about, rows.iter().map(|row| get(&row.1)))
    };
    let of = |get: fn(&RecordedSwings) -> f64| {
        move |swings: &Option<RecordedSwings>| swings.as_ref().map(get)
    };
    let (size, speed) = (of(|s| s.amplitude_rad), of(|s| s.frequency_hz));
    let stepped = |i: usize| move |o: &Oscillation| o.nature.map(|_| o.stepped_rad[i]);
    let count = |o: &Oscillation| o.recorded.map(|swings| swings.swings as i64);
    let columns = vec![
        text("participant", "who", |row| Some(row.0.participant.to_string())),
        text("session", "which session", |row| Some(row.0.session.to_string())),
        Column::integer(
            "trial",
            "1",
            "number of the trial in the session",
            rows.iter().map(|row| Some(i64::from(row.0.trial))),
        ),
        text("environment", "what was rendered", |row| Some(row.0.environment.to_string())),
        text("mode", "how it was rendered", |row| Some(row.0.mode.to_string())),
        text("source", "recorded, twin or imported", |row| Some(row.0.source.as_str().to_owned())),
        text("answer", "whether the recorded oscillation is the device's own", |row| {
            Some(row.1.origin.answer().as_str().to_owned())
        }),
        text("why", "why", |row| Some(row.1.origin.why())),
        float("bound_rad", "rad", "half the peak-to-peak angle of the least swing", &|o| {
            Some(o.bound_rad)
        }),
        Column::integer(
            "swings",
            "1",
            "recorded swings in a row",
            rows.iter().map(|row| count(&row.1)),
        ),
        float("from_s", "s", "when they begin, since the first sample", &|o| {
            o.recorded.map(|s| s.from_s)
        }),
        float("to_s", "s", "when they end", &|o| o.recorded.map(|s| s.to_s)),
        float("amplitude_rad", "rad", "their median half peak-to-peak", &|o| size(&o.recorded)),
        float("frequency_hz", "Hz", "their frequency", &|o| speed(&o.recorded)),
        float("with_force_amplitude_rad", "rad", "of the model with the user's force", &|o| {
            size(&o.with_force)
        }),
        float("with_force_frequency_hz", "Hz", "its frequency", &|o| speed(&o.with_force)),
        float("alone_amplitude_rad", "rad", "of the model with the force's slow part", &|o| {
            size(&o.alone)
        }),
        float("alone_frequency_hz", "Hz", "its frequency", &|o| speed(&o.alone)),
        float("stepped_amplitude_rad", "rad", "the same by a step of a quarter tick", &stepped(0)),
        float("half_step_amplitude_rad", "rad", "by half of that step", &stepped(1)),
        float("quarter_step_amplitude_rad", "rad", "by a quarter of it", &stepped(2)),
        text("nature", "what the model's motion is with the force's slow part", |row| {
            row.1.nature.map(|nature| nature.as_str().to_owned())
        }),
        float("power_factor", "1", "above 0 the user's force feeds the swing", &|o| o.power_factor),
    ];
    Table::new(name, "Oscillations of recorded trials", columns)
}
