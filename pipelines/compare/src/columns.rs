//! Columns that several tables share: what a row is about, and an estimate with its interval.

use crate::Parameters;
use crate::measure::Measure;
use crate::unit::Unit;
use zwidth_stats::Tested;
use zwidth_study::Contrast;
use zwidth_tables::Column;

/// What was rendered, by the places of the environments.
pub(crate) fn environments(parameters: &Parameters, places: impl Iterator<Item = usize>) -> Column {
    let names = places.map(|place| Some(parameters.environments[place].as_str()));
    Column::text("environment", "what was rendered", names)
}

/// How it was rendered, by the places of the modes.
pub(crate) fn modes(parameters: &Parameters, places: impl Iterator<Item = usize>) -> Column {
    let names = places.map(|place| Some(parameters.modes[place].as_str()));
    Column::text("mode", "how it was rendered", names)
}

/// Which modes are compared.
pub(crate) fn contrasts<'a>(contrasts: impl Iterator<Item = &'a Contrast>) -> Column {
    let names = contrasts.map(|contrast| Some(name(contrast)));
    Column::text("contrast", "the modes compared: the one minus the other", names)
}

/// A contrast's name: `hybrid − active`.
pub(crate) fn name(contrast: &Contrast) -> String {
    format!("{} − {}", contrast.mode, contrast.against)
}

/// What n counts, so many times.
pub(crate) fn units(unit: &Unit, rows: usize) -> Column {
    Column::text("unit_of_analysis", "what n counts", vec![Some(unit.words()); rows])
}

/// The columns of a tested quantity named `stem`: estimate, standard error and interval.
pub(crate) fn tested(
    measure: &Measure,
    stem: &str,
    description: &str,
    rows: &[Option<Tested>],
) -> [Column; 4] {
    let part = |part: &str, description: &str, of: fn(&Tested) -> f64| {
        let values = rows.iter().map(|row| row.as_ref().map(of));
        measure.column(&format!("{stem}{part}"), description, values)
    };
    [
        part("", description, |t| t.estimate),
        part("_std_error", "its standard error", |t| t.std_error),
        part("_ci_low", "lower end of its interval", |t| t.ci_low),
        part("_ci_high", "upper end of its interval", |t| t.ci_high),
    ]
}
