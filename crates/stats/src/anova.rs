//! One-way analysis of variance of independent groups.

use crate::error::{StatsError, all_finite};
use crate::f_distribution::upper_p;
use crate::tested::{FTest, Unestimable};

/// A table of a one-way analysis of variance. Sums of squares in the square of the values' unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OneWay {
    /// Σ nᵢ (ȳᵢ − ȳ)².
    pub between: f64,
    /// Σ Σ (yᵢⱼ − ȳᵢ)².
    pub within: f64,
    /// F = (between / (k − 1)) / (within / (n − k)), with its p value.
    pub test: FTest,
    /// between / (between + within).
    pub r2: f64,
    /// √(within / (n − k)), unit of the values.
    pub residual_sd: f64,
}

/// The analysis of variance of `groups`, each at least one value.
///
/// The first value is subtracted from all before anything is summed, which is exact for values that
/// differ in their last digits only: NIST's hardest data keep what their digits hold.
///
/// # Errors
/// Fewer than two groups or an empty one, no more values than groups, a value that is not finite,
/// values that do not differ within groups.
pub fn one_way(groups: &[&[f64]]) -> Result<OneWay, Unestimable> {
    let k = groups.len();
    let n = groups.iter().map(|g| g.len()).sum::<usize>();
    // An empty group has no mean, though the others might be compared.
    let filled = groups.iter().filter(|group| !group.is_empty()).count();
    if filled < 2 || filled < k {
        return Err(Unestimable::TooFew {
            units: "groups with values",
            found: filled,
            needed: k.max(2),
        });
    }
    if n <= k {
        return Err(Unestimable::TooFew { units: "values", found: n, needed: k + 1 });
    }
    groups.iter().try_for_each(|group| all_finite(group))?;
    let origin = groups[0][0];
    let shifted: Vec<Vec<f64>> =
        groups.iter().map(|group| group.iter().map(|v| v - origin).collect()).collect();
    let means: Vec<f64> =
        shifted.iter().map(|group| group.iter().sum::<f64>() / group.len() as f64).collect();
    let total = shifted.iter().flatten().sum::<f64>() / n as f64;
    let between: f64 =
        shifted.iter().zip(&means).map(|(g, mean)| g.len() as f64 * square(mean - total)).sum();
    let within: f64 = shifted
        .iter()
        .zip(&means)
        .map(|(group, mean)| group.iter().map(|v| square(v - mean)).sum::<f64>())
        .sum();
    if within <= 0.0 {
        return Err(Unestimable::Constant { units: "values of a group" });
    }
    let df_num = (k - 1) as f64;
    let df_den = (n - k) as f64;
    let statistic = between / df_num / (within / df_den);
    let p_value = upper_p(statistic, df_num, df_den)?;
    Ok(OneWay {
        between,
        within,
        test: FTest { statistic, df_num, df_den, p_value },
        r2: between / (between + within),
        residual_sd: (within / df_den).sqrt(),
    })
}

fn square(x: f64) -> f64 {
    x * x
}

/// Checks that a table has at least two rows and two columns, all rows of one length, all values
/// finite. `row_units` and `column_units` say in messages what rows and columns are.
pub(crate) fn check_table(
    table: &[Vec<f64>],
    row_units: &'static str,
    column_units: &'static str,
) -> Result<(), Unestimable> {
    if table.len() < 2 {
        return Err(Unestimable::TooFew { units: row_units, found: table.len(), needed: 2 });
    }
    let expected = table[0].len();
    for (row, values) in table.iter().enumerate() {
        if values.len() != expected {
            return Err(StatsError::Ragged { row, expected, found: values.len() }.into());
        }
        all_finite(values)?;
    }
    if expected < 2 {
        return Err(Unestimable::TooFew { units: column_units, found: expected, needed: 2 });
    }
    Ok(())
}

/// The two-way decomposition of a complete table without repeats.
pub(crate) struct TwoWay {
    /// Sum of squares between rows, times columns.
    pub(crate) rows: f64,
    /// Sum of squares between columns, times rows.
    pub(crate) columns: f64,
    /// The remaining sum of squares.
    pub(crate) error: f64,
    /// Σ (y − ȳ)², which tells what of `error` is rounding.
    pub(crate) total: f64,
}

/// A sum of squares below this share of the total is rounding.
pub(crate) const ROUNDING: f64 = 1e-24;

/// Decomposes a checked table.
pub(crate) fn two_way(table: &[Vec<f64>]) -> TwoWay {
    let n = table.len();
    let k = table[0].len();
    // Far from zero the squares would lose the digits in which values differ.
    let origin = table[0][0];
    let of_row: Vec<f64> =
        table.iter().map(|row| row.iter().map(|v| v - origin).sum::<f64>() / k as f64).collect();
    let of_column: Vec<f64> =
        (0..k).map(|j| table.iter().map(|row| row[j] - origin).sum::<f64>() / n as f64).collect();
    let mean = of_row.iter().sum::<f64>() / n as f64;
    let mut sums = TwoWay {
        rows: k as f64 * of_row.iter().map(|m| square(m - mean)).sum::<f64>(),
        columns: n as f64 * of_column.iter().map(|m| square(m - mean)).sum::<f64>(),
        error: 0.0,
        total: 0.0,
    };
    for (row, of_row) in table.iter().zip(&of_row) {
        for (value, of_column) in row.iter().zip(&of_column) {
            let value = value - origin;
            sums.error += square(value - of_row - of_column + mean);
            sums.total += square(value - mean);
        }
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Simon & Lesage's data by the rule that NIST StRD gives: nine groups around 1.4, 1.3, 1.5,
    /// 1.3, 1.5, …, each its centre once and then 0.1 below and above in turn, all far from zero.
    fn simon_lesage(offset: f64, size: usize) -> Vec<Vec<f64>> {
        // in tenths, so that each value is the number that NIST prints, to rounding
        let centre = |group: usize| match group {
            0 => 4,
            odd if odd % 2 == 1 => 3,
            _ => 5,
        };
        let value = |centre: i32, i: usize| match i {
            0 => centre,
            odd if odd % 2 == 1 => centre - 1,
            _ => centre + 1,
        };
        (0..9)
            .map(|g| {
                let number = |i| format!("{}.{}", offset, value(centre(g), i)).parse().unwrap();
                (0..size).map(number).collect()
            })
            .collect()
    }

    /// NIST StRD, SmLs01 to SmLs09. The rule makes the table a closed form: with k values in a
    /// group between 0.08 k, within 0.09 (k − 1), so F = k, which are the certified 21, 201 and
    /// 2001.
    #[test]
    fn simon_and_lesages_data_have_their_certified_table() {
        for (offset, digits) in [(1.0, 1e-12), (1_000_000.0, 1e-8), (1_000_000_000_000.0, 5e-3)] {
            for size in [21, 201, 2001] {
                let groups = simon_lesage(offset, size);
                let groups: Vec<&[f64]> = groups.iter().map(Vec::as_slice).collect();
                let found = one_way(&groups).unwrap();
                let (between, within) = (0.08 * size as f64, 0.09 * (size - 1) as f64);
                for (found, certified) in [
                    (found.test.statistic, size as f64),
                    (found.between, between),
                    (found.within, within),
                    (found.residual_sd, 0.1),
                    (found.r2, between / (between + within)),
                ] {
                    let error = (found / certified - 1.0).abs();
                    assert!(error < digits, "{offset} {size}: {found} for {certified}");
                }
                assert_eq!(
                    (found.test.df_num as usize, found.test.df_den as usize),
                    (8, 9 * (size - 1))
                );
            }
        }
    }

    /// NIST StRD, AtmWtAg: the atomic weight of silver on two instruments (Powell, Murphy &
    /// Gramlich 1982, NBS J. Res. 87:9); seven digits are the same throughout.
    const SILVER: [[f64; 24]; 2] = [
        [
            107.868_156_8,
            107.868_146_5,
            107.868_157_2,
            107.868_178_5,
            107.868_144_6,
            107.868_190_3,
            107.868_152_6,
            107.868_149_4,
            107.868_161_6,
            107.868_158_7,
            107.868_151_9,
            107.868_148_6,
            107.868_141_9,
            107.868_156_9,
            107.868_150_8,
            107.868_167_2,
            107.868_138_5,
            107.868_151_8,
            107.868_166_2,
            107.868_142_4,
            107.868_136_0,
            107.868_133_3,
            107.868_161_0,
            107.868_147_7,
        ],
        [
            107.868_107_9,
            107.868_134_4,
            107.868_151_3,
            107.868_119_7,
            107.868_160_4,
            107.868_138_5,
            107.868_164_2,
            107.868_136_5,
            107.868_115_1,
            107.868_108_2,
            107.868_151_7,
            107.868_144_8,
            107.868_119_8,
            107.868_148_2,
            107.868_133_4,
            107.868_160_9,
            107.868_110_1,
            107.868_151_2,
            107.868_146_9,
            107.868_136_0,
            107.868_125_4,
            107.868_126_1,
            107.868_145_0,
            107.868_136_8,
        ],
    ];

    /// NIST StRD, SiRstv: the resistivity of silicon wafers on five instruments (Ehrstein &
    /// Croarkin).
    const SILICON: [[f64; 5]; 5] = [
        [196.305_2, 196.124_0, 196.189_0, 196.256_9, 196.340_3],
        [196.304_2, 196.382_5, 196.166_9, 196.325_7, 196.042_2],
        [196.130_3, 196.200_5, 196.288_9, 196.034_3, 196.181_1],
        [196.279_5, 196.174_8, 196.149_4, 196.148_5, 195.988_5],
        [196.211_9, 196.105_1, 196.185_0, 196.005_2, 196.209_0],
    ];

    /// F, the sums of squares between and within, R² and the residual SD as NIST certifies them.
    /// The data of silver differ from the eighth digit on, so that a last bit of a value is 1e-9 of
    /// their spread.
    #[test]
    fn observed_data_have_their_certified_tables() {
        let check = |groups: &[&[f64]], certified: [f64; 5], digits: f64| {
            let found = one_way(groups).unwrap();
            let OneWay { between, within, test, r2, residual_sd } = found;
            for (found, certified) in
                [test.statistic, between, within, r2, residual_sd].into_iter().zip(certified)
            {
                assert!((found / certified - 1.0).abs() < digits, "{found} for {certified}");
            }
            let values: usize = groups.iter().map(|group| group.len()).sum();
            assert_eq!(test.df_num as usize, groups.len() - 1);
            assert_eq!(test.df_den as usize, values - groups.len());
        };
        let silver = [
            1.594_673_356_779_30e1,
            3.638_341_875_000_00e-9,
            1.049_517_291_666_67e-8,
            2.574_265_445_383_21e-1,
            1.510_483_144_464_10e-5,
        ];
        check(&SILVER.each_ref().map(|group| group.as_slice()), silver, 1e-8);
        let silicon = [
            1.180_462_374_402_55,
            5.114_626_160_000_00e-2,
            2.166_365_600_000_00e-1,
            1.909_990_390_511_29e-1,
            1.040_760_683_346_56e-1,
        ];
        check(&SILICON.each_ref().map(|group| group.as_slice()), silicon, 1e-11);
    }

    #[test]
    fn two_groups_have_the_square_of_students_t() {
        let found = one_way(&[&[1.0, 2.0, 4.0], &[3.0, 5.0, 7.0, 6.0]]).unwrap();
        // sums of squares 14/3 and 8.75 about the means 7/3 and 5.25
        let (a, b) = (7.0 / 3.0, 5.25);
        let pooled = (14.0 / 3.0 + 8.75) / 5.0;
        let t = (a - b) / f64::sqrt(pooled * (1.0 / 3.0 + 1.0 / 4.0));
        assert!((found.test.statistic - t * t).abs() < 1e-12);
    }

    #[test]
    fn what_cannot_be_said_is_said() {
        assert!(matches!(one_way(&[&[1.0]]), Err(Unestimable::TooFew { .. })));
        assert!(matches!(one_way(&[&[1.0], &[]]), Err(Unestimable::TooFew { .. })));
        assert!(matches!(one_way(&[&[1.0], &[2.0]]), Err(Unestimable::TooFew { .. })));
        assert!(matches!(one_way(&[&[1.0, 1.0], &[2.0]]), Err(Unestimable::Constant { .. })));
        assert!(matches!(one_way(&[&[f64::NAN, 1.0], &[2.0]]), Err(Unestimable::Refused(_))));
    }
}
