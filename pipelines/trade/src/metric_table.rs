//! The study's own metrics of every setting, as tables.

use crate::cells::Cell;
use crate::measured::MetricChange;
use crate::trade::Trade;
use zwidth_tables::{Column, Table, TableError};

/// How far a setting's metrics are off those of the right run.
pub(crate) fn metric_columns(cells: &[&Cell]) -> [Column; 4] {
    let furthest = cells.iter().map(|cell| cell.furthest_metric());
    let count = |cell: &&Cell, is: fn(&MetricChange) -> bool| {
        let n = cell.metrics.iter().filter(|metric| is(metric)).count();
        (!cell.metrics.is_empty()).then_some(n as i64)
    };
    let is_felt = |metric: &MetricChange| metric.felt_share.is_some_and(|share| share > 1.0);
    [
        Column::text(
            "metric",
            "the study's metric that changes most, over what is just felt",
            furthest.clone().map(|most| Some(most?.0.name.clone())),
        ),
        Column::float(
            "metric_share",
            "1",
            "its change over what is just felt",
            furthest.map(|most| Some(most?.1)),
        ),
        Column::integer(
            "metrics_felt",
            "1",
            "metrics that change by more than is just felt",
            cells.iter().map(|cell| count(cell, is_felt)),
        ),
        Column::integer(
            "metrics_lost",
            "1",
            "metrics that this run or the right one lacks",
            cells.iter().map(|cell| count(cell, MetricChange::is_lost)),
        ),
    ]
}

/// Every metric of every setting of every trade, beside that of the right run; a row each.
///
/// # Errors
/// None that finished trades can cause.
pub fn metrics_table(name: &str, title: &str, trades: &[Trade]) -> Result<Table, TableError> {
    type Metric<'a> = (&'a Trade, &'a Cell, &'a MetricChange);
    let cells = trades.iter().flat_map(|trade| trade.cells.iter().map(move |cell| (trade, cell)));
    let rows: Vec<Metric> = cells
        .flat_map(|(trade, cell)| cell.metrics.iter().map(move |metric| (trade, cell, metric)))
        .collect();
    let text = |name, about, get: fn(&Metric) -> String| {
        Column::text(name, about, rows.iter().map(|row| Some(get(row))))
    };
    let float = |name, unit, about, get: fn(&Metric) -> Option<f64>| {
        Column::float(name, unit, about, rows.iter().map(get))
    };
    let tolerance = |row: &Metric| {
        let setting = row.1.setting;
        Some(setting.size()).filter(|size| setting.step_s().is_none() && *size > 0.0)
    };
    let columns = vec![
        text("scene", "the scene", |row| row.0.scene.name.clone()),
        text("solver", "the solver", |row| row.1.setting.solver.to_owned()),
        float("step_s", "s", "its step", |row| row.1.setting.step_s()),
        float("tolerance", "1", "its relative error per step", tolerance),
        text("metric", "the metric", |row| row.2.name.clone()),
        text("unit", "the unit of right, found and change", |row| row.2.unit.clone()),
        float("right", "1", "of the right run", |row| row.2.right),
        float("found", "1", "of this one", |row| row.2.found),
        float("change", "1", "found less right", |row| row.2.change()),
        float("relative_change", "1", "its size over that of right", |row| row.2.relative()),
        float("felt_share", "1", "its size over what is just felt, where that is known", |row| {
            row.2.felt_share.filter(|share| share.is_finite())
        }),
    ];
    Ok(Table::new(name, title, columns)?
        .with_note(
            "Both runs at the same times, at most 2,000 of them, so that sampling changes nothing.",
        )
        .with_note("Model runs, not measurements."))
}
