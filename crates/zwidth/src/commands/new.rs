//! `zwidth new`: a commented study.toml.

use crate::exit::Exit;
use crate::screen::Screen;
use anyhow::bail;
use std::path::Path;
use zwidth_store::{Layout, Raw, RealFiles, check_study_id, write_new};
use zwidth_study::{StudyId, template, template_of_imports};

pub(crate) fn new(
    root: &Path,
    study: StudyId,
    imported: bool,
    screen: &Screen,
) -> anyhow::Result<Exit> {
    let layout = Layout::new(root, study.clone());
    let path = layout.study_toml();
    if path.exists() {
        bail!(
            "the study '{study}' is there already; edit {}, or choose another id",
            path.display()
        );
    }
    let text = if imported { template_of_imports(&study) } else { template(&study) };
    check_study_id(&RealFiles, &layout)?;
    write_new(&Raw::new_study(&RealFiles, &layout), &path, text.as_bytes())?;
    screen.result(format!("{}", path.display()));
    screen.say(format!("Edit it, then check it with `zwidth verify {study}`."));
    Ok(Exit::Fine)
}
