//! A job made again, to see whether the same bytes come out.

use crate::provenance::provenance;
use crate::{Job, Making, Output, Records, Results, Scripts};
use std::path::PathBuf;
use zwidth_store::{Lately, MOST_BYTES, StoreError};

/// A file that came out with other bytes when its job was made again.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Unlike {
    /// The file.
    pub path: PathBuf,
    /// What it holds; nothing if it cannot be read.
    pub kept: Vec<u8>,
    /// What came out.
    pub again: Vec<u8>,
}

/// Makes a job again that has a record, writes nothing, and gives the files that came out otherwise.
/// The inner error is the job's own.
///
/// # Errors
/// Records that cannot be read; a link on the way to a file.
pub fn made_twice(
    job: &Job,
    results: &Results,
    scripts: &Scripts,
) -> Result<Result<Vec<Unlike>, String>, StoreError> {
    let (records, _) = Records::read(results)?;
    let Some(record) = records.get(&job.name) else {
        return Ok(Err("it was not made, so that there is nothing to compare with".to_owned()));
    };
    let from = provenance(&job.name, &record);
    let trials = Lately::default();
    let root = results.root();
    let making = Making { from: &from, outputs: &job.outputs, root, trials: &trials, scripts };
    let made = match job.make(&making) {
        Ok(made) => made,
        Err(error) => return Ok(Err(error.to_string())),
    };
    let mut unlike = Vec::new();
    for (path, output) in job.outputs.iter().zip(made.outputs) {
        let mut again = Vec::new();
        match output {
            Output::Whole(bytes) => again = bytes,
            Output::Long(write) => {
                if let Err(error) = write(&mut again) {
                    return Ok(Err(error.to_string()));
                }
            }
        }
        let kept = results.read(path, MOST_BYTES)?.and_then(Result::ok).unwrap_or_default();
        if kept != again {
            unlike.push(Unlike { path: path.clone(), kept, again });
        }
    }
    Ok(Ok(unlike))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Made, Options, Stage, run};
    use std::fs;
    use std::sync::atomic::{AtomicU32, Ordering};
    use zwidth_store::{Layout, RealFiles};

    #[test]
    fn what_differs_the_second_time_is_found_and_nothing_is_written() {
        static TIMES: AtomicU32 = AtomicU32::new(0);
        let folder = tempfile::tempdir().unwrap();
        let layout = Layout::new(folder.path(), "s".parse().unwrap());
        let outputs = ["same", "other"].map(|name| layout.derived().join(name)).to_vec();
        let stage = Stage { name: "s", version: 1 };
        let job = Job::new(stage, "job", (), (), outputs.clone(), |(), (), _| {
            let times = TIMES.fetch_add(1, Ordering::SeqCst).to_string();
            Ok(Made::of(vec![b"same".to_vec(), times.into_bytes()]))
        });
        let results = Results::new(&layout, &RealFiles);
        let error = made_twice(&job, &results, &Scripts::None).unwrap().unwrap_err();
        assert!(error.contains("nothing to compare with"), "{error}");
        run(std::slice::from_ref(&job), &results, &Options::default(), &|_| {}).unwrap();
        let unlike = made_twice(&job, &results, &Scripts::None).unwrap().unwrap();
        let expect = Unlike { path: outputs[1].clone(), kept: b"0".to_vec(), again: b"1".to_vec() };
        assert_eq!(unlike, [expect]);
        assert_eq!(fs::read(&outputs[1]).unwrap(), b"0");
    }
}
