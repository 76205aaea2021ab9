//! `[[scores]]` of a `study.toml`: one number of several answers.

use crate::words::words;
use crate::{AnswerScale, AnswerValue, Better, IdError, MetricId, QuestionId};
use serde::{Deserialize, Serialize};

words! {
    /// How answers become one number.
    ScoreKind {
        /// NASA-TLX with weights: Σ w r / 15, r from 0 to 100 (Hart & Staveland 1988).
        NasaTlx = "nasa_tlx",
        /// Raw TLX: the mean of the six, from 0 to 100.
        NasaTlxRaw = "nasa_tlx_raw",
        /// System Usability Scale, from 0 to 100 (Brooke 1996).
        Sus = "sus",
        /// The mean of the answers.
        Mean = "mean",
        /// Their sum.
        Sum = "sum",
    }
}

/// One number of several answers after a trial.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "struct ScoreTable")]
pub struct Score {
    /// Its name: it is compared as the metric `score_` and this.
    pub id: MetricId,
    /// How it is made.
    pub kind: ScoreKind,
    /// Of which questions.
    pub questions: Vec<QuestionId>,
    /// The questions whose answers are the weights of these, of the weighted TLX alone; or `pairs`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub weights: Vec<QuestionId>,
    /// In place of `weights`: what people are asked about each two of the questions, of which they
    /// choose one ([`Score::weighing`]).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pairs: Option<String>,
    /// Of a mean: the share of the questions that must be answered; by default all of them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub min_answered: Option<f64>,
    /// What people call it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub label: Option<String>,
    /// Which values are better: of workload lower ones, of usability higher ones, of others neither unless it is
    /// said.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub better: Option<Better>,
}

/// Weights of the TLX: each of six against each other, so often chosen in all.
const TLX_WEIGHTS: f64 = 15.0;

impl Score {
    /// The unit of scores.
    pub const UNIT: &str = "points";

    /// The metric as which it is compared.
    ///
    /// # Errors
    /// An id that is too long with what stands before it.
    pub fn metric(&self) -> Result<MetricId, IdError> {
        MetricId::new(format!("score_{}", self.id))
    }

    /// What it is called, and how it is made: `Workload (weighted NASA-TLX)`.
    pub fn in_words(&self) -> String {
        let n = self.questions.len();
        let rule = match self.kind {
            ScoreKind::NasaTlx => "weighted NASA-TLX".to_owned(),
            ScoreKind::NasaTlxRaw => "raw NASA-TLX".to_owned(),
            ScoreKind::Sus => "System Usability Scale".to_owned(),
            ScoreKind::Mean if n == 1 => "one answer".to_owned(),
            ScoreKind::Mean => format!("mean of {n} answers"),
            ScoreKind::Sum => format!("sum of {n} answers"),
        };
        format!("{} ({rule})", self.label.as_deref().unwrap_or(self.id.as_str()))
    }

    /// Which values of it are better.
    pub fn better(&self) -> Better {
        self.better.unwrap_or(match self.kind {
            ScoreKind::NasaTlx | ScoreKind::NasaTlxRaw => Better::Lower,
            ScoreKind::Sus => Better::Higher,
            ScoreKind::Mean | ScoreKind::Sum => Better::Neither,
        })
    }

    /// Each two of its questions, by their places: 15 of six. The one whose id is first in the alphabet stands first, for
    /// the answer 1, and the other for 2: answers keep their meaning when the list gets another order.
    pub fn pairs_of_places(&self) -> Vec<[usize; 2]> {
        let n = self.questions.len();
        let mut by_id: Vec<usize> = (0..n).collect();
        by_id.sort_by_key(|place| self.questions[*place].as_str());
        let pairs = (0..n).flat_map(|first| (first + 1..n).map(move |second| [first, second]));
        pairs.map(|pair| pair.map(|place| by_id[place])).collect()
    }

    /// The id of the question about one of [`Score::pairs_of_places`]: `effort_or_mental`.
    ///
    /// # Errors
    /// An id that is too long.
    pub fn pair_id(&self, places: [usize; 2]) -> Result<QuestionId, IdError> {
        let [first, second] = places.map(|place| &self.questions[place]);
        QuestionId::new(format!("{first}_or_{second}"))
    }

    /// The questions whose answers weigh: those of `weights`, or one about each pair.
    pub fn weighing(&self) -> Vec<QuestionId> {
        if self.pairs.is_none() {
            return self.weights.clone();
        }
        // A study with a pair whose id cannot be is refused.
        self.pairs_of_places().into_iter().filter_map(|places| self.pair_id(places).ok()).collect()
    }

    /// How often each question was chosen of two, by the answers to [`Score::weighing`].
    fn weights(&self, answers: &[Option<AnswerValue>]) -> Result<Vec<f64>, String> {
        let given: Vec<AnswerValue> = answers.iter().flatten().copied().collect();
        let what = if self.pairs.is_some() { "pairs" } else { "weights" };
        if given.len() < answers.len() {
            return Err(format!("{} of {} {what} are answered", given.len(), answers.len()));
        }
        if self.pairs.is_none() {
            return Ok(given.into_iter().map(AnswerValue::get).collect());
        }
        let mut chosen = vec![0.0; self.questions.len()];
        for ([first, second], answer) in self.pairs_of_places().into_iter().zip(given) {
            let place = match answer.whole() {
                Some(1) => first,
                Some(2) => second,
                _ => {
                    return Err(format!(
                        "a pair is answered by {answer}, which is neither 1 nor 2"
                    ));
                }
            };
            chosen[place] += 1.0;
        }
        Ok(chosen)
    }

    /// The score of answers to its questions in their order, each with its scale and turned where the question is
    /// reversed, and of the answers to [`Score::weighing`]; or why there is none.
    ///
    /// # Errors
    /// A question without an answer, beyond what `min_answered` allows; a weight or a pair without one; weights that do
    /// not add up to 15.
    pub fn of(
        &self,
        answers: &[Option<(&AnswerScale, AnswerValue)>],
        weights: &[Option<AnswerValue>],
    ) -> Result<f64, String> {
        let number = self.questions.len();
        let given = answers.iter().flatten().map(|(scale, value)| self.item(scale, *value));
        let given: Vec<f64> = given.collect();
        let needed = match (self.kind, self.min_answered) {
            (ScoreKind::Mean, Some(share)) => {
                (share * number as f64 - 1e-9).ceil().max(1.0) as usize
            }
            _ => number,
        };
        if given.len() < needed {
            return Err(format!(
                "{} of {number} questions are answered, {needed} are needed",
                given.len()
            ));
        }
        let sum: f64 = given.iter().sum();
        Ok(match self.kind {
            ScoreKind::NasaTlxRaw | ScoreKind::Mean => sum / given.len() as f64,
            ScoreKind::Sum | ScoreKind::Sus => sum,
            ScoreKind::NasaTlx => {
                let weights = self.weights(weights)?;
                let all: f64 = weights.iter().sum();
                if (all - TLX_WEIGHTS).abs() > 1e-9 {
                    return Err(format!("the weights add up to {all}, and not to {TLX_WEIGHTS}"));
                }
                given.iter().zip(&weights).map(|(item, weight)| item * weight).sum::<f64>() / all
            }
        })
    }

    /// What an answer counts: of a TLX as a share of its scale of 100, of a SUS of 10.
    pub fn item(&self, scale: &AnswerScale, answer: AnswerValue) -> f64 {
        let [low, high] = [scale.lowest(), scale.highest()].map(f64::from);
        match self.kind {
            ScoreKind::NasaTlx | ScoreKind::NasaTlxRaw => {
                100.0 * (answer.get() - low) / (high - low)
            }
            ScoreKind::Sus => 10.0 * (answer.get() - low) / (high - low),
            ScoreKind::Mean | ScoreKind::Sum => answer.get(),
        }
    }
}
