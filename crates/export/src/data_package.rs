//! `datapackage.json`: a Data Package (version 2.0, datapackage.org) around the tables, with types, units,
//! keys and checksums.

use crate::contents::{Contents, Described};
use crate::folder::Folder;
use crate::{Asked, samples};
use serde_json::{Map, Value, json};
use std::collections::BTreeSet;
use zwidth_results::Values;

/// A table that is described, and its columns.
pub(crate) struct Resource {
    pub(crate) name: String,
    pub(crate) title: String,
    pub(crate) path: String,
    pub(crate) columns: Vec<Described>,
}

const KEY: [&str; 3] = ["participant", "session", "trial"];

/// The package of these tables.
pub(crate) fn data_package(
    contents: &Contents,
    asked: &Asked,
    resources: &[Resource],
    folder: &Folder,
) -> Value {
    let resources: Vec<Value> =
        resources.iter().map(|resource| described(resource, contents, folder)).collect();
    let mut package = json!({
        "$schema": "https://datapackage.org/profiles/2.0/datapackage.json",
        "name": contents.study.to_lowercase(),
        "title": format!("{}{}", contents.title, contents.mark()),
        "description": format!("Trials of a force-feedback study that count. Source of the numbers: {}.", contents.source),
        "version": asked.date,
        "resources": resources,
    });
    if let (Some(licence), Some(package)) = (&asked.licence, package.as_object_mut()) {
        package.insert(
            "licenses".to_owned(),
            json!([{ "name": licence, "path": format!("https://spdx.org/licenses/{licence}.html") }]),
        );
    }
    package
}

fn described(resource: &Resource, contents: &Contents, folder: &Folder) -> Value {
    let Resource { name, title, path, columns } = resource;
    let has = |wanted: &str| columns.iter().any(|column| column.name == wanted);
    let is_parquet = path == samples::PARQUET;
    let fields = columns.iter().map(|column| {
        let mut field = field(name, column, contents);
        // pandas, by which frictionless reads Parquet, has no whole numbers where some are missing.
        let is_always = ["trial", "repeat"].contains(&column.name.as_str());
        if is_parquet && column.kind == "integer" && !is_always {
            field["type"] = json!("number");
        }
        field
    });
    let fields: Vec<Value> = fields.collect();
    let mut schema = json!({ "fields": fields, "missingValues": [""] });
    let of_trial = KEY.into_iter().all(has);
    let mut links = Vec::new();
    if name == "trials" {
        schema["primaryKey"] = json!(KEY);
    } else if of_trial {
        links.push(json!({
            "fields": KEY, "reference": { "resource": "trials", "fields": KEY }
        }));
    }
    if name == "participants" {
        schema["primaryKey"] = json!(["participant"]);
    } else if has("participant") {
        links.push(json!({
            "fields": ["participant"], "reference": { "resource": "participants", "fields": ["participant"] }
        }));
    }
    if !links.is_empty() {
        schema["foreignKeys"] = json!(links);
    }
    let mut about = Map::from_iter([
        ("name".to_owned(), json!(name.replace('_', "-"))),
        ("title".to_owned(), json!(title)),
        ("path".to_owned(), json!(path)),
        ("type".to_owned(), json!("table")),
        ("format".to_owned(), json!(if is_parquet { "parquet" } else { "csv" })),
        (
            "mediatype".to_owned(),
            json!(if is_parquet { "application/vnd.apache.parquet" } else { "text/csv" }),
        ),
        ("encoding".to_owned(), json!("utf-8")),
        ("schema".to_owned(), schema),
    ]);
    // frictionless 5.21.0 cannot count the bytes of a Parquet file; RO-Crate and SHA256SUMS have them.
    if !is_parquet && let Value::Object(sealed) = folder.sealed(path) {
        about.extend(sealed);
    }
    about.into()
}

fn field(table: &str, column: &Described, contents: &Contents) -> Value {
    let Described { name, kind, unit, about } = column;
    let mut field = json!({ "name": name, "type": kind, "description": about });
    // A pure number, a word, or a number in the unit of its row.
    if !unit.is_empty() && unit != "1" {
        field["unit"] = json!(unit);
    }
    if *kind == "boolean" {
        field["trueValues"] = json!(["true"]);
        field["falseValues"] = json!(["false"]);
    }
    let is_named = ["environment", "mode", "source"].contains(&name.as_str());
    if is_named && let Some(words) = words(table, name, contents) {
        field["constraints"] = json!({ "enum": words });
    }
    field
}

/// The words that a column has.
fn words(table: &str, column: &str, contents: &Contents) -> Option<BTreeSet<String>> {
    let table = contents.tables.iter().find(|own| own.table.name() == table)?;
    match &table.table.column(column).ok()?.values {
        Values::Text(texts) => {
            let words: BTreeSet<String> =
                texts.iter().flatten().map(|text| text.to_string()).collect();
            (!words.is_empty()).then_some(words)
        }
        _ => None,
    }
}
