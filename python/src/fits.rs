//! Curves fitted to one's own numbers.

use crate::calling::{Fault, call};
use crate::given::numbers;
use crate::metrics::each;
use crate::table::Table;
use pyo3::prelude::*;
use pyo3::types::PyList;
use zwidth_characterise::{Characteristic as Found, Settings, Subject, Sweep, characterise};
use zwidth_stats::psychometric::fit::{Fit, Fitted, Model, Profiled, Side, Verdict, fit};
use zwidth_stats::psychometric::{Asks, LevelAnswers, Sigmoid};

/// More answers at one level are none.
const MOST_ANSWERS: f64 = 1e9;
/// More resamples are not drawn.
const MOST_RESAMPLES: usize = 1_000_000;

/// The response of an actuator or a sensor to its command: every candidate curve, and which one was chosen, why.
#[pyclass(module = "zwidth", frozen)]
pub(crate) struct Characteristic {
    found: Found,
    settings: Settings,
}

#[pymethods]
impl Characteristic {
    /// The chosen model.
    #[getter]
    fn model(&self) -> &'static str {
        self.found.candidates[self.found.chosen].name.as_str()
    }

    /// Why it was chosen, in a sentence.
    #[getter]
    fn reason(&self) -> &str {
        &self.found.reason
    }

    /// Scatter that no curve explains, in the unit of the response; None without a degree of freedom.
    #[getter]
    fn noise(&self) -> Option<f64> {
        self.found.noise
    }

    /// A row for each candidate: its errors, and why it was chosen or not.
    #[getter]
    fn models(&self) -> PyResult<Table> {
        Ok(Table::new(self.subject().models_table(&self.found).map_err(Fault::said)?)?)
    }

    /// A row for each parameter of each candidate, with its bootstrap interval.
    #[getter]
    fn parameters(&self) -> PyResult<Table> {
        Ok(Table::new(self.subject().parameters_table(&self.found).map_err(Fault::said)?)?)
    }

    fn __repr__(&self) -> String {
        format!("<zwidth.Characteristic {:?}: {}>", self.model(), self.found.reason)
    }

    fn _repr_html_(&self) -> PyResult<String> {
        Ok(self.models()?.html()?)
    }
}

impl Characteristic {
    fn subject(&self) -> Subject<'_> {
        Subject {
            actuator: "own",
            command_unit: &self.settings.command_unit,
            response_unit: &self.settings.response_unit,
        }
    }
}

/// Fits every candidate curve to the response of an actuator or a sensor and chooses one by cross-validation, as
/// `zwidth run` does of a study's sweeps.
///
/// `command` and `response` are arrays of one sweep, or lists of arrays with one for each sweep. Intervals are from
/// `resamples` bootstrap resamples at `level`; of one `seed` always the same.
#[pyfunction]
#[pyo3(signature = (command, response, *, command_unit = "V", response_unit = "N", resamples = 1000, seed = 1, level = 0.95))]
#[expect(clippy::too_many_arguments, reason = "they are keyword arguments of Python")]
pub(crate) fn fit_characteristic(
    py: Python<'_>,
    command: &Bound<'_, PyAny>,
    response: &Bound<'_, PyAny>,
    command_unit: &str,
    response_unit: &str,
    resamples: usize,
    seed: u64,
    level: f64,
) -> PyResult<Characteristic> {
    let [command, response] =
        [("command", command), ("response", response)].map(|(name, given)| {
            match given.is_instance_of::<PyList>() {
                true => each(name, &given.extract::<Vec<Bound<'_, PyAny>>>()?),
                false => Ok(vec![numbers(name, given)?]),
            }
        });
    let [command, response] = [command?, response?];
    if command.len() != response.len() {
        let what = format!("{} sweeps, where command has {}", response.len(), command.len());
        return Err(Fault::new(what, "give an array for each sweep").in_column("response").into());
    }
    if resamples > MOST_RESAMPLES {
        let what = format!("{resamples} resamples");
        return Err(Fault::new(what, &format!("take at most {MOST_RESAMPLES}")).into());
    }
    let settings = Settings {
        resamples,
        seed,
        level,
        command_unit: command_unit.to_owned(),
        response_unit: response_unit.to_owned(),
    };
    call(py, move |_| {
        let sweeps = command.iter().zip(&response);
        let sweeps: Vec<Sweep<'_>> =
            sweeps.map(|(command, response)| Sweep { command, response }).collect();
        let found = characterise(&sweeps, &settings).map_err(Fault::said)?;
        Ok(Characteristic { found, settings })
    })
}

/// What the answers of one person tell: a threshold and a JND with their intervals, or why there are none.
#[pyclass(module = "zwidth", frozen)]
pub(crate) struct Psychometric {
    fit: Fit,
}

impl Psychometric {
    fn of<T>(&self, of: fn(&Fitted) -> T) -> Option<T> {
        self.fit.fitted.as_ref().map(of)
    }
}

/// Ends of an interval; None where the likelihood does not fall that far.
fn ends(profiled: Profiled) -> (Option<f64>, Option<f64>) {
    (profiled.ci_low, profiled.ci_high)
}

#[pymethods]
impl Psychometric {
    /// "estimated", or why not: "below" or "above" the levels, "steep", "falling", "flat", "too few".
    #[getter]
    fn verdict(&self) -> &'static str {
        match self.fit.verdict {
            Verdict::Estimated => "estimated",
            Verdict::Outside(Side::Below) => "below",
            Verdict::Outside(Side::Above) => "above",
            Verdict::Steep => "steep",
            Verdict::Falling => "falling",
            Verdict::Flat => "flat",
            Verdict::TooFew => "too few",
        }
    }

    /// Trials that were answered.
    #[getter]
    fn trials(&self) -> u64 {
        self.fit.trials
    }

    /// The level at F = 1/2, in the unit of the stimulus.
    #[getter]
    fn threshold(&self) -> Option<f64> {
        self.of(|fitted| fitted.threshold.estimate)
    }

    /// Its profile-likelihood interval.
    #[getter]
    fn threshold_interval(&self) -> (Option<f64>, Option<f64>) {
        self.of(|fitted| ends(fitted.threshold)).unwrap_or_default()
    }

    /// The JND, half of x(F = 3/4) − x(F = 1/4), in the unit of the stimulus.
    #[getter]
    fn jnd(&self) -> Option<f64> {
        self.of(|fitted| fitted.jnd.estimate)
    }

    /// Its profile-likelihood interval.
    #[getter]
    fn jnd_interval(&self) -> (Option<f64>, Option<f64>) {
        self.of(|fitted| ends(fitted.jnd)).unwrap_or_default()
    }

    /// The lapse rate λ.
    #[getter]
    fn lapse(&self) -> Option<f64> {
        self.of(|fitted| fitted.curve.lapse)
    }

    /// The guess rate γ.
    #[getter]
    fn guess(&self) -> Option<f64> {
        self.of(|fitted| fitted.curve.guess)
    }

    /// The deviance of the curve.
    #[getter]
    fn deviance(&self) -> Option<f64> {
        self.of(|fitted| fitted.deviance)
    }

    /// The share of positive answers that the curve has at a level; None without a curve.
    fn share(&self, level: f64) -> Option<f64> {
        let share = self.fit.fitted.as_ref()?.curve.share(level);
        share.is_finite().then_some(share)
    }

    fn __repr__(&self) -> String {
        match self.threshold().zip(self.jnd()) {
            Some((threshold, jnd)) => {
                format!("<zwidth.Psychometric: threshold {threshold}, JND {jnd}>")
            }
            None => format!("<zwidth.Psychometric: {}>", self.verdict()),
        }
    }
}

/// The psychometric function of one person's answers, by maximum likelihood with profile intervals.
///
/// `level` in the unit of the stimulus, `trials` and `positive` (more, right, or yes) at each, as float64. `asks` is
/// "which_was_more" (γ = λ), "right_or_wrong" (γ = 1/2) or "yes_no" (γ free); `sigmoid` "norm", "logistic" or "weibull";
/// `lapse` the least and the largest λ. `constant` says that levels were chosen before the first answer; of staircases
/// answers are not overdispersed by their levels. The lapse's bounds decide more than the sigmoid does.
#[pyfunction]
#[pyo3(signature = (level, trials, positive, *, asks = "which_was_more", sigmoid = "norm", lapse = (0.0, 0.06), constant = true, confidence = 0.95))]
#[expect(clippy::too_many_arguments, reason = "they are keyword arguments of Python")]
pub(crate) fn fit_psychometric(
    py: Python<'_>,
    level: &Bound<'_, PyAny>,
    trials: &Bound<'_, PyAny>,
    positive: &Bound<'_, PyAny>,
    asks: &str,
    sigmoid: &str,
    lapse: (f64, f64),
    constant: bool,
    confidence: f64,
) -> PyResult<Psychometric> {
    let level = numbers("level", level)?;
    let trials = counts("trials", trials, level.len())?;
    let positive = counts("positive", positive, level.len())?;
    let asks = match asks {
        "which_was_more" => Asks::WhichWasMore,
        "right_or_wrong" => Asks::RightOrWrong,
        "yes_no" => Asks::YesNo,
        other => {
            return Err(Fault::new(
                format!("nobody asks {other:?}"),
                "choose which_was_more, right_or_wrong or yes_no",
            )
            .into());
        }
    };
    let sigmoid = match sigmoid {
        "norm" => Sigmoid::Norm,
        "logistic" => Sigmoid::Logistic,
        "weibull" => Sigmoid::Weibull,
        other => {
            return Err(Fault::new(
                format!("there is no sigmoid {other:?}"),
                "choose norm, logistic or weibull",
            )
            .into());
        }
    };
    let model = Model { asks, sigmoid, lapse: [lapse.0, lapse.1], is_constant: constant };
    call(py, move |_| {
        let answers: Vec<LevelAnswers> = level
            .into_iter()
            .zip(trials.into_iter().zip(positive))
            .map(|(level, (trials, positive))| LevelAnswers { level, trials, positive })
            .collect();
        Ok(Psychometric { fit: fit(&answers, &model, confidence).map_err(Fault::said)? })
    })
}

/// Whole numbers from 0 on.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "checked to be whole and small"
)]
#[expect(clippy::float_cmp, reason = "a whole number is its own floor, to the last bit")]
fn counts(name: &str, given: &Bound<'_, PyAny>, length: usize) -> PyResult<Vec<u64>> {
    let values = crate::given::beside(name, given, "level", length)?;
    match values.iter().position(|v| !(0.0..=MOST_ANSWERS).contains(v) || v.floor() != *v) {
        None => Ok(values.into_iter().map(|value| value as u64).collect()),
        Some(row) => {
            let what = format!("{} is no count", values[row]);
            Err(Fault::new(what, "give whole numbers from 0 on")
                .in_column(name)
                .in_row0(row)
                .into())
        }
    }
}
