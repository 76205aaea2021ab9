//! Scales of other lengths than five.

use crate::{Scheme, tally};
use zwidth_store::Answer;
use zwidth_study::{Condition, Study, StudyId, template};
use zwidth_tables::Table;

/// The template with a question from −3 to 3, one in steps of 5 up to 100 (which counts the other
/// way round), and one of five points.
fn scheme() -> Scheme {
    let text = template(&StudyId::new("demo").unwrap());
    let more = "[[questions]]\nid = \"mood\"\ntext = \"?\"\npoints = 7\nfrom = -3\nlabels = [\"bad\", \"good\"]\n\
                [[questions]]\nid = \"load\"\ntext = \"?\"\npoints = 21\nfrom = 0\nstep = 5\nreversed = true\n";
    Scheme::of(&Study::from_toml(&format!("{text}\n{more}")).unwrap())
}

fn given(question: &str, value: i16) -> Answer {
    Answer {
        participant: "P01".parse().unwrap(),
        session: "S01".parse().unwrap(),
        trial: 1,
        condition: Condition {
            environment: "spring".parse().unwrap(),
            mode: "active".parse().unwrap(),
        },
        question: question.parse().unwrap(),
        value,
        time_ms: None,
    }
}

fn cell(table: &Table, column: &str, row: usize) -> Option<i64> {
    table.integers(column).unwrap()[row]
}

#[test]
fn answers_below_zero_are_counted_from_the_lowest_on_and_keep_their_numbers_in_the_median() {
    let answers = [-3, -3, -2, 0, 3, 3].map(|value| given("mood", value));
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
    let answers = [0, 5, 20, 100].map(|value| given("load", value));
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
