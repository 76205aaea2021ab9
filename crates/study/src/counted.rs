//! A number of things in words.

/// `2 participants`, `1 participant`, `1 trial of a mode`: `units` in the plural, its first word
/// one that has an s more there.
pub fn counted(n: usize, units: &str) -> String {
    let (noun, rest) = units.split_at(units.find(' ').unwrap_or(units.len()));
    let noun = if n == 1 { noun.strip_suffix('s').unwrap_or(noun) } else { noun };
    format!("{n} {noun}{rest}")
}

#[cfg(test)]
mod tests {
    use super::counted;

    #[test]
    fn one_is_singular_and_none_is_not() {
        assert_eq!(counted(1, "trials of a mode"), "1 trial of a mode");
        assert_eq!(counted(1, "participants"), "1 participant");
        assert_eq!(counted(0, "points"), "0 points");
        assert_eq!(counted(64, "points"), "64 points");
        assert_eq!(counted(1, ""), "1 ");
    }
}
