//! How a call computes, and what it says if it fails.

use pyo3::prelude::*;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread::Builder;
use std::time::Duration;
use zwidth_store::StoreError;

/// How long a call waits before it looks for Ctrl-C again.
const LOOK: Duration = Duration::from_millis(50);
/// The stack of a call's thread, bytes: that of a program's first one.
const STACK: usize = 8 << 20;

/// What went wrong, in the parts that `zwidth.ZwidthError` has.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Fault {
    file: Option<String>,
    column: Option<String>,
    row: Option<usize>,
    what: String,
    remedy: Option<String>,
}

impl Fault {
    pub(crate) fn new(what: impl Into<String>, remedy: &str) -> Self {
        let remedy = Some(remedy.to_owned());
        Self { file: None, column: None, row: None, what: what.into(), remedy }
    }

    /// What a library says in one text, with its remedy.
    pub(crate) fn said(error: impl std::fmt::Display) -> Self {
        Self { file: None, column: None, row: None, what: error.to_string(), remedy: None }
    }

    /// In one text: where, what, and what to do.
    pub(crate) fn text(&self) -> String {
        let column = self.column.as_ref().map(|column| format!("column {column}"));
        let row = self.row.map(|row| format!("row {row}"));
        let place: Vec<String> = [self.file.clone(), column, row].into_iter().flatten().collect();
        let place =
            if place.is_empty() { String::new() } else { format!("{}: ", place.join(", ")) };
        let remedy = self.remedy.as_ref().map_or_else(String::new, |remedy| format!("; {remedy}"));
        format!("{place}{}{remedy}", self.what)
    }

    #[must_use]
    pub(crate) fn in_file(self, file: impl Into<String>) -> Self {
        Self { file: Some(file.into()), ..self }
    }

    #[must_use]
    pub(crate) fn in_column(self, column: impl Into<String>) -> Self {
        Self { column: Some(column.into()), ..self }
    }

    /// In a row counted from 0, shown from 1.
    #[must_use]
    pub(crate) fn in_row0(self, row: usize) -> Self {
        Self { row: Some(row + 1), ..self }
    }
}

impl From<StoreError> for Fault {
    fn from(error: StoreError) -> Self {
        let StoreError { path, column, row, what, remedy, .. } = error;
        let file = Some(path.to_string_lossy().into_owned());
        Self { file, column, row, what, remedy: Some(remedy) }
    }
}

/// Of several findings the first, and how many more there are.
impl From<Vec<StoreError>> for Fault {
    fn from(findings: Vec<StoreError>) -> Self {
        let more = findings.len().saturating_sub(1);
        let Some(first) = findings.into_iter().next() else {
            return Self::said("it cannot be read");
        };
        let mut fault = Self::from(first);
        if more > 0 {
            fault.what =
                format!("{} (and {more} more findings, which `zwidth verify` lists)", fault.what);
        }
        fault
    }
}

impl From<Fault> for PyErr {
    fn from(fault: Fault) -> Self {
        Python::attach(|py| {
            let text = fault.text();
            let Fault { file, column, row, remedy, .. } = fault;
            let raised = py.import("zwidth._errors").and_then(|errors| {
                errors.getattr("ZwidthError")?.call1((text, file, column, row, remedy))
            });
            raised.map_or_else(|error| error, PyErr::from_value)
        })
    }
}

/// What a call looks at to know that nobody waits for it any more.
#[derive(Debug, Clone, Default)]
pub(crate) struct Stop(Arc<AtomicBool>);

impl Stop {
    pub(crate) fn is_wanted(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// What `compute` gives, computed on a thread of its own. Python's other threads go on meanwhile. Ctrl-C raises
/// `KeyboardInterrupt`: `compute` is told by [`Stop`], and what it still gives is dropped.
pub(crate) fn call<T: Send + 'static>(
    py: Python<'_>,
    compute: impl FnOnce(&Stop) -> Result<T, Fault> + Send + 'static,
) -> PyResult<T> {
    Ok(computed(py, compute)??)
}

/// What `compute` gives, or that it panicked; the outer error is Ctrl-C.
fn computed<T: Send + 'static>(
    py: Python<'_>,
    compute: impl FnOnce(&Stop) -> Result<T, Fault> + Send + 'static,
) -> PyResult<Result<T, Fault>> {
    let stop = Stop::default();
    let (give, given) = channel();
    let told = stop.clone();
    let thread = Builder::new().name("zwidth".to_owned()).stack_size(STACK).spawn(move || {
        // Nobody may be waiting any more.
        let _ = give.send(compute(&told));
    });
    let thread = thread.map_err(|e| {
        Fault::new(format!("no thread could be started: {e}"), "end other programs")
    })?;
    let mut given = given;
    loop {
        let received;
        (given, received) = py.detach(move || {
            let received = given.recv_timeout(LOOK);
            (given, received)
        });
        match received {
            Ok(result) => return Ok(result),
            Err(RecvTimeoutError::Timeout) => {
                if let Err(interrupt) = py.check_signals() {
                    stop.0.store(true, Ordering::Relaxed);
                    return Err(interrupt);
                }
            }
            // The thread ended and gave nothing.
            Err(RecvTimeoutError::Disconnected) => {
                let why = thread.join().err().map(|panic| words(&*panic)).unwrap_or_default();
                let what = format!("zwidth met a case that it does not know ({why})");
                return Ok(Err(Fault::new(
                    what,
                    "this is a defect of zwidth; please report it with the call",
                )));
            }
        }
    }
}

/// What a panic says.
fn words(panic: &(dyn std::any::Any + Send)) -> String {
    let text = panic.downcast_ref::<&str>().map(|text| (*text).to_owned());
    text.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_default()
}

#[cfg(test)]
#[allow(clippy::panic, clippy::unwrap_used)] // of a test
mod tests {
    use super::*;

    #[test]
    fn a_panic_ends_as_a_fault_that_says_what_it_said() {
        Python::attach(|py| {
            let fault = computed(py, |_| -> Result<u8, Fault> { panic!("boom") }).unwrap();
            let text = fault.unwrap_err().text();
            assert!(text.contains("boom") && text.contains("defect of zwidth"), "{text}");
            assert_eq!(computed(py, |_| Ok(7)).unwrap(), Ok(7), "and the next call is as any");
        });
    }

    #[test]
    fn a_fault_says_where_what_and_what_to_do() {
        let fault = Fault::new("it is not there", "look elsewhere");
        let fault = fault.in_file("a.toml").in_column("mass").in_row0(4);
        assert_eq!(fault.text(), "a.toml, column mass, row 5: it is not there; look elsewhere");
        assert_eq!(Fault::said("it is not there").text(), "it is not there");
    }
}
