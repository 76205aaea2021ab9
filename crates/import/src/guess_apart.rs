//! The files of a guess that differ from the others, such as a table of answers beside forty
//! recordings.

use super::guess_read::look_at_head;
use super::guess_words::are_answers;
use super::spelling::shown;
use rayon::prelude::*;
use std::path::{Path, PathBuf};
use zwidth_store::StoreError;

/// Columns that are named of a file that differs.
const MOST_NAMED: usize = 8;

/// Files, each list in the order of the command.
#[derive(Debug, Default)]
pub(super) struct Sorted {
    /// Files with the same columns as most others.
    pub(super) alike: Vec<PathBuf>,
    /// The others: what each is instead, and what to do with it.
    pub(super) apart: Vec<StoreError>,
}

/// A file's columns in the order of their names; only their number where it has no header.
type Columns = (Option<Vec<String>>, usize);

/// Parts files with the same columns as most others from the rest. Of two that are equally many the
/// one that comes first is meant.
pub(super) fn sort(files: &[PathBuf]) -> Sorted {
    let [_, _, ..] = files else {
        return Sorted { alike: files.to_vec(), apart: Vec::new() };
    };
    let listed: Vec<Result<Columns, StoreError>> =
        files.par_iter().map(|file| columns(file)).collect();
    let like =
        |columns: &Columns| listed.iter().flatten().filter(|other| *other == columns).count();
    let most = listed.iter().flatten().map(like).max();
    let usual = listed.iter().flatten().find(|columns| Some(like(columns)) == most);
    let mut sorted = Sorted::default();
    for (file, columns) in files.iter().zip(&listed) {
        match (columns, usual) {
            (Ok(columns), Some(usual)) if columns == usual => sorted.alike.push(file.clone()),
            (Ok(columns), _) => sorted.apart.push(other_columns(file, columns, most.unwrap_or(0))),
            (Err(error), _) => sorted.apart.push(error.clone()),
        }
    }
    sorted
}

fn columns(file: &Path) -> Result<Columns, StoreError> {
    let table = look_at_head(file)?.table;
    let names = table.names.map(|mut names| {
        // A mapping finds columns by name, in whatever order they stand.
        names.sort();
        names
    });
    Ok((names, table.columns.len()))
}

fn other_columns(file: &Path, (names, number): &Columns, most: usize) -> StoreError {
    let files = if most == 1 { "file".to_owned() } else { format!("{most} files") };
    let which = names.as_ref().map_or_else(
        || format!("{number}, without a header"),
        |names| {
            let named = names.iter().take(MOST_NAMED).map(|name| shown(name).into_owned());
            let more = if names.len() > MOST_NAMED { ", …" } else { "" };
            named.collect::<Vec<_>>().join(", ") + more
        },
    );
    let what = format!("its columns are not those of the other {files}: {which}");
    let remedy = if names.as_ref().is_some_and(|names| are_answers(names)) {
        "it looks like answers: if it says of the other files what they were, join it to them by [log] in the mapping; else \
         import the other files without it, and give its answers with `zwidth answer STUDY --from FILE`; answers to trials that nobody recorded have a mapping of their own, kind = \"likert\""
    } else {
        "leave it out of this import, and guess a mapping of its own for it"
    };
    StoreError::new(file, what, remedy)
}

#[cfg(test)]
mod tests {
    use super::super::world::World;
    use super::*;

    const RECORDING: &str = "t_s,theta_rad\n0,1\n1,2\n";

    /// The files that are alike, and what is told of the others.
    fn check(files: &[(&str, &str)], alike: &[&str], told: &[&str]) {
        let world = World::new();
        let files: Vec<PathBuf> =
            files.iter().map(|(name, content)| world.file(name, content)).collect();
        let sorted = sort(&files);
        let names = sorted.alike.iter().map(|file| file.file_name().unwrap().to_str().unwrap());
        assert_eq!(names.collect::<Vec<_>>(), alike);
        assert_eq!(sorted.apart.len(), told.len(), "{:#?}", sorted.apart);
        for (error, words) in sorted.apart.iter().zip(told) {
            assert!(error.to_string().contains(words), "'{words}' is not in\n{error}");
        }
    }

    #[test]
    fn answers_beside_recordings_are_told_apart_wherever_they_stand() {
        let ratings = ("a.csv", "participant;trial;rating\nP01;1;4\n");
        let told =
            "not those of the other 2 files: participant, rating, trial; it looks like answers";
        check(&[ratings, ("b.csv", RECORDING), ("c.csv", RECORDING)], &["b.csv", "c.csv"], &[told]);
        check(&[("b.csv", RECORDING), ratings, ("c.csv", RECORDING)], &["b.csv", "c.csv"], &[told]);
    }

    #[test]
    fn other_recordings_and_what_cannot_be_read_are_told_apart() {
        check(
            &[
                ("a.csv", RECORDING),
                ("b.csv", "theta_rad,t_s\n1,0\n2,1\n"),
                ("c.csv", "time,theta_rad,rating\n0,1,2\n"),
                ("d.mat", "no matrix"),
                ("e.csv", "0,1,2\n1,2,3\n"),
            ],
            &["a.csv", "b.csv"],
            &["leave it out of this import", "d.mat", "3, without a header; leave it out"],
        );
    }

    #[test]
    fn of_two_kinds_equally_many_the_first_is_meant() {
        let other = ("b.csv", "time,F_N\n0,1\n");
        check(&[("a.csv", RECORDING), other], &["a.csv"], &["those of the other file: F_N, time"]);
        check(&[other], &["b.csv"], &[]);
    }
}
