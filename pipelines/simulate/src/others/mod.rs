//! The scene as other programs read it: a model file, or a short program.
//!
//! A format is a file here and an entry in [`OtherFormat`] and `writer`. It is made of templates
//! ([`template`]), whose lines ask for parts of the scene ([`parts`]); its remarks are a template
//! too, so that a file says what its format cannot say only where the scene has it.

mod drake;
mod equations;
mod expressions;
mod modelica;
mod mujoco;
mod parts;
mod python;
mod sdf;
mod signals;
mod template;
#[cfg(test)]
mod tests;
mod urdf;
mod writer;

use parts::Parts;
use template::{filled, holds_all};
use writer::{Comment, Writer};
use zwidth_dynamics::{ModelScene, System};
use zwidth_study::worded;

use crate::SimulateError;

worded! {
    /// What a scene can be written as.
    OtherFormat {
        /// MJCF, the model file of MuJoCo, and a program that pushes the lever.
        Mujoco = "mujoco",
        /// A program for Drake.
        Drake = "drake",
        /// The lever as a robot, for whatever reads URDF.
        Urdf = "urdf",
        /// The lever as a world of SDFormat.
        Sdf = "sdf",
        /// A model in Modelica.
        Modelica = "modelica",
        /// A program for SciPy.
        Python = "python",
    }
}

/// A file of a scene in another format.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct OtherFile {
    /// What its name ends with, behind the scene's: `mujoco.xml`.
    pub ending: &'static str,
    /// The text.
    pub text: String,
}

/// A scene in another format.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct OtherScene {
    /// The model first, then what goes with it.
    pub files: Vec<OtherFile>,
    /// What the format cannot say of this scene, and how to read it; these stand in the files too.
    pub remarks: Vec<String>,
}

fn writer(format: OtherFormat) -> &'static Writer {
    match format {
        OtherFormat::Mujoco => &mujoco::WRITER,
        OtherFormat::Drake => &drake::WRITER,
        OtherFormat::Urdf => &urdf::WRITER,
        OtherFormat::Sdf => &sdf::WRITER,
        OtherFormat::Modelica => &modelica::WRITER,
        OtherFormat::Python => &python::WRITER,
    }
}

/// A scene in another format: SI units and radians; θ = 0 is upright, above 0 into the object.
///
/// # Errors
/// A scene that makes no sense, or that the format has no way to say.
pub fn write_as(scene: ModelScene, format: OtherFormat) -> Result<OtherScene, SimulateError> {
    let system = System::new(scene)?;
    let mut parts = parts_of(&system)?;
    let writer = writer(format);
    let lacks = writer.refused.iter().find(|(asked, _)| holds_all(asked, &parts));
    if let Some((_, why)) = lacks {
        return Err(SimulateError::NotSaid { format: format.as_str(), why });
    }
    let remarks: Vec<String> = filled(writer.remarks, &parts).lines().map(str::to_owned).collect();
    let files = writer.files.iter().map(|form| {
        parts.text("head", head(&parts, &remarks, form.comment));
        let asked = form.templates.iter().filter(|(asked, _)| holds_all(asked, &parts));
        let text = asked.map(|(_, template)| filled(template, &parts)).collect();
        OtherFile { ending: form.ending, text }
    });
    Ok(OtherScene { files: files.collect(), remarks })
}

/// Everything that templates may ask for.
fn parts_of(system: &System) -> Result<Parts, SimulateError> {
    let mut parts = Parts::of(system)?;
    expressions::add(&mut parts, system);
    Ok(parts)
}

/// What a file begins with: where it comes from, and its remarks.
fn head(parts: &Parts, remarks: &[String], comment: Comment) -> String {
    /// Longest line of a comment, characters.
    const WIDTH: usize = 110;
    let scene = parts.value("scene").unwrap_or_default();
    let version = parts.value("version").unwrap_or_default();
    let origin = format!("{scene}. A model, nothing measured; written by zwidth {version}.");
    let mut lines = wrapped(&origin, WIDTH, "", "");
    for remark in remarks {
        lines.extend(wrapped(remark, WIDTH, "* ", "  "));
    }
    match comment {
        Comment::Hash => prefixed(&lines, "# "),
        Comment::Slashes => prefixed(&lines, "// "),
        Comment::Xml => format!("<!--\n{}\n-->", prefixed(&lines, "  ")),
    }
}

fn prefixed(lines: &[String], prefix: &str) -> String {
    lines.iter().map(|line| format!("{prefix}{line}")).collect::<Vec<_>>().join("\n")
}

/// A text in lines of at most so many characters, broken between words.
fn wrapped(text: &str, width: usize, first: &str, further: &str) -> Vec<String> {
    let mut lines = vec![first.to_owned()];
    let mut is_empty = true;
    for word in text.split_whitespace() {
        let line = lines.last().map_or(0, |line| line.chars().count());
        if !is_empty && line + 1 + word.chars().count() > width {
            lines.push(further.to_owned());
            is_empty = true;
        }
        if let Some(line) = lines.last_mut() {
            if !is_empty {
                line.push(' ');
            }
            line.push_str(word);
            is_empty = false;
        }
    }
    lines
}
