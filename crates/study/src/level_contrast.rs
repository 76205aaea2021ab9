//! How effects compare the levels of a factor: pairs, and trends over doses.

use crate::{Contrast, DoseScale, IdError, LevelId, Trend};
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
    /// The line over doses, and its bend: what each is called, and the weights of the doses in it, by least
    /// squares. The line per step of a power of ten, or per doubling; the bend per square of that.
    pub(crate) fn contrasts(self, doses: &[f64], unit: &str) -> Vec<(LevelContrast, Vec<f64>)> {
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let centred = |values: &[f64]| -> Vec<f64> {
            let mean = mean(values);
            values.iter().map(|value| value - mean).collect()
        };
        let (x, step, words) = match self.scale {
            DoseScale::Log2 => {
                (doses.iter().map(|dose| dose.log2()).collect(), 1.0, "doubling".to_owned())
            }
            DoseScale::Linear => {
                let range = doses[doses.len() - 1] - doses[0];
                let step = 10_f64.powf(range.log10().floor());
                let unit = if unit == "1" { String::new() } else { format!(" {unit}") };
                (doses.to_vec(), step, format!("{step}{unit}"))
            }
        };
        let x: Vec<f64> = centred(&x).into_iter().map(|x| x / step).collect();
        let slope = x.iter().map(|value| value / dot(&x, &x)).collect();
        let mut contrasts =
            vec![(LevelContrast::Trend(format!("{}{words}", LevelContrast::SLOPE)), slope)];
        if self.degree > 1 {
            // What is left of x² beside a level and a line.
            let squares: Vec<f64> = x.iter().map(|x| x * x).collect();
            let squares = centred(&squares);
            let along = dot(&squares, &x) / dot(&x, &x);
            let rest: Vec<f64> = squares.iter().zip(&x).map(|(s, x)| s - along * x).collect();
            let bend = rest.iter().map(|value| value / dot(&rest, &rest)).collect();
            let words = match self.scale {
                DoseScale::Linear => format!("({words})²"),
                DoseScale::Log2 => format!("{words}²"),
            };
            contrasts.push((LevelContrast::Trend(format!("{}{words}", LevelContrast::BEND)), bend));
        }
        contrasts
    }
}
