//! Queries over tables, by polars: a [`Frame`] is made of a table, grouped, and becomes a table
//! again.
//!
//! No other crate uses polars, so that only crates with queries wait for it to compile.
//! Polars groups by its in-memory engine with stable order: the same table gives the same bits.

use polars::prelude::{
    self as pl, ChunkAgg as _, ChunkTake as _, ChunkVar as _, IntoColumn, NamedFrom,
};
use std::panic::resume_unwind;
use std::sync::Arc;
use std::thread;
use zwidth_tables::{Column, Field, Table, TableError, Type, Values};

/// Why a query was refused.
#[derive(Debug, thiserror::Error)]
pub enum FrameError {
    /// Polars refused: a column that the frame lacks, or has with another type.
    #[error("table '{table}': {source}")]
    Polars {
        /// The table.
        table: String,
        /// What polars said.
        source: pl::PolarsError,
    },
    /// The result does not make a table.
    #[error(transparent)]
    Table(#[from] TableError),
}

/// What is made of the rows of a group.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Statistic {
    /// Mean of the values that are there; null if there are no values.
    Mean,
    /// Standard deviation (n − 1) of the values that are there; null for fewer than two.
    Deviation,
    /// Number of the values that are there.
    Count,
}

/// A column of a grouped frame: a statistic of a column, by the name it gets.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Aggregate {
    /// The column whose values are taken.
    pub of: String,
    /// The statistic.
    pub statistic: Statistic,
    /// The name of the resulting column.
    pub name: String,
}

/// The rows of a table, ready for a query.
#[derive(Debug, Clone)]
pub struct Frame {
    /// The table that it was made of, for messages.
    table: String,
    rows: pl::DataFrame,
}

impl Frame {
    /// The rows of a table.
    ///
    /// # Errors
    /// Those of polars.
    pub fn new(table: &Table) -> Result<Self, FrameError> {
        let columns = table.columns().iter().map(series).collect();
        let rows = pl::DataFrame::new(table.height(), columns);
        let refused = |source| FrameError::Polars { table: table.name().to_owned(), source };
        Ok(Self { table: table.name().to_owned(), rows: rows.map_err(refused)? })
    }

    /// One row per group of rows that share the values of `keys`, in the order in which the groups
    /// appear: the keys, the number of rows in a column named `rows`, and the aggregates.
    ///
    /// # Errors
    /// A column that the frame lacks.
    pub fn grouped(
        &self,
        keys: &[&str],
        rows: &str,
        aggregates: &[Aggregate],
    ) -> Result<Self, FrameError> {
        let work = || summary(&self.rows, keys, rows, aggregates);
        // Polars waits for threads of its own, and a thread of ours that waits takes up other
        // work, however long: so the grouping waits on a thread that has no other.
        let found = thread::scope(|scope| scope.spawn(work).join());
        let refused = |source| FrameError::Polars { table: self.table.clone(), source };
        let rows = found.unwrap_or_else(|panic| resume_unwind(panic)).map_err(refused)?;
        Ok(Self { table: self.table.clone(), rows })
    }

    /// A table of those columns that `fields` describe.
    ///
    /// # Errors
    /// A field that the frame lacks or has with another type; a float that is not finite.
    pub fn to_table(
        &self,
        name: &str,
        title: &str,
        fields: Vec<Field>,
    ) -> Result<Table, FrameError> {
        let column = |field: Field| Ok(Column { values: values(&self.rows, &field)?, field });
        let columns = fields.into_iter().map(column).collect::<Result<_, _>>();
        let refused = |source| FrameError::Polars { table: name.to_owned(), source };
        Ok(Table::new(name, title, columns.map_err(refused)?)?)
    }
}

/// One row per group, in the order in which the groups appear: its key, its number of rows, and the
/// aggregates.
fn summary(
    rows: &pl::DataFrame,
    keys: &[&str],
    n: &str,
    aggregates: &[Aggregate],
) -> Result<pl::DataFrame, pl::PolarsError> {
    let keys: Vec<String> = keys.iter().map(|key| (*key).to_owned()).collect();
    let grouped = rows.group_by_stable(&keys)?;
    let groups: Vec<Vec<pl::IdxSize>> = grouped.get_groups().iter().map(members).collect();
    let mut columns = grouped.keys();
    let heights = groups.iter().map(|group| whole(group.len()));
    columns.push(pl::Column::new(n.into(), heights.collect::<Vec<i64>>()));
    for Aggregate { of, statistic, name } in aggregates {
        // Of one column at a time: a frame for each of thousands of groups takes far more memory.
        let all = rows.column(of)?.f64()?;
        let values = groups.iter().map(|group| all.take(group)).collect::<Result<Vec<_>, _>>()?;
        let floats = |of: fn(&pl::Float64Chunked) -> Option<f64>| -> Vec<Option<f64>> {
            values.iter().map(of).collect()
        };
        let name = pl::PlSmallStr::from_str(name);
        columns.push(match statistic {
            Statistic::Mean => pl::Column::new(name, floats(|v| v.mean())),
            Statistic::Deviation => pl::Column::new(name, floats(|v| v.std(1))),
            Statistic::Count => {
                let there = values.iter().map(|v| whole(v.len() - v.null_count()));
                pl::Column::new(name, there.collect::<Vec<i64>>())
            }
        });
    }
    pl::DataFrame::new(groups.len(), columns)
}

/// The rows of a group.
fn members(group: pl::GroupsIndicator) -> Vec<pl::IdxSize> {
    match group {
        pl::GroupsIndicator::Idx((_, rows)) => rows.to_vec(),
        pl::GroupsIndicator::Slice([first, length]) => (first..first + length).collect(),
    }
}

/// A number of rows in memory, which fits into the type.
fn whole(rows: usize) -> i64 {
    i64::try_from(rows).unwrap_or(i64::MAX)
}

fn series(column: &Column) -> pl::Column {
    let name = pl::PlSmallStr::from_str(&column.field.name);
    match &column.values {
        Values::Float(v) => pl::Series::new(name, v),
        Values::Integer(v) => pl::Series::new(name, v),
        Values::Text(v) => {
            pl::Series::new(name, v.iter().map(Option::as_deref).collect::<Vec<_>>())
        }
        Values::Flag(v) => pl::Series::new(name, v),
    }
    .into_column()
}

fn values(rows: &pl::DataFrame, field: &Field) -> Result<Values, pl::PolarsError> {
    let series = rows.column(&field.name)?;
    Ok(match field.kind {
        Type::Float => Values::Float(series.f64()?.iter().collect()),
        Type::Integer => Values::Integer(series.i64()?.iter().collect()),
        Type::Text => Values::Text(series.str()?.iter().map(|v| v.map(Arc::from)).collect()),
        Type::Flag => Values::Flag(series.bool()?.iter().collect()),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample() -> Table {
        let columns = vec![
            Column::text("mode", "the mode", ["b", "a", "b"].map(Some)),
            Column::float("force_n", "N", "a force", [Some(1.5), None, Some(2.5)]),
            Column::integer("trial", "1", "number", [Some(1), Some(2), None]),
            Column::flag("wall_reached", "whether", [Some(true), None, Some(false)]),
        ];
        Table::new("sample", "A sample", columns).unwrap()
    }

    fn fields(table: &Table) -> Vec<Field> {
        table.fields().cloned().collect()
    }

    #[test]
    fn a_table_comes_back_from_its_frame_with_its_nulls() {
        let table = sample();
        let again = Frame::new(&table).unwrap().to_table("again", "", fields(&table)).unwrap();
        assert_eq!(again.columns(), table.columns());
    }

    #[test]
    fn groups_stand_in_the_order_of_their_first_rows_and_nulls_do_not_count() {
        let aggregate = |statistic, name: &str| Aggregate {
            of: "force_n".to_owned(),
            statistic,
            name: name.to_owned(),
        };
        let aggregates = [
            aggregate(Statistic::Mean, "mean"),
            aggregate(Statistic::Deviation, "deviation"),
            aggregate(Statistic::Count, "count"),
        ];
        let grouped = Frame::new(&sample()).unwrap().grouped(&["mode"], "n", &aggregates).unwrap();
        let field = |name: &'static str, kind| Field {
            name: name.into(),
            unit: "1".into(),
            description: "".into(),
            kind,
        };
        let fields = vec![
            field("mode", Type::Text),
            field("n", Type::Integer),
            field("mean", Type::Float),
            field("deviation", Type::Float),
            field("count", Type::Integer),
        ];
        let table = grouped.to_table("groups", "", fields).unwrap();
        assert_eq!(table.texts("mode").unwrap(), [Some("b".to_owned()), Some("a".to_owned())]);
        assert_eq!(table.integers("n").unwrap(), [Some(2), Some(1)]);
        assert_eq!(table.floats("mean").unwrap(), [Some(2.0), None]);
        assert_eq!(table.floats("deviation").unwrap(), [Some(0.5_f64.sqrt()), None]);
        assert_eq!(table.integers("count").unwrap(), [Some(2), Some(0)]);
    }

    #[test]
    fn a_column_that_is_not_there_or_of_another_type_is_named() {
        let frame = Frame::new(&sample()).unwrap();
        let field = |name: &'static str| Field {
            name: name.into(),
            unit: "1".into(),
            description: "".into(),
            kind: Type::Float,
        };
        for name in ["mass_kg", "trial"] {
            let error = frame.to_table("t", "", vec![field(name)]).unwrap_err().to_string();
            assert!(error.starts_with("table 't': "), "{error}");
        }
        assert!(frame.grouped(&["mass_kg"], "n", &[]).is_err());
    }
}
