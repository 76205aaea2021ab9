//! What the figures of trials are made from.

use crate::About;
use crate::words::{Words, plain};
use zwidth_results::{AveragedTime, LoopAngle, Row};
use zwidth_store::{Signal, Trial};
use zwidth_study::{Alignment, Environment, Source};
use zwidth_tables::{Table, TableError};

/// One trial of a figure, and when its movement began.
#[derive(Debug, Clone, Copy)]
pub struct Repeat<'a> {
    /// The trial.
    pub trial: &'a Trial,
    /// Movement onset, s; time axes count from it. Without one they count from the trial's start.
    pub onset_s: Option<f64>,
    /// When each sample comes on the scale of the mean, s, where that is not its time since onset.
    pub warped_s: Option<&'a [f64]>,
}

impl ModeData<'_> {
    /// Name in the legend, with the number of repeats. The mean may be of fewer repeats than are
    /// drawn.
    pub(crate) fn name(&self) -> String {
        let all = self.repeats.len();
        let n = match self.averaged() {
            Some(n) if n < all => format!("{n} of {all}"),
            _ => all.to_string(),
        };
        let trials = if n == "1" { "trial" } else { "trials" };
        plain(&format!("{} ({n} {trials})", self.label))
    }

    /// How many repeats the mean is of, where most are.
    pub(crate) fn averaged(&self) -> Option<usize> {
        let times: Vec<AveragedTime> = self.average?.to_rows().ok()?;
        times.iter().map(|time| time.n).max()
    }
}

/// How many repeats the means against position are of: `6 trials`, `4 to 6 trials`; nothing without
/// a mean.
pub(crate) fn repeats_averaged<'a>(
    modes: impl Iterator<Item = &'a ModeData<'a>>,
) -> Option<String> {
    let counts = modes.filter_map(|mode| {
        let angles: Vec<LoopAngle> = mode.loop_average?.to_rows().ok()?;
        angles.iter().map(|angle| angle.n).max()
    });
    let counts: Vec<usize> = counts.collect();
    let least = counts.iter().min()?;
    let most = counts.iter().max()?;
    Some(match (least == most, most) {
        (true, 1) => "1 trial".to_owned(),
        (true, most) => format!("{most} trials"),
        (false, most) => format!("{least} to {most} trials"),
    })
}

/// How force against position is averaged, in words.
pub(crate) const AT_THE_ANGLE: &str =
    "averaged at each angle: way in and way out as far as all go, vertical where the lever is held";

/// How means are aligned, in words.
pub(crate) fn aligned(alignment: Alignment, has_wall: bool) -> &'static str {
    match (alignment, has_wall) {
        (Alignment::Onset, _) => "aligned at movement onset",
        (Alignment::Landmarks, true) => {
            "aligned by landmarks (start, wall contact, reversal, return, end)"
        }
        (Alignment::Landmarks, false) => "aligned by landmarks (start, reversal, return, end)",
    }
}

impl Repeat<'_> {
    /// Time since onset, s, or on the scale of the mean.
    pub(crate) fn time(&self) -> Vec<f64> {
        if let Some(warped_s) = self.warped_s {
            return warped_s.to_vec();
        }
        let zero = self.onset_s.unwrap_or(0.0);
        self.trial.samples.get(Signal::Time).unwrap_or_default().iter().map(|t| t - zero).collect()
    }

    /// A signal; `None` where it was not recorded.
    pub(crate) fn signal(&self, signal: Signal) -> Option<&[f64]> {
        self.trial.samples.get(signal)
    }
}

/// One mode of a figure: its place among the study's modes, its repeats, and their mean.
#[derive(Debug, Clone)]
pub struct ModeData<'a> {
    /// Index among the study's modes: gives the colour.
    pub index: usize,
    /// Name in the legend.
    pub label: &'a str,
    /// The repeats.
    pub repeats: Vec<Repeat<'a>>,
    /// Their mean against time, as the stage `average` made it.
    pub average: Option<&'a Table>,
    /// The mean for force against position.
    pub loop_average: Option<&'a Table>,
}

/// One environment of one session, with every mode tried in it.
#[derive(Debug, Clone)]
pub struct EnvironmentData<'a> {
    /// The study.
    pub about: &'a About,
    /// The environment.
    pub environment: &'a Environment,
    /// Who and when, for the description: `P01 S01`.
    pub who: String,
    /// The modes, in the study's order.
    pub modes: Vec<ModeData<'a>>,
    /// How the means against time are aligned.
    pub alignment: Alignment,
    /// The notes on the means: why there is none, or where it ends.
    pub notes: Vec<String>,
}

impl EnvironmentData<'_> {
    /// Where all repeats come from.
    pub(crate) fn sources(&self) -> impl Iterator<Item = Source> {
        self.repeats().map(|repeat| repeat.trial.meta.source)
    }

    /// Whether any repeat has the signal.
    pub(crate) fn has(&self, signal: Signal) -> bool {
        self.repeats().any(|repeat| repeat.signal(signal).is_some())
    }

    /// Whether time counts from movement onset: where some repeat has one, those without are not
    /// drawn over time.
    pub(crate) fn aligned(&self) -> bool {
        self.repeats().any(|repeat| repeat.onset_s.is_some())
    }

    /// Label of the time axis. By landmarks it is the scale of their mean times, to which repeats
    /// are stretched too.
    pub(crate) fn time_label(&self) -> &'static str {
        let by_landmarks = self.alignment == Alignment::Landmarks
            && self.modes.iter().any(|m| m.average.is_some());
        match (self.aligned(), by_landmarks) {
            (false, _) => "time",
            (true, false) => "time since movement onset",
            (true, true) => "time since onset, by landmarks",
        }
    }

    /// The words of its axes.
    pub(crate) fn words(&self) -> Words {
        Words::new(self.about.coordinate)
    }

    /// The level of the study's intervals, in per cent: `95 %`.
    pub(crate) fn level(&self) -> String {
        crate::words::percent(self.about.confidence)
    }

    /// The force, or the torque where no lever length made it one.
    pub(crate) fn load(&self) -> Signal {
        match self.has(Signal::ForceEx) || !self.has(Signal::TorqueEx) {
            true => Signal::ForceEx,
            false => Signal::TorqueEx,
        }
    }

    /// All repeats of all modes.
    pub(crate) fn repeats(&self) -> impl Iterator<Item = &Repeat<'_>> {
        self.modes.iter().flat_map(|mode| &mode.repeats)
    }
}

/// The signals of a trial that figures show besides time.
pub const SIGNALS: [Signal; 5] =
    [Signal::Theta, Signal::ThetaDot, Signal::ForceEx, Signal::TorqueEx, Signal::ForceCmd];

/// What figures read of a table of the stage `average`.
pub fn average_columns() -> Vec<String> {
    let mut columns = names::<AveragedTime>();
    for signal in SIGNALS {
        columns.extend(["mean", "ci_low", "ci_high"].map(|what| mean_column(signal, what)));
    }
    columns
}

/// What figures read of a mean of force against position.
pub fn loop_columns() -> Vec<String> {
    let loads = [Signal::ForceEx, Signal::TorqueEx].map(|signal| mean_column(signal, "mean"));
    names::<LoopAngle>().into_iter().chain(loads).collect()
}

/// The columns of rows.
fn names<R: Row>() -> Vec<String> {
    R::fields().into_iter().map(|field| field.name.into_owned()).collect()
}

fn mean_column(signal: Signal, what: &str) -> String {
    format!("{}_{what}_{}", signal.stem(), signal.suffix())
}

/// The mean of a load against the angle, rad, there and back; `None` if there is no such mean. Where the
/// way back begins at another angle than the way in ends, nothing connects them.
pub(crate) fn mean_loop_of(
    table: &Table,
    load: Signal,
) -> Result<Option<[Vec<f64>; 2]>, TableError> {
    let Some(force) = mean_values(table, load)? else { return Ok(None) };
    let points = table.to_rows::<LoopAngle>()?;
    let mut x = Vec::new();
    let mut y = Vec::new();
    for (row, point) in points.iter().enumerate() {
        let is_apart = row > 0
            && point.branch != points[row - 1].branch
            && (point.theta_rad - points[row - 1].theta_rad).abs() > APART_RAD;
        if is_apart {
            x.push(f64::NAN);
            y.push(f64::NAN);
        }
        x.push(point.theta_rad);
        y.push(force[row]);
    }
    Ok(Some([x, y]))
}

/// Branches whose ends are closer than this, rad (0.3°), are drawn as one line.
const APART_RAD: f64 = 0.005;

/// The mean of a signal and the ends of its band; `None` if the average has no such signal.
pub(crate) fn mean_curve(
    average: &Table,
    signal: Signal,
) -> Result<Option<[Vec<f64>; 3]>, TableError> {
    let Some(mean) = mean_values(average, signal)? else { return Ok(None) };
    let [low, high] = ["ci_low", "ci_high"].map(|what| average.floats(&mean_column(signal, what)));
    Ok(Some([mean, gaps(low?), gaps(high?)]))
}

/// The means of a signal; `None` if a table has none.
fn mean_values(table: &Table, signal: Signal) -> Result<Option<Vec<f64>>, TableError> {
    let name = mean_column(signal, "mean");
    if !table.fields().any(|field| field.name == name) {
        return Ok(None);
    }
    let mean = gaps(table.floats(&name)?);
    // A table may have the column where no repeat has the signal.
    Ok(Some(mean).filter(|mean| !mean.iter().all(|value| value.is_nan())))
}

/// Null becomes a gap in a curve.
fn gaps(values: Vec<Option<f64>>) -> Vec<f64> {
    values.into_iter().map(|v| v.unwrap_or(f64::NAN)).collect()
}
