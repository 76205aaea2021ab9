//! What the cumulative-link model, and the probability of superiority, say of answers that no mode
//! changes.

use crate::drawn::{Kind, Study, tidy};
use crate::judged::{Asked, Judged, LEVEL, MOST, Said, judge};
use zwidth_stats::Tested;
use zwidth_stats::clmm::{
    Column, End, Fit, Integral, Model, Ratings, RatioTest, Terms, bootstrap, fit, profile_interval,
    test_columns,
};
use zwidth_stats::superiority::{Repeats, superiority};

/// As `compare_modes` takes it for studies of this size.
const INTEGRAL: Integral = Integral::Quadrature;
/// As in `compare_modes`: from so many participants on no bootstrap decides.
pub(crate) const FEW: usize = 8;
/// Studies that a bootstrap draws here, 999 in `compare_modes`. With 19 a share of 5 % is one of
/// 20, so p ≤ 5 % is as likely as with 999 (Davison & Hinkley 1997, §4.2); only power would be
/// lost.
const RESAMPLES: usize = 19;
/// Columns of the model: the second mode and the last, against the first.
const MODES: [usize; 2] = [0, 1];
const LAST: usize = 1;
/// What is asked of intervals is that of the profile.
const APPROXIMATE: Asked = Asked::Approximate { most: MOST, coverage: [0.93, 1.0] };

fn model(study: &Study) -> Option<Model> {
    let (participants, modes, values) = tidy(study);
    let answers: Vec<u8> = values.iter().map(|value| *value as u8).collect();
    let column = |mode: usize| Column {
        name: format!("mode {mode}"),
        values: modes.iter().map(|at| f64::from(u8::from(*at == mode))).collect(),
    };
    let columns = [column(1), column(2)];
    let (participants, modes) = (&participants, &modes);
    let ratings = Ratings { answers: &answers, points: 5, columns: &columns, participants, modes };
    Model::new(&ratings, Terms::ParticipantAndMode).ok()
}

fn fitted(study: &Study, integral: Integral) -> Option<(Model, Fit)> {
    let model = model(study)?;
    let fit = fit(&model, integral).ok()?;
    Some((model, fit))
}

/// The likelihood ratio of some columns; none where there is no estimate.
fn ratio(
    fitted: Option<&(Model, Fit)>,
    integral: Integral,
    columns: &[usize],
) -> Option<RatioTest> {
    let (model, fit) = fitted?;
    test_columns(model, integral, fit, columns, model.mode_df()).ok()
}

/// The likelihood ratios of "no mode differs" and of the contrast of the last mode with the first,
/// referred to F and to χ²; and P(last > first) + ½ P(equal), whose truth is ½.
pub(crate) fn tests(kind: Kind, studies: usize) -> Vec<Judged> {
    let pooled = if kind.is_even() { APPROXIMATE } else { Asked::Nothing };
    let tests = [
        ("F, any mode", pooled),
        ("F, contrast", pooled),
        ("χ², any mode", Asked::Nothing),
        ("χ², contrast", Asked::Nothing),
        ("superiority", Asked::Nothing),
    ];
    judge(studies, tests, |number| {
        let study = kind.draw(number);
        let fitted = fitted(&study, INTEGRAL);
        let [any, contrast] =
            [&MODES[..], &[LAST]].map(|columns| ratio(fitted.as_ref(), INTEGRAL, columns));
        [
            Said::by_p(any.map(|found| found.f.p_value)),
            Said::by_p(contrast.map(|found| found.f.p_value)),
            Said::by_p(any.map(|found| found.chi_square.p_value)),
            Said::by_p(contrast.map(|found| found.chi_square.p_value)),
            Said::by_estimate(delta(&study)),
        ]
    })
}

/// P(last > first) + ½ P(equal) as Cliff's δ, whose truth is 0.
fn delta(study: &Study) -> Option<Tested> {
    let whole = |repeats: &[f64]| repeats.iter().map(|answer| *answer as u8).collect::<Vec<_>>();
    let pairs: Vec<[Vec<u8>; 2]> =
        study.iter().map(|[first, _, last]| [whole(last), whole(first)]).collect();
    let repeats: Vec<Repeats<u8>> = pairs.iter().map(|[a, b]| Repeats { a, b }).collect();
    superiority(&repeats, LEVEL).ok()?.cliff_delta.ok()
}

/// The profile interval of the contrast of the last mode with the first, whose truth is 0.
pub(crate) fn profiles(kind: Kind, studies: usize) -> Vec<Judged> {
    let pooled = if kind.is_even() { APPROXIMATE } else { Asked::Nothing };
    judge(studies, [("profile", pooled)], |number| {
        let interval = fitted(&kind.draw(number), INTEGRAL).and_then(|(model, fit)| {
            profile_interval(&model, INTEGRAL, &fit, LAST, LEVEL, model.mode_df()).ok()
        });
        let covers = interval.and_then(|interval| {
            let low = holds(&interval.low, |low| low <= 0.0)?;
            Some(low && holds(&interval.high, |high| 0.0 <= high)?)
        });
        [Said { rejects: None, covers }]
    })
}

/// Whether an end lies on its side of the truth: one that the answers do not set does.
fn holds(end: &End, lies: fn(f64) -> bool) -> Option<bool> {
    match end {
        End::At(value) => Some(lies(*value)),
        End::Open => Some(true),
        End::NotFound(_) => None,
    }
}

/// The parametric bootstrap of "no mode differs".
pub(crate) fn bootstraps(kind: Kind, studies: usize) -> Vec<Judged> {
    let pooled = if kind.is_even() { APPROXIMATE } else { Asked::Nothing };
    judge(studies, [("bootstrap, any mode", pooled)], |number| {
        let found = model(&kind.draw(number))
            .and_then(|model| bootstrap(&model, Integral::Laplace, &MODES, RESAMPLES, number).ok());
        [Said::by_p(found.map(|found| found.p_value))]
    })
}
