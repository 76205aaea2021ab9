//! Agreement of sessions if some participants lack some sessions: intraclass correlations by a
//! mixed model, intervals by a parametric bootstrap.
//!
//! yᵢⱼ = μ + pᵢ + sⱼ + eᵢⱼ with variances σ²ₚ, σ²ₛ, σ²ₑ, by restricted maximum likelihood
//! (Patterson & Thompson 1971, Biometrika 58:545). Participants and sessions are crossed, and a
//! value missing at random needs no further assumption. Estimates below zero are allowed, as with
//! mean squares (Verbeke & Molenberghs 2003, Biometrics 59:254): on a complete table the two are
//! the same.
//!
//! With θ = σ²/σ²ₑ the participants' part W = I + θₚ Zₚ Zₚᵀ has an inverse in closed form. The
//! remaining system has the size of the sessions: M = Sᵀ W⁻¹ S, r = Sᵀ W⁻¹ y and B = (I + θₛ M)⁻¹
//! give all of yᵀV⁻¹y = yᵀW⁻¹y − θₛ rᵀBr, SᵀV⁻¹y = Br, 1ᵀV⁻¹1 = 1ᵀBM1, |V| = |W| / |B|.

use crate::agreement::{Agreement, Correlation, LIMIT, averaged};
use crate::bootstrap::stream;
use crate::error::{StatsError, all_finite, check_level};
use crate::null::Sampling;
use crate::tested::{Unestimable, at_least, not_constant};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use zwidth_numerics::dense::{Matrix, add_scaled, dot};
use zwidth_numerics::minimise::minimise;

/// Slope of twice the log-likelihood per e-fold of a variance ratio at which it is flat.
const FLAT: f64 = 1e-7;
/// Slope that rounding may leave.
const NEARLY_FLAT: f64 = 1e-4;
/// An error variance below this share of all variance is rounding.
const NO_ERROR: f64 = 1e-12;
/// Fewer resamples than this have no ends of a 95 % interval to speak of.
const FEWEST: usize = 99;

/// Agreement of the sessions of an incomplete table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct IncompleteAgreement {
    /// The same quantities as of a complete table; the intervals are those of the bootstrap.
    pub agreement: Agreement,
    /// Values in the table.
    pub values: usize,
    /// Tables drawn for the intervals.
    pub resamples: usize,
    /// Those of them whose search found no maximum: they are left out.
    pub unfitted: usize,
}

/// Agreement of the sessions of `table`, a row per participant and a column per session, `None`
/// where somebody lacks one; with intervals at `level` from tables drawn by `sampling`.
///
/// An end is T⁻¹(T(ρ̂) − (t − T(ρ₀))) with T(ρ) = ln((1 + (k − 1) ρ) / (1 − ρ)), t a quantile of T
/// over tables drawn from the fitted model, in which variances below zero count as zero, and ρ₀ the
/// correlation of that model (the basic bootstrap; Davison & Hinkley 1997, *Bootstrap Methods and
/// their Application*, §5.2). Of ICC(C,1) T is the logarithm of a ratio of mean squares where the
/// table is complete, and the interval the exact one but for the drawing.
///
/// # Errors
/// Fewer than two participants or sessions with values, rows of different lengths, a value
/// that is not finite; participants who share too few sessions to tell their differences from the
/// scatter ([`Unestimable::Confounded`]); sessions without any scatter; a search that found no
/// maximum; fewer than 99 draws; `level` outside (0, 1).
pub fn incomplete_agreement(
    table: &[Vec<Option<f64>>],
    level: f64,
    sampling: Sampling,
) -> Result<IncompleteAgreement, Unestimable> {
    check_level(level)?;
    at_least("draws", sampling.draws, FEWEST)?;
    let study = Study::new(table)?;
    let fit = study.fit()?;
    // Values can be drawn with variances of 0 or more only.
    let truth = Fit {
        participant: fit.participant.max(0.0),
        session: fit.session.max(0.0),
        error: fit.error,
    };
    let drawn: Vec<[f64; 2]> = (0..sampling.draws)
        .into_par_iter()
        .filter_map(|number| {
            let mut rng = stream(sampling.seed, number as u64);
            study.drawn(&truth, &mut rng).fit().map(|fit| fit.correlations()).ok()
        })
        .collect();
    if drawn.is_empty() {
        let what = "intervals of the correlations";
        return Err(Unestimable::NotConverged { what, slope: f64::INFINITY });
    }
    let k = study.sessions as f64;
    let [a1, c1] = [0, 1].map(|which| {
        let drawn = drawn.iter().map(|rho| rho[which]).collect();
        basic(fit.correlations()[which], truth.correlations()[which], drawn, k, level)
    });
    let sem = (fit.session.max(0.0) + fit.error).sqrt();
    Ok(IncompleteAgreement {
        agreement: Agreement {
            a1,
            c1,
            ak: averaged(a1, k),
            ck: averaged(c1, k),
            participant_variance: fit.participant.max(0.0),
            session_variance: fit.session.max(0.0),
            error_variance: fit.error,
            sem,
            mdc: LIMIT * core::f64::consts::SQRT_2 * sem,
        },
        values: study.values.len(),
        resamples: sampling.draws,
        unfitted: sampling.draws - drawn.len(),
    })
}

/// The interval of a correlation whose estimate is `estimate`, from those `drawn` where it is
/// `truth`.
fn basic(estimate: f64, truth: f64, drawn: Vec<f64>, k: f64, level: f64) -> Correlation {
    let mut drawn: Vec<f64> = drawn.into_iter().map(|rho| log_ratio(rho, k)).collect();
    drawn.sort_unstable_by(f64::total_cmp);
    // What lies above the estimate in the draws is taken from it: the upper quantile makes the
    // lower end.
    let [ci_low, ci_high] = [(1.0 + level) / 2.0, (1.0 - level) / 2.0].map(|share| {
        // Of R draws the (R + 1) share-th, as bootstraps count them, and one of them: a quantile
        // between two draws would move every interval that is stored.
        let place = (share * (drawn.len() + 1) as f64).round() as usize;
        let quantile = drawn[place.clamp(1, drawn.len()) - 1];
        let end = log_ratio(estimate, k) - (quantile - log_ratio(truth, k));
        // The ρ of this T(ρ).
        let ratio = libm::exp(end);
        (ratio - 1.0) / (ratio + k - 1.0)
    });
    Correlation { estimate, ci_low, ci_high }
}

/// T(ρ) of [`incomplete_agreement`].
fn log_ratio(rho: f64, k: f64) -> f64 {
    libm::log((1.0 + (k - 1.0) * rho) / (1.0 - rho))
}

/// A value with the places of its participant and its session.
#[derive(Debug, Clone, Copy)]
struct Value {
    participant: usize,
    session: usize,
    y: f64,
}

/// The values that there are, those of a participant together.
struct Study {
    values: Vec<Value>,
    participants: usize,
    sessions: usize,
}

/// The variances.
#[derive(Debug, Clone, Copy)]
struct Fit {
    participant: f64,
    session: f64,
    error: f64,
}

impl Fit {
    /// ICC(A,1) and ICC(C,1).
    fn correlations(&self) -> [f64; 2] {
        let consistent = self.participant + self.error;
        [self.participant / (consistent + self.session), self.participant / consistent]
    }
}

impl Study {
    /// The values of a table, without participants and sessions that have none.
    fn new(table: &[Vec<Option<f64>>]) -> Result<Self, Unestimable> {
        let expected = table.first().map_or(0, Vec::len);
        for (row, values) in table.iter().enumerate() {
            if values.len() != expected {
                return Err(StatsError::Ragged { row, expected, found: values.len() }.into());
            }
            all_finite(&values.iter().copied().flatten().collect::<Vec<_>>())?;
        }
        let kept: Vec<usize> =
            (0..expected).filter(|&j| table.iter().any(|row| row[j].is_some())).collect();
        let rows: Vec<&Vec<Option<f64>>> =
            table.iter().filter(|row| row.iter().any(Option::is_some)).collect();
        at_least("participants", rows.len(), 2)?;
        at_least("sessions", kept.len(), 2)?;
        let mut values = Vec::new();
        for (participant, row) in rows.iter().enumerate() {
            for (session, &j) in kept.iter().enumerate() {
                values.extend(row[j].map(|y| Value { participant, session, y }));
            }
        }
        // Far from zero digits would be lost.
        let origin = values[0].y;
        values.iter_mut().for_each(|value| value.y -= origin);
        let study = Self { values, participants: rows.len(), sessions: kept.len() };
        if study.residual_df() == 0 {
            let what = "participants' differences from the scatter of their sessions".to_owned();
            return Err(Unestimable::Confounded { what });
        }
        Ok(study)
    }

    /// Values less the rank of participants and sessions: n + k − the parts that share no session.
    fn residual_df(&self) -> usize {
        let mut part: Vec<usize> = (0..self.participants).collect();
        for a in &self.values {
            for b in self.values.iter().filter(|b| b.session == a.session) {
                let from = part[a.participant];
                let to = part[b.participant];
                part.iter_mut().filter(|part| **part == from).for_each(|part| *part = to);
            }
        }
        part.sort_unstable();
        part.dedup();
        self.values.len() + part.len() - self.participants - self.sessions
    }

    /// Values drawn from `truth`, in the same places.
    fn drawn(&self, truth: &Fit, rng: &mut ChaCha8Rng) -> Self {
        let mut normal = |variance: f64| variance.sqrt() * crate::bootstrap::normal(rng);
        let people: Vec<f64> = (0..self.participants).map(|_| normal(truth.participant)).collect();
        let times: Vec<f64> = (0..self.sessions).map(|_| normal(truth.session)).collect();
        let values = self.values.iter().map(|old| {
            let y = people[old.participant] + times[old.session] + normal(truth.error);
            Value { y, ..*old }
        });
        let values = values.collect();
        Self { values, participants: self.participants, sessions: self.sessions }
    }

    fn fit(&self) -> Result<Fit, Unestimable> {
        let totals = Totals::new(self);
        // As far below zero as a variance ratio may be: −1 / the most values of one.
        let floors = [&totals.of_participant, &totals.of_session]
            .map(|counts| -1.0 / counts.iter().fold(1.0, |most: f64, n| most.max(*n)));
        // As logarithms above their floors they have no bound that a search would have to watch.
        let ratios = |x: &[f64]| [libm::exp(x[0]) + floors[0], libm::exp(x[1]) + floors[1]];
        let what = "the variances of participants and sessions";
        let start = floors.map(|floor| libm::log(0.5 - floor));
        let minimum = minimise(
            |x: &[f64]| {
                let (value, slopes, _) = totals.criterion(ratios(x));
                (value, vec![slopes[0] * libm::exp(x[0]), slopes[1] * libm::exp(x[1])])
            },
            &start,
            FLAT,
        )
        .map_err(|_| Unestimable::NotConverged { what, slope: f64::INFINITY })?;
        let theta = ratios(&minimum.point);
        let error = totals.criterion(theta).2;
        let all = error * (1.0 + theta[0].max(0.0) + theta[1].max(0.0));
        not_constant("differences of sessions", error.is_nan() || error <= NO_ERROR * all)?;
        if minimum.slope() > NEARLY_FLAT {
            return Err(Unestimable::NotConverged { what, slope: minimum.slope() });
        }
        Ok(Fit { participant: theta[0] * error, session: theta[1] * error, error })
    }
}

/// The sums of the values that the criterion needs.
struct Totals {
    /// Sessions of each participant.
    sessions: Vec<Vec<usize>>,
    /// Sums of each participant's values.
    sums: Vec<f64>,
    of_participant: Vec<f64>,
    of_session: Vec<f64>,
    session_sums: Vec<f64>,
    squares: f64,
}

impl Totals {
    fn new(study: &Study) -> Self {
        let n = study.participants;
        let k = study.sessions;
        let mut totals = Self {
            sessions: vec![Vec::new(); n],
            sums: vec![0.0; n],
            of_participant: vec![0.0; n],
            of_session: vec![0.0; k],
            session_sums: vec![0.0; k],
            squares: 0.0,
        };
        for &Value { participant, session, y } in &study.values {
            totals.sessions[participant].push(session);
            totals.sums[participant] += y;
            totals.of_participant[participant] += 1.0;
            totals.of_session[session] += 1.0;
            totals.session_sums[session] += y;
            totals.squares += y * y;
        }
        totals
    }

    /// −2 ln REML at (θₚ, θₛ), the error variance profiled out (but for a constant), its slopes by
    /// θ, and the error variance. NaN where the covariance is not positive.
    fn criterion(&self, [people, times]: [f64; 2]) -> (f64, [f64; 2], f64) {
        let k = self.of_session.len();
        let df = self.of_session.iter().sum::<f64>() - 1.0;
        let mut m = Matrix::from_fn(k, k, |i, j| if i == j { self.of_session[i] } else { 0.0 });
        let mut r = self.session_sums.clone();
        let mut squares = self.squares;
        let mut log_det = 0.0;
        for ((sessions, sum), count) in
            self.sessions.iter().zip(&self.sums).zip(&self.of_participant)
        {
            let grown = 1.0 + people * count;
            let shrink = people / grown;
            log_det += libm::log(grown);
            squares -= shrink * sum * sum;
            for &i in sessions {
                r[i] -= shrink * sum;
                sessions.iter().for_each(|&j| m[(i, j)] -= shrink);
            }
        }
        let b = Inverse::new(&m, times);
        let ones = m.times_vector(&vec![1.0; k]);
        let by_one = b.times(&ones);
        let by_r = b.times(&r);
        let weight: f64 = by_one.iter().sum();
        let mean = by_r.iter().sum::<f64>() / weight;
        // SᵀV⁻¹(y − μ)
        let mut by_rest = by_r.clone();
        add_scaled(&mut by_rest, -mean, &by_one);
        let rest = squares - times * dot(&r, &by_r) - mean * mean * weight;
        // The mean is no part of the likelihood: along it, and nowhere else, V may be negative.
        let allowed = b.negative() == usize::from(weight < 0.0);
        log_det += if allowed { libm::log(b.determinant * weight) } else { f64::NAN };
        let mut slopes = [0.0; 2];
        slopes[1] = b.trace_times_m()
            - dot(&by_one, &by_one) / weight
            - df * dot(&by_rest, &by_rest) / rest;
        for ((sessions, sum), count) in
            self.sessions.iter().zip(&self.sums).zip(&self.of_participant)
        {
            let grown = 1.0 + people * count;
            let [rest_sum, one_sum] =
                [&by_rest, &by_one].map(|v| sessions.iter().map(|&j| v[j]).sum::<f64>());
            // ZᵀV⁻¹(y − μ), ZᵀV⁻¹1 and the diagonal of ZᵀV⁻¹Z
            let value = (sum - mean * count - times * rest_sum) / grown;
            let one = (count - times * one_sum) / grown;
            let indicator: Vec<f64> =
                (0..k).map(|j| f64::from(u8::from(sessions.contains(&j)))).collect();
            let diagonal =
                count / grown - times * dot(&indicator, &b.times(&indicator)) / (grown * grown);
            slopes[0] += diagonal - one * one / weight - df * value * value / rest;
        }
        (df * libm::log(rest) + log_det, slopes, rest / df)
    }
}

/// (I + θ M)⁻¹ by the eigenvalues of M: with θ below zero it need not be positive definite.
struct Inverse {
    values: Vec<f64>,
    vectors: Matrix,
    theta: f64,
    /// |I + θ M|.
    determinant: f64,
}

impl Inverse {
    fn new(m: &Matrix, theta: f64) -> Self {
        let (values, vectors) = m.eigen();
        let determinant = values.iter().map(|value| 1.0 + theta * value).product();
        Self { values, vectors, theta, determinant }
    }

    fn times(&self, v: &[f64]) -> Vec<f64> {
        let mut turned = self.vectors.times_vector(v);
        turned.iter_mut().zip(&self.values).for_each(|(t, value)| *t /= 1.0 + self.theta * value);
        self.vectors.transposed_times_vector(&turned)
    }

    /// Number of negative eigenvalues of I + θ M.
    fn negative(&self) -> usize {
        self.values.iter().filter(|value| 1.0 + self.theta * **value < 0.0).count()
    }

    /// tr B M.
    fn trace_times_m(&self) -> f64 {
        self.values.iter().map(|value| value / (1.0 + self.theta * value)).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::agreement::agreement;
    use crate::agreement::tests::shrout_fleiss;
    use crate::bootstrap::normal;

    const SAMPLING: Sampling = Sampling { draws: 1999, seed: 5 };

    fn full(table: &[Vec<f64>]) -> Vec<Vec<Option<f64>>> {
        table.iter().map(|row| row.iter().copied().map(Some).collect()).collect()
    }

    /// `n` × `k` values with the SDs of participants, sessions and the rest.
    fn simulated(seed: u64, n: usize, k: usize, sd: [f64; 3]) -> Vec<Vec<f64>> {
        let mut rng = stream(seed, 0);
        let times: Vec<f64> = (0..k).map(|_| sd[1] * normal(&mut rng)).collect();
        let row = |_| {
            let person = 1e3 + sd[0] * normal(&mut rng);
            times.iter().map(|time| person + time + sd[2] * normal(&mut rng)).collect()
        };
        (0..n).map(row).collect()
    }

    fn tables() -> Vec<Vec<Vec<f64>>> {
        let mut tables = vec![shrout_fleiss()];
        for (seed, sd) in [[2.0, 0.5, 1.0], [1.0, 2.0, 0.3], [0.0, 0.0, 1.0], [0.0, 1.0, 1.0]]
            .into_iter()
            .enumerate()
        {
            tables
                .extend([(5, 2), (12, 3), (30, 2)].map(|(n, k)| simulated(seed as u64, n, k, sd)));
        }
        tables
    }

    /// Some of the simulated tables have mean squares that make variances negative.
    #[test]
    fn on_complete_tables_estimates_are_those_of_mean_squares() {
        let mut negative = 0;
        for table in tables() {
            let squares = agreement(&table, 0.95).unwrap();
            let model = Study::new(&full(&table)).unwrap().fit().unwrap();
            negative += usize::from(model.participant < 0.0 || model.session < 0.0);
            let [a1, c1] = model.correlations();
            assert!((a1 - squares.a1.estimate).abs() < 1e-6, "{model:?} {squares:?}");
            assert!((c1 - squares.c1.estimate).abs() < 1e-6, "{model:?} {squares:?}");
            assert!((model.error / squares.error_variance - 1.0).abs() < 1e-6);
        }
        assert!(negative >= 3, "{negative}");
    }

    /// ICC(C,1): exact but for the drawing of 1999; ICC(A,1): Satterthwaite's interval is an
    /// approximation itself.
    #[test]
    fn on_complete_tables_intervals_are_near_those_of_mean_squares() {
        for table in [simulated(7, 12, 3, [2.0, 0.5, 1.0]), simulated(8, 20, 2, [1.0, 0.3, 1.0])] {
            let squares = agreement(&table, 0.95).unwrap();
            let drawn = incomplete_agreement(&full(&table), 0.95, SAMPLING).unwrap();
            assert_eq!((drawn.unfitted, drawn.values), (0, table.len() * table[0].len()));
            let near =
                |a: f64, b: f64, room: f64| assert!((a - b).abs() < room, "{drawn:?} {squares:?}");
            near(drawn.agreement.c1.ci_low, squares.c1.ci_low, 0.03);
            near(drawn.agreement.c1.ci_high, squares.c1.ci_high, 0.03);
            near(drawn.agreement.a1.ci_low, squares.a1.ci_low, 0.1);
            near(drawn.agreement.a1.ci_high, squares.a1.ci_high, 0.1);
        }
    }

    #[test]
    fn the_slopes_agree_with_differences() {
        let mut table = full(&simulated(9, 7, 3, [1.5, 0.7, 1.0]));
        (table[0][1], table[3][0], table[3][2], table[5][2]) = (None, None, None, None);
        let study = Study::new(&table).unwrap();
        let totals = Totals::new(&study);
        for theta in [[0.5, 0.2], [3.0, 0.0], [-0.1, 1.0], [0.2, -0.05]] {
            let (_, slopes, _) = totals.criterion(theta);
            for i in 0..2 {
                let at = |step: f64| {
                    let mut moved = theta;
                    moved[i] += step;
                    totals.criterion(moved).0
                };
                let difference = (at(1e-5) - at(-1e-5)) / 2e-5;
                assert!(
                    (difference - slopes[i]).abs() < 1e-5,
                    "{theta:?}: {difference} {slopes:?}"
                );
            }
        }
    }

    /// The criterion with V as a dense matrix, from its definition.
    #[test]
    fn the_criterion_is_that_of_the_dense_covariance() {
        let mut table = full(&simulated(10, 6, 3, [1.0, 1.0, 1.0]));
        (table[1][0], table[4][2], table[5][1]) = (None, None, None);
        let study = Study::new(&table).unwrap();
        let dense = |[people, times]: [f64; 2]| {
            let v = &study.values;
            let same = |is: bool, ratio: f64| if is { ratio } else { 0.0 };
            let entry = |i: usize, j: usize| {
                same(i == j, 1.0)
                    + same(v[i].participant == v[j].participant, people)
                    + same(v[i].session == v[j].session, times)
            };
            let (inverse, log_det) =
                Matrix::from_fn(v.len(), v.len(), entry).inverse_and_log_det().unwrap();
            let (y, one): (Vec<f64>, Vec<f64>) = v.iter().map(|v| (v.y, 1.0)).unzip();
            let weight = inverse.form(&one, &one);
            let cross = inverse.form(&one, &y);
            let rest = inverse.form(&y, &y) - cross * cross / weight;
            (v.len() as f64 - 1.0) * libm::log(rest) + log_det + libm::log(weight)
        };
        let totals = Totals::new(&study);
        for theta in [[0.5, 0.2], [3.0, 0.0], [0.0, 5.0], [-0.1, 0.3]] {
            assert!((totals.criterion(theta).0 - dense(theta)).abs() < 1e-9, "{theta:?}");
        }
    }

    /// 95 % intervals of 400 tables of 12 participants and 3 sessions, of which a fifth is missing:
    /// the truth is in at least the share that chance alone falls short of once in a thousand times
    /// if they hold it 93 %.
    #[test]
    fn intervals_of_incomplete_tables_hold_the_truth() {
        let (sd, tables) = ([1.5_f64, 0.5, 1.0], 400);
        let truth = sd[0] * sd[0] / (sd[0] * sd[0] + sd[2] * sd[2]);
        let holds = |seed: &u64| {
            let mut table = full(&simulated(1000 + seed, 12, 3, sd));
            (0..12).filter(|i| i % 2 == 0).for_each(|i| table[i][i / 2 % 3] = None);
            let sampling = Sampling { draws: 199, seed: *seed };
            let found = incomplete_agreement(&table, 0.95, sampling).unwrap().agreement.c1;
            found.ci_low <= truth && truth <= found.ci_high
        };
        let held = (0..tables).into_par_iter().filter(holds).count() as f64 / tables as f64;
        assert!(held > 0.93 - 3.1 * f64::sqrt(0.93 * 0.07 / tables as f64), "{held}");
        assert!(held < 0.985, "{held}");
    }

    #[test]
    fn one_seed_is_one_result_and_what_cannot_be_said_is_said() {
        let mut table = full(&simulated(11, 8, 2, [1.0, 0.5, 1.0]));
        table[2][1] = None;
        let sampling = Sampling { draws: 99, seed: 3 };
        let of = |table: &[Vec<Option<f64>>]| incomplete_agreement(table, 0.95, sampling);
        assert_eq!(of(&table), of(&table));
        assert_eq!(of(&table).unwrap().values, 15);
        let words = |table: &[Vec<Option<f64>>]| of(table).unwrap_err().to_string();
        assert_eq!(words(&table[2..3]), "1 participant, 2 are needed");
        assert_eq!(
            words(&[vec![Some(1.0), None], vec![Some(2.0), None]]),
            "1 session, 2 are needed"
        );
        let apart = [vec![Some(1.0), None, Some(1.5)], vec![Some(2.0), Some(1.0), None]];
        assert!(words(&apart).contains("cannot tell participants' differences"));
        let alike: Vec<_> = (0..5).map(|i| vec![Some(f64::from(i)), Some(f64::from(i))]).collect();
        assert!(
            words(&alike).contains("all differences of sessions are equal"),
            "{}",
            words(&alike)
        );
        assert!(words(&[vec![Some(1.0)], vec![]]).contains("points"));
    }
}
