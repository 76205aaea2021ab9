//! `zwidth export`: what counts of a study, as a folder for others.

use super::locate::records;
use super::{join_findings, study};
use crate::exit::Exit;
use crate::screen::Screen;
use crate::workbook::workbook;
use anyhow::{Context as _, bail};
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use jiff::Timestamp;
use serde::Serialize;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::time::SystemTime;
use zwidth_export::{Asked, Beside, Codes, Contents, Format, Key, Origin, Written, planned, write};
use zwidth_plan as plan;
use zwidth_runner::{Again, Job, ORIGIN, states};
use zwidth_store::{
    Layout, NewFolder, RealFiles, StudyData, findings, read_entries, read_regular, real_path,
};
use zwidth_study::{StudyId, counted};
use zwidth_tables::Table;

#[derive(Debug, clap::Args)]
pub(crate) struct ExportArgs {
    /// The study
    pub(crate) study: StudyId,
    /// The folder to make; it must not exist yet
    #[arg(long, value_name = "DIR")]
    pub(crate) to: PathBuf,
    /// Also these forms, separated by commas
    #[arg(long, value_name = "FORM,…", value_delimiter = ',', value_parser = format_parser())]
    pub(crate) with: Vec<Format>,
    /// Give participants random codes, and leave out what may say who they are
    #[arg(long)]
    pub(crate) rename: bool,
    /// The new file that keeps which code is whose, outside of DIR
    #[arg(long, value_name = "FILE", requires = "rename")]
    pub(crate) key: Option<PathBuf>,
    /// Also what the participants' file says of people
    #[arg(long)]
    pub(crate) people: bool,
    /// The licence of the data, by its SPDX id
    #[arg(long, value_name = "SPDX")]
    pub(crate) licence: Option<String>,
    /// List what would leave and what stays behind; write nothing
    #[arg(long)]
    pub(crate) dry_run: bool,
}

/// The forms by their words.
fn format_parser() -> impl TypedValueParser<Value = Format> {
    let values = Format::ALL.map(|format| PossibleValue::new(format.as_str()).help(format.about()));
    PossibleValuesParser::new(values).try_map(|word| {
        let format = Format::ALL.into_iter().find(|format| format.as_str() == word);
        format.ok_or_else(|| format!("'{word}' is not a form"))
    })
}

/// What `--json` prints.
#[derive(Serialize)]
struct Outcome {
    study: String,
    to: String,
    dry_run: bool,
    source: String,
    files: Vec<File>,
    left_out: Vec<String>,
    warnings: Vec<String>,
}

/// A file of the export; of a dry run without its size and its checksum, which are not known.
#[derive(Serialize)]
struct File {
    path: String,
    about: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    bytes: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    sha256: Option<String>,
}

pub(crate) fn export(root: &Path, command: &ExportArgs, screen: &Screen) -> anyhow::Result<Exit> {
    let layout = study(root, command.study.clone())?;
    check_places(&layout, command)?;
    for left in NewFolder::unfinished(&RealFiles, &command.to) {
        screen.warn(format!(
            "{} is what an export left that was cut short; it is not complete, and can be removed",
            left.display()
        ));
    }
    let data = StudyData::load(&layout).map_err(|findings| join_findings(&findings))?;
    check_seals(&data)?;
    let findings = findings(&RealFiles, &data);
    // What the system refused says nothing of a recording: the next time it may be there.
    if let Some(refused) = findings.left_out.iter().find(|finding| finding.by_system) {
        return Err(refused.clone().into());
    }
    let jobs = plan::jobs(&data, &findings);
    let tables = plan::exported(&layout, &jobs);
    check_fresh(&layout, &jobs, &tables, screen)?;
    let derived = tables.iter().map(read_table).collect::<anyhow::Result<Vec<_>>>()?;
    let text = String::from_utf8(read_regular(&layout.study_toml(), zwidth_store::MOST_STUDY)?)?;
    let codes = command.rename.then(|| draw_codes(&data)).transpose()?;
    let asked = Asked {
        formats: command.with.iter().copied().collect(),
        people: command.people,
        licence: command.licence.clone(),
        date: today(),
        software: concat!("zwidth ", env!("CARGO_PKG_VERSION")).to_owned(),
    };
    let contents = Contents::of(&data, &text, derived, &asked, codes.as_ref())?;
    if contents.tables.iter().all(|own| own.table.name() != "trials" || own.table.height() == 0) {
        bail!(
            "{} has no trial and no answer that counts: there is nothing to export",
            command.study
        );
    }
    let beside = sheets(&contents, &asked)?;
    let written = if command.dry_run {
        planned(&contents, &asked, &beside)?
    } else {
        let key = command.key.as_deref().zip(codes.as_ref());
        let key = key.map(|(path, codes)| Key { path, codes });
        write(&RealFiles, &command.to, key.as_ref(), &contents, &asked, &beside)?
    };
    let mut warnings: Vec<String> = findings.left_out.iter().map(ToString::to_string).collect();
    let exit = if warnings.is_empty() { Exit::Fine } else { Exit::Partly };
    warnings.extend(still_to_do(command));
    let outcome = Outcome {
        study: command.study.to_string(),
        to: command.to.display().to_string(),
        dry_run: command.dry_run,
        source: contents.source.clone(),
        files: written.into_iter().map(|file| File::of(file, command.dry_run)).collect(),
        left_out: contents.left_out.clone(),
        warnings,
    };
    outcome.warnings.iter().for_each(|warning| screen.warn(warning));
    screen.give(&outcome, || tell(&outcome, command, screen))?;
    Ok(exit)
}

impl File {
    fn of(file: Written, is_dry: bool) -> Self {
        let Written { path, about, bytes, sha256 } = file;
        Self { path, about, bytes: (!is_dry).then_some(bytes), sha256: (!is_dry).then_some(sha256) }
    }
}

/// Refuses a folder or a key that is there, or that lies where it must not.
fn check_places(layout: &Layout, command: &ExportArgs) -> anyhow::Result<()> {
    if command.rename && command.key.is_none() && !command.dry_run {
        bail!(
            "--rename gives random codes: name the file that keeps which is whose with --key FILE, outside of {}",
            command.to.display()
        );
    }
    let to = free_place(layout, &command.to, "--to")?;
    if let Some(key) = &command.key {
        if real_path(key).is_ok_and(|real| real.starts_with(&to)) {
            bail!(
                "--key {} lies in the folder that goes to others: whoever gets it could tell who is who; choose another place",
                key.display()
            );
        }
        free_place(layout, key, "--key")?;
    }
    Ok(())
}

/// Where a path leads, at which nothing is yet, in a folder that is there, and outside of the study's data.
fn free_place(layout: &Layout, path: &Path, option: &str) -> anyhow::Result<PathBuf> {
    let shown = path.display();
    // Not `exists`, which follows a link.
    if path.symlink_metadata().is_ok() {
        bail!("{option} {shown}: it exists already, and is not written over; choose another name");
    }
    if path.file_name().is_none() {
        bail!("{option} {shown}: name something new in a folder");
    }
    let real = real_path(path).with_context(|| format!("{option} {shown}"))?;
    if !real.parent().is_some_and(Path::is_dir) {
        bail!("{option} {shown}: the folder in which it is to lie does not exist; make it first");
    }
    let root = layout.root();
    let root = if root.as_os_str().is_empty() { Path::new(".") } else { root };
    for folder in ["raw", "derived", "reports"] {
        let own = real_path(&root.join(folder)).with_context(|| folder.to_owned())?;
        if real.starts_with(&own) {
            bail!(
                "{option} {shown}: it lies in {folder}/, where only recordings and results are; choose a folder elsewhere"
            );
        }
    }
    Ok(real)
}

/// Refuses a study of which a session is sealed: what leaves would lack it, and would be known to all.
fn check_seals(data: &StudyData) -> anyhow::Result<()> {
    let sealed = data.sessions.iter().find(|log| log.is_sealed());
    let Some(log) = sealed else { return Ok(()) };
    let (study, participant, session) =
        (data.layout.study(), &log.record.participant, &log.record.session);
    bail!(
        "session {session} of {participant} is sealed: nothing of a blinded study leaves before its modes may be known; \
         `zwidth unseal {study} -p {participant} -s {session}`"
    )
}

/// Refuses results that a run would make again.
fn check_fresh(
    layout: &Layout,
    jobs: &[Job],
    tables: &[plan::Exported],
    screen: &Screen,
) -> anyhow::Result<()> {
    let files: BTreeSet<&PathBuf> = tables.iter().flat_map(|table| &table.files).collect();
    let records = records(layout, screen)?;
    let is_needed = |job: &Job| job.outputs.iter().any(|output| files.contains(output));
    let states = states(jobs, layout.root(), &records, is_needed);
    let old: Vec<&str> = states
        .iter()
        .filter(|state| state.again() != Again::No)
        .map(|state| state.job.name.as_str())
        .collect();
    let Some(first) = old.first() else { return Ok(()) };
    let study = layout.study();
    bail!(
        "the results of {study} are not up to date ({}, first '{first}'): what leaves would not be what was recorded; \
         `zwidth run {study}` first",
        counted(old.len(), "jobs to make again")
    )
}

/// A derived table, whole, under the name by which it leaves.
fn read_table(exported: &plan::Exported) -> anyhow::Result<Origin> {
    let parts: Result<Vec<Table>, _> =
        exported.files.iter().map(|file| Table::from_parquet(file)).collect();
    let title =
        parts.as_ref().ok().and_then(|parts| parts.first()).map(|table| table.title().to_owned());
    let table = Table::concat(exported.name, &title.unwrap_or_default(), parts?)?;
    let table = table.with_context(|| format!("the table {} has no file", exported.name))?;
    let origin = match exported.files.as_slice() {
        [file] => read_entries(file)?.0.remove(ORIGIN),
        _ => None,
    };
    Ok(Origin { table, origin })
}

fn draw_codes(data: &StudyData) -> anyhow::Result<Codes> {
    let with_samples = data.counting().map(|entry| &entry.meta.participant);
    let answered = data.answers.iter().map(|answer| &answer.participant);
    let known = data.people.iter().map(|(person, _)| person);
    let all = with_samples.chain(answered).chain(known).cloned();
    Codes::draw(all, || {
        getrandom::u32()
            .map_err(|error| anyhow::anyhow!("the system gives no random numbers: {error}"))
    })
}

/// The day, in UTC.
fn today() -> String {
    let now = Timestamp::try_from(SystemTime::now()).unwrap_or(Timestamp::MAX);
    now.strftime("%Y-%m-%d").to_string()
}

/// The workbook of the tables, if it is asked for.
fn sheets(contents: &Contents, asked: &Asked) -> anyhow::Result<Vec<Beside>> {
    if !asked.formats.contains(&Format::Xlsx) {
        return Ok(Vec::new());
    }
    let tables = contents.tables.iter();
    let tables: Vec<Table> =
        tables.map(|own| own.table.clone().with_mark(contents.is_simulated)).collect();
    let bytes = workbook(&tables)
        .context("cannot make tables.xlsx; leave xlsx out of --with where a table has more rows than a sheet can")?;
    let (path, about) = ("tables.xlsx".to_owned(), "the tables as a workbook".to_owned());
    Ok(vec![Beside { path, about, bytes }])
}

/// What people have to fill in before others get the data.
fn still_to_do(command: &ExportArgs) -> Vec<String> {
    let mut lines = Vec::new();
    if command.licence.is_none() {
        lines.push(
            "no licence: nobody may use the data; name one, as --licence CC-BY-4.0".to_owned(),
        );
    }
    lines.push("CITATION.cff has the author TODO: write who made the data".to_owned());
    lines
}

fn tell(outcome: &Outcome, command: &ExportArgs, screen: &Screen) {
    if command.dry_run {
        let names: Vec<&str> = outcome.files.iter().map(|file| file.path.as_str()).collect();
        screen.result(format!("would leave, as {}:", outcome.to));
        names.iter().for_each(|name| screen.result(format!("  {name}")));
        screen.result("would stay behind:");
        outcome.left_out.iter().for_each(|line| screen.result(format!("  {line}")));
        return;
    }
    let bytes: u64 = outcome.files.iter().filter_map(|file| file.bytes).sum();
    screen.result(format!(
        "{}: {}, {:.1} MB, source {}; look first at {}",
        outcome.to,
        counted(outcome.files.len(), "files"),
        bytes as f64 / 1e6,
        outcome.source,
        command.to.join("README.md").display()
    ));
    if let Some(key) = &command.key {
        screen.result(format!(
            "{}: which code is whose; keep it, and give it to nobody who has the data",
            key.display()
        ));
    }
}
