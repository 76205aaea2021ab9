//! Whether a recorded movement oscillated, how fast, and how strongly.

use crate::MetricsError;
use crate::compliance::range;
use crate::signals::Signals;
use zwidth_numerics::order::upper_median;
use zwidth_numerics::phases::Phases;
use zwidth_numerics::spectrum::{BandPower, band_power};
use zwidth_numerics::zigzag::zigzag;
use zwidth_results::RecordedStability;

/// The band of oscillations, Hz: above what a hand does on purpose, up to what is felt as motion.
const BAND_HZ: (usize, usize) = (5, 50);
/// A turn of the lever is a retreat by more than this share of the angles travelled: a dozen counts
/// of the angle sensor in a stroke of 77°.
const TURN_SHARE: f64 = 0.002;
/// No hand reverses faster than this, s: half a period at 5 Hz.
const FAST_S: f64 = 0.1;
/// Fewer fast swings are an impact or a transient (as in `zwidth_dynamics::verdict`).
const FEW: usize = 6;
/// Fewest samples in the time of a fast swing that show it.
const SAMPLES_A_SWING: f64 = 4.0;

/// How the lever swung between onset and end.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Swings {
    /// Turns of the lever: extremes of θ from which it retreats by more than 0.2 % of the angles
    /// travelled. A movement there and back has one. Null without a movement.
    pub reversals: Option<i64>,
    /// Fast swings: turns within 0.1 s of the one before. Null if there are fewer than 40 samples
    /// per second.
    pub fast: Option<i64>,
    /// Their verdict; null with them.
    pub verdict: Option<RecordedStability>,
    /// Frequency of the fast swings where there are at least six: 1 / (2 · their mean duration),
    /// Hz.
    pub frequency_hz: Option<f64>,
    /// Their median angle between two turns, rad.
    pub amplitude_rad: Option<f64>,
}

pub(crate) fn swings(signals: &Signals) -> Result<Swings, MetricsError> {
    let Some((theta, Phases { onset, end, .. })) = signals.theta().zip(signals.phases) else {
        return Ok(Swings::default());
    };
    let t = signals.t()?;
    let t = &t[onset..=end];
    let theta = &theta[onset..=end];
    let legs = zigzag(theta, TURN_SHARE * range(theta));
    let turns: Vec<usize> = legs.iter().skip(1).map(|leg| leg.from).collect();
    let reversals = Some(turns.len() as i64);
    // Too few samples show no fast swing, which is not the same as none.
    if rate_hz(t).is_none_or(|rate| rate * FAST_S < SAMPLES_A_SWING) {
        return Ok(Swings { reversals, ..Swings::default() });
    }
    let swings = turns.windows(2).map(|w| (t[w[1]] - t[w[0]], (theta[w[1]] - theta[w[0]]).abs()));
    let fast: Vec<_> = swings.filter(|(duration, _)| *duration < FAST_S).collect();
    let oscillates = fast.len() >= FEW;
    let verdict =
        if oscillates { RecordedStability::Oscillating } else { RecordedStability::Smooth };
    Ok(Swings {
        reversals,
        fast: Some(fast.len() as i64),
        verdict: Some(verdict),
        frequency_hz: oscillates
            .then(|| fast.len() as f64 / (2.0 * fast.iter().map(|s| s.0).sum::<f64>())),
        amplitude_rad: upper_median(fast.iter().map(|s| s.1)).filter(|_| oscillates),
    })
}

/// Mean rate of samples, Hz; `None` for a single one.
fn rate_hz(t: &[f64]) -> Option<f64> {
    let first = t.first()?;
    let last = t.last()?;
    (last > first).then(|| (t.len() - 1) as f64 / (last - first))
}

/// What θ̇ does from 5 to 50 Hz between onset and end.
pub(crate) fn velocity_band(signals: &Signals) -> Result<Option<BandPower>, MetricsError> {
    let Some((velocity, Phases { onset, end, .. })) = signals.theta_dot().zip(signals.phases)
    else {
        return Ok(None);
    };
    Ok(band(&signals.t()?[onset..=end], &velocity[onset..=end], f64::INFINITY))
}

/// What the user's force does there, by the values its sensor gave at the times it gave them: a
/// held value would add steps. `force_rate_hz` bounds the rate where no age of the values is
/// recorded.
pub(crate) fn force_band(
    signals: &Signals,
    force_rate_hz: Option<f64>,
) -> Result<Option<BandPower>, MetricsError> {
    let Some(Phases { onset, end, .. }) = signals.phases else { return Ok(None) };
    let t = signals.t()?;
    if let Some(updates) = signals.force_updates() {
        let from = updates.t.partition_point(|at| *at < t[onset]);
        let to = updates.t.partition_point(|at| *at <= t[end]);
        return Ok(band(&updates.t[from..to], &updates.values[from..to], f64::INFINITY));
    }
    let Some(force) = signals.force() else { return Ok(None) };
    Ok(band(&t[onset..=end], &force[onset..=end], force_rate_hz.unwrap_or(f64::INFINITY)))
}

/// The band of a signal whose source gives at most `most_hz` values per second.
fn band(t: &[f64], y: &[f64], most_hz: f64) -> Option<BandPower> {
    let nyquist_hz = rate_hz(t)?.min(most_hz) / 2.0;
    band_power(t, y, nyquist_hz, BAND_HZ.0, BAND_HZ.1)
}
