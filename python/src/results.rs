//! What a run made of a study, where it still is what the recordings give: another file would be read as the study's result.

use crate::calling::Fault;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use zwidth_runner::{Records, Results, trace};
use zwidth_store::{RealFiles, StudyData, file_blake3};

/// A result of the study, by its path below the root with `/`.
///
/// # Errors
/// One that was not made; one of which a source, a table on the way or the file itself is another now; one that does not
/// have every trial that counts, or has another, if it is `of_all_trials`.
pub(crate) fn up_to_date(
    data: &StudyData,
    result: &str,
    of_all_trials: bool,
) -> Result<PathBuf, Fault> {
    let layout = &data.layout;
    let root = layout.root();
    let path = root.join(result);
    let study = layout.study();
    let remedy = format!(
        "run: zwidth run {study} --root {}",
        zwidth_store::shell_line([root.to_string_lossy().into_owned()])
    );
    let stale = |file: &str, what: &str| {
        Fault::new(what, &remedy).in_file(root.join(file).to_string_lossy())
    };
    let results = Results::new(layout, &RealFiles);
    let (records, _) = Records::read(&results)?;
    let Some(job) = records.maker(result) else {
        return Err(stale(result, "no run has made this result"));
    };
    let Some(found) = trace(&records, job) else {
        return Err(stale(result, "no run has made this result"));
    };
    if let Some(lost) = found.lost.first() {
        return Err(stale(
            &lost.path,
            "this file was made again after the result that rests on it",
        ));
    }
    let made = found.steps.first().and_then(|step| step.record.outputs.get(result));
    if is_another(&path, made) {
        return Err(stale(result, "this result is another one than the run made"));
    }
    if let Some(source) =
        found.sources.iter().find(|s| is_another(&root.join(&s.path), Some(&s.blake3)))
    {
        return Err(stale(&source.path, "this file has changed since the run"));
    }
    if of_all_trials {
        let read: BTreeSet<&str> =
            found.sources.iter().map(|source| source.path.as_str()).collect();
        for trial in &data.trials {
            let file = layout.shown(&trial.path).to_string_lossy().replace('\\', "/");
            let counts = trial.counts()
                && data.study.environments.iter().any(|e| e.id == trial.meta.environment)
                && data.study.modes.iter().any(|mode| mode.id == trial.meta.mode);
            if counts != read.contains(file.as_str()) {
                let what = match counts {
                    true => "this trial counts, and is not in the result",
                    false => "this trial does not count any more, and is in the result",
                };
                return Err(stale(&file, what));
            }
        }
    }
    Ok(path)
}

/// Whether a file is not the one that had this hash.
fn is_another(path: &Path, blake3: Option<&String>) -> bool {
    file_blake3(path).ok().as_ref() != blake3
}
