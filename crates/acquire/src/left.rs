//! What remains to be done in a session that has begun.

use crate::flow::Flow;
use crate::session::recorded;
use zwidth_store::{SessionLog, TrialEntry};

/// How many trials of a session's order are still to be done, its own among `trials`; 0 for an
/// imported session, which has no order.
pub fn left_to_do<'t>(trials: impl IntoIterator<Item = &'t TrialEntry>, log: &SessionLog) -> usize {
    if log.record.order.is_none() {
        return 0;
    }
    // Without questions: one that is open is no trial to be done.
    let order = log.record.trials.iter().map(|t| (t.clone(), Vec::new())).collect();
    let (flow, _) = Flow::begin(order, 0.0, &recorded(trials, log), &log.events);
    flow.places().len() - flow.done()
}
