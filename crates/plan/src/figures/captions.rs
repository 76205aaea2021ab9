//! The captions of all figures in one file per format, for documents.

use crate::figures::drawing::{Drawing, STAGE};
use std::path::PathBuf;
use zwidth_figures::{CAPTION_FORMATS, NamedCaption, captions_text};
use zwidth_runner::{Job, JobError, Made, Making, ORIGIN};
use zwidth_store::{MOST_BYTES, StoreError, StudyData, read_regular};

/// What its files are called.
const STEM: &str = "captions";

/// The job that gathers the captions of these figures.
pub(crate) fn job(data: &StudyData, figures: &[Drawing]) -> Job {
    let names: Vec<String> = figures.iter().map(|figure| figure.caption.stem()).collect();
    let files: Vec<PathBuf> = figures.iter().map(Drawing::words).collect();
    let folder = data.layout.reports().join("figures");
    let outputs = CAPTION_FORMATS.map(|f| folder.join(format!("{STEM}.{}", f.extension())));
    // Tolerant: a figure that fails should cost the document one caption, not all.
    Job::new(STAGE, STEM, names, files, outputs.to_vec(), make).tolerant()
}

/// A figure that could not be made has no caption.
fn make(names: &Vec<String>, files: &Vec<PathBuf>, making: &Making) -> Result<Made, JobError> {
    let mut captions = Vec::new();
    for (name, file) in names.iter().zip(files).filter(|(_, file)| file.exists()) {
        let bytes = read_regular(file, MOST_BYTES).map_err(|e| StoreError::io(file, "read", &e))?;
        captions.push(NamedCaption::of(name, &String::from_utf8(bytes)?));
    }
    let origin = making.from.get(ORIGIN);
    let texts = CAPTION_FORMATS.map(|format| {
        let comment = origin.and_then(|origin| format.comment(origin)).unwrap_or_default();
        (captions_text(format, &captions) + &comment).into_bytes()
    });
    Ok(Made::of(texts.to_vec()))
}
