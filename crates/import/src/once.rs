//! The same recording counts once: by its content, within an import and in the whole study.

use super::context::{Context, Converted};
use super::errors::Errors;
use super::identity::{Cases, Identity};
use super::report::FileReport;
use std::collections::BTreeSet;
use std::path::Path;
use zwidth_store::{StoreError, files_below, readable_records, sweep_sources, trial_sources};

/// The files of which the study has no trial yet, and in words those that are there already, as the same
/// sessions: a glob may be given again when people were added.
///
/// # Errors
/// A recording from which another session's trial was made.
pub(super) fn new_trials<T>(
    context: &Context,
    files: Vec<Converted<T>>,
    identities: impl Fn(&T) -> Vec<&Identity>,
) -> Result<(Vec<Converted<T>>, Vec<FileReport>), Errors> {
    let sources = trial_sources(context.files, context.layout)?;
    let (mut new, mut existing, mut errors) = (Vec::new(), Vec::new(), Errors::default());
    for file in files {
        let Some(trials) = sources.get(&file.blake3) else {
            new.push(file);
            continue;
        };
        let sessions: BTreeSet<_> = trials.iter().map(|(who, session, _)| (who, session)).collect();
        let here: BTreeSet<_> =
            identities(&file.parsed).into_iter().map(|i| (&i.participant, &i.session)).collect();
        let words =
            trials.iter().map(|(who, session, trial)| format!("{who} {session} trial {trial}"));
        let words = words.collect::<Vec<_>>().join(", ");
        // The same sessions: the file was given again. Other ones: it would count twice.
        if here == sessions {
            existing.push(FileReport::there_already(&file.path, &words));
        } else {
            errors.push(imported_before(&file.path, &words));
        }
    }
    errors.none().map(|()| (new, existing))
}

/// Checks that no sweep of the study was imported from one of these recordings.
pub(super) fn sweeps<T>(context: &Context, files: &[Converted<T>]) -> Result<(), Errors> {
    let sources = sweep_sources(context.files, context.layout)?;
    let before = files
        .iter()
        .filter_map(|file| Some(imported_before(&file.path, sources.get(&file.blake3)?)));
    before.collect::<Errors>().none()
}

/// Checks that no session of the study has answers from the same columns of one of these tables.
pub(super) fn answers<'a, T: 'a>(
    context: &Context,
    tables: impl Iterator<Item = &'a Converted<T>>,
    columns: impl Fn(&T) -> &BTreeSet<usize>,
) -> Result<(), Errors> {
    let records = readable_records(context.files, context.layout)?;
    let mut seen = BTreeSet::new();
    let before = tables.filter(|table| seen.insert(&table.path)).filter_map(|table| {
        let record = records.iter().find(|record| {
            // A record that names no columns has all of them.
            let taken = &record.answer_columns;
            record.imported_from.contains(&table.blake3)
                && (taken.is_empty() || taken.iter().any(|at| columns(&table.parsed).contains(at)))
        })?;
        let first = format!("{} {}", record.participant, record.session);
        Some(imported_before(&table.path, &first))
    });
    before.collect::<Errors>().none()
}

fn imported_before(path: &Path, first: &str) -> StoreError {
    let what = format!("this recording was imported before, as {first}");
    StoreError::new(path, what, "leave the file out; a recording must not count twice")
}

/// The actuators that have sweeps.
pub(super) fn existing_actuators(context: &Context) -> Result<Cases, StoreError> {
    let mut cases = Cases::default();
    for path in files_below(context.files, &context.layout.sweeps())? {
        let folder = path.parent().and_then(Path::file_name).and_then(|name| name.to_str());
        if let Some(actuator) = folder.and_then(|name| name.strip_prefix("actuator=")) {
            cases.knows("", actuator);
        }
    }
    Ok(cases)
}

#[cfg(test)]
mod tests {
    use super::super::world::{FORCE, ONE, World, trials_map};
    use std::path::Path;

    const CSV: &str = "t,f\n0,1\n1,2\n";

    #[test]
    fn a_copy_a_link_and_another_way_to_write_its_path_are_the_same_recording() {
        let world = World::new();
        let first = world.file("a.csv", CSV);
        let copy = world.file("deeper/b.csv", CSV);
        let linked = first.with_file_name("c.csv");
        std::fs::hard_link(&first, &linked).unwrap();
        let dotted = first.parent().unwrap().join("./a.csv");
        for second in [&copy, &linked, &dotted, &first] {
            let files = [first.clone(), second.clone()];
            let errors = world.import(&trials_map(&[ONE, FORCE]), &files).unwrap_err();
            assert!(errors.len() == 1 && errors[0].path == *second, "{errors:?}");
            assert!(
                errors[0].what.contains("given twice") && errors[0].what.contains("a.csv has"),
                "{errors:?}"
            );
        }
        assert_eq!(world.written(), ["study.toml"]);
    }

    #[test]
    fn a_recording_that_the_study_has_under_another_name_is_refused_with_where_it_is() {
        let one = trials_map(&[ONE, FORCE]);
        let sweep = "kind = \"sweeps\"\n[sweep]\nactuator = \"brake\"\n[command]\nname = \"u\"\nunit = \"V\"\nfrom = \"t\"\n\
            [response]\nname = \"f\"\nunit = \"N\"\nfrom = \"f\"\n";
        let likert = "kind = \"likert\"\n[trial]\nparticipant = \"P01\"\nsession = \"S01\"\nenvironment = \"spring\"\n\
            mode = { column = \"m\" }\n[questions.columns]\nfelt_spring = 2\n";
        let answers = "m,a\nactive,3\npassive,4\n";
        for (map, ours, theirs, content, words) in [
            (one.as_str(), "S01", "S02", CSV, "imported before, as P01 S01 trial 1"),
            (one.as_str(), "P01", "P02", CSV, "imported before, as P01 S01 trial 1"),
            (sweep, "brake", "motor", CSV, "imported before, as sweep 1 of brake"),
            (likert, "S01", "S02", answers, "imported before, as P01 S01"),
        ] {
            let world = World::new();
            world.import(map, &[world.file("a.csv", content)]).unwrap();
            let before = world.written();
            let other = map.replace(ours, theirs);
            let errors = world.import(&other, &[world.file("b.csv", content)]).unwrap_err();
            assert!(errors.len() == 1 && errors[0].what.contains(words), "{errors:?}");
            assert_eq!(world.written(), before);
        }
    }

    #[test]
    fn a_glob_that_is_given_again_with_more_people_imports_what_is_new_and_says_what_was_there() {
        let world = World::new();
        let named = ONE.replace("\"P01\"", "{ name = \"who\" }");
        let map = trials_map(&["[name]\npattern = '(?<who>P\\d+)'\n", &named, FORCE]);
        let file = |n: u32| world.file(&format!("P0{n}.csv"), format!("t,f\n0,{n}\n1,2\n"));
        let mut files = vec![file(1), file(2)];
        world.import(&map, &files).unwrap();
        files.push(file(3));
        let report = world.import(&map, &files).unwrap();
        assert_eq!((report.trials, report.sessions, report.is_doubtful()), (1, 1, false));
        let text = report.to_string();
        assert!(
            text.contains("P02.csv: it is in the study already, as P02 S01 trial 1: left out"),
            "{text}"
        );
        let before = world.written();
        assert_eq!(world.import(&map, &files).unwrap().trials, 0);
        assert_eq!(world.written(), before);
    }

    #[test]
    fn a_recording_of_which_nothing_was_kept_may_come_again() {
        let world = World::new();
        let (map, file) = (trials_map(&[ONE, FORCE]), world.file("a.csv", CSV));
        world.import(&map, std::slice::from_ref(&file)).unwrap();
        for folder in [world.layout.trials(), world.layout.sessions()] {
            std::fs::remove_dir_all(folder).unwrap();
        }
        world.import(&map.replace("S01", "S02"), &[file]).unwrap();
        assert_eq!(world.load().counting().count(), 1);
        assert!(Path::new(&world.layout.trials()).join("participant=P01/session=S02").is_dir());
    }
}
