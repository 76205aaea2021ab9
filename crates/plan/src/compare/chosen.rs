//! Whether a metric that another program computed was chosen before the data. Its rule can be written when the data are
//! known, so it makes claims only if each session began with a study.toml that names it as primary.

use zwidth_store::StudyData;
use zwidth_study::{OutsideMetric, Study};

/// What is to be said of a metric from outside that was chosen after the data, or became primary after them; `None` for
/// any other metric.
pub(crate) fn chosen_after(data: &StudyData, metric: &str) -> Option<String> {
    let outside = OutsideMetric::is_named(metric) && data.study.outside_metric(metric).is_some();
    let is_primary = |study: &Study| study.compare.primary.has(metric);
    let is_named = |study: &Study| {
        let others = study.compare.metrics.iter().flatten();
        is_primary(study) || others.into_iter().any(|own| own.as_str() == metric)
    };
    // Without a copy of study.toml nobody knows what a session began with.
    let lacking = |has: &dyn Fn(&Study) -> bool| {
        data.sessions.iter().find(|log| !log.study.as_deref().is_some_and(has))
    };
    let copy_of = |log: &zwidth_store::SessionLog| {
        format!("the study.toml of session {} of {}", log.record.session, log.record.participant)
    };
    if !outside {
        return None;
    }
    if let Some(log) = lacking(&is_named) {
        return Some(format!("Chosen after the data: {} does not name it.", copy_of(log)));
    }
    let log = lacking(&is_primary).filter(|_| is_primary(&data.study))?;
    Some(format!("Made primary after the data: {} does not name it as primary.", copy_of(log)))
}
