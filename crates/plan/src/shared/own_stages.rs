//! Where stages of the study's own leave what they give.

use crate::shared::conditions::trial_sources;
use crate::shared::handle::Derived;
use crate::shared::making::derived;
use std::path::PathBuf;
use zwidth_report::OwnFigure;
use zwidth_results::OutsideValue;
use zwidth_store::{Layout, StudyData};
use zwidth_study::{GivenFigure, GivenMetric, OutsideMetric, OwnStage, Source, StageId};

/// The values of a metric that a stage gives: `stages/grip.grip_peak.parquet`.
pub(crate) fn values(
    layout: &Layout,
    stage: &OwnStage,
    metric: &GivenMetric,
) -> Derived<OutsideValue> {
    Derived::at(derived(layout, format!("stages/{}.{}.parquet", stage.id, metric.id)))
}

/// The stage that gives a metric, and how study.toml names the metric.
pub(crate) fn given<'d>(
    data: &'d StudyData,
    metric: &OutsideMetric,
) -> Option<(&'d OwnStage, &'d GivenMetric)> {
    let is_of_stage = |(_, own): &&(StageId, OutsideMetric)| own.column == metric.column;
    let (id, own) = data.study.from_stages.iter().find(is_of_stage)?;
    let stage = data.study.stages.iter().find(|stage| stage.id == *id)?;
    Some((stage, stage.gives.iter().find(|given| given.id == own.id)?))
}

/// Where a figure that a stage draws is kept, and the file that says where it comes from.
pub(crate) fn figure_files(
    layout: &Layout,
    stage: &OwnStage,
    figure: &GivenFigure,
) -> [PathBuf; 2] {
    let folder = layout.reports().join("stages").join(stage.id.as_str());
    [folder.join(&figure.file), folder.join(format!("{}.json", figure.file))]
}

/// The figures of all stages, as the page shows them.
pub(crate) fn shown(data: &StudyData) -> Vec<OwnFigure> {
    let simulated = trial_sources(data).into_iter().any(Source::is_simulated);
    let of_stage = |stage: &OwnStage| {
        let made_by = stage.in_words();
        let figures = stage.figures.iter().map(|figure| OwnFigure {
            path: format!("stages/{}/{}", stage.id, figure.file),
            caption: figure.caption.clone(),
            made_by: made_by.clone(),
            simulated,
        });
        figures.collect::<Vec<_>>()
    };
    data.study.stages.iter().flat_map(of_stage).collect()
}
