//! Metrics of a study's own: one number of one quantity over one part of a trial.

use crate::part::Part;
use crate::signals::Signals;
use crate::{MetricsError, Parameters};
use zwidth_store::{Signal, Values};
use zwidth_study::{OwnMetric, Statistic, TrialPart};

/// The study's own metrics of a trial, in the order of study.toml. Null where the quantity is not
/// recorded, and where the trial has no such part.
pub(crate) fn own_metrics(
    signals: &Signals,
    parameters: &Parameters,
) -> Result<Vec<Option<f64>>, MetricsError> {
    let wall_rad = parameters.scene.wall_rad();
    parameters.own.iter().map(|metric| own_metric(metric, signals, wall_rad)).collect()
}

fn own_metric(
    metric: &OwnMetric,
    signals: &Signals,
    wall_rad: Option<f64>,
) -> Result<Option<f64>, MetricsError> {
    let t = signals.t()?;
    let phases = signals.phases;
    let part = match metric.over {
        TrialPart::Recording => Some(Part::between(0, t.len() - 1, t.len())),
        TrialPart::Movement => phases.map(|p| Part::between(p.onset, p.end, t.len())),
        TrialPart::Compression => phases.map(|p| Part::between(p.onset, p.reversal, t.len())),
        TrialPart::Decompression => phases.map(|p| Part::between(p.reversal, p.end, t.len())),
        TrialPart::PastWall => {
            signals.theta().zip(wall_rad).map(|(theta, wall)| Part::past(&theta, wall))
        }
    };
    let Some((part, y)) = part.zip(quantity(&metric.of, signals)) else { return Ok(None) };
    Ok(of_part(metric.statistic, &part, &t, &y))
}

/// A channel of the study or a column; the user's force as every metric takes it.
fn quantity<'a>(name: &str, signals: &Signals<'a>) -> Option<Values<'a>> {
    match Signal::from_name(name) {
        Some(Signal::ForceEx) => signals.force(),
        Some(signal) => signals.column(signal),
        None => signals.channel(name),
    }
}

/// Null where no sample belongs to the part.
fn of_part(statistic: Statistic, part: &Part, t: &[f64], y: &[f64]) -> Option<f64> {
    let first = part.places().next()?;
    let max = part.largest(y)?;
    let min = part.places().map(|i| y[i]).reduce(f64::min)?;
    let duration = |i: usize, share: f64| share * (t[i + 1] - t[i]);
    let integral = |y: &[f64]| {
        part.over_pieces(|piece| piece.mean(y) * duration(piece.i, piece.to - piece.from))
    };
    let span_s = part.over_pieces(|piece| duration(piece.i, piece.to - piece.from));
    // A single sample has no duration to divide by.
    let mean = |y: &[f64]| if span_s > 0.0 { integral(y) / span_s } else { y[first] };
    let mean_square = |about: f64| {
        let squares: Vec<f64> = y.iter().map(|y| (y - about) * (y - about)).collect();
        mean(&squares).sqrt()
    };
    Some(match statistic {
        Statistic::Mean => mean(y),
        Statistic::Rms => mean_square(0.0),
        Statistic::Sd => mean_square(mean(y)),
        Statistic::Min => min,
        Statistic::Max => max,
        Statistic::MaxAbs => max.abs().max(min.abs()),
        Statistic::Range => max - min,
        Statistic::Path => {
            part.over_pieces(|piece| (piece.to - piece.from) * (y[piece.i + 1] - y[piece.i]).abs())
        }
        Statistic::Integral => integral(y),
        Statistic::TimeToMax => t[part.places().find(|i| y[*i] >= max)?] - t[first],
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{REST_RAD, at_wall, check, in_spring, only, stroke, trial};
    use crate::trial_metrics;
    use core::f64::consts::{FRAC_1_SQRT_2, PI};
    use zwidth_store::Trial;

    fn metric(of: &str, statistic: Statistic, over: TrialPart) -> OwnMetric {
        OwnMetric {
            id: "own".parse().unwrap(),
            of: of.to_owned(),
            statistic,
            over,
            label: "own".to_owned(),
            unit: "1".to_owned(),
            better: zwidth_study::Better::Neither,
        }
    }

    fn found(trial: &Trial, parameters: &Parameters, own: OwnMetric) -> Option<f64> {
        let parameters = Parameters { own: vec![own], ..parameters.clone() };
        trial_metrics(trial, &parameters).unwrap().own[0]
    }

    /// The grip g = sin(π t) for two seconds: its numbers are those of a sine.
    #[test]
    fn every_statistic_of_a_channel_over_the_recording_is_that_of_its_sine() {
        let mut gripped = trial(&stroke(1.0, 1.0), |_, _| 0.0);
        let t = gripped.samples.get(Signal::Time).unwrap().to_vec();
        let grip: Vec<f64> = t.iter().map(|t| 1.0 + libm::sin(PI * t)).collect();
        gripped.samples.set_channel("grip_n".parse().unwrap(), grip);
        let parameters = in_spring(4.0, REST_RAD);
        let of = |statistic| {
            let own = metric("grip_n", statistic, TrialPart::Recording);
            found(&gripped, &parameters, own)
        };
        for (statistic, expect) in [
            (Statistic::Mean, 1.0),
            (Statistic::Rms, 1.5_f64.sqrt()),
            (Statistic::Sd, FRAC_1_SQRT_2),
            (Statistic::Min, 0.0),
            (Statistic::Max, 2.0),
            (Statistic::MaxAbs, 2.0),
            (Statistic::Range, 2.0),
            (Statistic::Path, 4.0),
            (Statistic::Integral, 2.0),
            (Statistic::TimeToMax, 0.5),
        ] {
            check(of(statistic), expect, 2e-6);
        }
        let other = metric("other_n", Statistic::Max, TrialPart::Recording);
        assert_eq!(found(&gripped, &parameters, other), None, "not recorded");
    }

    #[test]
    fn a_rule_gives_what_the_metric_of_that_name_gives() {
        let force = |theta: f64, v: f64| 4.0 * (theta - REST_RAD) + 0.3 * v.signum();
        let pushed = trial(&stroke(1.2, 2.0), force);
        let parameters = at_wall(4.0, REST_RAD, REST_RAD + 1.0);
        let row = trial_metrics(&pushed, &parameters).unwrap();
        let of =
            |of: &str, statistic, over| found(&pushed, &parameters, metric(of, statistic, over));
        use {Statistic::*, TrialPart::*};
        for (own, built_in) in [
            (of("force_ex_n", Mean, Recording), row.force.mean_n),
            (of("force_ex_n", Rms, Recording), row.force.rms_n),
            (of("force_ex_n", TimeToMax, Movement), row.force.peak_s),
            (of("theta_rad", Path, Movement), row.movement.path_rad),
            (of("theta_rad", Max, Compression), row.movement.theta_max_rad),
            (of("theta_dot_rad_s", Max, Compression), row.movement.velocity_forward_peak_rad_s),
            (
                of("theta_dot_rad_s", MaxAbs, Decompression),
                row.movement.velocity_backward_peak_rad_s,
            ),
            (of("force_ex_n", Integral, PastWall), row.wall.impulse_n_s),
            (of("force_ex_n", Max, PastWall), row.wall.force_max_n),
        ] {
            check(own, built_in.unwrap(), 1e-12);
        }
    }

    #[test]
    fn a_part_that_a_trial_does_not_have_gives_nothing_and_a_single_sample_is_its_own_mean() {
        let pushed = trial(&stroke(1.0, 2.0), |_, _| 1.0);
        let own = || metric("force_ex_n", Statistic::Mean, TrialPart::PastWall);
        assert_eq!(found(&pushed, &in_spring(4.0, REST_RAD), own()), None, "no wall");
        let far = at_wall(4.0, REST_RAD, REST_RAD + 2.0);
        assert_eq!(found(&pushed, &far, own()), None, "not reached");
        let mut still = only(&pushed, []);
        still.samples.set(Signal::Time, vec![0.0]);
        still.samples.set(Signal::ForceEx, vec![2.5]);
        for (over, expect) in [(TrialPart::Recording, Some(2.5)), (TrialPart::Movement, None)] {
            let own = metric("force_ex_n", Statistic::Mean, over);
            assert_eq!(found(&still, &far, own), expect);
        }
    }

    #[test]
    fn a_column_has_the_unit_of_its_signal() {
        for (name, unit) in OwnMetric::COLUMNS {
            assert_eq!(Signal::from_name(name).unwrap().column().unit, unit, "{name}");
        }
    }
}
