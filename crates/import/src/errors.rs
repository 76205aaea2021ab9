//! Everything found wrong, file by file.

use zwidth_store::FirstErrors;

/// Everything found wrong; never empty.
pub(super) type Errors = FirstErrors;

/// Every value, or every error.
pub(super) fn all<T, E: Into<Errors>>(
    results: impl IntoIterator<Item = Result<T, E>>,
) -> Result<Vec<T>, Errors> {
    let mut values = Vec::new();
    let mut errors = Errors::default();
    for result in results {
        match result {
            Ok(value) => values.push(value),
            Err(error) => append(&mut errors, error),
        }
    }
    errors.none().map(|()| values)
}

/// Adds errors behind others.
pub(super) fn append(errors: &mut Errors, others: impl Into<Errors>) {
    let others = others.into();
    errors.extend(others.iter().cloned());
    errors.count(others.more());
}
