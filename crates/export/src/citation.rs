//! `CITATION.cff` (version 1.2.0, citation-file-format.github.io) and `LICENCE`.

use crate::Asked;
use crate::contents::Contents;
use serde_json::json;

/// How the data are cited. Texts are in quotes of JSON, which YAML has too.
pub(crate) fn citation(contents: &Contents, asked: &Asked) -> String {
    let licence = asked.licence.as_ref().map(|id| format!("license: {id}\n")).unwrap_or_default();
    format!(
        "cff-version: 1.2.0\nmessage: If you use these data, please cite them.\ntype: dataset\ntitle: {}\nauthors:\n\
         \x20 - name: TODO\ndate-released: {}\n{licence}",
        json!(format!("{}{}", contents.title, contents.mark())),
        asked.date
    )
}

/// Under which licence they stand.
pub(crate) fn licence(asked: &Asked) -> String {
    match &asked.licence {
        Some(id) => format!("SPDX-License-Identifier: {id}\n\nhttps://spdx.org/licenses/{id}.html\n"),
        None => "TODO: choose a licence, such as CC-BY-4.0, and give the command again with --licence CC-BY-4.0.\n\
                 Without a licence nobody may use these data.\n"
            .to_owned(),
    }
}
