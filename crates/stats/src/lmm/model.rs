//! The parts of a linear mixed model.

use crate::answers::Column;
use crate::error::{StatsError, all_finite, same_length};

/// A random term: each level of it within a group draws one vector of effects, one effect per
/// column, with a covariance matrix of its own. `(Days|Subject)` is the columns 1 and Days with one
/// level; participant × mode is the column 1 with the mode as level.
#[derive(Debug, Clone, PartialEq)]
pub struct RandomTerm {
    /// Its name in messages and tables.
    pub name: String,
    /// The columns that its effects multiply, one value per row each.
    pub columns: Vec<Vec<f64>>,
    /// The level of each row. Levels of different groups are different, whatever their number.
    pub level: Vec<usize>,
}

impl RandomTerm {
    /// A term of one effect per level (column of ones).
    pub fn intercept(name: &str, level: Vec<usize>) -> Self {
        Self { name: name.to_owned(), columns: vec![vec![1.0; level.len()]], level }
    }
}

/// A linear mixed model y = X β + Z b + ε whose random effects lie within the levels of one
/// grouping: those of different groups (participants) are independent.
#[derive(Debug, Clone, PartialEq)]
pub struct Model {
    /// y, one value per row.
    pub response: Vec<f64>,
    /// The columns of X; the unit of a coefficient is that of y per unit of its column.
    pub fixed: Vec<Column>,
    /// The group of each row, any numbers.
    pub group: Vec<usize>,
    /// The random terms, within groups.
    pub random: Vec<RandomTerm>,
}

impl Model {
    /// Checks lengths and that all numbers are finite.
    pub(super) fn check(&self) -> Result<(), StatsError> {
        let rows = self.response.len();
        all_finite(&self.response)?;
        same_length("the grouping", rows, self.group.len())?;
        for column in &self.fixed {
            same_length("a fixed column", rows, column.values.len())?;
            all_finite(&column.values)?;
        }
        for term in &self.random {
            same_length("a random term's levels", rows, term.level.len())?;
            for column in &term.columns {
                same_length("a random column", rows, column.len())?;
                all_finite(column)?;
            }
        }
        Ok(())
    }
}
