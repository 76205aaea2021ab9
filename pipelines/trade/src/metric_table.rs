//! The study's own metrics of every setting.

use crate::table::MODEL;
use crate::trade::Trade;
use zwidth_results::{Row, TradeMetric};
use zwidth_tables::{Table, TableError};

/// Every metric of every setting of every trade, beside that of the right run.
pub fn metrics(trades: &[Trade]) -> Vec<TradeMetric> {
    let cells = trades.iter().flat_map(|trade| trade.cells.iter().map(move |cell| (trade, cell)));
    let mut rows = Vec::new();
    for (trade, cell) in cells {
        rows.extend(cell.metrics.iter().map(|metric| TradeMetric {
            scene: trade.scene.name.as_str().into(),
            solver: cell.setting.solver.into(),
            step_s: cell.setting.step_s(),
            tolerance: cell.setting.tolerance(),
            metric: metric.name.as_str().into(),
            unit: metric.unit.as_str().into(),
            right: metric.right,
            found: metric.found,
            change: metric.change(),
            relative_change: metric.relative(),
            felt_share: metric.felt_share.filter(|share| share.is_finite()),
        }));
    }
    rows
}

/// The table of [`metrics`].
///
/// # Errors
/// None that finished trades can cause.
pub fn metrics_table(title: &str, rows: &[TradeMetric]) -> Result<Table, TableError> {
    Ok(Table::of_rows(rows)?
        .called(TradeMetric::NAME, title)
        .with_note(
            "Both runs at the same times, at most 2,000 of them, so that sampling changes nothing.",
        )
        .with_note(MODEL))
}
