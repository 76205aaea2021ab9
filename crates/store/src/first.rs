//! The first of many errors, and how many more there are. A file can be wrong in every row, and
//! nobody reads one message per row.

use crate::StoreError;
use std::ops::Deref;

/// Errors that are kept: of many files the same is often wrong, which is then told once.
const MOST_KEPT: usize = 1_000;

/// Errors in the order in which they were found: the first of them, and a count of the others.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct FirstErrors {
    first: Vec<StoreError>,
    more: usize,
}

impl FirstErrors {
    /// Adds an error behind the others.
    pub fn push(&mut self, error: StoreError) {
        if self.first.len() < MOST_KEPT {
            self.first.push(error);
        } else {
            self.more += 1;
        }
    }

    /// Counts errors that were found but not kept.
    pub fn count(&mut self, more: usize) {
        self.more += more;
    }

    /// The number of errors besides the ones kept.
    pub fn more(&self) -> usize {
        self.more
    }

    /// The same errors, with `change` applied to each one kept.
    #[must_use]
    pub fn map(self, change: impl FnMut(StoreError) -> StoreError) -> Self {
        Self { first: self.first.into_iter().map(change).collect(), ..self }
    }

    /// Nothing, if there is no error.
    ///
    /// # Errors
    /// The errors.
    pub fn none(self) -> Result<(), Self> {
        if self.first.is_empty() { Ok(()) } else { Err(self) }
    }
}

/// The errors kept.
impl Deref for FirstErrors {
    type Target = [StoreError];

    fn deref(&self) -> &[StoreError] {
        &self.first
    }
}

impl Extend<StoreError> for FirstErrors {
    fn extend<I: IntoIterator<Item = StoreError>>(&mut self, errors: I) {
        errors.into_iter().for_each(|error| self.push(error));
    }
}

impl FromIterator<StoreError> for FirstErrors {
    fn from_iter<I: IntoIterator<Item = StoreError>>(errors: I) -> Self {
        let mut first = Self::default();
        first.extend(errors);
        first
    }
}

impl From<StoreError> for FirstErrors {
    fn from(error: StoreError) -> Self {
        Self { first: vec![error], more: 0 }
    }
}

/// The errors kept and, if there are more, one that gives their number.
impl From<FirstErrors> for Vec<StoreError> {
    fn from(FirstErrors { mut first, more }: FirstErrors) -> Self {
        if let Some(last) = first.last().filter(|_| more > 0) {
            let what = format!("there are {more} more errors than these");
            first.push(StoreError::new(&last.path, what, "mend these first, and try again"));
        }
        first
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[test]
    fn of_many_errors_the_first_are_kept_and_the_others_counted() {
        let error = |i: usize| StoreError::new(Path::new("a.csv"), format!("row {i}"), "mend it");
        let mut errors: FirstErrors = (0..200_000).map(error).collect();
        errors.count(5);
        assert_eq!((errors.len(), errors.more()), (MOST_KEPT, 199_005));
        let list = Vec::from(errors.clone());
        assert_eq!((list.len(), &list[0]), (MOST_KEPT + 1, &error(0)));
        assert_eq!(list[MOST_KEPT].what, "there are 199005 more errors than these");
        assert!(errors.none().is_err() && FirstErrors::default().none().is_ok());
        assert_eq!(Vec::from(FirstErrors::from(error(1))), [error(1)]);
    }
}
