//! Columns: what each is, and its values.

use std::borrow::Cow;
use std::sync::Arc;

/// The unit of a column whose every row has its own, named by the text column `unit`.
pub const UNIT_OF_ROW: &str = "";

/// One place of a table.
#[derive(Debug, Clone, PartialEq)]
pub enum Scalar {
    /// A number.
    Float(f64),
    /// A whole number.
    Integer(i64),
    /// A text.
    Text(Arc<str>),
    /// Yes or no.
    Flag(bool),
    /// Not applicable, or not known.
    Null,
}

/// Type of a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Type {
    /// `f64`, finite or null.
    Float,
    /// `i64`.
    Integer,
    /// Text.
    Text,
    /// Yes or no.
    Flag,
}

/// What a column is: name (with its unit as suffix), unit, meaning.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Field {
    /// Name, in snake case, with the unit as its suffix: `theta_max_rad`.
    pub name: Cow<'static, str>,
    /// Unit: `rad`, `N`, `1` for a pure number or a word.
    pub unit: Cow<'static, str>,
    /// Meaning, one sentence.
    pub description: Cow<'static, str>,
    /// Type.
    pub kind: Type,
}

/// The values of a column; `None` is null: not applicable, or not known.
#[derive(Debug, Clone, PartialEq)]
pub enum Values {
    /// Numbers.
    Float(Vec<Option<f64>>),
    /// Whole numbers.
    Integer(Vec<Option<i64>>),
    /// Texts; one that comes back a few rows later is kept once.
    Text(Vec<Option<Arc<str>>>),
    /// Yes or no.
    Flag(Vec<Option<bool>>),
}

impl Values {
    /// The value of a row; null for a row that is not there.
    pub(crate) fn scalar(&self, row: usize) -> Scalar {
        fn of<T: Clone>(values: &[Option<T>], row: usize, scalar: fn(T) -> Scalar) -> Scalar {
            values.get(row).cloned().flatten().map_or(Scalar::Null, scalar)
        }
        match self {
            Self::Float(v) => of(v, row, Scalar::Float),
            Self::Integer(v) => of(v, row, Scalar::Integer),
            Self::Text(v) => of(v, row, Scalar::Text),
            Self::Flag(v) => of(v, row, Scalar::Flag),
        }
    }

    /// The text of a row; `None` where there is none.
    pub(crate) fn text(&self, row: usize) -> Option<&str> {
        match self {
            Self::Text(texts) => texts.get(row)?.as_deref(),
            _ => None,
        }
    }

    /// Their type.
    pub fn kind(&self) -> Type {
        match self {
            Self::Float(_) => Type::Float,
            Self::Integer(_) => Type::Integer,
            Self::Text(_) => Type::Text,
            Self::Flag(_) => Type::Flag,
        }
    }

    /// Numbers as whole numbers, as which they can be written; all others as they are.
    #[must_use]
    pub fn in_whole_numbers(self) -> Self {
        match self {
            Self::Float(v) => Self::Integer(v.into_iter().map(|n| n.map(|n| n as i64)).collect()),
            other => other,
        }
    }

    /// How many there are.
    #[expect(clippy::len_without_is_empty, reason = "nobody asks")]
    pub fn len(&self) -> usize {
        match self {
            Self::Float(v) => v.len(),
            Self::Integer(v) => v.len(),
            Self::Text(v) => v.len(),
            Self::Flag(v) => v.len(),
        }
    }

    /// Whether any is not null.
    pub fn are_any(&self) -> bool {
        match self {
            Self::Float(v) => v.iter().any(Option::is_some),
            Self::Integer(v) => v.iter().any(Option::is_some),
            Self::Text(v) => v.iter().any(Option::is_some),
            Self::Flag(v) => v.iter().any(Option::is_some),
        }
    }

    /// Their values one after the other; all are of one type.
    pub fn joined(parts: Vec<Self>) -> Option<Self> {
        let rows: usize = parts.iter().map(Self::len).sum();
        let mut parts = parts.into_iter();
        let mut all = parts.next()?;
        // Once for all parts: each `append` alone could move everything before it.
        all.reserve(rows - all.len());
        parts.for_each(|more| all.append(more));
        Some(all)
    }

    /// Makes room for this many more.
    pub fn reserve(&mut self, more: usize) {
        match self {
            Self::Float(v) => v.reserve_exact(more),
            Self::Integer(v) => v.reserve_exact(more),
            Self::Text(v) => v.reserve_exact(more),
            Self::Flag(v) => v.reserve_exact(more),
        }
    }

    /// Appends values of the same type; the caller never passes another.
    pub fn append(&mut self, more: Self) {
        match (self, more) {
            (Self::Float(v), Self::Float(more)) => v.extend(more),
            (Self::Integer(v), Self::Integer(more)) => v.extend(more),
            (Self::Text(v), Self::Text(more)) => v.extend(more),
            (Self::Flag(v), Self::Flag(more)) => v.extend(more),
            _ => {}
        }
    }

    /// The values of some rows, in this order; null for a row that is not there.
    #[must_use]
    pub fn of_rows(&self, rows: impl Iterator<Item = Option<usize>>) -> Self {
        fn of<T: Clone>(
            values: &[Option<T>],
            rows: impl Iterator<Item = Option<usize>>,
        ) -> Vec<Option<T>> {
            rows.map(|row| values.get(row?).cloned().flatten()).collect()
        }
        match self {
            Self::Float(v) => Self::Float(of(v, rows)),
            Self::Integer(v) => Self::Integer(of(v, rows)),
            Self::Text(v) => Self::Text(of(v, rows)),
            Self::Flag(v) => Self::Flag(of(v, rows)),
        }
    }
}

/// A column to be: its field and its values.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// What it is.
    pub field: Field,
    /// Its values.
    pub values: Values,
}

impl Column {
    fn new(
        name: &'static str,
        unit: &'static str,
        description: &'static str,
        values: Values,
    ) -> Self {
        let field = Field {
            name: name.into(),
            unit: unit.into(),
            description: description.into(),
            kind: values.kind(),
        };
        Self { field, values }
    }

    /// A column of numbers.
    pub fn float(
        name: &'static str,
        unit: &'static str,
        description: &'static str,
        values: impl IntoIterator<Item = Option<f64>>,
    ) -> Self {
        Self::new(name, unit, description, Values::Float(values.into_iter().collect()))
    }

    /// A column of whole numbers.
    pub fn integer(
        name: &'static str,
        unit: &'static str,
        description: &'static str,
        values: impl IntoIterator<Item = Option<i64>>,
    ) -> Self {
        Self::new(name, unit, description, Values::Integer(values.into_iter().collect()))
    }

    /// A column of texts.
    pub fn text(
        name: &'static str,
        description: &'static str,
        values: impl IntoIterator<Item = Option<impl Into<Arc<str>>>>,
    ) -> Self {
        let values = values.into_iter().map(|text| text.map(Into::into));
        Self::new(name, "1", description, Values::Text(values.collect()))
    }

    /// A column of yes and no.
    pub fn flag(
        name: &'static str,
        description: &'static str,
        values: impl IntoIterator<Item = Option<bool>>,
    ) -> Self {
        Self::new(name, "1", description, Values::Flag(values.into_iter().collect()))
    }
}
