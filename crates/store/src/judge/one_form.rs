//! Whether a study's trial files are all of one form. Files of two forms do not open as one data
//! set in other tools, so a study keeps the form with which it began.

use crate::disk::walk::parquet_below;
use crate::form::footer::read_footer_from;
use crate::{Files, Layout, StoreError, TrialEntry};
use zwidth_study::{Study, TrialForm};

/// Whether trials of the form that `study` asks for may join those that are there.
///
/// # Errors
/// They have another form: which one, and what to do.
pub fn check_form(files: &dyn Files, layout: &Layout, study: &Study) -> Result<(), StoreError> {
    let paths = parquet_below(files, &layout.trials())?;
    // What cannot be read is a finding of `verify`.
    let first = paths.iter().find_map(|path| read_footer_from(files, path).ok());
    let form = study.trial_form();
    match first.filter(|first| first.form != form) {
        None => Ok(()),
        Some(first) => {
            let what = format!(
                "it asks for trial files with {}, and those that are there have {}",
                words(&form),
                words(&first.form)
            );
            Err(StoreError::new(&layout.study_toml(), what, REMEDY))
        }
    }
}

const REMEDY: &str = "a study keeps the form it began with: put schema, channels and the number of \
                      questions back, or begin another study";

/// The trials that have another form than `study` asks for: they count, and other tools do not open
/// them together with the rest.
pub(crate) fn other_forms(
    layout: &Layout,
    study: &Study,
    trials: &[TrialEntry],
) -> Option<StoreError> {
    let form = study.trial_form();
    let mut other = trials.iter().filter(|trial| trial.said.form != form);
    let first = other.next()?;
    let n = 1 + other.count();
    let what = format!(
        "it asks for trial files with {}, and {n} of {} have others: {} has {}",
        words(&form),
        trials.len(),
        layout.shown(&first.path).display(),
        words(&first.said.form)
    );
    Some(StoreError::new(&layout.study_toml(), what, REMEDY))
}

/// A form in words.
fn words(form: &TrialForm) -> String {
    let likert = if form.likert { "a column for the answer" } else { "no column for the answer" };
    let channels: Vec<String> =
        form.channels.iter().map(|c| format!("{} ({})", c.id.as_str(), c.unit)).collect();
    let channels = if channels.is_empty() { "no channels".to_owned() } else { channels.join(", ") };
    format!("schema {}, {likert}, {channels}", form.schema.number())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::crashes::{
        FOUR, UTC, ended_as, folder_with_study, meta, protocol, rows, toml,
    };
    use crate::{
        Protocol, RealFiles, Signal, StudyData, TrialFile, read_channels, read_footer, read_trial,
        verify,
    };
    use std::path::PathBuf;
    use zwidth_study::{Extra, Sample};

    const SKIN: &str = "[[channels]]\nid = \"skin_c\"\nunit = \"°C\"\ndescription = \"the skin\"\n";

    /// The study with a channel of its own.
    fn with_skin(layout: &Layout) -> Study {
        let text = String::from_utf8(toml(layout)).unwrap();
        Study::from_toml(&format!("{text}\n{SKIN}")).unwrap()
    }

    /// Records trial 1 of P01 S01 as a protocol says.
    fn recorded(layout: &Layout, protocol: &Protocol, rows: &[Sample]) -> PathBuf {
        let journal = ended_as(&RealFiles, layout, &meta(1), &TrialFile::new(), protocol, rows);
        journal.finish(&RealFiles, layout, FOUR, UTC).unwrap().unwrap()
    }

    #[test]
    fn trials_of_another_form_than_the_study_asks_for_are_told_and_no_more_are_added() {
        let (_folder, layout) = folder_with_study();
        let other = with_skin(&layout);
        recorded(&layout, &Protocol { form: other.trial_form(), ..protocol() }, &rows(0, 20));
        // They count all the same.
        let data = StudyData::load(&layout).unwrap();
        assert_eq!((data.trials.len(), data.answers.len()), (1, 1));
        let [finding] = verify(&layout).try_into().unwrap();
        assert!(finding.what.contains("1 of 1 have others"), "{finding}");
        let form = "schema 2, no column for the answer, skin_c (°C)";
        assert!(finding.what.contains(form), "{finding}");
        let error = check_form(&RealFiles, &layout, &data.study).unwrap_err();
        assert!(error.remedy.contains("keeps the form it began with"), "{error}");
        assert_eq!(check_form(&RealFiles, &layout, &other), Ok(()));
    }

    #[test]
    fn where_several_questions_are_asked_an_answer_is_an_event_and_no_column() {
        let (_folder, layout) = folder_with_study();
        let path = recorded(&layout, &protocol(), &rows(0, 20));
        assert_eq!(read_trial(&path, []).unwrap().meta.likert, None);
        let (batch, _) = crate::read_parquet(&path).unwrap();
        assert!(batch.column_by_name("likert").is_none());
        let data = StudyData::load(&layout).unwrap();
        assert_eq!(data.answers[0].value, 4.into());
        assert_eq!(verify(&layout), []);
    }

    #[test]
    fn a_channel_comes_back_by_its_name_and_what_the_study_did_not_ask_for_does_not() {
        let (_folder, layout) = folder_with_study();
        let grip = "[[channels]]\nid = \"grip_n\"\nunit = \"N\"\ndescription = \"the grip\"\n";
        let text = String::from_utf8(toml(&layout)).unwrap();
        let study = Study::from_toml(&format!("{text}\n{grip}{SKIN}")).unwrap();
        let form = study.trial_form();
        let other = zwidth_study::Channel {
            id: "current_a".parse().unwrap(),
            unit: "A".to_owned(),
            description: "the motor's".to_owned(),
        };
        let given = vec![other, form.channels[0].clone()];
        let protocol = Protocol { form: form.clone(), given, ..protocol() };
        let mut rows = rows(0, 3);
        for (i, row) in rows.iter_mut().enumerate() {
            row.extra = Extra::new(&[7.0, i as f64]);
        }
        let path = recorded(&layout, &protocol, &rows);
        let [grip, skin] = ["grip_n", "skin_c"].map(|id| id.parse().unwrap());
        let trial = read_channels(&path, &[grip, skin]).unwrap();
        let found: Vec<_> = trial.samples.channels().collect();
        assert_eq!(found, [(&form.channels[0].id, [0.0, 1.0, 2.0].as_slice())]);
        assert!(read_channels(&path, &[]).unwrap().samples.channels().next().is_none());
        assert_eq!(read_footer(&path).unwrap().form, form);
        let (batch, footer) = crate::read_parquet(&path).unwrap();
        assert_eq!(batch.column_by_name("skin_c").unwrap().null_count(), 3);
        let schema = batch.schema();
        let field = schema.field_with_name("grip_n").unwrap();
        assert_eq!(field.metadata()["description"], "the grip");
        assert!(footer["units"].contains("\"skin_c\":\"°C\""));
    }

    #[test]
    fn a_footer_that_claims_more_channels_than_there_may_be_is_refused() {
        let (_folder, layout) = folder_with_study();
        let channel = |i: usize| zwidth_study::Channel {
            id: format!("c{i}").parse().unwrap(),
            unit: "1".to_owned(),
            description: "one too many".to_owned(),
        };
        let form = TrialForm { channels: (0..9).map(channel).collect(), ..TrialForm::default() };
        let path = recorded(&layout, &Protocol { form, ..protocol() }, &rows(0, 3));
        let error = read_footer(&path).unwrap_err();
        assert!(error.what.contains("it has 9, and at most 8 are read"), "{error}");
    }

    #[test]
    fn a_trial_of_more_than_a_million_rows_has_two_row_groups_and_comes_back() {
        use parquet::file::reader::{FileReader as _, SerializedFileReader};
        let n = (1 << 20) + 5;
        let mut samples = crate::Samples::default();
        samples.set(Signal::Time, (0..n).map(|i| i as f64 * 1e-3).collect());
        let trial = crate::Trial { meta: meta(1), file: TrialFile::new(), samples };
        let (_folder, layout) = folder_with_study();
        let path = layout.trial(&meta(1).participant, &meta(1).session, 1);
        let bytes = crate::trial_bytes(&trial, &TrialForm::default(), &path).unwrap();
        let reader = SerializedFileReader::new(bytes::Bytes::from(bytes.clone())).unwrap();
        assert_eq!(reader.metadata().num_row_groups(), 2);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(&path, bytes).unwrap();
        let again = read_trial(&path, [Signal::Time]).unwrap();
        assert!(again.samples == trial.samples);
    }
}
