//! Diverging stacked bars: where each box begins and ends.

use crate::figure::LikertScale;

/// One answer's box in a row.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Segment {
    pub(crate) answer: usize,
    pub(crate) count: u32,
    pub(crate) from: f64,
    pub(crate) to: f64,
}

/// The boxes of one row from left to right, zero counts left out. Zero on the axis is the middle of
/// the neutral answer, or the border between the two halves if the number of answers is even.
pub(crate) fn segments(counts: &[u32], scale: LikertScale) -> Vec<Segment> {
    let total: f64 = counts.iter().map(|&count| f64::from(count)).sum();
    let unit = match scale {
        LikertScale::Percent if total > 0.0 => 100.0 / total,
        _ => 1.0,
    };
    let half = counts.len() / 2;
    let negative: f64 = counts[..half].iter().map(|&count| f64::from(count)).sum();
    let neutral = if counts.len() % 2 == 1 { f64::from(counts[half]) } else { 0.0 };
    // Counted in answers and scaled last: each box begins to the bit where the one before it ends.
    let mut edge = -(negative + neutral / 2.0);
    let mut segments = Vec::new();
    for (answer, &count) in counts.iter().enumerate() {
        let (from, to) = (edge * unit, (edge + f64::from(count)) * unit);
        edge += f64::from(count);
        if count > 0 {
            segments.push(Segment { answer, count, from, to });
        }
    }
    segments
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check_row(counts: &[u32], scale: LikertScale, expect: &[(usize, f64, f64)]) {
        let seen: Vec<_> =
            segments(counts, scale).iter().map(|s| (s.answer, s.from, s.to)).collect();
        assert_eq!(seen, expect);
    }

    #[test]
    fn the_neutral_box_straddles_zero_and_zero_counts_are_not_drawn() {
        check_row(
            &[1, 2, 4, 0, 3],
            LikertScale::Counts,
            &[(0, -5.0, -4.0), (1, -4.0, -2.0), (2, -2.0, 2.0), (4, 2.0, 5.0)],
        );
    }

    #[test]
    fn an_even_number_of_answers_meets_at_zero() {
        check_row(
            &[1, 2, 3, 4],
            LikertScale::Counts,
            &[(0, -3.0, -2.0), (1, -2.0, 0.0), (2, 0.0, 3.0), (3, 3.0, 7.0)],
        );
    }

    #[test]
    fn boxes_of_a_row_touch_and_add_up_to_all_answers() {
        for counts in [[3, 1, 4, 1, 5], [0, 0, 7, 0, 0], [9, 0, 0, 0, 1]] {
            for (scale, whole) in [
                (LikertScale::Counts, f64::from(counts.iter().sum::<u32>())),
                (LikertScale::Percent, 100.0),
            ] {
                let row = segments(&counts, scale);
                assert!(row.windows(2).all(|pair| pair[0].to == pair[1].from));
                let length: f64 = row.iter().map(|s| s.to - s.from).sum();
                assert!((length - whole).abs() < 1e-9);
            }
        }
    }
}
