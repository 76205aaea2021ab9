//! What a program prints, by its name.

use super::observed::observed;
use super::trials::{Row, Trials, distinct};
use super::within::{Errors, Within, within};
use crate::answers::Column;
use crate::effect::d_av;
use crate::error::same_length;
use crate::lmm::{Criterion, Fit, Model, RandomTerm, fit};
use crate::paired::{differences, mean_difference};
use crate::reference::normal_wald;
use crate::studentised_range::StudentisedRange;
use crate::tested::{Tested, Unestimable, at_least};
use core::f64::consts::SQRT_2;
use std::collections::BTreeMap;
use zwidth_numerics::moments::Moments;

/// A program, and the call by which it compares modes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Peer {
    /// R's lmerTest: `summary(lmer(value ~ mode + (1 | participant)))`.
    LmerTest,
    /// The same with `+ (1 | participant:mode)`.
    LmerTestModes,
    /// That model by R's pbkrtest: `summary(…, ddf = "Kenward-Roger")`.
    Pbkrtest,
    /// That model by R's emmeans: `confint(pairs(emmeans(…, ~ mode)))`, `eff_size`.
    Emmeans,
    /// Python's statsmodels: `mixedlm("value ~ mode", data, groups="participant").fit()`.
    Statsmodels,
    /// Python's pingouin: `pairwise_tests(dv="value", within="mode", subject="participant")`.
    Pingouin,
    /// Python's pyfixest: `feols("value ~ mode | participant")`.
    Pyfixest,
    /// The same with `vcov={"CRV1": "participant"}`.
    PyfixestClustered,
}

/// The distribution that a program refers a statistic to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Reference {
    /// Student's t.
    T,
    /// The normal distribution.
    Normal,
    /// The Studentised range of so many means.
    StudentisedRange(usize),
}

/// What a program prints of one contrast; what it does not print is `None`.
#[derive(Debug, Clone, PartialEq)]
pub struct Printed {
    /// The participants whose trials it uses, in their order.
    pub participants: Vec<usize>,
    /// How many trials these are.
    pub trials: usize,
    /// The difference between the modes.
    pub estimate: f64,
    /// Its standard error.
    pub std_error: Option<f64>,
    /// Its interval.
    pub interval: Option<[f64; 2]>,
    /// The difference divided by its standard error.
    pub statistic: f64,
    /// What it is referred to.
    pub reference: Reference,
    /// Degrees of freedom; infinite with the normal distribution.
    pub df: f64,
    /// The p value.
    pub p_value: f64,
    /// The effect size that it prints beside: pingouin's Hedges' g, emmeans' difference in residual SDs.
    pub effect_size: Option<f64>,
    /// Whether its model has a variance at zero.
    pub singular: bool,
}

/// From this number of trials on, emmeans uses neither pbkrtest nor lmerTest unless it is told
/// (`pbkrtest.limit`, `lmerTest.limit`).
pub const EMMEANS_LIMIT: usize = 3000;

/// The trials with the models that several programs fit to them.
#[derive(Debug)]
pub struct Fitted<'a> {
    trials: Trials<'a>,
    /// The modes that have trials, in their order.
    modes: Vec<usize>,
    /// The participants, likewise.
    participants: Vec<usize>,
    /// With a random effect of participant.
    intercept: Result<Fit, Unestimable>,
    /// With one of participant × mode besides.
    with_modes: Result<Fit, Unestimable>,
}

impl<'a> Fitted<'a> {
    /// Fits the models.
    ///
    /// # Errors
    /// Columns of different lengths; fewer than two participants or modes.
    pub fn of(trials: Trials<'a>) -> Result<Self, Unestimable> {
        let rows = trials.value.len();
        same_length("the participants", rows, trials.participant.len())?;
        same_length("the modes", rows, trials.mode.len())?;
        let modes = distinct(trials.mode);
        let participants = distinct(trials.participant);
        at_least("participants", participants.len(), 2)?;
        at_least("modes", modes.len(), 2)?;
        let of_participant = RandomTerm::intercept("participant", vec![0; rows]);
        let of_mode = RandomTerm::intercept("participant × mode", trials.mode.to_vec());
        let model = |random| {
            let fixed = modes.iter().map(|mode| Column {
                name: format!("mode {mode}"),
                values: trials.mode.iter().map(|own| f64::from(u8::from(own == mode))).collect(),
            });
            let model = Model {
                response: trials.value.to_vec(),
                fixed: fixed.collect(),
                group: trials.participant.to_vec(),
                random,
            };
            fit(&model, Criterion::Reml)
        };
        let intercept = model(vec![of_participant.clone()]);
        let with_modes = model(vec![of_participant, of_mode]);
        Ok(Self { trials, modes, participants, intercept, with_modes })
    }

    /// What a program prints of the first mode minus the second, with intervals at `level`.
    ///
    /// # Errors
    /// A mode without trials; data of which it gives no such number.
    pub fn printed(
        &self,
        peer: Peer,
        contrast: [usize; 2],
        level: f64,
    ) -> Result<Printed, Unestimable> {
        let [first, second] = self.places(contrast)?;
        let mut weights = vec![0.0; self.modes.len()];
        weights[first] = 1.0;
        weights[second] = -1.0;
        match peer {
            Peer::LmerTest => {
                let fit = self.intercept.as_ref().map_err(Clone::clone)?;
                // `summary` prints no interval.
                let tested = fit.satterthwaite()?.test(&weights, level)?;
                Ok(Printed { interval: None, singular: fit.singular, ..self.of_all(tested) })
            }
            Peer::LmerTestModes => {
                let fit = self.with_modes.as_ref().map_err(Clone::clone)?;
                let tested = fit.satterthwaite()?.test(&weights, level)?;
                Ok(Printed { interval: None, singular: fit.singular, ..self.of_all(tested) })
            }
            Peer::Pbkrtest => {
                let fit = self.with_modes.as_ref().map_err(Clone::clone)?;
                let tested = fit.kenward_roger()?.test(&weights, level)?;
                Ok(Printed { interval: None, singular: fit.singular, ..self.of_all(tested) })
            }
            Peer::Emmeans => self.emmeans(&weights, level),
            Peer::Statsmodels => {
                let fit = self.intercept.as_ref().map_err(Clone::clone)?;
                let estimate = fit.coefficients[first] - fit.coefficients[second];
                let variance = observed(self.trials, &self.modes, fit, &weights)?;
                let tested = normal_wald(estimate, variance.sqrt(), level)?;
                let reference = Reference::Normal;
                Ok(Printed { reference, singular: fit.singular, ..self.of_all(tested) })
            }
            Peer::Pingouin => self.pingouin([first, second], level),
            Peer::Pyfixest => self.pyfixest(&weights, Errors::Independent, level),
            Peer::PyfixestClustered => self.pyfixest(&weights, Errors::OfParticipants, level),
        }
    }

    /// The places of two modes among those that have trials.
    fn places(&self, contrast: [usize; 2]) -> Result<[usize; 2], Unestimable> {
        let lacking = Unestimable::TooFew { units: "trials of the mode", found: 0, needed: 1 };
        let place = |mode| self.modes.binary_search(&mode).map_err(|_| lacking.clone());
        Ok([place(contrast[0])?, place(contrast[1])?])
    }

    /// A test that uses everybody's trials, by Student's t.
    fn of_all(&self, tested: Tested) -> Printed {
        Printed {
            participants: self.participants.clone(),
            trials: self.trials.value.len(),
            estimate: tested.estimate,
            std_error: Some(tested.std_error),
            interval: Some([tested.ci_low, tested.ci_high]),
            statistic: tested.statistic,
            reference: Reference::T,
            df: tested.df,
            p_value: tested.p_value,
            effect_size: None,
            singular: false,
        }
    }

    /// Kenward and Roger's test, with Tukey's adjustment for all pairs of modes: q = √2 |t|.
    fn emmeans(&self, weights: &[f64], level: f64) -> Result<Printed, Unestimable> {
        let fit = self.with_modes.as_ref().map_err(Clone::clone)?;
        let tested = if self.trials.value.len() > EMMEANS_LIMIT {
            let each = weights.iter().zip(&fit.covariance);
            let variance: f64 = each
                .map(|(weight, row)| {
                    weight * row.iter().zip(weights).map(|(c, w)| c * w).sum::<f64>()
                })
                .sum();
            let estimate = weights.iter().zip(&fit.coefficients).map(|(w, b)| w * b).sum();
            normal_wald(estimate, variance.sqrt(), level)?
        } else {
            fit.kenward_roger()?.test(weights, level)?
        };
        let range = StudentisedRange::new(self.modes.len(), tested.df)?;
        let half = range.critical_value(level)? / SQRT_2 * tested.std_error;
        Ok(Printed {
            interval: Some([tested.estimate - half, tested.estimate + half]),
            reference: Reference::StudentisedRange(self.modes.len()),
            p_value: range.upper_p(SQRT_2 * tested.statistic),
            effect_size: Some(tested.estimate / fit.residual_variance.sqrt()),
            singular: fit.singular,
            ..self.of_all(tested)
        })
    }

    /// Student's t of the means of those who have every mode, and Hedges' g by d_av (1 − 3 / (8 n − 9)).
    fn pingouin(&self, contrast: [usize; 2], level: f64) -> Result<Printed, Unestimable> {
        let mut values: BTreeMap<usize, Vec<Vec<f64>>> = BTreeMap::new();
        for Row { participant, place, value } in self.trials.rows(&self.modes) {
            let own = values.entry(participant).or_insert_with(|| vec![vec![]; self.modes.len()]);
            own[place].push(value);
        }
        values.retain(|_, own| own.iter().all(|mode| !mode.is_empty()));
        let means = |own: &Vec<Vec<f64>>| contrast.map(|place| Moments::of(&own[place]).mean);
        let pairs: Vec<[f64; 2]> = values.values().map(means).collect();
        let tested = mean_difference(&differences(&pairs), level)?;
        let scale = 1.0 - 3.0 / (8.0 * pairs.len() as f64 - 9.0);
        Ok(Printed {
            participants: values.keys().copied().collect(),
            trials: values.values().flatten().map(Vec::len).sum(),
            std_error: None,
            interval: None,
            effect_size: d_av(&pairs, level).ok().map(|effect| effect.d * scale),
            ..self.of_all(tested)
        })
    }

    /// Least squares with a constant for each participant.
    fn pyfixest(
        &self,
        weights: &[f64],
        errors: Errors,
        level: f64,
    ) -> Result<Printed, Unestimable> {
        let Within { tested, participants, trials } =
            within(self.trials, &self.modes, weights, errors, level)?;
        Ok(Printed { participants, trials, ..self.of_all(tested) })
    }
}
