//! How two quantities go together within people.

use crate::Unestimable;
use crate::error::{all_finite, check_level};
use crate::reference::normal_critical;
use crate::student_t::two_sided_p;
use crate::tested::{at_least, not_constant};

/// A correlation within people.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Correlation {
    /// r: of the deviations from everybody's own means.
    pub r: f64,
    /// Degrees of freedom: pairs less people less one.
    pub df: f64,
    /// Two-sided p value of "they do not go together".
    pub p_value: f64,
    /// The ends of its interval.
    pub ends: [f64; 2],
}

/// The repeated-measures correlation: everybody has a level of their own in both quantities and all share one slope
/// (Bland & Altman 1995, BMJ 310:446; Bakdash & Marusich 2017, Front. Psychol. 8:456). `people` has everybody's
/// pairs; who has one pair tells nothing. The interval is Fisher's, with a standard error of 1/√(df − 1).
///
/// # Errors
/// Fewer than three degrees of freedom; a quantity that does not change within anybody; a value that is not finite; a
/// level outside (0, 1).
pub fn within_people(people: &[Vec<[f64; 2]>], level: f64) -> Result<Correlation, Unestimable> {
    check_level(level)?;
    let (mut xx, mut yy, mut xy) = (0.0, 0.0, 0.0);
    let (mut pairs, mut persons) = (0, 0);
    let mut largest = [0.0_f64; 2];
    for own in people.iter().filter(|own| own.len() > 1) {
        all_finite(own.as_flattened())?;
        let mean = |i: usize| own.iter().map(|pair| pair[i]).sum::<f64>() / own.len() as f64;
        let [x, y] = [mean(0), mean(1)];
        for pair in own {
            xx += (pair[0] - x).powi(2);
            yy += (pair[1] - y).powi(2);
            xy += (pair[0] - x) * (pair[1] - y);
            largest = [largest[0].max(pair[0].abs()), largest[1].max(pair[1].abs())];
        }
        pairs += own.len();
        persons += 1;
    }
    at_least("pairs beyond one a participant", pairs - persons, 4)?;
    let is_flat = |squares: f64, largest: f64| squares.sqrt() <= 1e-12 * largest;
    not_constant("values within participants", is_flat(xx, largest[0]) || is_flat(yy, largest[1]))?;
    let df = (pairs - persons - 1) as f64;
    let r = (xy / (xx.sqrt() * yy.sqrt())).clamp(-1.0, 1.0);
    let t = r * (df / (1.0 - r * r).max(f64::EPSILON)).sqrt();
    let half = normal_critical(level)? / (df - 1.0).sqrt();
    // Of r = ±1 the interval is that point.
    let end = |sign: f64| if r.abs() < 1.0 { (r.atanh() + sign * half).tanh() } else { r };
    Ok(Correlation { r, df, p_value: two_sided_p(t, df)?, ends: [end(-1.0), end(1.0)] })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn people_with_other_levels_do_not_make_a_correlation() {
        // Between people larger values go with smaller ones; within them with larger ones, by one slope.
        let person =
            |level: f64| [0.0, 1.0, 2.0].map(|x| [x + level, 0.5 * x - 3.0 * level]).to_vec();
        let people: Vec<Vec<[f64; 2]>> = [0.0, 10.0, 20.0].map(person).to_vec();
        let found = within_people(&people, 0.95).unwrap();
        assert!((found.r - 1.0).abs() < 1e-12 && found.p_value < 1e-6);
        assert!((found.df - 5.0).abs() < 1e-12 && found.ends[1] <= 1.0);
    }

    #[test]
    fn what_has_no_correlation_says_why() {
        let words = |people: &[Vec<[f64; 2]>]| within_people(people, 0.95).unwrap_err().to_string();
        let alone = vec![vec![[1.0, 2.0]]; 20];
        assert_eq!(words(&alone), "0 pairs beyond one a participant, 4 are needed");
        let flat = vec![vec![[1.0, 2.0], [1.0, 3.0]]; 5];
        assert!(words(&flat).contains("values within participants are equal"), "{}", words(&flat));
        assert!(within_people(&[vec![[f64::NAN, 1.0], [1.0, 2.0]]], 0.95).is_err());
    }
}
