//! Names near a mistyped one.

use strsim::normalized_damerau_levenshtein;

/// Names that share less than this with the typed one are no help: half of the letters.
const ALIKE: f64 = 0.5;
/// The most names that are suggested.
const MOST: usize = 3;

/// The names most like `typed`, best first; none that is not alike.
pub(super) fn near<'a>(typed: &str, names: impl IntoIterator<Item = &'a str>) -> Vec<&'a str> {
    let mut alike: Vec<(f64, &str)> = names
        .into_iter()
        .map(|name| (normalized_damerau_levenshtein(typed, name), name))
        .filter(|(share, _)| *share >= ALIKE)
        .collect();
    alike.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(b.1)));
    // Equal names stand side by side after the sort.
    alike.dedup();
    alike.into_iter().map(|(_, name)| name).take(MOST).collect()
}

/// As a clause: `; did you mean a, b?`, or nothing.
pub(super) fn did_you_mean<'a>(typed: &str, names: impl IntoIterator<Item = &'a str>) -> String {
    match near(typed, names).as_slice() {
        [] => String::new(),
        names => format!("; did you mean {}?", names.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_names_most_alike_come_first_and_those_unlike_not_at_all() {
        let names = [
            "likert",
            "loops.P01.S01",
            "modes.P01.S01.spring",
            "modes.P01.S01.spring_wall",
            "metrics",
        ];
        assert_eq!(near("mods.P01.S01.spring", names)[0], "modes.P01.S01.spring");
        assert_eq!(near("metric", names), ["metrics"]);
        assert!(near("nonsense", names).is_empty());
        assert_eq!(did_you_mean("liket", names), "; did you mean likert?");
        assert_eq!(did_you_mean("zzz", names), "");
    }
}
