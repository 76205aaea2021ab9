//! Answers on an ordered scale, with variables that may explain them, screened before any search:
//! are there two different answers, can the columns be told apart, has the likelihood a maximum at
//! all?

use crate::error::{StatsError, all_finite, same_length};
use crate::separation::{self, Pattern};
use crate::tested::{Unestimable, at_least};
use std::collections::BTreeMap;
use zwidth_numerics::{NumericsError, lsq};

/// A component of a direction below this share of the largest is rounding.
pub(crate) const DIRECTION_ROUNDING: f64 = 1e-6;

/// The categories of a scale, divided by whether anybody chose them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Scale {
    /// Categories that were chosen, ascending: those of the model.
    pub used: Vec<u8>,
    /// Categories that nobody chose. The model leaves them out: their probability would be
    /// estimated as 0, between two equal thresholds, and nothing else would change.
    pub unused: Vec<u8>,
}

/// A column of the fixed effects: one value per row. A model of answers has its thresholds for an
/// intercept, so there no column may be constant.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// Its name in messages: `mode passive`.
    pub name: String,
    /// Its values.
    pub values: Vec<f64>,
}

/// Answers with their columns, in the order given.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Answers {
    pub(crate) scale: Scale,
    /// Index of each answer among the categories used.
    pub(crate) codes: Vec<usize>,
    pub(crate) columns: Vec<Column>,
}

impl Answers {
    /// Answers from 1 to `points` with their columns.
    pub(crate) fn new(answers: &[u8], points: u8, columns: &[Column]) -> Result<Self, Unestimable> {
        if let Some(index) = answers.iter().position(|&a| a < 1 || a > points) {
            return Err(StatsError::Answer { index, found: answers[index], points }.into());
        }
        for column in columns {
            all_finite(&column.values)?;
            same_length("a column", answers.len(), column.values.len())?;
        }
        let (used, unused): (Vec<u8>, Vec<u8>) = (1..=points).partition(|c| answers.contains(c));
        match used.len() {
            0 => return Err(Unestimable::TooFew { units: "answers", found: 0, needed: 2 }),
            1 => return Err(Unestimable::Constant { units: "answers" }),
            _ => {}
        }
        let codes = answers.iter().map(|&a| used.partition_point(|&c| c < a)).collect();
        Ok(Self { scale: Scale { used, unused }, codes, columns: columns.to_vec() })
    }

    /// Number of categories used.
    pub(crate) fn categories(&self) -> usize {
        self.scale.used.len()
    }

    /// Whether a finite maximum of the likelihood exists and is unique: the columns (and a column
    /// of ones) are independent, and nothing separates the answers.
    pub(crate) fn screen(&self) -> Result<(), Unestimable> {
        match self.separated_along()? {
            None => Ok(()),
            Some(direction) => Err(Unestimable::Separated { what: self.names(&direction) }),
        }
    }

    /// The direction of the coefficients along which the likelihood only rises; `None` where it has
    /// a finite maximum.
    pub(crate) fn separated_along(&self) -> Result<Option<Vec<f64>>, Unestimable> {
        self.independent()?;
        let patterns = self.patterns(0..self.codes.len());
        Ok(separation::direction(&patterns, self.categories()))
    }

    fn independent(&self) -> Result<(), Unestimable> {
        let rows = self.codes.len();
        // The thresholds stand for an intercept: the columns must be independent of ones, too.
        let ones = vec![1.0; rows];
        let mut all: Vec<&[f64]> = vec![&ones];
        all.extend(self.columns.iter().map(|c| c.values.as_slice()));
        at_least("answers", rows, all.len() + 1)?;
        // Whatever is fitted, the fit tests the rank of the columns.
        match lsq::fit(&all, &ones) {
            Err(NumericsError::RankDeficient { column }) => {
                let what = match column {
                    1 => format!("{} from what all answers share", self.columns[0].name),
                    _ => format!("{} from the columns before it", self.columns[column - 1].name),
                };
                Err(Unestimable::Confounded { what })
            }
            Err(other) => Err(StatsError::from(other).into()),
            Ok(_) => Ok(()),
        }
    }

    /// The names of the columns that a direction of the coefficients moves along.
    pub(crate) fn names(&self, direction: &[f64]) -> String {
        let largest = direction.iter().fold(0.0_f64, |most, d| most.max(d.abs()));
        let pairs = self.columns.iter().zip(direction);
        // By their share of the largest: a direction has any length.
        let moved = pairs.filter(|(_, d)| d.abs() > DIRECTION_ROUNDING * largest);
        moved.map(|(column, _)| column.name.as_str()).collect::<Vec<_>>().join(" and ")
    }

    /// The answers of some rows, counted by their values of the columns, in the order in which
    /// those first occur.
    pub(crate) fn patterns(&self, rows: impl IntoIterator<Item = usize>) -> Vec<Pattern> {
        let mut places: BTreeMap<Vec<u64>, usize> = BTreeMap::new();
        let mut patterns: Vec<Pattern> = Vec::new();
        for row in rows {
            // + 0.0 makes one number of 0 and −0.
            let x: Vec<f64> = self.columns.iter().map(|c| c.values[row] + 0.0).collect();
            let key = x.iter().map(|v| v.to_bits()).collect();
            let place = *places.entry(key).or_insert(patterns.len());
            if place == patterns.len() {
                patterns.push(Pattern { x, counts: vec![0.0; self.categories()] });
            }
            patterns[place].counts[self.codes[row]] += 1.0;
        }
        patterns
    }
}
