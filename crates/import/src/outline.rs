//! Compares the trials of an import, and finds those that differ from the others.

use super::convert::median;
use super::identity::Identity;
use std::path::PathBuf;
use zwidth_numerics::series::ends;
use zwidth_store::{Plateau, Samples, Signal, plateau};
use zwidth_study::{EnvironmentId, Kind};

/// Fewest other trials that show what is usual.
const LEAST_OTHERS: usize = 3;
/// A trial that lasts less than this share of the others may be a stump of one.
const STUMP: f64 = 0.2;
/// A rate that differs by more than this share from that of the others is another one.
const OTHER_RATE: f64 = 0.1;
/// An angle that goes less far than this, rad, stands.
const STANDS_RAD: f64 = 1e-9;

/// A trial in outline.
pub(super) struct Outline {
    pub(super) file: PathBuf,
    environment: EnvironmentId,
    kind: Kind,
    span_s: f64,
    rate_hz: f64,
    /// Whether its angle changes, if it has one.
    moves: Option<bool>,
    /// The largest magnitude of its force, and where it stands there for long.
    largest: Option<(f64, Option<Plateau>)>,
}

impl Outline {
    pub(super) fn of(identity: &Identity, samples: &Samples) -> Self {
        let t = samples.get(Signal::Time).unwrap_or_default();
        let span_s = t.last().zip(t.first()).map_or(0.0, |(last, first)| last - first);
        let steps = t.windows(2).map(|t| t[1] - t[0]).collect();
        let moves = samples.get(Signal::Theta).map(|theta| {
            let first = theta.first().copied().unwrap_or(0.0);
            theta.iter().any(|angle| (angle - first).abs() > STANDS_RAD)
        });
        Self {
            file: identity.file.clone(),
            environment: identity.environment.clone(),
            kind: identity.kind,
            span_s,
            rate_hz: 1.0 / median(steps),
            moves,
            largest: samples.get(Signal::ForceEx).map(|force| {
                let (low, high) = ends(force);
                (low.abs().max(high.abs()), plateau(force))
            }),
        }
    }
}

/// Why each of these trials may not be what it is taken for.
pub(super) fn doubts(trials: &[Outline]) -> Vec<Vec<String>> {
    let mut doubts: Vec<Vec<String>> =
        trials.iter().map(|trial| against_others(trial, trials)).collect();
    for (shortest, doubt) in odd_files(trials) {
        doubts[shortest].push(doubt);
    }
    doubts
}

/// Doubts about a trial that differs from the others of its kind.
fn against_others(trial: &Outline, trials: &[Outline]) -> Vec<String> {
    let others: Vec<&Outline> = trials
        .iter()
        .filter(|other| (&trial.environment, trial.kind) == (&other.environment, other.kind))
        .collect();
    let mut doubts = Vec::new();
    let moves = others.iter().any(|other| other.moves == Some(true));
    if trial.moves == Some(false) && moves {
        doubts.push("theta_rad: it is one value throughout, and changes in other trials; look at the sensor".to_owned());
    }
    // The trial is one of them.
    if others.len() <= LEAST_OTHERS {
        return doubts;
    }
    // A single load that is held looks like a sensor at its end; several loads differ.
    let plateau = |trial: &Outline| Some(trial.largest?.1?.value.to_bits());
    let own = plateau(trial);
    let standing = others.iter().filter(|other| own.is_some() && plateau(other) == own);
    let at_an_end = standing.count() >= LEAST_OTHERS
        && !others
            .iter()
            .any(|other| other.largest.zip(trial.largest).is_some_and(|(o, own)| o.0 > own.0));
    if let Some((_, Some(Plateau { value, .. }))) =
        trial.largest.filter(|_| trial.moves != Some(true) && at_an_end)
    {
        doubts.push(format!(
            "force_ex_n: it stands at {value}, its largest value, as other trials do, and none goes farther: is the sensor, or \
             its converter, at the end of its range?"
        ));
    }
    let span_s = median(others.iter().map(|other| other.span_s).collect());
    if trial.span_s < STUMP * span_s {
        doubts.push(format!(
            "t_s: it lasts {:.2} s, and the trials of {} last {span_s:.2} s (their median): is it a stump, which a label that \
             changes within a trial leaves?",
            trial.span_s, trial.environment
        ));
    }
    let rate_hz = median(others.iter().map(|other| other.rate_hz).collect());
    if (trial.rate_hz / rate_hz - 1.0).abs() > OTHER_RATE {
        doubts.push(format!(
            "t_s: it has {:.1} samples a second, and the trials of {} have {rate_hz:.1}; look at the unit and the clock",
            trial.rate_hz, trial.environment
        ));
    }
    doubts
}

/// The shortest trial of each file that has more trials than most files, or fewer, and why it may be none.
fn odd_files(trials: &[Outline]) -> Vec<(usize, String)> {
    let files: Vec<&[Outline]> = trials.chunk_by(|a, b| a.file == b.file).collect();
    let counts: Vec<usize> = files.iter().map(|file| file.len()).collect();
    let frequency = |n: usize| counts.iter().filter(|m| **m == n).count();
    // Of two that are as frequent the smaller: labels part trials more often than they join them.
    let usual = counts.iter().copied().max_by_key(|n| (frequency(*n), std::cmp::Reverse(*n)));
    let Some(usual) =
        usual.filter(|usual| counts.len() >= LEAST_OTHERS && frequency(*usual) < counts.len())
    else {
        return Vec::new();
    };
    let (mut odd, mut begin) = (Vec::new(), 0);
    for file in files {
        if file.len() != usual {
            let spans = file.iter().enumerate();
            let shortest =
                spans.min_by(|a, b| a.1.span_s.total_cmp(&b.1.span_s)).map_or(0, |(i, _)| i);
            odd.push((
                begin + shortest,
                format!(
                    "its file has {} trials, and {} of {} files have {usual}; this is its shortest: does a label change within a \
                     trial, or are trials missing?",
                    file.len(),
                    frequency(usual),
                    counts.len()
                ),
            ));
        }
        begin += file.len();
    }
    odd
}
