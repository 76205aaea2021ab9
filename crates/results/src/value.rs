//! What a column of a table can hold, and its type in memory.

use crate::column::{Scalar, Type};
use std::sync::Arc;
use zwidth_study::{
    AnswerValue, Contrast, EnvironmentId, MetricId, ModeId, ParticipantId, QuestionId, SessionId,
};

/// What a field of a row can be.
pub trait Value: Sized {
    /// The type of its column.
    const KIND: Type;

    /// Whether it can be read from a column of a type.
    fn reads(kind: Type) -> bool {
        kind == Self::KIND
    }

    /// As the table holds it.
    fn scalar(&self) -> Scalar;

    /// What the table holds, back; `None` where that is no such value.
    fn of(scalar: Scalar) -> Option<Self>;
}

/// A value that a table holds as it is.
macro_rules! scalars {
    ($($name:ty = $kind:ident),*) => {$(
        impl Value for $name {
            const KIND: Type = Type::$kind;

            fn scalar(&self) -> Scalar {
                Scalar::$kind(Self::clone(self))
            }

            fn of(scalar: Scalar) -> Option<Self> {
                match scalar {
                    Scalar::$kind(value) => Some(value),
                    _ => None,
                }
            }
        }
    )*};
}

scalars!(f64 = Float, i64 = Integer, bool = Flag, Arc<str> = Text);

/// A count: none of things in memory, and none of work, is larger than a whole number of a table.
macro_rules! counts {
    ($($name:ty),*) => {$(
        impl Value for $name {
            const KIND: Type = Type::Integer;

            fn scalar(&self) -> Scalar {
                Scalar::Integer(i64::try_from(*self).unwrap_or(i64::MAX))
            }

            fn of(scalar: Scalar) -> Option<Self> {
                Self::try_from(i64::of(scalar)?).ok()
            }
        }
    )*};
}

counts!(u64, usize);

impl Value for u32 {
    const KIND: Type = Type::Integer;

    fn scalar(&self) -> Scalar {
        Scalar::Integer((*self).into())
    }

    fn of(scalar: Scalar) -> Option<Self> {
        Self::try_from(i64::of(scalar)?).ok()
    }
}

impl Value for String {
    const KIND: Type = Type::Text;

    fn scalar(&self) -> Scalar {
        Scalar::Text(self.as_str().into())
    }

    fn of(scalar: Scalar) -> Option<Self> {
        Arc::<str>::of(scalar).map(|text| text.to_string())
    }
}

/// The columns of answers hold whole numbers in a study whose scales have no decimals.
impl Value for AnswerValue {
    const KIND: Type = Type::Float;

    fn reads(kind: Type) -> bool {
        matches!(kind, Type::Float | Type::Integer)
    }

    fn scalar(&self) -> Scalar {
        Scalar::Float(self.get())
    }

    fn of(scalar: Scalar) -> Option<Self> {
        match scalar {
            Scalar::Float(number) => Self::new(number).ok(),
            Scalar::Integer(number) => i16::try_from(number).ok().map(Self::from),
            _ => None,
        }
    }
}

impl<V: Value> Value for Option<V> {
    const KIND: Type = V::KIND;

    fn reads(kind: Type) -> bool {
        V::reads(kind)
    }

    fn scalar(&self) -> Scalar {
        self.as_ref().map_or(Scalar::Null, V::scalar)
    }

    fn of(scalar: Scalar) -> Option<Self> {
        match scalar {
            Scalar::Null => Some(None),
            scalar => V::of(scalar).map(Some),
        }
    }
}

/// A text that stands for no value.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("'{0}' is no {1}: another version wrote it; make it again")]
pub struct NoSuchText(pub(crate) String, pub(crate) &'static str);

/// The one of these values that a text stands for. They are read back by writing: a number in
/// another form, such as `+1`, stands for none.
pub(crate) fn written<V: std::fmt::Display>(
    text: &str,
    what: &'static str,
    values: impl IntoIterator<Item = V>,
) -> Result<V, NoSuchText> {
    let found = values.into_iter().find(|value| value.to_string() == text);
    found.ok_or_else(|| NoSuchText(text.to_owned(), what))
}

/// A value whose column holds the text that stands for it.
macro_rules! texts {
    ($($name:ty),*) => {$(
        impl $crate::value::Value for $name {
            const KIND: $crate::column::Type = $crate::column::Type::Text;

            fn scalar(&self) -> $crate::column::Scalar {
                $crate::column::Scalar::Text(self.to_string().into())
            }

            fn of(scalar: $crate::column::Scalar) -> Option<Self> {
                std::sync::Arc::<str>::of(scalar)?.parse().ok()
            }
        }
    )*};
}
pub(crate) use texts;

texts!(ParticipantId, SessionId, EnvironmentId, ModeId, MetricId, QuestionId, Contrast);

/// A value of `study` that has a word for each of what it can be.
macro_rules! named {
    ($($name:ty),*) => {$(
        impl $crate::value::Value for $name {
            const KIND: $crate::column::Type = $crate::column::Type::Text;

            fn scalar(&self) -> $crate::column::Scalar {
                $crate::column::Scalar::Text(self.as_str().into())
            }

            fn of(scalar: $crate::column::Scalar) -> Option<Self> {
                Self::from_word(&*std::sync::Arc::<str>::of(scalar)?)
            }
        }
    )*};
}
pub(crate) use named;

/// One of a few things, each with the word that stands for it in tables.
macro_rules! words {
    ($($(#[$doc:meta])* $name:ident { $($(#[$about:meta])* $variant:ident = $word:literal,)* })*) => {$(
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
        pub enum $name {
            $($(#[$about])* $variant,)*
        }

        impl $name {
            /// All of them.
            pub const ALL: &[Self] = &[$(Self::$variant,)*];

            /// That of a word.
            pub fn from_word(word: &str) -> Option<Self> {
                Self::ALL.iter().copied().find(|one| one.as_str() == word)
            }

            /// The word that stands for it.
            pub const fn as_str(self) -> &'static str {
                match self {
                    $(Self::$variant => $word,)*
                }
            }
        }

        $crate::value::named!($name);
    )*};
}
pub(crate) use words;
