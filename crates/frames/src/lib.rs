//! Rows in groups, by polars: rows that share a key, and the summaries of their numbers.
//!
//! No other crate uses polars, so that only crates with queries wait for it to compile.
//! Polars groups by its in-memory engine with stable order: the same rows give the same bits.

use polars::prelude::{
    self as pl, ChunkAgg as _, ChunkTake as _, ChunkVar as _, IntoColumn as _, NamedFrom as _,
};
use std::panic::resume_unwind;
use std::sync::Arc;
use std::thread;
use zwidth_results::{Column, ReadError, Row, Type, Values};

/// Why rows could not be grouped.
#[derive(Debug, thiserror::Error)]
pub enum FrameError {
    /// Polars refused: numbers that are more or fewer than the rows.
    #[error("the rows could not be grouped: {0}")]
    Polars(#[from] pl::PolarsError),
    /// The keys of the groups are no keys.
    #[error("the groups could not be read: {0}")]
    Read(#[from] ReadError),
}

/// The statistics of the numbers of a group.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Statistics {
    /// How many there are.
    pub count: usize,
    /// Their mean; `None` if there are none.
    pub mean: Option<f64>,
    /// Their standard deviation (n − 1); `None` for fewer than two.
    pub sd: Option<f64>,
}

/// Rows that share a key.
#[derive(Debug, Clone, PartialEq)]
pub struct Group<K> {
    /// What they share.
    pub key: K,
    /// How many they are.
    pub rows: usize,
    /// The statistics of each column of numbers.
    pub numbers: Vec<Statistics>,
}

/// The rows of each key, in the order in which the keys appear. `numbers` are columns of as many
/// numbers as there are keys.
///
/// # Errors
/// A column of another length.
pub fn grouped<K: Row + Send + Sync>(
    keys: &[K],
    numbers: &[&[Option<f64>]],
) -> Result<Vec<Group<K>>, FrameError> {
    // Polars waits for threads of its own, and a thread of ours that waits takes up other work,
    // however long: so the grouping waits on a thread that has no other.
    let groups = thread::scope(|scope| scope.spawn(|| groups(keys, numbers)).join());
    groups.unwrap_or_else(|panic| resume_unwind(panic))
}

fn groups<K: Row>(keys: &[K], numbers: &[&[Option<f64>]]) -> Result<Vec<Group<K>>, FrameError> {
    let names: Vec<String> = K::fields().iter().map(|field| field.name.to_string()).collect();
    let rows = pl::DataFrame::new(keys.len(), K::columns(keys).iter().map(series).collect())?;
    let grouped = rows.group_by_stable(&names)?;
    let members: Vec<Vec<pl::IdxSize>> = grouped.get_groups().iter().map(members).collect();
    let first: Vec<Column> = K::fields()
        .into_iter()
        .zip(grouped.keys())
        .map(|(field, values)| Ok(Column { values: values_of(&values, field.kind)?, field }))
        .collect::<Result<_, pl::PolarsError>>()?;
    let mut groups: Vec<Group<K>> = K::read(&first)?
        .into_iter()
        .zip(&members)
        .map(|(key, rows)| Group { key, rows: rows.len(), numbers: Vec::new() })
        .collect();
    for column in numbers {
        let all = pl::Series::new(pl::PlSmallStr::EMPTY, column);
        let all = all.f64()?;
        // Of one group at a time: a frame for each of thousands of groups takes far more memory.
        for (group, rows) in groups.iter_mut().zip(&members) {
            let own = all.take(rows)?;
            let count = own.len() - own.null_count();
            group.numbers.push(Statistics { count, mean: own.mean(), sd: own.std(1) });
        }
    }
    Ok(groups)
}

/// The rows of a group.
fn members(group: pl::GroupsIndicator) -> Vec<pl::IdxSize> {
    match group {
        pl::GroupsIndicator::Idx((_, rows)) => rows.to_vec(),
        pl::GroupsIndicator::Slice([first, length]) => (first..first + length).collect(),
    }
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

fn values_of(series: &pl::Column, kind: Type) -> Result<Values, pl::PolarsError> {
    Ok(match kind {
        Type::Float => Values::Float(series.f64()?.iter().collect()),
        Type::Integer => Values::Integer(series.i64()?.iter().collect()),
        Type::Text => Values::Text(series.str()?.iter().map(|v| v.map(Arc::from)).collect()),
        Type::Flag => Values::Flag(series.bool()?.iter().collect()),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use zwidth_results::ConditionKey;

    fn key(mode: &str) -> ConditionKey {
        ConditionKey {
            participant: "P01".parse().unwrap(),
            session: "S01".parse().unwrap(),
            environment: "spring".parse().unwrap(),
            mode: mode.parse().unwrap(),
        }
    }

    #[test]
    fn groups_stand_in_the_order_of_their_first_rows_and_nulls_do_not_count() {
        let keys = ["b", "a", "b"].map(key);
        let groups = grouped(&keys, &[&[Some(1.5), None, Some(2.5)]]).unwrap();
        let [b, a] = groups.as_slice() else { panic!("two groups") };
        let of = |count, mean, sd| vec![Statistics { count, mean, sd }];
        assert_eq!((&b.key, b.rows), (&key("b"), 2));
        assert_eq!(b.numbers, of(2, Some(2.0), Some(0.5_f64.sqrt())));
        assert_eq!((&a.key, a.rows), (&key("a"), 1));
        assert_eq!(a.numbers, of(0, None, None));
    }

    #[test]
    fn no_rows_have_no_groups() {
        assert_eq!(grouped::<ConditionKey>(&[], &[&[]]).unwrap(), []);
    }

    #[test]
    fn numbers_of_another_length_are_refused() {
        assert!(grouped(&["a", "b"].map(key), &[&[Some(1.0)]]).is_err());
    }
}
