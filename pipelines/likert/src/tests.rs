//! Scales of other lengths than five.

use crate::{LikertError, Scheme, long_table, tally_table};
use proptest::prelude::*;
use zwidth_results::{AnswerTally, GivenAnswer};
use zwidth_store::Answer;
use zwidth_study::{AnswerValue, Condition, Study, StudyId, template};
use zwidth_tables::Table;

/// The template with a question from −3 to 3, one in steps of 5 up to 100 (which counts the other
/// way round), and one of five points.
fn scheme() -> Scheme {
    let text = template(&StudyId::new("demo").unwrap());
    let more = "[[questions]]\nid = \"mood\"\ntext = \"?\"\npoints = 7\nfrom = -3\nlabels = [\"bad\", \"good\"]\n\
                [[questions]]\nid = \"load\"\ntext = \"?\"\npoints = 21\nfrom = 0\nstep = 5\nreversed = true\n";
    Scheme::of(&Study::from_toml(&format!("{text}\n{more}")).unwrap())
}

pub(crate) fn answer(
    participant: &str,
    mode: &str,
    question: &str,
    value: impl Into<AnswerValue>,
) -> Answer {
    Answer {
        participant: participant.parse().unwrap(),
        session: "S01".parse().unwrap(),
        trial: 7,
        condition: Condition {
            environment: "spring".parse().unwrap(),
            mode: mode.parse().unwrap(),
        },
        question: question.parse().unwrap(),
        value: value.into(),
        time_ms: None,
    }
}

fn given(question: &str, value: impl Into<AnswerValue>) -> Answer {
    answer("P01", "active", question, value)
}

/// The table of the counts.
fn tally(answers: &[Answer], scheme: &Scheme) -> Result<Table, LikertError> {
    let rows = crate::tally(answers, scheme)?;
    let table = tally_table(&rows, scheme)?;
    assert_eq!(table.to_rows::<AnswerTally>().unwrap(), rows);
    Ok(table)
}

/// The table of the answers themselves.
fn long(answers: &[Answer], scheme: &Scheme) -> Table {
    let rows = crate::long(answers, &[]);
    let table = long_table(&rows, scheme).unwrap();
    assert_eq!(table.to_rows::<GivenAnswer>().unwrap(), rows);
    table
}

fn cell(table: &Table, column: &str, row: usize) -> Option<i64> {
    table.integers(column).unwrap()[row]
}

#[test]
fn answers_below_zero_are_counted_from_the_lowest_on_and_keep_their_numbers_in_the_median() {
    let answers = [-3, -3, -2, 0, 3, 3_i16].map(|value| given("mood", value));
    let table = tally(&answers, &scheme()).unwrap();
    let counts =
        ["count_1", "count_2", "count_3", "count_4", "count_7"].map(|c| cell(&table, c, 0));
    assert_eq!(counts, [Some(2), Some(1), Some(0), Some(1), Some(2)]);
    assert_eq!(
        [cell(&table, "median_low", 0), cell(&table, "median_high", 0)],
        [Some(-2), Some(0)]
    );
    let about = &table.column("count_1").unwrap().field.description;
    assert_eq!(about.as_ref(), "answers at point 1 as scored: 1 (strongly disagree), -3 (bad)");
    assert!(
        table.title().contains("scale from -3 to 3")
            && table.title().contains("lowest + highest - a")
    );
}

#[test]
fn a_scale_of_many_points_has_quartiles_and_a_mean_in_the_place_of_counts() {
    let answers = [0, 5, 20, 100_i16].map(|value| given("load", value));
    let table = tally(&answers, &scheme()).unwrap();
    assert!((1..=7).all(|point| cell(&table, &format!("count_{point}"), 0).is_none()));
    assert!(table.integers("count_8").is_err(), "no count of a point of the long scale");
    let of = |column: &str| table.floats(column).unwrap()[0].unwrap();
    // turned round: 100, 95, 80, 0
    assert_eq!(
        ["lowest", "highest", "mean"].map(of).map(f64::to_bits),
        [0.0, 100.0, 68.75].map(f64::to_bits)
    );
    assert_eq!(
        ["quartile_1", "quartile_3"].map(of).map(f64::to_bits),
        [60.0, 96.25].map(f64::to_bits)
    );
    assert_eq!(
        [cell(&table, "median_low", 0), cell(&table, "median_high", 0)],
        [Some(80), Some(95)]
    );
    assert!(table.notes().iter().any(|note| note.contains("more than 11 points")));
}

#[test]
fn an_answer_between_the_steps_of_a_scale_is_refused() {
    let error = tally(&[given("load", 7)], &scheme()).unwrap_err().to_string();
    assert!(error.contains("0 to 100 in steps of 5"), "{error}");
}

/// A study with a line from 0 to 100, and one of five points.
fn with_line() -> Scheme {
    let text = template(&StudyId::new("demo").unwrap());
    let line = "[[questions]]\nid = \"line\"\ntext = \"?\"\npoints = 101\nfrom = 0\n";
    Scheme::of(&Study::from_toml(&format!("{text}\n{line}")).unwrap())
}

fn on_line(numbers: &[f64]) -> Vec<Answer> {
    numbers.iter().map(|number| given("line", AnswerValue::new(*number).unwrap())).collect()
}

/// NumPy: `np.quantile([12.5, 33.333, 47.273, 47.273, 52.1, 100], [0, 0.25, 0.75, 1])`, `np.mean`,
/// `np.std(ddof=1)`.
#[test]
fn answers_on_a_line_are_summed_up_by_their_own_numbers() {
    let answers = on_line(&[47.273, 100.0, 12.5, 52.1, 33.333, 47.273]);
    let table = tally(&answers, &with_line()).unwrap();
    let of = |column: &str| table.floats(column).unwrap()[0].unwrap();
    let medians = ["median_low", "median_high"].map(|column| table.floats(column).unwrap()[0]);
    assert_eq!(medians, [Some(47.273); 2]);
    for (column, numpy) in [
        ("lowest", 12.5),
        ("quartile_1", 36.818),
        ("quartile_3", 50.893_25),
        ("highest", 100.0),
        ("mean", 48.746_5),
        ("sd", 28.961_679_417_810_01),
    ] {
        assert!((of(column) - numpy).abs() < 1e-12, "{column}: {}", of(column));
    }
    let numbers = long(&answers, &with_line()).floats("answer").unwrap();
    assert_eq!(numbers[..2], [Some(47.273), Some(100.0)]);
}

#[test]
fn columns_of_answers_are_whole_numbers_in_a_study_without_a_line() {
    for (scheme, decimals) in [(scheme(), false), (with_line(), true)] {
        let answers = [given("felt_spring", 4_i16)];
        let (tally, long) = (tally(&answers, &scheme).unwrap(), long(&answers, &scheme));
        for (table, column) in [(&tally, "median_low"), (&tally, "median_high"), (&long, "answer")]
        {
            let whole = table.integers(column).ok();
            assert_eq!(whole, (!decimals).then(|| vec![Some(4)]), "{column}");
            assert_eq!(table.numbers(column).unwrap(), [Some(4.0)], "{column}");
        }
    }
}

#[test]
fn an_answer_off_a_line_is_refused() {
    let error = tally(&on_line(&[100.5]), &with_line()).unwrap_err().to_string();
    assert!(error.contains("the answer 100.5 to 'line' is not on its scale, 0 to 100"), "{error}");
}

proptest! {
    /// Counted point by point, which is all that whole answers need.
    #[test]
    fn whole_answers_on_a_line_are_summed_up_as_counts_of_its_points(
        given in proptest::collection::vec(0..=100_i16, 1..40)
    ) {
        let numbers: Vec<f64> = given.iter().map(|n| f64::from(*n)).collect();
        let table = tally(&on_line(&numbers), &with_line()).unwrap();
        let of = |column: &str| table.floats(column).unwrap()[0];
        let mut counts = [0_usize; 101];
        given.iter().for_each(|n| counts[*n as usize] += 1);
        let each = || counts.iter().enumerate().map(|(point, n)| (point as f64, *n as f64));
        let n = given.len() as f64;
        let mean = each().map(|(point, count)| point * count).sum::<f64>() / n;
        let squares: f64 = each().map(|(x, count)| count * (x - mean) * (x - mean)).sum();
        let ranked = |rank: usize| {
            let mut below = 0;
            counts.iter().position(|count| { below += count; rank < below }).map(|at| at as f64)
        };
        prop_assert_eq!(of("mean"), Some(mean));
        prop_assert_eq!(of("sd"), (n > 1.0).then(|| (squares / (n - 1.0)).sqrt()));
        prop_assert_eq!(of("median_low"), ranked((given.len() - 1) / 2));
        prop_assert_eq!(of("median_high"), ranked(given.len() / 2));
        prop_assert_eq!([of("lowest"), of("highest")], [ranked(0), ranked(given.len() - 1)]);
    }
}
