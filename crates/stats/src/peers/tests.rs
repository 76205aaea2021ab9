//! Four studies by formula, of which the programs printed these numbers: lmerTest 3.1.3, pbkrtest 0.5.2 and emmeans 1.8.4.1 with lme4
//! 1.1.31 tightly converged, statsmodels 0.15.0, pingouin 0.7.0, pyfixest 0.60.0.

use super::*;
use crate::studentised_range::StudentisedRange;
use crate::tested::Unestimable;
use core::f64::consts::SQRT_2;

/// A number between −1/2 and 1/2: (h³ mod 9941) / 9941 − 1/2.
fn u(a: u64, b: u64, c: u64) -> f64 {
    let h = 1 + 131 * a + 173 * b + 197 * c;
    (h * h * h % 9941) as f64 / 9941.0 - 0.5
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Case {
    Complete,
    MissingTrials,
    /// The third participant has no trial in the third mode.
    LacksMode,
    /// Participants differ in nothing.
    NoVariance,
}

struct Data {
    participant: Vec<usize>,
    mode: Vec<usize>,
    value: Vec<f64>,
}

impl Data {
    fn of(case: Case) -> Self {
        let mut data = Self { participant: vec![], mode: vec![], value: vec![] };
        for p in 0..6_u64 {
            for m in 0..3_u64 {
                for r in 0..4_u64 {
                    let value = match case {
                        Case::NoVariance => {
                            let noise = |r| u(3 * p + m, 7 * r + 1, 0);
                            let own = (0..4).map(noise).sum::<f64>() / 4.0;
                            2.0 + 0.3 * m as f64 + 0.6 * noise(r) - 0.54 * own
                        }
                        _ => {
                            let own = 0.8 * u(p, 0, 0) + 0.5 * u(p, m + 1, 0);
                            2.0 + 0.3 * m as f64 + own + 0.6 * u(p, m + 1, r)
                        }
                    };
                    let is_missing = match case {
                        Case::MissingTrials => (p + 2 * m + 3 * r) % 7 == 0,
                        Case::LacksMode => (p, m) == (2, 2),
                        Case::Complete | Case::NoVariance => false,
                    };
                    if !is_missing {
                        data.participant.push(p as usize);
                        data.mode.push(m as usize);
                        data.value.push((value * 1e4).round() / 1e4);
                    }
                }
            }
        }
        data
    }

    fn fitted(&self) -> Fitted<'_> {
        let Self { participant, mode, value } = self;
        Fitted::of(Trials { participant, mode, value }).unwrap()
    }
}

#[track_caller]
fn near(found: f64, expected: f64, relative: f64) {
    assert!((found - expected).abs() <= relative * expected.abs(), "{found} {expected}");
}

/// Estimate, standard error, degrees of freedom, p. What lmerTest takes from finite differences has five digits.
type Four = [f64; 4];

#[track_caller]
fn check(case: Case, peer: Peer, [estimate, std_error, df, p]: Four, relative: f64) -> Printed {
    let data = Data::of(case);
    let found = data.fitted().printed(peer, [2, 0], 0.95).unwrap();
    near(found.estimate, estimate, relative);
    near(found.std_error.unwrap(), std_error, relative);
    if df.is_finite() {
        near(found.df, df, relative);
    } else {
        assert!(found.df.is_infinite());
    }
    // Far out p changes by a hundred times the share by which t does. emmeans prints four decimals, and R's `ptukey` has
    // not many more: 4.965e-8 for 4.752e-8.
    match peer {
        Peer::Emmeans => assert!((found.p_value - p).abs() < 1e-8, "{} {p}", found.p_value),
        _ => near(found.p_value, p, 100.0 * relative),
    }
    found
}

const R: f64 = 1e-6;

#[test]
fn lmer_test_with_an_intercept_counts_trials() {
    for (case, printed) in [
        (Case::Complete, [0.642504166667, 0.0592475071516, 64.0, 3.92604712833e-16]),
        (Case::MissingTrials, [0.656912730197, 0.0663946245295, 53.0431948943, 1.20867637533e-13]),
        (Case::LacksMode, [0.580246954053, 0.0605942677133, 60.3847793243, 1.00753383307e-13]),
        (Case::NoVariance, [0.598491666667, 0.0370974040707, 69.0, 4.12101551894e-25]),
    ] {
        let found = check(case, Peer::LmerTest, printed, R);
        assert_eq!(found.singular, case == Case::NoVariance);
        assert_eq!(found.interval, None);
    }
}

#[test]
fn lmer_test_with_modes_counts_people_unless_a_variance_is_zero() {
    for (case, printed) in [
        (Case::Complete, [0.642504166667, 0.0985022878556, 10.0, 6.69972684949e-05]),
        (Case::MissingTrials, [0.636157177612, 0.109479124174, 10.0173109405, 0.000169302390452]),
        (Case::LacksMode, [0.56993392613588, 0.09880297631848, 8.9377908683, 0.00027716207163]),
        (Case::NoVariance, [0.598491666667, 0.0370974040707, 69.0, 4.12101551894e-25]),
    ] {
        check(case, Peer::LmerTestModes, printed, R);
    }
}

#[test]
fn pbkrtest_counts_people_always() {
    for (case, printed) in [
        (Case::Complete, [0.642504166667, 0.0985022878556, 10.0, 6.69972761383e-05]),
        (Case::MissingTrials, [0.636157177612, 0.109498156932, 10.0545558118, 0.000167106144809]),
        (Case::LacksMode, [0.569933926135878, 0.09938922063452, 9.19185548403, 0.000260305197375]),
        (Case::NoVariance, [0.598491666667, 0.0370974040707, 10.0, 1.73337440891e-08]),
    ] {
        check(case, Peer::Pbkrtest, printed, R);
    }
}

#[test]
fn emmeans_adjusts_for_every_pair_of_modes() {
    for (case, printed, ends, size) in [
        (
            Case::Complete,
            [0.642504166667, 0.0985022878556, 10.0, 0.000179488312754],
            [0.372480324822, 0.912528008511],
            3.81509778945,
        ),
        (
            Case::MissingTrials,
            [0.636157177612, 0.109498156932, 10.0545558118, 0.00044493573527],
            [0.336257576673, 0.93605677855],
            3.91870445851,
        ),
        (
            Case::LacksMode,
            [0.569933926135878, 0.09938922063452, 9.19185548403, 0.000682743090376],
            [0.293502440943, 0.846365411329],
            3.44871072618,
        ),
        (
            Case::NoVariance,
            [0.598491666667, 0.0370974040707, 10.0, 4.96502290392e-08],
            [0.496796733608, 0.700186599726],
            4.65719008531,
        ),
    ] {
        let found = check(case, Peer::Emmeans, printed, R);
        let interval = found.interval.unwrap();
        near(interval[0], ends[0], R);
        near(interval[1], ends[1], R);
        near(found.effect_size.unwrap(), size, R);
        assert_eq!(found.reference, Reference::StudentisedRange(3));
    }
}

#[test]
fn statsmodels_takes_the_normal_distribution_and_the_observed_information() {
    for (case, printed, ends) in [
        (
            Case::Complete,
            [0.6425041666666667, 0.0592475071905, f64::INFINITY, 2.1200288939e-27],
            [0.5263811863995, 0.7586271469339],
        ),
        (
            Case::MissingTrials,
            [0.6569127302052, 0.0663959981583, f64::INFINITY, 4.4262313368e-23],
            [0.5267789650974, 0.7870464953131],
        ),
        (
            Case::LacksMode,
            [0.5802469538376, 0.060730320646, f64::INFINITY, 1.2419977332e-21],
            [0.4612177126019, 0.6992761950733],
        ),
        (
            Case::NoVariance,
            [0.5984916666667, 0.0370972854087, f64::INFINITY, 1.49499056e-58],
            [0.5257823233414, 0.6712010099919],
        ),
    ] {
        // Where the variance is zero it stops beside the optimum.
        let relative = if case == Case::NoVariance { 1e-5 } else { R };
        let found = check(case, Peer::Statsmodels, printed, relative);
        let interval = found.interval.unwrap();
        near(interval[0], ends[0], relative);
        near(interval[1], ends[1], relative);
    }
}

#[test]
fn pingouin_leaves_out_who_lacks_any_mode() {
    for (case, [estimate, t, df, p, g]) in [
        (Case::Complete, [0.6425041666667, 5.9002018602758, 5.0, 0.0019897843476, 2.200061533382]),
        (
            Case::MissingTrials,
            [0.6309027777778, 5.2685110276523, 5.0, 0.0032757963119, 2.0187282196799],
        ),
        (Case::LacksMode, [0.56721, 5.886931755648, 4.0, 0.0041624619239, 3.1307476266218]),
        (
            Case::NoVariance,
            [0.5984916666667, 94.4801858326935, 5.0, 2.5181351482e-09, 54.848021770552],
        ),
    ] {
        let data = Data::of(case);
        let found = data.fitted().printed(Peer::Pingouin, [2, 0], 0.95).unwrap();
        near(found.estimate, estimate, 1e-9);
        near(found.statistic, t, 1e-9);
        near(found.df, df, 1e-12);
        near(found.p_value, p, 1e-8);
        near(found.effect_size.unwrap(), g, 1e-9);
        let all: Vec<usize> = (0..6).filter(|p| case != Case::LacksMode || *p != 2).collect();
        assert_eq!((found.participants, found.std_error, found.interval), (all, None, None));
        // Who is left out lacks the third mode: the other two are compared without them too.
        let others = data.fitted().printed(Peer::Pingouin, [1, 0], 0.95).unwrap();
        assert_eq!(others.participants.len(), if case == Case::LacksMode { 5 } else { 6 });
    }
}

#[test]
fn pyfixest_counts_trials_unless_it_is_told_of_participants() {
    for (case, plain, clustered) in [
        (
            Case::Complete,
            [0.6425041666667, 0.0592475071905, 64.0],
            [0.1104622047649, 0.0021204731436, 0.3585520295738, 0.9264563037595],
        ),
        (
            Case::MissingTrials,
            [0.657559798995, 0.0664081882427, 53.0],
            [0.123381394908, 0.0031158974858, 0.3403978263889, 0.9747217716011],
        ),
        (
            Case::LacksMode,
            [0.5865129166667, 0.060694284137, 60.0],
            [0.0938397083804, 0.0015365534425, 0.3452902668426, 0.8277355664908],
        ),
        (
            Case::NoVariance,
            [0.5984916666667, 0.0385022895506, 64.0],
            [0.0064257229679, 2.7045006234516e-09, 0.5819738199245, 0.6150095134088],
        ),
    ] {
        let data = Data::of(case);
        let found = data.fitted().printed(Peer::Pyfixest, [2, 0], 0.95).unwrap();
        near(found.estimate, plain[0], 1e-9);
        near(found.std_error.unwrap(), plain[1], 1e-9);
        near(found.df, plain[2], 1e-12);
        let found = data.fitted().printed(Peer::PyfixestClustered, [2, 0], 0.95).unwrap();
        near(found.std_error.unwrap(), clustered[0], 1e-9);
        near(found.p_value, clustered[1], 1e-7);
        near(found.interval.unwrap()[0], clustered[2], 1e-8);
        near(found.interval.unwrap()[1], clustered[3], 1e-8);
        near(found.df, 5.0, 1e-12);
    }
}

#[test]
fn a_participant_with_a_single_trial_tells_pyfixest_nothing() {
    let mut data = Data::of(Case::Complete);
    let all = data.fitted().printed(Peer::PyfixestClustered, [2, 0], 0.95).unwrap();
    data.participant.push(6);
    data.mode.push(0);
    data.value.push(9.0);
    let found = data.fitted().printed(Peer::PyfixestClustered, [2, 0], 0.95).unwrap();
    assert_eq!((found.participants.len(), found.trials), (6, 72));
    near(found.std_error.unwrap(), all.std_error.unwrap(), 1e-9);
}

/// emmeans 1.8.4.1 prints "Inf" of more than 3000 trials, and p = 0.0295 for z = −2.544.
#[test]
fn emmeans_has_no_degrees_of_freedom_for_many_trials() {
    let repeats = EMMEANS_LIMIT / 18 + 1;
    let mut data = Data { participant: vec![], mode: vec![], value: vec![] };
    for p in 0..6_u64 {
        for m in 0..3_u64 {
            for r in 0..repeats as u64 {
                data.participant.push(p as usize);
                data.mode.push(m as usize);
                data.value.push(u(p, 7, 1) + u(p, m, 2) + 2.0 * u(17 * p + m, r, 3));
            }
        }
    }
    let found = data.fitted().printed(Peer::Emmeans, [2, 0], 0.95).unwrap();
    assert!(found.df.is_infinite());
    let t = data.fitted().printed(Peer::Pbkrtest, [2, 0], 0.95).unwrap();
    near(found.std_error.unwrap(), t.std_error.unwrap(), 1e-9);
    near(t.df, 10.0, 1e-9);
    let range = StudentisedRange::new(3, f64::INFINITY).unwrap();
    near(range.upper_p(2.544 * SQRT_2), 0.0295, 2e-3);
}

#[test]
fn data_without_an_answer_say_why() {
    let one =
        Trials { participant: &[1, 1, 1, 1], mode: &[0, 0, 1, 1], value: &[1.0, 2.0, 3.0, 4.5] };
    assert!(Fitted::of(one).is_err());
    // One trial of each condition: participant × mode is the residual.
    let single = Trials {
        participant: &[0, 0, 1, 1, 2, 2],
        mode: &[0, 1, 0, 1, 0, 1],
        value: &[1.0, 2.0, 3.0, 4.5, 2.0, 2.5],
    };
    let fitted = Fitted::of(single).unwrap();
    assert!(fitted.printed(Peer::LmerTest, [0, 1], 0.95).is_ok());
    for peer in [Peer::LmerTestModes, Peer::Pbkrtest, Peer::Emmeans] {
        let refused = fitted.printed(peer, [0, 1], 0.95);
        assert!(matches!(refused, Err(Unestimable::Confounded { .. })), "{refused:?}");
    }
    assert!(fitted.printed(Peer::LmerTest, [0, 7], 0.95).is_err());
    // Nobody has both modes.
    let apart =
        Trials { participant: &[0, 0, 1, 1], mode: &[0, 0, 1, 1], value: &[1.0, 2.0, 3.0, 4.5] };
    if let Ok(fitted) = Fitted::of(apart) {
        for peer in [Peer::Pingouin, Peer::Pyfixest, Peer::PyfixestClustered] {
            assert!(fitted.printed(peer, [0, 1], 0.95).is_err());
        }
    }
}
