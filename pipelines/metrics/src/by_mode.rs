//! The metrics by condition in a form that fits on a page: one row per metric, modes side by side.

use crate::columns::ALONG_PUSH;
use zwidth_results::ConditionTrials;
use zwidth_tables::{Column, Field, Table, TableError, Type, UNIT_OF_ROW, Values, split_unit};

/// What the rows of one block share.
const BLOCK: [&str; 3] = ["participant", "session", "environment"];

/// A metric in the table of conditions.
struct Metric<'a> {
    /// Its name without its unit, and whether it is along the push where others are not.
    stem: String,
    unit: &'a str,
    means: &'a [Option<f64>],
    deviations: &'a [Option<f64>],
}

/// The table of conditions ([`crate::by_condition`]) with one row per participant, session,
/// environment and metric, and in each mode's columns mean and standard deviation; `modes` are ids
/// and labels, and a mode that is not among them comes after them under its id. A metric that no
/// mode of an environment has is left out. The first row of each block is the number of trials.
///
/// # Errors
/// A table that is not one of conditions, or labels that cannot be names of columns beside each
/// other.
pub fn by_mode(conditions: &Table, modes: &[(String, String)]) -> Result<Table, TableError> {
    let rows: Vec<ConditionTrials> = conditions.to_rows()?;
    let modes = present(modes, &rows);
    let metrics = metrics(conditions);
    let counts: Vec<Option<f64>> = rows.iter().map(|row| Some(row.n as f64)).collect();
    let trials = Metric {
        stem: "trials".to_owned(),
        unit: "1",
        means: &counts,
        deviations: &vec![None; counts.len()],
    };

    let mut keys: [Vec<Option<String>>; 5] = Default::default();
    let mut cells: Vec<[Vec<Option<f64>>; 2]> = vec![Default::default(); modes.len()];
    for (block, of_block) in blocks(&rows) {
        let of_modes = modes
            .iter()
            .map(|(id, _)| of_block.iter().copied().find(|row| rows[*row].mode.as_str() == id));
        let of_modes: Vec<Option<usize>> = of_modes.collect();
        for metric in std::iter::once(&trials).chain(&metrics) {
            let values: Vec<_> =
                of_modes.iter().map(|row| row.and_then(|r| metric.means[r])).collect();
            if values.iter().all(Option::is_none) {
                continue;
            }
            let about = [Some(metric.stem.clone()), Some(metric.unit.to_owned())];
            let row = block.iter().cloned().map(Some).chain(about);
            keys.iter_mut().zip(row).for_each(|(column, cell)| column.push(cell));
            for (k, value) in values.into_iter().enumerate() {
                cells[k][0].push(value);
                cells[k][1].push(of_modes[k].and_then(|row| metric.deviations[row]));
            }
        }
    }
    let names = BLOCK.into_iter().chain(["metric", "unit"]);
    let mut columns: Vec<Column> =
        names.zip(keys).map(|(name, cells)| Column::text(name, "", cells)).collect();
    for ((_, label), [means, deviations]) in modes.iter().zip(cells) {
        columns.push(numbers(label.clone(), "mean of the repeats", means));
        columns.push(numbers(format!("{label}_sd"), "standard deviation", deviations));
    }
    let table = Table::new(conditions.name(), conditions.title(), columns)?;
    Ok(conditions.notes_by_kind().fold(table, |t, (kind, note)| t.with_note_of(kind, note)))
}

/// A column whose every row has its own unit.
fn numbers(name: String, description: &'static str, values: Vec<Option<f64>>) -> Column {
    let field = Field {
        name: name.into(),
        unit: UNIT_OF_ROW.into(),
        description: description.into(),
        kind: Type::Float,
    };
    Column { field, values: Values::Float(values) }
}

/// What the rows of a block share, and which rows these are; in the order of the table.
type Block = ([String; 3], Vec<usize>);

fn blocks(conditions: &[ConditionTrials]) -> Vec<Block> {
    let mut blocks: Vec<Block> = Vec::new();
    for (row, ConditionTrials { participant, session, environment, .. }) in
        conditions.iter().enumerate()
    {
        let keys = [participant.to_string(), session.to_string(), environment.to_string()];
        match blocks.iter_mut().find(|(block, _)| *block == keys) {
            Some((_, rows)) => rows.push(row),
            None => blocks.push((keys, vec![row])),
        }
    }
    blocks
}

/// The modes that rows have, with their labels: those of the study, in its order, then others.
fn present(labelled: &[(String, String)], rows: &[ConditionTrials]) -> Vec<(String, String)> {
    let mut modes = labelled.to_vec();
    modes.retain(|(id, _)| rows.iter().any(|row| row.mode.as_str() == id));
    for ConditionTrials { mode, .. } in rows {
        if !modes.iter().any(|(id, _)| id == mode.as_str()) {
            modes.push((mode.to_string(), mode.to_string()));
        }
    }
    modes
}

/// The metrics that have a standard deviation beside them.
fn metrics(conditions: &Table) -> Vec<Metric<'_>> {
    let metrics = conditions.columns().iter().filter_map(|column| {
        let field = &column.field;
        let (stem, suffix) = split_unit(&field.name, &field.unit);
        let deviations = floats(conditions, &format!("{stem}_sd{suffix}"))?;
        let means = floats(conditions, &field.name)?;
        let along = if field.description.ends_with(ALONG_PUSH) { "_along_push" } else { "" };
        Some(Metric { stem: format!("{stem}{along}"), unit: &field.unit, means, deviations })
    });
    metrics.collect()
}

fn floats<'t>(table: &'t Table, name: &str) -> Option<&'t [Option<f64>]> {
    match &table.column(name).ok()?.values {
        Values::Float(values) => Some(values.as_slice()),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn conditions() -> Table {
        let texts =
            |name, values: [&str; 3]| Column::text(name, "", values.map(|v| Some(v.to_owned())));
        let n = |name, unit, values| Column::float(name, unit, "", values);
        let columns = vec![
            texts("participant", ["P01"; 3]),
            texts("session", ["S01"; 3]),
            texts("environment", ["spring", "spring", "wall"]),
            texts("mode", ["hybrid", "active", "odd"]),
            Column::integer("n", "1", "trials", [Some(6), Some(5), Some(4)]),
            n("theta_max_rad", "rad", [Some(0.5), Some(0.6), Some(0.7)]),
            n("theta_max_sd_rad", "rad", [Some(0.01), None, Some(0.03)]),
            n("wall_dwell_s", "s", [None, None, Some(1.0)]),
            n("wall_dwell_sd_s", "s", [None, None, Some(0.1)]),
        ];
        Table::new("conditions", "By condition", columns).unwrap().with_note("a note")
    }

    #[test]
    fn modes_stand_beside_each_other_and_what_no_mode_has_is_left_out() {
        let modes = [("active", "Motor alone"), ("passive", "Brake"), ("hybrid", "Both")];
        let table =
            by_mode(&conditions(), &modes.map(|(id, label)| (id.into(), label.into()))).unwrap();
        let texts = |name| table.texts(name).unwrap().into_iter().flatten().collect::<Vec<_>>();
        assert_eq!(texts("environment"), ["spring", "spring", "wall", "wall", "wall"]);
        assert_eq!(texts("metric"), ["trials", "theta_max", "trials", "theta_max", "wall_dwell"]);
        assert_eq!(texts("unit"), ["1", "rad", "1", "rad", "s"]);
        let numbers = |name| table.floats(name).unwrap();
        assert_eq!(numbers("Motor alone"), [Some(5.0), Some(0.6), None, None, None]);
        assert_eq!(numbers("Both"), [Some(6.0), Some(0.5), None, None, None]);
        assert_eq!(numbers("Both_sd"), [None, Some(0.01), None, None, None]);
        assert_eq!(numbers("odd"), [None, None, Some(4.0), Some(0.7), Some(1.0)]);
        assert!(table.floats("Brake").is_err(), "no trial in this mode");
        assert_eq!((table.name(), table.notes()), ("conditions", &["a note".to_owned()][..]));
    }
}
