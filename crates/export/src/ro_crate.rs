//! `ro-crate-metadata.json`: an RO-Crate (version 1.2, w3id.org/ro/crate/1.2) of all files, made by an
//! action of zwidth.

use crate::contents::Contents;
use crate::folder::Written;
use crate::{Asked, ExportError};
use serde_json::{Value, json};

/// The crate of these files.
pub(crate) fn ro_crate(contents: &Contents, asked: &Asked, files: &[Written]) -> Value {
    let parts: Vec<Value> = files.iter().map(|file| json!({ "@id": file.path })).collect();
    let licence = match &asked.licence {
        Some(licence) => format!("https://spdx.org/licenses/{licence}"),
        None => "LICENCE".to_owned(),
    };
    let mut graph = vec![
        json!({
            "@id": "ro-crate-metadata.json",
            "@type": "CreativeWork",
            "conformsTo": { "@id": "https://w3id.org/ro/crate/1.2" },
            "about": { "@id": "./" },
        }),
        json!({
            "@id": "./",
            "@type": "Dataset",
            "name": format!("{}{}", contents.title, contents.mark()),
            "description": format!("Trials of a force-feedback study that count: samples, metrics, answers, comparisons. Source of \
                                    the numbers: {}.", contents.source),
            "datePublished": asked.date,
            "license": { "@id": licence },
            "hasPart": parts,
            "mentions": { "@id": "#export" },
        }),
        json!({
            "@id": "#export",
            "@type": "CreateAction",
            "name": format!("zwidth export {}", contents.study),
            "endTime": asked.date,
            "instrument": { "@id": "#zwidth" },
            "result": { "@id": "./" },
        }),
        json!({
            "@id": "#zwidth",
            // A SoftwareApplication must have a page of its own, and source code must be a file of the crate.
            "@type": "CreativeWork",
            "additionalType": "https://schema.org/SoftwareApplication",
            "name": "zwidth",
            "description": "force-feedback studies from raw recordings to figures and tables",
            "version": asked.software,
        }),
    ];
    if let Some(licence) = &asked.licence {
        graph.push(json!({
            "@id": format!("https://spdx.org/licenses/{licence}"),
            "@type": "CreativeWork",
            "name": licence,
        }));
    }
    graph.extend(files.iter().map(file));
    json!({ "@context": "https://w3id.org/ro/crate/1.2/context", "@graph": graph })
}

fn file(file: &Written) -> Value {
    let extension = file.path.rsplit_once('.').map_or("", |(_, extension)| extension);
    let kind = match extension {
        "csv" => "text/csv",
        "tsv" => "text/tab-separated-values",
        "md" => "text/markdown",
        "json" => "application/json",
        "toml" => "application/toml",
        "parquet" => "application/vnd.apache.parquet",
        "xlsx" => "application/vnd.openxmlformats-officedocument.spreadsheetml.sheet",
        "mat" => "application/x-matlab-data",
        "cff" => "application/yaml",
        "mcap" => "application/octet-stream",
        _ => "text/plain",
    };
    json!({
        "@id": file.path,
        "@type": "File",
        "name": file.path,
        "description": file.about,
        "encodingFormat": kind,
        "contentSize": file.bytes.to_string(),
        "sha256": file.sha256,
    })
}

/// Checks that an id can be that of a licence.
///
/// # Errors
/// One that cannot.
pub(crate) fn check_licence(licence: &str) -> Result<(), ExportError> {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "-.+".contains(c);
    if !licence.is_empty() && licence.chars().all(is_plain) {
        return Ok(());
    }
    Err(ExportError::Refused(format!(
        "{licence:?} is not the SPDX id of a licence: it has letters, digits, '-', '.' and '+', as CC-BY-4.0"
    )))
}
