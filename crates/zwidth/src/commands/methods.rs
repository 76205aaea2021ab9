//! `zwidth methods`: what was done, in words.

use crate::exit::Exit;
use crate::screen::Screen;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use std::path::Path;
use zwidth_plan as plan;
use zwidth_report::{MethodsForm, methods as parts};
use zwidth_study::StudyId;

#[derive(Debug, clap::Args)]
pub(crate) struct MethodsArgs {
    /// The study
    pub(crate) study: StudyId,
    /// The form in which to print them: Markdown, LaTeX or Typst
    #[arg(long, default_value = MethodsForm::ALL[0].0, value_parser = methods_forms())]
    pub(crate) format: MethodsForm,
}

/// The forms of the methods, by the extensions of their files.
fn methods_forms() -> impl TypedValueParser<Value = MethodsForm> {
    PossibleValuesParser::new(MethodsForm::ALL.map(|(word, _)| word)).try_map(|word| {
        let form = MethodsForm::ALL.into_iter().find(|(name, _)| *name == word);
        form.map(|(_, form)| form).ok_or_else(|| format!("'{word}' is not a format"))
    })
}

pub(crate) fn methods(root: &Path, command: &MethodsArgs, screen: &Screen) -> anyhow::Result<Exit> {
    let data = super::load(root, &command.study)?;
    let parts = parts(&data.study, &plan::recorded(&data), env!("CARGO_PKG_VERSION"));
    screen.file(&command.format.written(&parts));
    Ok(Exit::Fine)
}
