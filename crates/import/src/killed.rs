//! An import is killed, or the power is cut, at every step of its writing; the next import succeeds
//! without manual repair, and each recording counts once.

use super::world::{BY, COLUMNS, FORCE, ONE, UTC, template_once, trials_map};
use super::{Mapping, Report, import};
use rayon::prelude::*;
use std::path::{Path, PathBuf};
use tempfile::TempDir;
use zwidth_store::{Fault, Layout, Memory, StoreError, StudyData, Survives, recover, verify_from};
use zwidth_study::{Study, StudyId};

/// An import into a study in memory, of files on the disk.
struct Case {
    _folder: TempDir,
    mapping: Mapping,
    files: Vec<PathBuf>,
    /// Imported before, in order.
    before: Vec<PathBuf>,
    /// Trials that count, sweeps and answers, at the end.
    whole: (usize, usize, usize),
}

const SWEEPS: &str = "kind = \"sweeps\"\n[sweep]\nactuator = \"brake\"\nsweep = { column = \"n\" }\n\
    [command]\nname = \"u\"\nunit = \"V\"\nfrom = \"t\"\n[response]\nname = \"f\"\nunit = \"N\"\nfrom = \"f\"\n";
const LIKERT: &str = "kind = \"likert\"\n[trial]\nparticipant = { column = \"who\" }\nsession = \"S01\"\n\
    environment = \"spring\"\nmode = { column = \"mode\" }\n[questions.columns]\nfelt_spring = 3\n";

impl Case {
    fn new(map: &str, contents: &[&str], before: usize, whole: (usize, usize, usize)) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let file = |(i, content): (usize, &&str)| {
            let path = folder.path().join(format!("{i}.csv"));
            std::fs::write(&path, content).unwrap();
            path
        };
        let mut files: Vec<PathBuf> = contents.iter().enumerate().map(file).collect();
        let rest = files.split_off(before);
        let mapping = Mapping::from_toml(map, Path::new("map.toml")).unwrap();
        Self { _folder: folder, mapping, files: rest, before: files, whole }
    }

    /// One trial.
    fn one() -> Self {
        Self::new(&trials_map(&[ONE, FORCE]), &["t,f\n0,1\n1,2\n"], 0, (1, 0, 0))
    }

    /// Three trials of two participants.
    fn trials() -> Self {
        let head = "who,mode,n,kind,q,t,f\n";
        let one = format!(
            "{head}P01,active,1,trial,3,0,1\nP01,active,1,trial,3,1,1\nP02,active,1,trial,3,0,1\n"
        );
        let two = format!("{head}P01,passive,2,trial,4,0,1\n");
        Self::new(&trials_map(&[COLUMNS, FORCE]), &[&one, &two], 0, (3, 0, 3))
    }

    /// Two sweeps beside one that is there.
    fn sweeps() -> Self {
        Self::new(SWEEPS, &["n,t,f\n7,0,1\n", "n,t,f\n1,0,1\n2,0,1\n"], 1, (0, 3, 0))
    }

    /// The first sweep of a study.
    fn first_sweep() -> Self {
        Self::new(SWEEPS, &["n,t,f\n1,0,1\n"], 0, (0, 1, 0))
    }

    /// Questionnaires of two participants.
    fn likert() -> Self {
        let table = "who,mode,a\nP01,active,1\nP02,active,2\nP01,passive,3\n";
        Self::new(LIKERT, &[table], 0, (0, 0, 3))
    }

    /// A study with what was imported before.
    fn study(&self) -> (Memory, Layout) {
        let disk = Memory::new();
        let layout = Layout::new(Path::new("/root"), StudyId::new("demo").unwrap());
        disk.put(&layout.study_toml(), template_once().as_bytes());
        if !self.before.is_empty() {
            self.import(&disk, &layout, &self.before).unwrap();
        }
        (disk, layout)
    }

    fn import(
        &self,
        disk: &Memory,
        layout: &Layout,
        files: &[PathBuf],
    ) -> Result<Report, Vec<StoreError>> {
        let study = Study::from_toml(&template_once()).unwrap();
        Ok(import(layout, &study, &self.mapping, files, BY, disk, &|_| {})?)
    }

    /// The import, killed at step `n`, and what is then done with what stands on the disk: whether the
    /// kill came before its end, and what came of that.
    fn killed<T>(
        &self,
        n: u64,
        end: Survives,
        then: impl FnOnce(&Memory, &Layout) -> T,
    ) -> (bool, T) {
        let (disk, layout) = self.study();
        disk.fail_in(n, Fault::End);
        let _ = self.import(&disk, &layout, &self.files);
        // A head that cannot be written is no error, and the kill came all the same.
        let killed = disk.has_failed();
        disk.restart(end);
        (killed, then(&disk, &layout))
    }

    /// Imports again. `false` if there was nothing to do: the kill came when all was done but the
    /// last word.
    fn goes_through(&self, disk: &Memory, layout: &Layout, what: &str) -> bool {
        let again = self.import(disk, layout, &self.files);
        let data = StudyData::load_from(disk, layout).unwrap();
        let found = (data.counting().count(), data.sweeps.len(), data.answers.len());
        assert_eq!((found, verify_from(disk, layout)), (self.whole, vec![]), "{what}: {again:?}");
        assert_eq!(recover(disk, layout, UTC), [], "{what}");
        if let Err(errors) = &again {
            let known = ["already", "imported before"];
            let is_known = |e: &StoreError| known.iter().any(|words| e.what.contains(words));
            assert!(errors.iter().all(is_known), "{what}: {errors:?}");
        }
        // What was there already is left out.
        again.is_ok_and(|report| report.trials + report.sweeps + report.answers > 0)
    }
}

const ENDS: [Survives; 5] =
    [Survives::Everything, Survives::Synced, Survives::Names, Survives::Zeros, Survives::Half];

/// Kills the import at each of its steps; how many there are.
fn every_step(case: &Case, steps: u64, ends: &[Survives]) {
    for end in ends.iter().copied() {
        let step = |n: u64| {
            case.killed(n, end, |disk, layout| {
                !case.goes_through(disk, layout, &format!("step {n}, {end:?} survives"))
            })
        };
        let tried: Vec<(bool, bool)> = (0..=steps).into_par_iter().map(step).collect();
        // From the removal of the list on the import is done: what follows is the sync of its folder
        // and the heads of logs.
        let killed = tried.iter().filter(|(killed, _)| *killed).count();
        assert!(killed as u64 == steps, "every step, {end:?}: {tried:?}");
        let undone = tried.iter().take_while(|(_, done)| !done).count();
        assert!(undone + 6 >= tried.len(), "{end:?}: {tried:?}");
        assert!(tried[undone..].iter().all(|(_, done)| *done), "{end:?}: {tried:?}");
    }
}

#[test]
fn an_import_that_is_killed_at_any_step_goes_through_the_next_time_and_each_recording_counts_once()
{
    every_step(&Case::one(), 35, &ENDS);
    every_step(&Case::sweeps(), 23, &ENDS);
    every_step(&Case::first_sweep(), 23, &ENDS[..2]);
    every_step(&Case::trials(), 63, &ENDS[..2]);
    every_step(&Case::likert(), 41, &ENDS[..2]);
}

#[test]
fn an_import_of_a_long_text_that_is_killed_at_any_step_goes_through_the_next_time_too() {
    let mut case = Case::one();
    case.mapping.file.long_from = 0;
    for end in ENDS {
        let step = |n: &u64| {
            let (killed, _) = case.killed(*n, end, |disk, layout| {
                case.goes_through(disk, layout, &format!("long, step {n}, {end:?} survives"))
            });
            killed
        };
        let steps = (0..1000).take_while(step).count();
        assert!((30..1000).contains(&steps), "{steps}");
    }
}

#[test]
fn what_a_killed_import_left_is_told_by_verify_and_taken_back_by_recover() {
    for case in [Case::trials(), Case::sweeps(), Case::likert()] {
        let before = {
            let (disk, layout) = case.study();
            disk.below(&layout.raw())
        };
        for n in 4.. {
            let (killed, _) = case.killed(n, Survives::Everything, |disk, layout| {
                let list = layout.unfinished();
                let is_told = |e: &StoreError| e.path == list && e.remedy.contains("again");
                let told = verify_from(disk, layout).iter().any(is_told);
                let found = recover(disk, layout, UTC);
                assert!(found.iter().all(Result::is_ok), "step {n}: {found:?}");
                if told {
                    assert_eq!(disk.below(&layout.raw()), before, "step {n}: {found:?}");
                }
                assert_eq!(verify_from(disk, layout), [], "step {n}: {found:?}");
                case.goes_through(disk, layout, &format!("step {n}, recovered"))
            });
            if !killed {
                break;
            }
        }
    }
}

#[test]
fn an_import_that_is_killed_while_it_takes_the_last_one_back_goes_through_too() {
    for case in [Case::one(), Case::sweeps()] {
        for [end, again] in
            [[Survives::Everything, Survives::Everything], [Survives::Synced, Survives::Half]]
        {
            let killed = |n: u64, m: u64| {
                let (_, cut) = case.killed(n, end, |disk, layout| {
                    disk.fail_in(m, Fault::End);
                    let cut = case.import(disk, layout, &case.files).is_err();
                    disk.restart(again);
                    let what = format!("step {n} {end:?}, then {m} {again:?}");
                    case.goes_through(disk, layout, &what);
                    cut
                });
                cut
            };
            // Taking back has as many steps as there were files; the last of them are those of the
            // import itself.
            let tries =
                |n: u64| (0..24).step_by(2).filter(|m| killed(2 * n + m % 4 / 2, *m)).count();
            let tried: usize = (0..18_u64).into_par_iter().map(tries).sum();
            assert!(tried > 100, "only {tried}");
        }
    }
}

#[test]
fn a_list_that_names_what_no_import_wrote_removes_nothing() {
    let case = Case::one();
    let (disk, layout) = case.study();
    case.import(&disk, &layout, &case.files).unwrap();
    let trial = layout.trial(&"P01".parse().unwrap(), &"S01".parse().unwrap(), 1);
    disk.put(&layout.raw().join("trials/x.txt"), b"mine");
    let before = disk.below(Path::new("/"));
    let hash = |path: &Path| zwidth_store::hex_blake3(&before[path]);
    let study = hash(&layout.study_toml());
    for (path, blake3) in [
        ("../../raw/demo/study.toml".to_owned(), &study),
        ("/root/raw/demo/study.toml".to_owned(), &study),
        ("trials/../study.toml".to_owned(), &study),
        ("study.toml".to_owned(), &study),
        ("trials/x.txt".to_owned(), &zwidth_store::hex_blake3(b"mine")),
        (format!("trials/{}", trial.strip_prefix(layout.trials()).unwrap().display()), &study),
    ] {
        let list = format!(
            "{{\"files\":[{{\"path\":{path:?},\"blake3\":\"{blake3}\"}}],\"folders\":[\"..\", \"/\"]}}"
        );
        disk.put(&layout.unfinished(), list.as_bytes());
        let errors = case.import(&disk, &layout, &case.files).unwrap_err();
        assert_eq!(errors.len(), 1, "{errors:?}");
        let what = &errors[0].what;
        assert!(what.contains("cut short lists it") || what.contains("no change writes"), "{what}");
        disk.put(&layout.unfinished(), b"");
        let now = disk.below(Path::new("/"));
        assert!(before.iter().all(|(path, bytes)| now.get(path) == Some(bytes)), "{path}");
    }
}
