//! Whether several means are zero, whatever their covariances.

use crate::error::all_finite;
use crate::f_distribution::upper_p;
use crate::tested::at_least;
use crate::{FTest, Unestimable};
use zwidth_numerics::dense::{Matrix, dot};

/// Hotelling's test that the mean of each column of `people`, a row per person, is zero: T² = n x̄ᵀ S⁻¹ x̄, F = T² (n − p) / (p (n
/// − 1)) with p and n − p degrees of freedom (Hotelling 1931, Ann. Math. Stat. 2:360).
///
/// # Errors
/// No column; no more people than columns and one; rows of different length; a value that is not finite; columns
/// of which one follows from the others.
pub fn test(people: &[Vec<f64>]) -> Result<FTest, Unestimable> {
    let n = people.len();
    let p = people.first().map_or(0, Vec::len);
    at_least("columns", p, 1)?;
    at_least("participants", n, p + 2)?;
    for (row, values) in people.iter().enumerate() {
        if values.len() != p {
            return Err(crate::StatsError::Ragged { row, expected: p, found: values.len() }.into());
        }
        all_finite(values)?;
    }
    let [people_n, columns] = [n, p].map(|count| count as f64);
    let mean: Vec<f64> =
        (0..p).map(|i| people.iter().map(|row| row[i]).sum::<f64>() / people_n).collect();
    // In standard deviations, so that the covariances are correlations.
    let sd: Vec<f64> = (0..p)
        .map(|i| {
            let squares: f64 = people.iter().map(|row| (row[i] - mean[i]).powi(2)).sum();
            (squares / (people_n - 1.0)).sqrt()
        })
        .collect();
    let correlation = Matrix::from_fn(p, p, |i, j| {
        let products = people.iter().map(|row| (row[i] - mean[i]) * (row[j] - mean[j]));
        products.sum::<f64>() / (people_n - 1.0) / (sd[i] * sd[j])
    });
    let constant = Unestimable::Constant { units: "participants in one of several contrasts" };
    if sd.iter().any(|sd| *sd <= 0.0) {
        return Err(constant);
    }
    // Nearly singular correlations have no inverse that could be trusted.
    let Some(triangle) = correlation.cholesky(1e-10) else { return Err(constant) };
    let scaled: Vec<f64> = mean.iter().zip(&sd).map(|(mean, sd)| mean / sd).collect();
    let t2 = people_n * dot(&scaled, &triangle.solve_by_triangle(&scaled));
    let (df_num, df_den) = (columns, people_n - columns);
    let statistic = t2 * df_den / (columns * (people_n - 1.0));
    Ok(FTest { statistic, df_num, df_den, p_value: upper_p(statistic, df_num, df_den)? })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of one column it is Student's t², and whatever the columns' scales it is the same.
    #[test]
    fn one_column_is_students_t_and_scales_change_nothing() {
        let one: Vec<Vec<f64>> = [0.3, 1.2, -0.4, 0.9, 0.5].map(|x| vec![x]).to_vec();
        let found = test(&one).unwrap();
        // mean 0.5, SD 0.6123724.
        let t = 0.5 / (0.6123724 / 5.0_f64.sqrt());
        assert!((found.statistic - t * t).abs() < 1e-5 && (found.df_den - 4.0).abs() < 1e-12);
        let two: Vec<Vec<f64>> = (0..6)
            .map(|i| {
                let x = f64::from(i);
                vec![0.4 + (2.0 * x).sin(), 0.1 + (3.0 * x).cos()]
            })
            .collect();
        let scaled: Vec<Vec<f64>> =
            two.iter().map(|row| vec![1e-6 * row[0], 1e5 * (row[1] + row[0])]).collect();
        let [plain, scaled] = [two, scaled].map(|rows| test(&rows).unwrap().statistic);
        assert!((plain / scaled - 1.0).abs() < 1e-9, "{plain} {scaled}");
    }

    /// Eight people at four doses, three repeats, by formula; NumPy by definition.
    #[test]
    fn all_contrasts_of_a_dose_are_those_of_numpy() {
        let u = |of: [u64; 3]| {
            let h = 1 + 131 * of[0] + 173 * of[1] + 197 * of[2];
            (h * h * h % 9941) as f64 / 9941.0 - 0.5
        };
        let mean = |person: u64, l: u64, x: f64| {
            let repeats = (1..=3).map(|repeat| {
                let y = 0.5 + 0.004 * x - 0.000_003 * x * x
                    + 0.6 * u([person, 0, 0])
                    + 0.003 * u([person, 7, 0]) * x
                    + 0.3 * u([person, l, 0])
                    + 0.3 * u([person, l, repeat]);
                (y * 1000.0).round() / 1000.0
            });
            repeats.sum::<f64>() / 3.0
        };
        let people: Vec<Vec<f64>> = (1..=8)
            .map(|person| {
                let doses = [100.0, 150.0, 250.0, 400.0];
                let means: Vec<f64> = (1..).zip(doses).map(|(l, x)| mean(person, l, x)).collect();
                means[1..].iter().map(|own| own - means[0]).collect()
            })
            .collect();
        let found = test(&people).unwrap();
        assert!((found.statistic - 23.2154895).abs() < 1e-5, "{found:?}");
        assert!((found.p_value - 0.00230820166).abs() < 1e-9 && found.df_den > 4.9);
    }

    #[test]
    fn what_has_no_test_says_why() {
        let words = |rows: &[Vec<f64>]| test(rows).unwrap_err().to_string();
        assert_eq!(words(&[vec![1.0], vec![2.0]]), "2 participants, 3 are needed");
        assert!(test(&[]).is_err());
        let doubled: Vec<Vec<f64>> =
            (0..6).map(|i| vec![f64::from(i), 2.0 * f64::from(i)]).collect();
        assert!(words(&doubled).contains("equal"));
    }
}
