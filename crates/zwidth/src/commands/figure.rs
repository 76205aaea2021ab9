//! `zwidth figure`: one figure of a study again, in another size or form, in a folder of its own.

use super::consent::scripts;
use super::load;
use super::locate::REMADE;
use super::near::did_you_mean;
use super::output::Output;
use crate::exit::Exit;
use crate::limits::{positive, size};
use crate::screen::Screen;
use anyhow::{Context as _, anyhow, bail};
use clap::ValueEnum;
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use zwidth_acquire::Unsynced;
use zwidth_draw::{Figure, Font, FontFile};
use zwidth_figures::caption_text;
use zwidth_plan as plan;
use zwidth_runner::{JobEnd, ORIGIN, Options, Report, Results, origins, run as run_jobs};
use zwidth_store::{Layout, RealFiles, StudyData, findings, read_named};
use zwidth_study::StudyId;

/// The form of a figure's file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum FigureFormat {
    /// For the web and for editing
    Svg,
    /// For print
    Pdf,
    /// For screens
    Png,
}

#[derive(Debug, clap::Args)]
pub(crate) struct FigureArgs {
    /// The study
    pub(crate) study: StudyId,
    /// The figure; omit it to list the figures
    pub(crate) name: Option<String>,
    /// Its width on paper in mm, or its width and height: 85 (one column), 175x120 [default: as a
    /// run makes it]
    #[arg(long, value_name = "MM[xMM]", value_parser = size)]
    pub(crate) size: Option<(f64, Option<f64>)>,
    /// File formats, separated by commas
    #[arg(long, value_enum, value_delimiter = ',', default_value = "svg,pdf,png")]
    pub(crate) format: Vec<FigureFormat>,
    /// Without heading and small print, which stand in its caption's file; the mark of simulated
    /// data stays
    #[arg(long)]
    pub(crate) bare: bool,
    /// Words of an SVG as text, to be edited and searched, in place of outlines
    #[arg(long)]
    pub(crate) text: bool,
    /// Font of these words, such as the document's, by its name; each keeps the width that it has
    /// in the font by which the figure is laid out
    #[arg(long, value_name = "NAME", requires = "text")]
    pub(crate) font: Option<String>,
    /// Font file (.ttf, .otf) in which the figure is laid out and set, in every format; give it up
    /// to three times, for upright, italic and bold [default: that of study.toml, else Noto Sans]
    #[arg(long, value_name = "FILE")]
    pub(crate) font_file: Vec<PathBuf>,
    /// Dots per inch of a PNG
    #[arg(long, value_name = "DPI", default_value_t = zwidth_draw::DEFAULT_DPI, value_parser = positive)]
    pub(crate) dpi: f64,
    /// Folder to write to [default: reports/STUDY/remade]
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
}

#[derive(Serialize)]
struct Entry {
    name: String,
    shows: String,
}

pub(crate) fn figure(root: &Path, command: &FigureArgs, screen: &Screen) -> anyhow::Result<Exit> {
    let data = load(root, &command.study)?;
    let captions = plan::captions(&data);
    let Some(name) = &command.name else {
        let has_form =
            command.size.is_some() || command.bare || command.text || command.out.is_some();
        if has_form || !command.font_file.is_empty() {
            bail!(
                "name the figure that is to be made; `zwidth figure {}` lists them",
                command.study
            );
        }
        let entries: Vec<Entry> =
            captions.into_iter().map(|(name, shows)| Entry { name, shows }).collect();
        screen.give(&entries, || {
            entries.iter().for_each(|e| screen.result(format!("{:<44} {}", e.name, e.shows)));
        })?;
        return Ok(Exit::Fine);
    };
    if !captions.iter().any(|(stem, _)| stem == name) {
        let names = captions.iter().map(|(stem, _)| stem.as_str());
        bail!(no_figure(&command.study, name, names));
    }
    let folder = folder(&data.layout, command)?;
    let origin = make(&data, name)?;
    let (figure, problems) = plan::describe(&data, name)
        .ok_or_else(|| anyhow!(no_figure(&command.study, name, [])))?
        .map_err(|error| anyhow!("{name} cannot be drawn: {error}"))?;
    let font = match command.font_file.as_slice() {
        [] => plan::font(&data).map_err(|error| anyhow!("{error}"))?,
        files => Some(font(files)?),
    };
    let (width_mm, height_mm) = command.size.unwrap_or((figure.width_mm, figure.height_mm));
    let figure = Figure { font, width_mm, height_mm, bare: command.bare, ..figure };
    let files = write(name, figure, &folder, origin, command)?;
    problems.iter().for_each(|problem| screen.warn(format!("left out: {problem}")));
    screen.give(&files, || {
        files.iter().for_each(|file| screen.result(file.display().to_string()));
    })?;
    Ok(if problems.is_empty() { Exit::Fine } else { Exit::Partly })
}

/// What to say where a study has no figure of this name.
fn no_figure<'a>(study: &StudyId, name: &str, names: impl IntoIterator<Item = &'a str>) -> String {
    let near = did_you_mean(name, names);
    format!("{study} has no figure '{name}'{near} (`zwidth figure {study}` lists them)")
}

/// Where the files go, which may not be among recordings nor among what a run makes.
fn folder(layout: &Layout, command: &FigureArgs) -> anyhow::Result<PathBuf> {
    let Some(folder) = &command.out else { return Ok(layout.reports().join(REMADE)) };
    let own = [layout.raw(), layout.derived(), layout.reports().join("figures")];
    // By their real places, so that no link leads into them.
    let real_folder = real(folder);
    if let Some(taken) = own.iter().find(|taken| real_folder.starts_with(real(taken))) {
        bail!(
            "{} is inside {}; choose another folder with --out",
            folder.display(),
            taken.display()
        );
    }
    Ok(folder.clone())
}

/// A path without links, where it exists.
fn real(path: &Path) -> PathBuf {
    path.canonicalize().unwrap_or_else(|_| path.to_owned())
}

/// Makes the figure as a run does, with all that it needs, so that nothing stale is drawn; what its
/// file says of its origin.
fn make(data: &StudyData, name: &str) -> anyhow::Result<Option<String>> {
    let mut jobs = plan::jobs(data, &findings(&RealFiles, data));
    if !jobs.iter().any(|job| job.is_called(name)) {
        jobs.extend(plan::on_demand(data, name)); // of a session whose figures no run makes
    }
    let of_figure = jobs.iter().find(|job| job.name == format!("figure {name}"));
    let job = of_figure.ok_or_else(|| anyhow!(no_figure(data.layout.study(), name, [])))?;
    let options = Options {
        only: Some(job.name.clone()),
        scripts: scripts(&data.layout)?,
        ..Options::default()
    };
    let results = Results::new(&data.layout, &Unsynced);
    let done = run_jobs(&jobs, &results, &options, &|_: &Report| {})?;
    for report in done.reports {
        if let JobEnd::Failed(why) | JobEnd::Blocked(why) = report.verdict {
            bail!("{} could not be made: {why}", report.name);
        }
    }
    // All forms of a figure hold the same origin; the first output is its SVG.
    let svg = std::fs::read(&job.outputs[0])?;
    Ok(origins(&svg).into_iter().next())
}

/// The font of the named files.
fn font(files: &[PathBuf]) -> anyhow::Result<Font> {
    if files.len() > Font::MOST_FILES {
        bail!("--font-file: give at most one file for each of upright, italic and bold");
    }
    let mut fonts = Vec::new();
    for path in files {
        let name = path.display().to_string();
        let bytes = read_named(path, Font::MOST_BYTES)
            .with_context(|| format!("the font file {name} cannot be read"))?;
        fonts.push(FontFile { name, bytes: Arc::new(bytes) });
    }
    Ok(Font::new(&fonts)?)
}

fn write(
    name: &str,
    figure: Figure,
    folder: &Path,
    origin: Option<String>,
    command: &FigureArgs,
) -> anyhow::Result<Vec<PathBuf>> {
    let source = match &figure.mark {
        Some(mark) => mark.clone(),
        None => format!("the study {}", command.study),
    };
    let mut caption = caption_text(&figure);
    if let Some(origin) = &origin {
        caption = format!("{caption}\n{origin}\n");
    }
    let size = match figure.height_mm {
        Some(height_mm) => format!("{} x {height_mm} mm", figure.width_mm),
        None => format!("{} mm wide", figure.width_mm),
    };
    // Its own form beside the job's origin: with both the same file can be made again.
    let bare = if figure.bare { ", bare" } else { "" };
    let font = figure.font.as_ref().map(|font| format!(", set in {}", font.name()));
    let form = format!("{size}{bare}{}", font.unwrap_or_default());
    let made_from = [
        ("job", Some(format!("figure {name}"))),
        ("form", Some(form)),
        ("source", Some(source)),
        (ORIGIN, origin),
    ];
    let made_from = made_from.into_iter().filter_map(|(key, value)| Some((key, value?)));
    let mut output = Output::new(folder, made_from);
    output.text(name, "txt", &caption)?;
    let drawing = output.drawn(figure)?;
    for format in &command.format {
        let (extension, bytes) = match format {
            FigureFormat::Svg if command.text => {
                ("svg", drawing.svg_with_text(command.font.as_deref())?.into_bytes())
            }
            FigureFormat::Svg => ("svg", drawing.svg()?.into_bytes()),
            FigureFormat::Pdf => ("pdf", drawing.pdf()?),
            FigureFormat::Png => ("png", drawing.png(command.dpi)?),
        };
        output.write(name, extension, &bytes)?;
    }
    Ok(output.files)
}
