//! `zwidth verify`: every finding, with file, column, row and remedy.

use super::alike::once;
use super::{nameless, studies};
use crate::exit::Exit;
use crate::screen::Screen;
use serde::Serialize;
use std::path::Path;
use zwidth_store::{Layout, RealFiles, StoreError, read_study, study_notes};
use zwidth_study::StudyId;

#[derive(Serialize)]
struct Finding<'a> {
    study: &'a str,
    file: String,
    column: Option<&'a str>,
    row: Option<usize>,
    what: &'a str,
    remedy: &'a str,
}

pub(crate) fn verify(root: &Path, named: Vec<StudyId>, screen: &Screen) -> anyhow::Result<Exit> {
    let nameless = nameless(root, &named);
    let checked: Vec<(StudyId, Vec<StoreError>)> = studies(root, named)?
        .into_iter()
        .map(|l| {
            let vain = read_study(&l).map(|mut study| {
                // A log that is damaged is a finding of its own.
                let given = zwidth_store::outside_log(&l).unwrap_or_default();
                let counting = given.into_iter().filter(|table| table.why_not.is_none());
                study.from_tables = counting.map(|table| table.metric).collect();
                zwidth_plan::asked_in_vain(&study)
            });
            let vain = vain.unwrap_or_default().into_iter();
            let vain = vain.map(|what| StoreError::new(&l.study_toml(), what, "correct it there"));
            let bar = screen.bar(0).with_message(l.study().to_string());
            let findings = zwidth_store::verify_with(&l, &|all| {
                bar.set_length(all as u64);
                bar.inc(1);
            });
            bar.finish_and_clear();
            let findings = findings.into_iter().chain(vain);
            (l.study().clone(), findings.chain(zwidth_plan::plan_finding(&l)).collect())
        })
        .collect();
    if screen.json {
        let rows =
            checked.iter().flat_map(|(study, all)| all.iter().map(|f| finding(study.as_str(), f)));
        screen.listing(&rows.chain(nameless.iter().map(|f| finding("", f))).collect::<Vec<_>>())?;
    } else {
        nameless.iter().for_each(|f| screen.result(f.to_string()));
        for (study, findings) in &checked {
            let lines: Vec<String> = findings.iter().map(ToString::to_string).collect();
            once(&lines, screen.verbose).into_iter().for_each(|line| screen.result(line));
            let notes = study_notes(&RealFiles, &Layout::new(root, study.clone()));
            notes.iter().for_each(|note| screen.result(format!("{study}: note: {note}")));
            let schema = read_study(&Layout::new(root, study.clone()));
            let schema = schema
                .map_or_else(|_| String::new(), |s| format!(" (schema {})", s.schema.number()));
            screen.result(match findings.len() {
                0 => format!("{study}: no findings{schema}"),
                1 => format!("{study}: 1 finding{schema}"),
                n => format!("{study}: {n} findings{schema}"),
            });
        }
    }
    let clean = nameless.is_empty() && checked.iter().all(|(_, findings)| findings.is_empty());
    Ok(if clean { Exit::Fine } else { Exit::Failed })
}

fn finding<'a>(study: &'a str, f: &'a StoreError) -> Finding<'a> {
    Finding {
        study,
        file: f.path.display().to_string(),
        column: f.column.as_deref(),
        row: f.row,
        what: &f.what,
        remedy: &f.remedy,
    }
}
