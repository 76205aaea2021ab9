//! Closed forms, differences, and answers that have no estimate.

use super::*;

fn column(name: &str, values: &[f64]) -> Column {
    Column { name: name.to_owned(), values: values.to_vec() }
}

/// Answers on three points in two groups, with ties and overlap.
const ANSWERS: [u8; 14] = [1, 1, 2, 2, 2, 3, 1, 1, 2, 2, 3, 3, 3, 3];

fn groups() -> Column {
    column("group", &std::array::from_fn::<f64, 14, _>(|i| f64::from(u8::from(i > 6))))
}

fn dose() -> Column {
    column("dose", &std::array::from_fn::<f64, 14, _>(|i| (i * 5 % 7) as f64 / 3.0))
}

fn fitted(columns: &[Column]) -> (Model, Fit) {
    let model = Model::new(&ANSWERS, 3, columns).unwrap();
    let fit = fit(&model).unwrap();
    (model, fit)
}

#[test]
fn without_columns_thresholds_are_logits_of_cumulated_shares() {
    let (_, fit) = fitted(&[]);
    let shares = [4.0 / 14.0, 9.0 / 14.0];
    for (theta, share) in fit.thresholds.iter().zip(shares) {
        assert!((theta - logit(share)).abs() < 1e-12, "{theta}");
    }
    let expect: f64 = [4.0, 5.0, 5.0].iter().map(|n| n * libm::log(n / 14.0)).sum();
    assert!((fit.log_likelihood - expect).abs() < 1e-12);
    // The variance of a logit: 1 / (n p (1 − p)).
    for (k, p) in shares.iter().enumerate() {
        assert!((fit.covariance[k][k] * 14.0 * p * (1.0 - p) - 1.0).abs() < 1e-10);
    }
}

/// Two answers in two groups: the odds ratio of the 2 × 2 table, with Woolf's variance.
#[test]
fn with_two_categories_it_is_logistic_regression() {
    let counts = [[7_u8, 3], [4, 9]];
    let (mut answers, mut x) = (Vec::new(), Vec::new());
    for (group, row) in counts.iter().enumerate() {
        for (answer, &n) in row.iter().enumerate() {
            answers.extend(std::iter::repeat_n(answer as u8 + 1, n.into()));
            x.extend(std::iter::repeat_n(group as f64, n.into()));
        }
    }
    let model = Model::new(&answers, 2, &[column("group", &x)]).unwrap();
    let fit = fit(&model).unwrap();
    assert!((fit.coefficients[0] - libm::log(7.0 * 9.0 / (3.0 * 4.0))).abs() < 1e-12);
    let variance = 1.0 / 7.0 + 1.0 / 3.0 + 1.0 / 4.0 + 1.0 / 9.0;
    assert!((fit.covariance[1][1] - variance).abs() < 1e-10);
    let wald = fit.wald(0, 0.95).unwrap();
    assert!((wald.statistic - fit.coefficients[0] / variance.sqrt()).abs() < 1e-10);
    assert!((wald.ci_high - wald.estimate - 1.95996398 * variance.sqrt()).abs() < 1e-10);
    // R: 2 * pnorm(-1.8121882365859632)
    assert!((wald.p_value - 0.0699571160660).abs() < 1e-12, "{wald:?}");
}

#[test]
fn gradient_and_information_agree_with_differences() {
    let model = Model::new(&ANSWERS, 3, &[groups(), dose()]).unwrap();
    let point = [-0.9, 0.4, 0.7, -0.3];
    let here = surface(&model, &point);
    for i in 0..point.len() {
        let h = 1e-5;
        let at = |step: f64| {
            let mut moved = point;
            moved[i] += step;
            surface(&model, &moved)
        };
        let (low, high) = (at(-h), at(h));
        let slope = (high.value - low.value) / (2.0 * h);
        assert!((slope - here.gradient[i]).abs() < 1e-8, "{slope} {}", here.gradient[i]);
        for j in 0..point.len() {
            let bend = (low.gradient[j] - high.gradient[j]) / (2.0 * h);
            assert!((bend - here.information[(i, j)]).abs() < 1e-8, "{i} {j}");
        }
    }
}

#[test]
fn at_the_maximum_the_gradient_is_zero() {
    let (model, fit) = fitted(&[groups(), dose()]);
    let point: Vec<f64> = fit.thresholds.iter().chain(&fit.coefficients).copied().collect();
    assert!(surface(&model, &point).gradient.iter().all(|g| g.abs() < 1e-9));
}

#[test]
fn turning_the_scale_round_turns_the_sign_of_the_effect() {
    let (_, forward) = fitted(&[groups()]);
    let turned: Vec<u8> = ANSWERS.iter().map(|a| 4 - a).collect();
    let model = Model::new(&turned, 3, &[groups()]).unwrap();
    let backward = fit(&model).unwrap();
    assert!((forward.coefficients[0] + backward.coefficients[0]).abs() < 1e-12);
    assert!((forward.thresholds[0] + backward.thresholds[1]).abs() < 1e-12);
    assert!((forward.log_likelihood - backward.log_likelihood).abs() < 1e-12);
}

#[test]
fn an_unused_category_is_left_out_and_named() {
    let gaps: Vec<u8> = ANSWERS.iter().map(|a| 2 * a - 1).collect();
    let model = Model::new(&gaps, 7, &[groups()]).unwrap();
    let found = fit(&model).unwrap();
    assert_eq!(found.scale, Scale { used: vec![1, 3, 5], unused: vec![2, 4, 6, 7] });
    let (_, dense) = fitted(&[groups()]);
    assert_eq!((found.thresholds, found.coefficients), (dense.thresholds, dense.coefficients));
}

#[test]
fn the_profile_interval_ends_where_the_likelihood_has_fallen_by_half_of_z_squared() {
    let (model, fit) = fitted(&[groups(), dose()]);
    let (low, high) = profile_interval(&model, &fit, 0, 0.9).unwrap();
    assert!(low < fit.coefficients[0] && fit.coefficients[0] < high);
    for end in [low, high] {
        // The column with its effect held as an offset: thresholds and the other effect are
        // searched.
        let mut start = model.start();
        start[2] = end;
        let (_, there) = maximise(&model, start, Some(2)).unwrap();
        let fall = 2.0 * (fit.log_likelihood - there.value);
        assert!((fall.sqrt() - 1.64485363).abs() < 1e-7, "{fall}");
    }
}

#[test]
fn the_likelihood_ratio_counts_the_columns_left_out() {
    let (_, both) = fitted(&[groups(), dose()]);
    let (_, none) = fitted(&[]);
    let test = likelihood_ratio(&both, &none).unwrap();
    assert!((test.df - 2.0).abs() < 1e-15);
    // χ² with two degrees of freedom has the tail e^(−x/2).
    assert!((test.p_value / libm::exp(-test.statistic / 2.0) - 1.0).abs() < 1e-8);
    assert!(likelihood_ratio(&none, &both).is_err());
}

#[test]
fn answers_without_estimates_are_named_by_their_reason() {
    let check = |answers: &[u8], columns: &[Column], expect: &str| {
        let found = Model::new(answers, 3, columns).unwrap_err();
        assert_eq!(found.to_string(), expect);
    };
    check(&[], &[], "0 answers, 2 are needed");
    check(&[2, 2, 2], &[], "all answers are equal, so nothing tells how far they scatter");
    let x = column("mode", &[0.0, 0.0, 0.0, 1.0, 1.0]);
    check(
        &[1, 2, 1, 3, 3],
        std::slice::from_ref(&x),
        "the answers separate mode completely, so the estimate has no end",
    );
    let twice = column("session", &[0.0, 0.0, 0.0, 2.0, 2.0]);
    check(
        &[1, 2, 3, 3, 1],
        &[x.clone(), twice],
        "the data cannot tell session from the columns before it apart",
    );
    check(
        &[1, 2, 3],
        &[column("one", &[1.0; 3])],
        "the data cannot tell one from what all answers share apart",
    );
    let off = Model::new(&[1, 2, 4], 3, &[]).unwrap_err();
    assert!(matches!(off, Unestimable::Refused(StatsError::Answer { index: 2, found: 4, .. })));
    let nan = Model::new(&[1, 2, 3], 3, &[column("x", &[0.0, 1.0, f64::NAN])]).unwrap_err();
    assert!(matches!(nan, Unestimable::Refused(StatsError::NonFinite { index: 2, .. })));
    let short = Model::new(&[1, 2, 3], 3, &[column("x", &[0.0, 1.0])]).unwrap_err();
    assert!(matches!(short, Unestimable::Refused(StatsError::Numerics(_))));
}

/// One step from separation the estimates are large, and found.
#[test]
fn answers_next_to_separation_are_fitted() {
    let mut answers = vec![1; 200];
    answers.extend([2; 200]);
    answers[0] = 2;
    answers[399] = 1;
    let x: Vec<f64> = (0..400).map(|i| f64::from(u8::from(i >= 200))).collect();
    let model = Model::new(&answers, 2, &[column("x", &x)]).unwrap();
    assert!((fit(&model).unwrap().coefficients[0] - 2.0 * libm::log(199.0)).abs() < 1e-9);
}
