//! Rows of results.
#![expect(clippy::missing_panics_doc, reason = "an id that is none is a failed test")]

use zwidth_results::{Compared, Mean, ModeDifference, Role, UnitOfAnalysis, Verdict};

/// A primary metric.
pub fn metric(id: &str, unit: &str, words: &str, of: UnitOfAnalysis) -> Compared {
    Compared {
        metric: id.parse().unwrap(),
        unit: unit.into(),
        words: words.to_owned(),
        role: Role::Primary,
        unit_of_analysis: of,
    }
}

/// A metric's mean of six in a mode of `spring`.
pub fn mean(metric: &Compared, mode: &str, mean: f64, sd: Option<f64>) -> Mean {
    Mean {
        metric: metric.metric.clone(),
        unit: metric.unit.clone(),
        environment: "spring".parse().unwrap(),
        mode: mode.parse().unwrap(),
        unit_of_analysis: metric.unit_of_analysis.clone(),
        n: 6,
        trials: 6,
        trials_with_value: 6,
        mean,
        sd,
        ci_low: None,
        ci_high: None,
    }
}

/// A metric's difference between hybrid and active in `spring`: −0.1 [−0.15, −0.05].
pub fn difference(metric: &Compared, verdict: Verdict) -> ModeDifference {
    let people = metric.unit_of_analysis == UnitOfAnalysis::Participants;
    let of_people = |value: f64| people.then_some(value);
    ModeDifference {
        metric: metric.metric.clone(),
        unit: metric.unit.clone(),
        environment: "spring".parse().unwrap(),
        contrast: "hybrid − active".parse().unwrap(),
        unit_of_analysis: metric.unit_of_analysis.clone(),
        n: 6,
        sessions: Some(1),
        mean_first: 0.1,
        mean_second: 0.2,
        difference: -0.1,
        difference_std_error: Some(0.02),
        difference_ci_low: Some(-0.15),
        difference_ci_high: Some(-0.05),
        statistic: of_people(-5.0),
        df: Some(5.0),
        p_value: None,
        p_adjusted: Some(0.0123),
        smallest_p_adjusted: None,
        g_av: None,
        d_av: of_people(-1.25),
        d_av_ci_low: None,
        d_av_ci_high: None,
        g_z: None,
        d_z: None,
        d_z_ci_low: None,
        d_z_ci_high: None,
        p_sign_flip: None,
        p_signed_rank: None,
        p_sharp_null: None,
        commanded: None,
        jnd: None,
        difference_jnd: None,
        difference_jnd_ci_low: None,
        difference_jnd_ci_high: None,
        size: None,
        bound: None,
        p_not_equivalent: None,
        verdict,
        remark: None,
    }
}
