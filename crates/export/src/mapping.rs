//! The mapping files by which `zwidth import` reads the samples back, to the last bit.

use crate::contents::Contents;
use crate::mat;
use crate::{ExportError, Format};

/// A mapping for the table of samples, Parquet or CSV.
pub(crate) const TABLE: &str = "import/samples.toml";
/// A mapping for the MAT files of trials.
pub(crate) const MAT: &str = "import/mat.toml";
/// The same for MCAP.
pub(crate) const MCAP: &str = "import/mcap.toml";

/// What a mapping begins with.
fn head(contents: &Contents, files: &str) -> String {
    let study = &contents.study;
    let simulated = if contents.is_simulated {
        "# All of them are marked as simulated, because some of them are.\nsimulated = true\n"
    } else {
        ""
    };
    format!(
        "# How `zwidth import` reads these samples back: beside an empty raw/{study} put study.toml there, and\n\
         #     zwidth import {study} --map THIS FILE {files}\n\
         # Columns that only some trials have are left out.\nkind = \"trials\"\n{simulated}\n"
    )
}

/// The columns, each under the name that it has in the file.
///
/// # Errors
/// Those of `name`.
fn columns(
    contents: &Contents,
    name: impl Fn(&str) -> Result<String, ExportError>,
) -> Result<String, ExportError> {
    let mut text = "[time]\nfrom = \"t_s\"\nunit = \"s\"\n".to_owned();
    let own = contents.in_all.iter().map(|signal| signal.column());
    for column in own.filter(|column| column.name != "t_s") {
        let from = name(column.name)?;
        text += &format!(
            "\n[[column]]\nto = \"{}\"\nfrom = \"{from}\"\nunit = \"{}\"\n",
            column.name, column.unit
        );
    }
    for channel in &contents.channels {
        let from = name(channel.id.as_str())?;
        let unit = toml::Value::String(channel.unit.clone());
        text += &format!(
            "\n[[channel]]\nto = \"{}\"\nfrom = \"{from}\"\nunit = {unit}\n",
            channel.id.as_str()
        );
    }
    Ok(text)
}

/// The mappings: path, and text. Presentations of tasks cannot be imported with their samples.
///
/// # Errors
/// Those of names in MAT files.
pub(crate) fn mappings(
    contents: &Contents,
    formats: &std::collections::BTreeSet<Format>,
) -> Result<Vec<(&'static str, String)>, ExportError> {
    if contents.tasks || contents.trials.is_empty() {
        return Ok(Vec::new());
    }
    let labels = ["participant", "session", "trial", "repeat", "environment", "mode"];
    let by_column = labels.map(|label| format!("{label} = {{ column = \"{label}\" }}\n")).concat();
    let table = head(contents, "samples.parquet")
        + &format!("[trial]\n{by_column}\n")
        + &columns(contents, |name| Ok(name.to_owned()))?;
    let mut all = vec![(TABLE, table)];
    let by_name = labels.map(|label| format!("{label} = {{ name = \"{label}\" }}\n")).concat();
    let by_trial = |folder: &str, name: &dyn Fn(&str) -> Result<String, ExportError>| {
        let id = "[A-Za-z0-9_-]+";
        let pattern = format!(
            "participant=(?<participant>{id})/session=(?<session>{id})/trial-(?<trial>\\d+)_environment=(?<environment>{id})_\
             mode=(?<mode>{id})_repeat=(?<repeat>\\d+)\\.{folder}$"
        );
        let files = format!("{folder}/*/*/*.{folder}");
        let named = format!("[name]\npattern = '{pattern}'\n\n[trial]\n{by_name}\n");
        Ok::<_, ExportError>(head(contents, &files) + &named + &columns(contents, name)?)
    };
    if formats.contains(&Format::Mat) {
        all.push((MAT, by_trial("mat", &mat::name)?));
    }
    if formats.contains(&Format::Mcap) {
        all.push((MCAP, by_trial("mcap", &|name| Ok(name.to_owned()))?));
    }
    Ok(all)
}
