//! A figure as a job of the stage `figures`: SVG, PDF and PNG, with its data and its caption beside
//! it.

use crate::figures::font;
use serde::Serialize;
use std::path::PathBuf;
use std::sync::Arc;
use zwidth_draw::{DEFAULT_DPI, Figure, draw};
use zwidth_figures::{Caption, FigureKind};
use zwidth_runner::{Inputs, Job, JobError, Made, Making, ORIGIN, Stage};
use zwidth_store::StudyData;

pub(crate) const STAGE: Stage = Stage { name: "figures", version: zwidth_figures::VERSION };

/// A figure that was described, and what had to be left out of it.
pub(crate) type Figured = Result<(Figure, Vec<String>), JobError>;

/// A figure of the plan.
pub(crate) struct Drawing {
    pub(crate) caption: Caption,
    pub(crate) job: Job,
    /// Describes it from what the job reads, without writing it.
    pub(crate) describe: Box<dyn Fn() -> Figured + Send + Sync>,
}

/// What a figure is described from besides files, and the function that does it: the parameters
/// alone are the job's key.
#[derive(Serialize)]
#[serde(transparent)]
struct Described<P, I> {
    parameters: P,
    #[serde(skip)]
    describe: fn(&P, &I) -> Figured,
}

impl Drawing {
    /// A figure of a kind and a subject.
    pub(crate) fn new<P, I>(
        data: &StudyData,
        kind: FigureKind,
        subject: impl IntoIterator<Item = impl Into<String>>,
        parameters: P,
        inputs: I,
        describe: fn(&P, &I) -> Figured,
    ) -> Self
    where
        P: Serialize + Send + Sync + 'static,
        I: Inputs,
    {
        let caption = Caption::new(kind, subject);
        let stem = caption.stem();
        let folder = data.layout.reports().join("figures");
        let outputs = EXTENSIONS.map(|e| folder.join(format!("{stem}.{e}"))).to_vec();
        let described = Arc::new(Described { parameters, describe });
        let inputs = Arc::new(inputs);
        // The font is an input of every figure: all are drawn again with another one.
        let job_inputs = (inputs.clone(), font::files(data));
        let name = format!("figure {stem}");
        // The job and the function that describes it alone have both in common.
        let job = Job::new(STAGE, name, described.clone(), job_inputs, outputs, make);
        let describe = Box::new(move || (described.describe)(&described.parameters, &inputs));
        Self { caption, job, describe }
    }

    /// The same, drawn from `n` trials, sweeps or answers.
    pub(crate) fn of(mut self, n: usize) -> Self {
        self.caption.n = Some(n);
        self
    }

    /// Its caption's file.
    pub(crate) fn words(&self) -> PathBuf {
        // Outputs stand in the order of `EXTENSIONS`.
        self.job.outputs[4].clone()
    }

    /// Its PNG.
    pub(crate) fn picture(&self) -> PathBuf {
        self.job.outputs[2].clone()
    }
}

/// Files of a figure: SVG, PDF, PNG, its data, and its caption.
const EXTENSIONS: [&str; 5] = ["svg", "pdf", "png", "parquet", "txt"];

/// A figure in every form, with its data and its caption.
fn make<P, I>(
    described: &Arc<Described<P, I>>,
    (inputs, font): &(Arc<I>, Vec<PathBuf>),
    making: &Making,
) -> Result<Made, JobError> {
    let (figure, problems) = (described.describe)(&described.parameters, inputs)?;
    let [svg_file, _, _, data_file, _] = making.outputs else {
        return Err("a figure has five files".into());
    };
    let stem = svg_file.file_stem().unwrap_or_default().to_string_lossy();
    let table = zwidth_figures::data_table(&stem, &figure)?;
    let origin = making.from.get(ORIGIN).map(|origin| format!("\n{origin}\n"));
    let caption = zwidth_figures::caption_text(&figure) + &origin.unwrap_or_default();
    let provenance = Some(serde_json::to_string(making.from)?);
    let drawing = draw(&Figure { provenance, font: font::read(font)?, ..figure })?;
    let (image, others) = rayon::join(
        || drawing.png(DEFAULT_DPI),
        || -> Result<_, JobError> {
            let table = table.to_parquet(making.from, data_file)?;
            Ok((drawing.svg()?.into_bytes(), drawing.pdf()?, table))
        },
    );
    let (svg, pdf, table) = others?;
    Ok(Made { problems, ..Made::of(vec![svg, pdf, image?, table, caption.into_bytes()]) })
}
