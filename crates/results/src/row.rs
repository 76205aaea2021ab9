//! Rows of a derived table, and the one declaration that each has.

use crate::column::{Column, Field, Scalar, Type, Values};
use crate::value::Value;
use std::sync::Arc;

/// What cannot be read as rows.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ReadError {
    /// A column that is not there, or of another type.
    #[error(
        "there is no column '{column}' of type {kind:?}: another version wrote the file; make it again"
    )]
    NoColumn {
        /// The column.
        column: &'static str,
        /// Its type.
        kind: Type,
    },
    /// A place that holds nothing, or no such value.
    #[error("row {row}, column '{column}': this is no {what}: the file is damaged; make it again")]
    NoValue {
        /// The row, from 1.
        row: usize,
        /// The column.
        column: &'static str,
        /// The type of the value.
        what: &'static str,
    },
}

/// A row of a derived table.
pub trait Row: Sized {
    /// The table's name.
    const NAME: &'static str;
    /// Its title, a phrase.
    const TITLE: &'static str;

    /// What the columns are, in their order.
    fn fields() -> Vec<Field>;

    /// The columns of some rows.
    fn columns(rows: &[Self]) -> Vec<Column>;

    /// The rows of columns, found by their names.
    ///
    /// # Errors
    /// A column that is not there or of another type; a value that is none.
    fn read(columns: &[Column]) -> Result<Vec<Self>, ReadError>;
}

/// A column that is read: its name and its values; none of one that need not be there.
pub(crate) struct ColumnReader<'a, V> {
    name: &'static str,
    values: Option<&'a Values>,
    /// What was read last where texts stand. Rows of one trial follow each other with the same
    /// words, so that most need not be understood again.
    last: Option<(&'a str, V)>,
}

impl<'a, V: Value + Clone> ColumnReader<'a, V> {
    /// The column of that name, of a type that values `V` are read from.
    ///
    /// # Errors
    /// There is none, and it may not be `absent`; it is of another type.
    pub(crate) fn of(
        columns: &'a [Column],
        name: &'static str,
        absent: &[&str],
    ) -> Result<Self, ReadError> {
        let column = columns.iter().find(|column| column.field.name == name);
        match column.map(|column| &column.values) {
            None if !absent.is_empty() => Ok(ColumnReader { name, values: None, last: None }),
            Some(values) if V::reads(values.kind()) => {
                Ok(ColumnReader { name, values: Some(values), last: None })
            }
            _ => Err(ReadError::NoColumn { column: name, kind: V::KIND }),
        }
    }

    /// The value of a row.
    ///
    /// # Errors
    /// Nothing, or no such value.
    pub(crate) fn at(&mut self, row: usize) -> Result<V, ReadError> {
        let text = self.values.and_then(|values| values.text(row));
        if let (Some((before, value)), Some(text)) = (&self.last, text)
            && *before == text
        {
            return Ok(value.clone());
        }
        let scalar = self.values.map_or(Scalar::Null, |values| values.scalar(row));
        let value = V::of(scalar).ok_or_else(|| ReadError::NoValue {
            row: row + 1,
            column: self.name,
            what: std::any::type_name::<V>(),
        })?;
        self.last = text.map(|text| (text, value.clone()));
        Ok(value)
    }
}

/// The values of one field of some rows; what is the same in one row after the other is kept once.
pub(crate) fn values<'a, V: Value + PartialEq + 'a>(
    fields: impl ExactSizeIterator<Item = &'a V>,
) -> Values {
    match V::KIND {
        Type::Float => Values::Float(fields.map(|field| f64::of(field.scalar())).collect()),
        Type::Integer => Values::Integer(fields.map(|field| i64::of(field.scalar())).collect()),
        Type::Flag => Values::Flag(fields.map(|field| bool::of(field.scalar())).collect()),
        // A repeated text shares its allocation.
        Type::Text => {
            let mut last: Option<(&V, Option<Arc<str>>)> = None;
            let texts = fields.map(|field| match &last {
                Some((before, text)) if *before == field => text.clone(),
                _ => last.insert((field, Arc::of(field.scalar()))).1.clone(),
            });
            Values::Text(texts.collect())
        }
    }
}

/// Declares the rows of derived tables: name and title of the table, and a field for each column
/// with its meaning, its type and its unit (none for a pure number or a word). A column that only
/// some studies have is `or absent`: where it is not there, all its values are null. The first
/// columns may be those of a group: `..of_trial`.
macro_rules! rows {
    ($(
        $(# $about:tt)+
        $row:ident = $name:literal, $title:literal { $($fields:tt)+ }
    )*) => {$(
        $crate::row::one_row! { { $(# $about)+ $row = $name, $title } $($fields)+ }
    )*};
}
pub(crate) use rows;

/// Declares one of them: what it is, then its fields.
macro_rules! one_row {
    ($head:tt ..$group:ident, $($fields:tt)*) => {
        $group! { $head $($fields)* }
    };
    (
        { $(#[doc = $about:literal])+ $row:ident = $name:literal, $title:literal }
        $(
            $(#[doc = $meaning:literal])+
            $field:ident $(or $absent:ident)?: $kind:ty $(= $unit:expr)?,
        )+
    ) => {
        $(#[doc = $about])+
        #[derive(Debug, Clone, PartialEq)]
        pub struct $row {
            $($(#[doc = $meaning])+ pub $field: $kind,)+
        }

        impl $crate::row::Row for $row {
            const NAME: &'static str = $name;
            const TITLE: &'static str = $title;

            fn fields() -> Vec<$crate::column::Field> {
                vec![$($crate::column::Field {
                    name: stringify!($field).into(),
                    unit: $crate::row::unit([$($unit)?].first().copied()).into(),
                    description: concat!($($meaning),+).trim().into(),
                    kind: <$kind as $crate::value::Value>::KIND,
                }),+]
            }

            fn columns(rows: &[Self]) -> Vec<$crate::column::Column> {
                let values = [$($crate::row::values(rows.iter().map(|row| &row.$field))),+];
                let fields = Self::fields().into_iter().zip(values);
                fields.map(|(field, values)| $crate::column::Column { field, values }).collect()
            }

            fn read(
                columns: &[$crate::column::Column],
            ) -> Result<Vec<Self>, $crate::row::ReadError> {
                $(let mut $field = $crate::row::ColumnReader::<$kind>::of(
                    columns,
                    stringify!($field),
                    &[$(stringify!($absent))?],
                )?;)+
                let rows = columns.first().map_or(0, |column| column.values.len());
                (0..rows).map(|row| Ok(Self { $($field: $field.at(row)?),+ })).collect()
            }
        }
    };
}
pub(crate) use one_row;

/// The columns that say which trial a row is about.
macro_rules! of_trial {
    ($head:tt $($fields:tt)*) => {
        $crate::row::one_row! {
            $head
            /// participant's code
            participant: zwidth_study::ParticipantId,
            /// session
            session: zwidth_study::SessionId,
            /// number within the session
            trial: u32,
            /// repeat of the condition
            repeat: u32,
            /// what was rendered
            environment: zwidth_study::EnvironmentId,
            /// how it was rendered
            mode: zwidth_study::ModeId,
            /// recorded, twin or imported
            source: zwidth_study::Source,
            $($fields)*
        }
    };
}
pub(crate) use of_trial;

/// The columns that say which participant's condition a row is about.
macro_rules! of_condition {
    ($head:tt $($fields:tt)*) => {
        $crate::row::one_row! {
            $head
            /// participant's code
            participant: zwidth_study::ParticipantId,
            /// session
            session: zwidth_study::SessionId,
            /// what was rendered
            environment: zwidth_study::EnvironmentId,
            /// how it was rendered
            mode: zwidth_study::ModeId,
            $($fields)*
        }
    };
}
pub(crate) use of_condition;

/// The columns that say which metric a row is about, and where.
macro_rules! of_metric {
    ($head:tt $($fields:tt)*) => {
        $crate::row::one_row! {
            $head
            /// what is compared
            metric: zwidth_study::MetricId,
            /// unit of the metric
            unit: std::sync::Arc<str>,
            /// what was rendered
            environment: zwidth_study::EnvironmentId,
            $($fields)*
        }
    };
}
pub(crate) use of_metric;

/// The unit that a declaration names; that of a pure number where it names none.
pub(crate) fn unit(named: Option<&'static str>) -> &'static str {
    named.unwrap_or("1")
}

#[cfg(test)]
#[expect(unreachable_pub, reason = "the macros declare what others read")]
mod tests {
    use super::*;
    use crate::UNIT_OF_ROW;
    use crate::value::words;

    words! {
        /// A word.
        Word {
            /// One.
            Small = "small",
            /// Another.
            Large = "large",
        }
    }

    rows! {
        /// A row.
        One = "ones", "Some of them" {
            /// a whole number
            count: usize,
            /// an angle
            theta_rad: Option<f64> = "rad",
            /// a number
            bias: f64 = UNIT_OF_ROW,
            /// a word
            word: Word,
            /// whether
            is_it: bool,
            /// a text
            remark or absent: Option<String>,
        }
    }

    fn sample() -> Vec<One> {
        let remark = Some("late".to_owned());
        vec![
            One {
                count: 3,
                theta_rad: Some(0.5),
                bias: 1.0,
                word: Word::Small,
                is_it: true,
                remark,
            },
            One {
                count: 0,
                theta_rad: None,
                bias: -2.0,
                word: Word::Large,
                is_it: false,
                remark: None,
            },
        ]
    }

    #[test]
    fn a_declaration_gives_names_units_and_meanings() {
        let fields = One::fields();
        let told: Vec<[&str; 3]> =
            fields.iter().map(|f| [&*f.name, &*f.unit, &*f.description]).collect();
        assert_eq!(told[0], ["count", "1", "a whole number"]);
        assert_eq!(told[1], ["theta_rad", "rad", "an angle"]);
        assert_eq!(told[2], ["bias", UNIT_OF_ROW, "a number"]);
        assert_eq!((One::NAME, One::TITLE), ("ones", "Some of them"));
    }

    #[test]
    fn rows_come_back_from_their_columns_in_any_order() {
        let mut columns = One::columns(&sample());
        columns.reverse();
        assert_eq!(One::read(&columns).unwrap(), sample());
        assert_eq!(One::read(&One::columns(&[])).unwrap(), []);
    }

    #[test]
    fn a_column_that_may_be_absent_is_null_where_it_is() {
        let mut columns = One::columns(&sample());
        columns.truncate(5);
        let rows = One::read(&columns).unwrap();
        assert!(rows.iter().all(|row| row.remark.is_none()) && rows[0].count == 3);
        columns.push(Column::integer("remark", "1", "", [Some(1), Some(2)]));
        assert!(One::read(&columns).unwrap_err().to_string().contains("no column 'remark'"));
    }

    #[test]
    fn a_column_that_is_not_there_and_a_value_that_is_none_are_named() {
        let mut columns = One::columns(&sample());
        columns[3] = Column::text("word", "", ["small", "huge"].map(Some));
        let error = One::read(&columns).unwrap_err().to_string();
        assert!(error.starts_with("row 2, column 'word'"), "{error}");
        columns[2] = Column::float("bias", "", "", [None, Some(1.0)]);
        assert!(One::read(&columns).unwrap_err().to_string().contains("row 1, column 'bias'"));
        columns[2] = Column::integer("bias", "", "", [Some(1), Some(1)]);
        assert!(One::read(&columns).unwrap_err().to_string().contains("no column 'bias'"));
        columns.remove(0);
        assert!(One::read(&columns).unwrap_err().to_string().contains("no column 'count'"));
    }
}
