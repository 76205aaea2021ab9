//! How effects compare the levels of a factor: pairs, and trends over doses.

use crate::{Contrast, DoseScale, IdError, LevelId, Trend, Weight};
use serde::Serialize;
use std::fmt;
use std::str::FromStr;

/// How an effect compares the levels of one factor.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[serde(untagged)]
pub enum LevelContrast {
    /// The one less the other.
    Pair([LevelId; 2]),
    /// Of a dose: the slope of a line, or the bend of a parabola, over so much of it: `per 100 N/m`.
    Trend(String),
}

impl LevelContrast {
    const SLOPE: &str = "per ";
    const BEND: &str = "bend per ";

    /// Whether it is the bend of a parabola.
    pub fn is_bend(&self) -> bool {
        matches!(self, Self::Trend(words) if words.starts_with(Self::BEND))
    }
}

impl fmt::Display for LevelContrast {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Pair([one, other]) => write!(f, "{one}{}{other}", Contrast::MINUS),
            Self::Trend(words) => f.write_str(words),
        }
    }
}

impl FromStr for LevelContrast {
    type Err = IdError;

    fn from_str(text: &str) -> Result<Self, IdError> {
        if text.starts_with(Self::SLOPE) || text.starts_with(Self::BEND) {
            return Ok(Self::Trend(text.to_owned()));
        }
        // Without the sign the second text is empty, which is no id: that is the error.
        let (one, other) = text.split_once(Contrast::MINUS).unwrap_or((text, ""));
        Ok(Self::Pair([one.parse()?, other.parse()?]))
    }
}

impl Trend {
    /// How the line over doses, and its bend, are called. The line is per step of a power of ten, or per
    /// doubling; the bend per square of that.
    pub(crate) fn contrasts(self, doses: &[f64], unit: &str) -> Vec<LevelContrast> {
        let (words, square) = match self.scale {
            DoseScale::Log2 => ("doubling".to_owned(), "doubling²".to_owned()),
            DoseScale::Linear => {
                let unit = if unit == "1" { String::new() } else { format!(" {unit}") };
                let words = format!("{}{unit}", step(doses));
                (words.clone(), format!("({words})²"))
            }
        };
        let slope = LevelContrast::Trend(format!("{}{words}", LevelContrast::SLOPE));
        let bend = LevelContrast::Trend(format!("{}{square}", LevelContrast::BEND));
        [slope, bend].into_iter().take(self.degree.into()).collect()
    }

    /// Doses as the line is over them: in steps of a power of ten, or in doublings. The step is that of all
    /// doses of the study.
    fn scaled(self, all: &[f64], doses: &[f64]) -> Vec<f64> {
        let scaled = |dose: &f64| match self.scale {
            DoseScale::Log2 => dose.log2(),
            DoseScale::Linear => dose / step(all),
        };
        doses.iter().map(scaled).collect()
    }
}

/// The power of ten that the range of doses has the digits of.
fn step(doses: &[f64]) -> f64 {
    let range = doses[doses.len() - 1] - doses[0];
    10_f64.powf(range.log10().floor())
}

/// Everybody's own line, or parabola, over the levels of a dose.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OverDose {
    /// Its degree, and over what it is drawn.
    pub trend: Trend,
    /// The doses from the lowest on.
    pub doses: Vec<f64>,
    /// Their unit.
    pub unit: String,
    /// The weights of the conditions in the mean of each level.
    pub levels: Vec<Vec<Weight>>,
}

impl OverDose {
    /// The weights of the means of some levels, by their places, in a coefficient of the line or parabola by least squares: 1
    /// is the slope of the line, 2 the bend of the parabola. Fewer levels than it takes have none.
    pub fn coefficient(&self, places: &[usize], number: usize) -> Option<Vec<f64>> {
        let columns = self.columns(places, number, None);
        let column = columns.get(number)?;
        let size: f64 = column.iter().map(|value| value * value).sum();
        (places.len() > number).then(|| column.iter().map(|value| value / size).collect())
    }

    /// The weights of the means of all levels in the line, or parabola, at a dose.
    pub fn at(&self, dose: f64) -> Vec<f64> {
        let places: Vec<usize> = (0..self.doses.len()).collect();
        let mut weights = vec![0.0; places.len()];
        for mut column in self.columns(&places, self.trend.degree.into(), Some(dose)) {
            let here = column.pop().unwrap_or_default();
            let size: f64 = column.iter().map(|value| value * value).sum();
            weights
                .iter_mut()
                .zip(&column)
                .for_each(|(weight, value)| *weight += here * value / size);
        }
        weights
    }

    /// The doses as the line is over them: in steps of a power of ten, or in doublings.
    pub fn scaled(&self) -> Vec<f64> {
        self.trend.scaled(&self.doses, &self.doses)
    }

    /// The dose at a share of the way from the lowest to the highest, as the line is drawn.
    pub fn along(&self, share: f64) -> f64 {
        let [low, high] = [self.doses[0], self.doses[self.doses.len() - 1]];
        match self.trend.scale {
            DoseScale::Linear => low + share * (high - low),
            DoseScale::Log2 => low * (high / low).powf(share),
        }
    }

    /// The powers of the doses at `places` from 0 on, each less its parts along those before it: what is
    /// orthogonal at these. Each has at its end its value at `also`.
    fn columns(&self, places: &[usize], highest: usize, also: Option<f64>) -> Vec<Vec<f64>> {
        let doses: Vec<f64> = places.iter().map(|place| self.doses[*place]).chain(also).collect();
        let x = self.trend.scaled(&self.doses, &doses);
        let n = places.len();
        let mean = x[..n].iter().sum::<f64>() / n as f64;
        let mut columns: Vec<Vec<f64>> = Vec::new();
        for power in 0..=highest {
            let mut column: Vec<f64> = x.iter().map(|x| (x - mean).powi(power as i32)).collect();
            for before in &columns {
                let dot = |a: &[f64], b: &[f64]| {
                    a[..n].iter().zip(&b[..n]).map(|(a, b)| a * b).sum::<f64>()
                };
                let along = dot(before, &column) / dot(before, before);
                column.iter_mut().zip(before).for_each(|(value, before)| *value -= along * before);
            }
            columns.push(column);
        }
        columns
    }
}
