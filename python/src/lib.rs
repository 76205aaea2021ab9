//! zwidth for Python (`zwidth._native`, docs/python.md): a study's tables as Arrow, and what the stages compute on one's own
//! arrays. It reads and computes; only the command writes.
//!
//! Each call computes on a thread of its own ([`calling`]): so Python goes on meanwhile, Ctrl-C ends the wait, and a panic
//! ends as an error.

mod arrow;
mod calling;
mod fits;
mod given;
mod judging;
mod metrics;
mod results;
mod scene;
mod simulating;
mod stability;
mod study;
mod table;
mod trial;

/// A study's tables as Arrow, and what the stages compute on one's own arrays.
#[pyo3::pymodule]
mod _native {
    use pyo3::prelude::*;

    #[pymodule_export]
    use crate::fits::{Characteristic, Psychometric, fit_characteristic, fit_psychometric};
    #[pymodule_export]
    use crate::judging::{Judgement, judge};
    #[pymodule_export]
    use crate::metrics::{means_by_branch, onset, smoothness, trial_metrics};
    #[pymodule_export]
    use crate::simulating::{Runs, simulate};
    #[pymodule_export]
    use crate::stability::{stability_limits, stability_map};
    #[pymodule_export]
    use crate::study::{Study, read_study};
    #[pymodule_export]
    use crate::table::{Column, Table};
    #[pymodule_export]
    use crate::trial::{Samples, Trial, read_trial};

    /// Its version is that of the command.
    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
