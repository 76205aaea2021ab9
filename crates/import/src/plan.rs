//! The plan by which every file becomes trials: the mapping joined with the study.

use super::axes::{Projection, check_axes};
use super::convert::{Linear, Zero};
use super::errors::{Errors, all};
use super::mapping::{ChannelFrom, ColumnFrom, Mend, Origin, Rule, SignalFrom, Time};
use super::table::ColumnRef;
use super::unit;
use super::unit::Unit;
use std::collections::BTreeMap;
use std::path::Path;
use zwidth_store::{Signal, StoreError};
use zwidth_study::Study;

/// A column of times, and what is done with it before it is converted.
#[derive(Debug, Clone, Copy)]
pub(super) struct TimeColumn<'a> {
    pub(super) from: &'a ColumnRef,
    pub(super) unit: &'static Unit,
    /// Whether times count from the first sample of a trial.
    pub(super) from_first: bool,
    pub(super) mend: Mend,
}

impl<'a> TimeColumn<'a> {
    pub(super) fn of(column: &'a ColumnFrom, mend: Mend) -> Self {
        let ColumnFrom { from, unit, line, .. } = column;
        Self { from, unit, from_first: line.zero == Zero::First, mend }
    }
}

/// The signals that are taken from every file, and those that are computed.
#[derive(Default)]
pub(super) struct Plan<'a> {
    /// Time first, where it has a column; then the mapped signals.
    pub(super) taken: Vec<Taken<'a>>,
    /// The column of time, and what is mended of it.
    pub(super) time: Option<TimeColumn<'a>>,
    /// Rows a second, where there is no time column.
    pub(super) rate_hz: Option<f64>,
    /// Columns that become channels of the study's own.
    pub(super) channels: &'a [ChannelFrom],
    /// Signals computed from others, in order.
    pub(super) derived: Vec<(Signal, Rule)>,
    /// Of those that are projections on the push, how.
    pub(super) projections: BTreeMap<Signal, Projection>,
    /// For the report.
    pub(super) converted: Vec<String>,
    /// For the report and the files.
    pub(super) computed: Vec<String>,
    /// The lever length that a conversion used, m.
    pub(super) lever_m: Option<f64>,
}

/// A column of theirs that becomes a signal of ours.
pub(super) struct Taken<'a> {
    pub(super) to: Signal,
    pub(super) from: &'a ColumnRef,
    pub(super) line: Linear,
    /// The factor from the named unit to SI.
    pub(super) factor: f64,
    /// The value at which it starts over, in the named unit.
    pub(super) wrap: Option<f64>,
    /// The unit named, and how the mapping spells it.
    pub(super) unit: (&'static unit::Unit, &'a str),
}

/// Joins a mapping, by its file, with a study.
///
/// # Errors
/// A unit that only fits with a lever length or a linear coordinate, or a column that only fits with axes, which the
/// study lacks.
pub(super) fn plan<'a>(
    study: &Study,
    mapping: &Path,
    time: &'a Time,
    columns: &'a [SignalFrom],
    channels: &'a [ChannelFrom],
) -> Result<Plan<'a>, Errors> {
    check_axes(study, mapping, columns)?;
    all(channels.iter().map(|channel| {
        let id = channel.to.as_str();
        let (what, remedy) = match study.channels.iter().find(|c| c.id == channel.to) {
            None => (
                format!("'{id}' is not a channel of study.toml"),
                "add it to [[channels]] before the first trial, or remove it from the mapping",
            ),
            // What a unit of another's is, nobody knows: it must be the study's own word.
            Some(own) if own.unit != channel.unit => (
                format!(
                    "'{id}' is in '{}' in study.toml, and in '{}' here",
                    own.unit, channel.unit
                ),
                "write the study's unit, and convert the values to it with sign, scale and offset",
            ),
            Some(_) => return Ok(()),
        };
        let error = StoreError::new(mapping, what, remedy);
        Err(error.column(channel.from.to_string()))
    }))?;
    let converted = channels.iter().map(|c| {
        let line = c.line.words().map(|w| format!(", {w}")).unwrap_or_default();
        format!("{} ← {} ({}){line}", c.to.as_str(), c.from, c.unit)
    });
    let mut plan = Plan { channels, converted: converted.collect(), ..Plan::default() };
    match time {
        Time::Rate { rate_hz } => {
            plan.rate_hz = Some(*rate_hz);
            plan.computed.push(rate_words(*rate_hz));
        }
        Time::Column { column, mend } => {
            plan.take(study, mapping, Signal::Time, column, None)?;
            plan.time = Some(TimeColumn::of(column, *mend));
            plan.computed.extend(mend.words());
        }
    }
    let added = columns.iter().map(|SignalFrom { to, origin }| match origin {
        Origin::Column { column, wrap } => {
            // The user's torque is kept as a force where the study has a lever length, F = τ / L.
            let has_force = columns.iter().any(|c| c.to == Signal::ForceEx);
            let to = match to {
                Signal::TorqueEx if study.device.lever_m.is_some() && !has_force => Signal::ForceEx,
                other => *other,
            };
            plan.take(study, mapping, to, column, *wrap)
        }
        Origin::Derived(rule) => {
            let words = match rule {
                Rule::AlongPush(origin) => {
                    let projection = Projection::of(study, mapping, *to, *origin, columns)?;
                    if *to == Signal::Theta {
                        plan.lever_m = study.device.lever_m;
                    }
                    let words = projection.words();
                    plan.projections.insert(*to, projection);
                    words
                }
                Rule::DerivativeOf(source) => {
                    format!("derivative of {} (central differences)", source.name())
                }
                Rule::IntegralOf(source) => {
                    format!("integral of {} (trapezoids, 0 at the first sample)", source.name())
                }
            };
            plan.computed.push(format!("{} = {words}", to.name()));
            // In the order of the mapping: a signal stands below the one that it is computed from.
            plan.derived.push((*to, *rule));
            Ok(())
        }
    });
    all(added)?;
    Ok(plan)
}

/// The times at a rate, s, of samples by their numbers. A row that was dropped or is empty leaves a
/// gap: later rows keep the time they were recorded at.
#[allow(clippy::cast_precision_loss)] // a number beyond 2⁵³ is past any time that is read
pub(super) fn rate_times(rate_hz: f64, numbers: impl IntoIterator<Item = usize>) -> Vec<f64> {
    numbers.into_iter().map(|number| number as f64 / rate_hz).collect()
}

/// The note about times that were made from a rate.
pub(super) fn rate_words(rate_hz: f64) -> String {
    format!("t_s = row / {rate_hz} Hz, the first row at 0 (the recording has no time)")
}

impl<'a> Plan<'a> {
    /// Their columns that are taken: those of our signals, then those of the channels.
    pub(super) fn columns(&self) -> impl Iterator<Item = &'a ColumnRef> + use<'a, '_> {
        self.taken.iter().map(|taken| taken.from).chain(self.channels.iter().map(|c| &c.from))
    }

    fn take(
        &mut self,
        study: &Study,
        mapping: &Path,
        to: Signal,
        column: &'a ColumnFrom,
        wrap: Option<f64>,
    ) -> Result<(), StoreError> {
        let ColumnFrom { from, unit, unit_text, line } = column;
        let (factor, length) = unit::factor(unit, to, study).map_err(|lacks| {
            let what =
                format!("{unit_text} becomes {} only where study.toml has {lacks}", to.name());
            let remedy = "add it to study.toml, or choose another unit or column of ours";
            StoreError::new(mapping, what, remedy).column(from.to_string())
        })?;
        let line_words = line.words().map(|w| format!(", {w}")).unwrap_or_default();
        let name = to.name();
        self.converted.push(format!("{name} ← {from} ({unit_text}){line_words}"));
        if let Some(lever_m) = length {
            self.lever_m = Some(lever_m);
            let rule =
                if unit.dimension == unit::Dimension::Torque { "F = τ / L" } else { "θ = x / L" };
            self.computed.push(format!("{name} by {rule} with L = {lever_m} m"));
        }
        match line.zero {
            Zero::None => {}
            Zero::First => self.computed.push(format!("{name} less its first value")),
            Zero::Rest { from_s, to_s } => {
                let words =
                    format!("{name} less its median from {from_s} s to {to_s} s of the trial");
                self.computed.push(words);
            }
        }
        if let Some(wrap) = wrap {
            self.computed.push(format!("{name} unwrapped at {wrap} {unit_text}"));
        }
        let unit = (column.unit, unit_text.as_str());
        self.taken.push(Taken { to, from, line: *line, factor, wrap, unit });
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::world::{FORCE, ONE, World, close, column, trials_map};
    use zwidth_store::Signal;
    use zwidth_study::{StudyId, template};

    #[test]
    fn degrees_signs_scales_and_offsets_become_si() {
        let world = World::new();
        let file = world.file("a.csv", "5,180,2000,1\n6,90,1000,2\n");
        let columns = "
[file]
header = false
[time]
from = 1
unit = \"s\"
zero = \"first\"
[[column]]
to = \"theta_rad\"
from = 2
unit = \"deg\"
zero = \"first\"
[[column]]
to = \"voltage_motor_v\"
from = 3
unit = \"mV\"
sign = -1
[[column]]
to = \"force_ex_n\"
from = 4
unit = \"N\"
scale = 2.0
offset = 1.0
";
        let report = world.import(&trials_map(&[ONE, columns]), &[file]).unwrap();
        assert_eq!(world.column(1, Signal::Time), [0.0, 1.0]);
        close(&world.column(1, Signal::Theta), &[0.0, -std::f64::consts::FRAC_PI_2]);
        assert_eq!(world.column(1, Signal::VoltageMotor), [-2.0, -1.0]);
        assert_eq!(world.column(1, Signal::ForceEx), [3.0, 5.0]);
        let made = world.computed(1);
        assert_eq!(made, "t_s less its first value; theta_rad less its first value");
        assert!(report.to_string().contains("force_ex_n ← 4 (N), (2 x + 1)"), "{report}");
    }

    #[test]
    fn torque_becomes_force_by_the_lever_and_stays_torque_without_one() {
        let csv = "tau\n90\n45\n";
        let torque = column("torque_ex_nm", "tau", "mN·m");
        let map = trials_map(&[ONE, "[time]\nrate_hz = 200.0\n", &torque]);
        let world = World::new();
        world.import(&map, &[world.file("a.csv", csv)]).unwrap();
        close(&world.column(1, Signal::ForceEx), &[2.0, 1.0]);
        assert_eq!(world.trial("P01", "S01", 1).samples.get(Signal::TorqueEx), None);
        let made = world.computed(1);
        assert!(made.contains("force_ex_n by F = τ / L with L = 0.045 m"), "{made}");

        let leverless = template(&StudyId::new("demo").unwrap()).replace("lever_m = 0.045", "");
        let world = World::with(&leverless);
        let file = world.file("a.csv", csv);
        let asks_force = map.replace("torque_ex_nm", "force_ex_n");
        let words = "only where study.toml has device.lever_m";
        world.refuses(&asks_force, &file, words, None);
        world.import(&map, &[file]).unwrap();
        close(&world.column(1, Signal::TorqueEx), &[0.09, 0.045]);
        assert_eq!(world.trial("P01", "S01", 1).samples.get(Signal::ForceEx), None);
    }

    #[test]
    fn millimetres_become_radians_by_the_linear_coordinate_only() {
        let map = FORCE.replace("force_ex_n", "theta_rad").replace("\"N\"", "\"mm\"");
        let map = trials_map(&[ONE, &map]);
        let world = World::new();
        let file = world.file("a.csv", "t,f\n0,5\n1,10\n");
        let words = "mm becomes theta_rad only where study.toml has coord";
        world.refuses(&map, &file, words, None);
        let slide = "schema = 2\n[study]\nid = \"demo\"\ntitle = \"x\"\n[design]\nrepeats = 1\ntrial_limit_s = 4.0
[coordinate]\nkind = \"linear\"\n[device]\nname = \"x\"\nlever_m = 0.5
[[environments]]\nid = \"spring\"\nlabel = \"x\"\nkind = \"free\"\n[[modes]]\nid = \"hybrid\"\nlabel = \"x\"\n";
        let world = World::with(slide);
        world.import(&map, &[world.file("a.csv", "t,f\n0,5\n1,10\n")]).unwrap();
        close(&world.column(1, Signal::Theta), &[0.01, 0.02]);
        let made = world.computed(1);
        assert!(made.contains("theta_rad by θ = x / L with L = 0.5 m"), "{made}");
    }
}
