//! `zwidth table`: a derived table, in any form.

use crate::args::Table as Asked;
use crate::exit::Exit;
use crate::plan;
use crate::screen::Screen;
use anyhow::bail;
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::Path;
use zwidth_store::StudyData;
use zwidth_tables::Table;

#[derive(Serialize)]
struct Entry {
    name: String,
    title: String,
    rows: usize,
}

pub(crate) fn table(root: &Path, asked: &Asked, screen: &Screen) -> anyhow::Result<Exit> {
    let layout = super::study(root, asked.study.clone())?;
    let data = StudyData::load(&layout).map_err(|findings| super::together(&findings))?;
    let files: Vec<_> = plan::printed_tables(&data).into_iter().filter(|f| f.exists()).collect();
    if files.is_empty() {
        bail!("{} has no tables yet; make them with `zwidth run {}`", asked.study, asked.study);
    }
    let tables = files.iter().map(|f| Table::from_parquet(f)).collect::<Result<Vec<_>, _>>()?;
    let Some(name) = &asked.name else {
        return list(&tables, screen);
    };
    let Some((file, table)) = files.iter().zip(&tables).find(|(_, t)| t.name() == name) else {
        let names: Vec<_> = tables.iter().map(Table::name).collect();
        bail!("{} has no table '{name}'; it has {}", asked.study, names.join(", "));
    };
    let wanted = [(asked.format.into(), file.as_path())];
    for bytes in table.to_bytes(&wanted, data.study.coordinate, &BTreeMap::new())? {
        screen.file(&String::from_utf8(bytes)?);
    }
    Ok(Exit::Fine)
}

fn list(tables: &[Table], screen: &Screen) -> anyhow::Result<Exit> {
    let entry =
        |t: &Table| Entry { name: t.name().to_owned(), title: t.title().to_owned(), rows: t.height() };
    if screen.json {
        screen.listing(&tables.iter().map(entry).collect::<Vec<_>>())?;
    } else {
        tables
            .iter()
            .for_each(|t| screen.result(format!("{:<28} {} ({} rows)", t.name(), t.title(), t.height())));
    }
    Ok(Exit::Fine)
}
