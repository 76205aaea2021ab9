//! `zwidth simulate --as`: a scene as other programs read it.

use super::super::output::write_text;
use super::scene_file::{SceneFile, stem};
use crate::exit::Exit;
use crate::screen::Screen;
use anyhow::bail;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use serde::Serialize;
use std::path::{Path, PathBuf};
use zwidth_simulate::{OtherFormat, write_as};

/// What is asked for of every scene.
pub(super) struct Request<'a> {
    pub(super) format: OtherFormat,
    /// In place of the scene's own, s.
    pub(super) step_s: Option<f64>,
    /// The file of the model, in place of one below `reports/simulate`.
    pub(super) out: Option<&'a Path>,
}

/// What `--json` prints.
#[derive(Serialize)]
struct Written {
    scene: PathBuf,
    files: Vec<PathBuf>,
    /// What the format cannot say of the scene; empty where nothing was written.
    remarks: Vec<String>,
    error: Option<String>,
}

pub(super) fn format() -> impl TypedValueParser<Value = OtherFormat> {
    PossibleValuesParser::new(OtherFormat::ALL.map(OtherFormat::as_str))
        .try_map(|word| OtherFormat::from_word(&word).ok_or("no such format"))
}

/// Writes each scene; one that cannot be written is told and left out.
pub(super) fn write(
    root: &Path,
    scenes: &[PathBuf],
    request: &Request,
    screen: &Screen,
) -> anyhow::Result<Exit> {
    if request.out.is_some() && scenes.len() > 1 {
        bail!(
            "--out names one file, but there are several scenes; write them one at a time, or without --out"
        );
    }
    let mut written = Vec::new();
    for scene in scenes {
        let result = one(root, scene, request);
        written.push(result.unwrap_or_else(|error| Written {
            scene: scene.clone(),
            files: Vec::new(),
            remarks: Vec::new(),
            error: Some(format!("{error:#}")),
        }));
    }
    if written.iter().all(|scene| scene.error.is_some()) {
        let errors = written.into_iter().filter_map(|scene| scene.error);
        return Err(super::super::as_lines(errors.collect(), 0));
    }
    let exit =
        if written.iter().any(|scene| scene.error.is_some()) { Exit::Partly } else { Exit::Fine };
    screen.give(&written, || {
        for scene in &written {
            if let Some(error) = &scene.error {
                screen.warn(format!("skipped: {error}"));
                continue;
            }
            for file in &scene.files {
                screen.result(file.display().to_string());
            }
            for remark in &scene.remarks {
                screen.result(format!("  * {remark}"));
            }
        }
    })?;
    Ok(exit)
}

fn one(root: &Path, path: &Path, request: &Request) -> anyhow::Result<Written> {
    let mut file = SceneFile::read(path)?;
    if let Some(step_s) = request.step_s {
        file.scene.step_s = step_s;
    }
    let other = write_as(file.scene.clone(), request.format).map_err(|e| file.error(&e))?;
    let mut files = Vec::new();
    for (i, text) in other.files.iter().enumerate() {
        let default = || {
            let name = format!("{}.{}", stem(path), text.ending);
            root.join("reports").join("simulate").join(name)
        };
        let to = request.out.map_or_else(default, |out| match i {
            0 => out.to_owned(),
            // What goes with a model lies beside it under its name.
            _ => out.with_extension(Path::new(text.ending).extension().unwrap_or_default()),
        });
        if to == path || files.contains(&to) {
            bail!("{} would be written over; give --out another name", to.display());
        }
        files.push(to);
    }
    for (to, text) in files.iter().zip(&other.files) {
        write_text(to, &text.text)?;
    }
    Ok(Written { scene: path.to_owned(), files, remarks: other.remarks, error: None })
}
