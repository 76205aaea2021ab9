//! A figure as a job of the stage `figures`: SVG, PDF and PNG, with its data beside it.

use serde::Serialize;
use std::path::PathBuf;
use zwidth_draw::{DEFAULT_DPI, Figure, draw};
use zwidth_figures::{Caption, FigureKind};
use zwidth_runner::{Inputs, Job, JobError, Made, Making, Stage};
use zwidth_store::{Layout, StudyData};

pub(crate) const STAGE: Stage = Stage { name: "figures", version: zwidth_figures::VERSION };

/// A figure of the plan.
pub(crate) struct Drawing {
    pub(crate) caption: Caption,
    pub(crate) job: Job,
}

impl Drawing {
    /// The figure of a kind, of a subject.
    pub(crate) fn new<P, I>(
        data: &StudyData,
        kind: FigureKind,
        subject: impl IntoIterator<Item = impl Into<String>>,
        parameters: P,
        inputs: I,
        make: fn(&P, &I, &Making) -> Result<Made, JobError>,
    ) -> Self
    where
        P: Serialize + Send + Sync + 'static,
        I: Inputs,
    {
        let caption = Caption::new(kind, subject);
        let stem = caption.stem();
        let outputs = files_of(&data.layout, &stem);
        let job = Job::new(STAGE, format!("figure {stem}"), parameters, inputs, outputs, make);
        Self { caption, job }
    }

    /// The same, drawn from so many trials, sweeps or answers.
    pub(crate) fn of(mut self, n: usize) -> Self {
        self.caption.n = Some(n);
        self
    }

    /// Its PNG.
    pub(crate) fn picture(&self) -> PathBuf {
        self.job.outputs[2].clone()
    }
}

/// Files of a figure: SVG, PDF, PNG, and its data.
fn files_of(layout: &Layout, stem: &str) -> Vec<PathBuf> {
    let folder = layout.reports().join("figures");
    ["svg", "pdf", "png", "parquet"].iter().map(|e| folder.join(format!("{stem}.{e}"))).collect()
}

/// A figure in every form, with its data.
pub(crate) fn write_figure(
    figure: Figure,
    problems: Vec<String>,
    making: &Making,
) -> Result<Made, JobError> {
    let [svg_file, _, _, data_file] = making.outputs else {
        return Err("a figure has four files".into());
    };
    let stem = svg_file.file_stem().unwrap_or_default().to_string_lossy();
    let table = zwidth_figures::data_table(&stem, &figure)?;
    let provenance = Some(serde_json::to_string(making.from)?);
    let drawing = draw(&Figure { provenance, ..figure })?;
    let others = || -> Result<_, JobError> {
        let table = table.to_parquet(making.from, data_file)?;
        Ok((drawing.svg()?.into_bytes(), drawing.pdf()?, table))
    };
    let (image, others) = rayon::join(|| drawing.png(DEFAULT_DPI), others);
    let (svg, pdf, table) = others?;
    Ok(Made { outputs: vec![svg, pdf, image?, table], problems, ..Made::default() })
}
