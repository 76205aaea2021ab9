//! Enumerations whose values have a word each: the one table of values and words.

/// Enumerations of values that have one word each.
#[macro_export]
macro_rules! worded {
    ($($(#[$doc:meta])* $name:ident { $($(#[$vdoc:meta])* $variant:ident = $word:literal,)* })*) => {$(
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum $name { $($(#[$vdoc])* $variant,)* }

        impl $name {
            /// Every value.
            pub const ALL: [Self; [$($word),*].len()] = [$(Self::$variant),*];

            /// The word as it is written in files.
            pub const fn as_str(self) -> &'static str {
                match self { $(Self::$variant => $word,)* }
            }

            /// The value of a word from a file, if it is one.
            pub fn from_word(word: &str) -> Option<Self> {
                match word { $($word => Some(Self::$variant),)* _ => None }
            }
        }
    )*};
}

/// The same in files that serde reads and writes.
macro_rules! words {
    ($($(#[$doc:meta])* $name:ident { $($values:tt)* })*) => {
        $crate::worded! {$(
            $(#[$doc])*
            #[derive(serde::Serialize, serde::Deserialize)]
            #[serde(rename_all = "snake_case")]
            $name { $($values)* }
        )*}
    };
}

pub(crate) use words;

#[cfg(test)]
mod tests {
    use crate::*;

    fn check<T: Copy + PartialEq + std::fmt::Debug + serde::Serialize>(
        all: &[T],
        word: fn(T) -> &'static str,
        from_word: fn(&str) -> Option<T>,
    ) {
        for value in all {
            let word = word(*value);
            assert_eq!(serde_json::to_string(value).unwrap(), format!("\"{word}\""));
            assert_eq!(from_word(word), Some(*value));
        }
        assert_eq!(from_word("made_up"), None);
    }

    #[test]
    fn every_value_has_one_word_in_files_and_in_code_which_reads_back_as_the_value() {
        check(&Kind::ALL, Kind::as_str, Kind::from_word);
        check(&Status::ALL, Status::as_str, Status::from_word);
        check(&Source::ALL, Source::as_str, Source::from_word);
        check(&ModeLaw::ALL, ModeLaw::as_str, ModeLaw::from_word);
        check(&SceneKind::ALL, SceneKind::as_str, SceneKind::from_word);
        check(&ActuatorKind::ALL, ActuatorKind::as_str, ActuatorKind::from_word);
        check(&Alignment::ALL, Alignment::as_str, Alignment::from_word);
        check(&Better::ALL, Better::as_str, Better::from_word);
        check(&EffectSize::ALL, EffectSize::as_str, EffectSize::from_word);
        check(&Moment::ALL, Moment::as_str, Moment::from_word);
        check(&Asks::ALL, Asks::as_str, Asks::from_word);
        check(&TaskSigmoid::ALL, TaskSigmoid::as_str, TaskSigmoid::from_word);
        check(&Statistic::ALL, Statistic::as_str, Statistic::from_word);
        check(&TrialPart::ALL, TrialPart::as_str, TrialPart::from_word);
    }
}
