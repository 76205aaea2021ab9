#![allow(clippy::float_cmp)] // numbers that no sum changed

use super::super::world::{FORCE, ONE, World, close, column, template_once, trials_map};
use std::path::PathBuf;
use zwidth_store::{DOUBTS, GAPS, JOINED, Signal, StoreError};
use zwidth_study::Event;

/// Recordings by the numbers in their names, of which a log knows the mode and the answer.
const NUMBERED: &str = "
[name]
pattern = '(?<who>P\\d+)_(?<n>\\d+)\\.csv$'
[log]
path = \"../log/{who}.csv\"
trial = \"trials.thisN\"
number = { name = \"n\" }
add = 1
[log.file]
missing = \"drop\"
[trial]
participant = { name = \"who\" }
session = \"S01\"
environment = \"spring\"
mode = { column = \"condition@log\" }
trial = { name = \"n\" }
";
const ANSWERS: &str = "
[questions]
time_unit = \"s\"
[questions.columns]
felt_spring = \"slider.response@log\"
[questions.times]
felt_spring = \"slider.rt@log\"
";
/// As PsychoPy writes it: the last column has no name, and an instruction has a row.
const PSYCHOPY: &str = "condition,trials.thisN,slider.response,slider.rt,\n\
    ,,None,,\nactive,0,4,1.25,\npassive,1,None,,\nhybrid,2,2,0.5,\n";

fn three(world: &World) -> Vec<PathBuf> {
    let one = |n: u32| world.file(&format!("rig/P07_{n:02}.csv"), format!("t,f\n0,{n}\n1,{n}\n"));
    [1, 2, 3].map(one).to_vec()
}

/// What an import says is wrong; nothing is written then.
fn refused(world: &World, map: &str, files: &[PathBuf]) -> Vec<StoreError> {
    let before = world.written();
    let errors = world.import(map, files).unwrap_err();
    assert_eq!(world.written(), before);
    errors
}

#[track_caller]
fn says(errors: &[StoreError], words: &str) {
    let all = errors.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n");
    assert!(all.contains(words), "'{words}' is not in\n{all}");
}

#[test]
fn a_log_gives_trials_their_modes_and_answers_by_their_numbers() {
    let world = World::new();
    world.file("log/P07.csv", PSYCHOPY);
    let files = three(&world);
    let map = trials_map(&[NUMBERED, ANSWERS, FORCE]);
    let report = world.import(&map, &files).unwrap();
    assert_eq!((report.trials, report.answers), (3, 2));
    let modes = [1, 2, 3].map(|n| world.trial("P07", "S01", n).meta.mode.as_str().to_owned());
    assert_eq!(modes, ["active", "passive", "hybrid"]);
    let question = "felt_spring".parse().unwrap();
    let first = Event::Answer { trial: 1, question, value: 4.into(), time_ms: Some(1250) };
    assert!(world.events("P07", "S01").contains(&first));
    // Each file says of which row of which log it is.
    let hash = blake3::hash(PSYCHOPY.as_bytes()).to_hex();
    let joined = world.trial("P07", "S01", 3).file[JOINED].clone();
    assert_eq!(joined, format!("line 5 of the log {hash} (trials.thisN = 2)"));
    let computed = report.files[0].computed.join("\n");
    assert!(
        computed.contains("condition@log, slider.response@log, slider.rt@log of the row of a log"),
        "{computed}"
    );
    // The same command again adds nothing.
    assert_eq!(world.import(&map, &files).unwrap().trials, 0);
}

#[test]
fn a_log_that_counts_from_another_number_is_refused_with_what_mends_it() {
    let world = World::new();
    world.file("log/P07.csv", PSYCHOPY);
    let files = three(&world);
    let map = trials_map(&[&NUMBERED.replace("add = 1\n", ""), FORCE]);
    let errors = refused(&world, &map, &files);
    says(&errors, "its trial 3 has no row in the log");
    says(&errors, "has 0 to 2 in trials.thisN");
    says(&errors, "set add = 1 in [log]");
}

#[test]
fn rows_without_a_trial_trials_without_a_row_and_two_rows_are_refused_with_their_lines() {
    let world = World::new();
    world.file("log/P07.csv", PSYCHOPY);
    let files = three(&world);
    let map = trials_map(&[NUMBERED, FORCE]);
    let errors = refused(&world, &map, &files[..2]);
    says(&errors, "no recording has the trial of this row (trials.thisN = 2) (line 5)");
    assert_eq!(errors.len(), 1, "{errors:?}");
    let report = world
        .import(&map.replace("add = 1", "add = 1\nunmatched = \"drop\""), &files[..2])
        .unwrap();
    assert!(report.files[0].told.join("\n").contains("1 rows of the log"), "{report}");

    let world = World::new();
    world.file("log/P07.csv", PSYCHOPY.replace("hybrid,2", "hybrid,1"));
    let errors = refused(&world, &map, &three(&world));
    says(&errors, "line 4 has the number 1 too: a trial has one row (line 5)");

    let world = World::new();
    world.file("log/P07.csv", PSYCHOPY.replace("passive,1,None,,\n", ""));
    let errors = refused(&world, &map, &three(&world));
    says(&errors, "its trial 2 has no row in the log");
    let world = World::new();
    let errors = refused(&world, &map, &three(&world));
    says(&errors, "P07.csv");
}

#[test]
fn trials_of_one_recording_are_counted_where_nothing_numbers_them_and_have_no_row_in_common() {
    let world = World::new();
    world.file("log/P07.csv", PSYCHOPY);
    let file = world.file("rig/P07_01.csv", "t,f\n0,1\n1,1\n0,2\n1,2\n0,3\n1,3\n");
    let map = NUMBERED.replace("trial = { name = \"n\" }\n", "");
    let split = trials_map(&["[file]\nsplit = \"time\"\n", &map, FORCE]);
    let errors = refused(&world, &split, std::slice::from_ref(&file));
    says(&errors, "the trial has line 3 of the log");
    let counted = split.replace("number = { name = \"n\" }\n", "");
    assert_eq!(world.import(&counted, &[file]).unwrap().trials, 3);
    assert_eq!(world.trial("P07", "S01", 3).meta.mode.as_str(), "hybrid");
}

#[test]
fn where_and_when_choose_the_rows_of_a_person_and_of_a_screen() {
    let world = World::new();
    world.file(
        "log/all.csv",
        "subject,screen,n,mode\n7,start,1,\n7,test,1,active\n7,test,2,passive\n8,test,1,hybrid\n7,test,3,hybrid\n",
    );
    let by = "path = \"../log/all.csv\"\ntrial = \"n\"\nwhere = { subject = { name = \"who\", translate = { P07 = \"7\", P08 = \"8\" } } }\n\
        when = { screen = [\"test\"] }\n";
    let map = NUMBERED
        .replace("path = \"../log/{who}.csv\"\ntrial = \"trials.thisN\"\n", by)
        .replace("add = 1\n", "")
        .replace("condition@log", "mode@log");
    let mut files = three(&world);
    files.push(world.file("rig/P08_1.csv", "t,f\n0,9\n1,9\n"));
    assert_eq!(world.import(&trials_map(&[&map, FORCE]), &files).unwrap().trials, 4);
    assert_eq!(world.trial("P08", "S01", 1).meta.mode.as_str(), "hybrid");
    assert_eq!(world.trial("P07", "S01", 1).meta.mode.as_str(), "active");
    let other = World::new();
    other.file("log/all.csv", "subject,screen,n,mode\n9,test,1,active\n");
    says(&refused(&other, &trials_map(&[&map, FORCE]), &three(&other)), "no row has '7'");
}

#[test]
fn answers_in_the_middle_of_a_line_are_told_for_a_slider_that_was_not_touched_stays_there() {
    let line = "id = \"felt_spring\"\npoints = 101\nfrom = 0\n";
    let world = World::with(&template_once().replace("id = \"felt_spring\"\n", line));
    world.file("log/P07.csv", PSYCHOPY.replace("0,4,", "0,50,").replace("2,2,", "2,50,"));
    let report = world.import(&trials_map(&[NUMBERED, ANSWERS, FORCE]), &three(&world)).unwrap();
    let told = report.files.iter().filter(|file| {
        file.told.iter().any(|told| told.contains("1 answers to 'felt_spring' are 50, the middle"))
    });
    assert_eq!(told.count(), 2, "{report}");
}

/// A recording of a whole session, which a log parts into trials by its own clock.
const TIMED: &str = "
[log]
path = \"log.csv\"
time = \"started\"
unit = \"s\"
offset_s = 10.0
[trial]
participant = \"P01\"
session = \"S01\"
environment = \"spring\"
mode = { column = \"mode@log\" }
";

fn session(world: &World) -> PathBuf {
    let rows: Vec<String> =
        (0..100).map(|i| format!("{},{i}", 10.0 + f64::from(i) / 10.0)).collect();
    world.file("rig/a.csv", format!("t,f\n{}\n", rows.join("\n")))
}

#[test]
fn rows_of_a_log_part_a_recording_by_time_and_a_stated_offset() {
    let world = World::new();
    let file = session(&world);
    world
        .file("rig/log.csv", "started,stopped,mode\n1,3.05,active\n4,,passive\n,,\n7.5,9,hybrid\n");
    let map = trials_map(&[TIMED, FORCE]);
    let report = world.import(&map, &[file]).unwrap();
    assert_eq!(report.trials, 3);
    let lengths = [1, 2, 3].map(|n| world.trial("P01", "S01", n).samples.len());
    assert_eq!(lengths, [30, 35, 25]);
    assert_eq!(world.column(2, Signal::ForceEx)[0], 40.0);
    let dropped = &report.files[0].rows_dropped;
    assert!(
        dropped.iter().any(|d| d.rows == 10 && d.why.contains("outside of the times")),
        "{dropped:?}"
    );
    let joined = world.trial("P01", "S01", 2).file[JOINED].clone();
    assert!(
        joined.starts_with("line 3 of the log ")
            && joined.ends_with("(at 14.000000 s of the recording)"),
        "{joined}"
    );

    // Until when a trial lasts may be a column too.
    let world = World::new();
    let file = session(&world);
    world.file("rig/log.csv", "started,stopped,mode\n1,3.05,active\n4,5,passive\n7.5,9,hybrid\n");
    world.import(&map.replace("offset_s", "until = \"stopped\"\noffset_s"), &[file]).unwrap();
    let lengths = [1, 2, 3].map(|n| world.trial("P01", "S01", n).samples.len());
    assert_eq!(lengths, [21, 11, 16]);

    // Rows that are written when a trial is over.
    let world = World::new();
    let file = session(&world);
    world.file("rig/log.csv", "started,mode\n2,active\n4,passive\n");
    world.import(&map.replace("offset_s", "at = \"end\"\noffset_s"), &[file]).unwrap();
    let lengths = [1, 2].map(|n| world.trial("P01", "S01", n).samples.len());
    assert_eq!(lengths, [21, 20]);
}

#[test]
fn times_of_a_log_that_do_not_meet_the_recording_are_refused_with_both_spans() {
    let world = World::new();
    let file = session(&world);
    world.file("rig/log.csv", "started,mode\n1,active\n4,passive\n");
    let map = trials_map(&[TIMED, FORCE]);
    let far = map.replace("10.0", "1000.0");
    let errors = refused(&world, &far, std::slice::from_ref(&file));
    says(
        &errors,
        "it lasts from 10.000000 s to 19.900000 s, and the log, with offset_s, from 1001.000000 s to 1004.000000 s",
    );
    let partly = map.replace("offset_s = 10.0", "offset_s = 17.0");
    says(
        &refused(&world, &partly, std::slice::from_ref(&file)),
        "no recording has the trial of this row (at 21.000000 s of the recording) (line 3)",
    );
    world.file("rig/log.csv", "started,mode\n4,active\n4,passive\n");
    says(&refused(&world, &map, std::slice::from_ref(&file)), "line 2 has the same time");
    let backwards = world.file("rig/b.csv", "t,f\n10,1\n15,2\n12,3\n");
    says(&refused(&world, &map, &[backwards]), "its times run backwards");
}

#[test]
fn a_row_within_each_recording_says_what_the_trial_was() {
    let world = World::new();
    world.file(
        "rig/log.csv",
        "started,mode\n2020-01-01T10:00:01,active\n2020-01-01T10:00:11.5,passive\n",
    );
    let map = trials_map(&[&TIMED.replace("10.0", "0.0\nat = \"within\""), FORCE]);
    let files = ["0", "1"].map(|n| {
        world.file(
            &format!("rig/{n}.csv"),
            format!("t,f\n2020-01-01T10:00:{n}0,1\n2020-01-01T10:00:{n}5,{n}\n"),
        )
    });
    world.import(&map, &files).unwrap();
    assert_eq!(
        [1, 2].map(|n| world.trial("P01", "S01", n).meta.mode.as_str().to_owned()),
        ["active", "passive"]
    );
    let other = World::new();
    let files = ["0", "1"].map(|n| {
        other.file(
            &format!("rig/{n}.csv"),
            format!("t,f\n2020-01-01T10:00:{n}0,1\n2020-01-01T10:00:{n}5,{n}\n"),
        )
    });
    other.file(
        "rig/log.csv",
        "started,mode\n2020-01-01T10:00:01,active\n2020-01-01T10:00:02,passive\n",
    );
    let errors = refused(&other, &map, &files);
    says(&errors, "two rows of the log");
    says(&errors, "no row of the log");
}

/// Force here, motion there.
const MOTION: &str = "
[[with]]
id = \"mocap\"
path = \"motion_{n}.csv\"
time = \"time\"
unit = \"ms\"
offset_s = 0.05
resample = \"linear\"
[name]
pattern = '(?<n>\\d+)\\.csv$'
";

fn motion(world: &World, n: u32) -> PathBuf {
    let rows: Vec<String> = (0..20).map(|i| format!("{},{}", i * 25, i * i)).collect();
    world.file(&format!("rig/motion_{n}.csv"), format!("time,x\n{}\n", rows.join("\n")));
    let rows: Vec<String> =
        (0..60).map(|i| format!("{},{}", f64::from(i) / 100.0, i + n)).collect();
    world.file(&format!("rig/{n}.csv"), format!("t,f\n{}\n", rows.join("\n")))
}

#[test]
fn a_second_file_is_put_on_the_times_of_the_recording_as_the_mapping_says() {
    let world = World::new();
    let file = motion(&world, 1);
    let map = trials_map(&[MOTION, ONE, FORCE, &column("theta_rad", "x@mocap", "deg")]);
    let report = world.import(&map, std::slice::from_ref(&file)).unwrap();
    // From 0.05 s to 0.525 s both have samples.
    let t = world.column(1, Signal::Time);
    assert_eq!((t[0], t[t.len() - 1], t.len()), (0.05, 0.52, 48));
    let theta = world.column(1, Signal::Theta);
    let expect = t.iter().map(|t| {
        let at = (t - 0.05) / 0.025;
        let (i, share) = (at.floor(), at - at.floor());
        (i * i + share * (2.0 * i + 1.0)).to_radians()
    });
    for (found, expect) in theta.iter().zip(expect) {
        assert!((found - expect).abs() < 1e-9, "{found} {expect}");
    }
    assert!(
        report.files[0]
            .care
            .iter()
            .any(|care| care.contains("12 of 60 rows lie outside of the times of 'mocap'")),
        "{report}"
    );
    let trial = world.trial("P01", "S01", 1);
    assert!(
        trial.file[JOINED]
            .contains("on the line between samples 0.025000 s apart at most, its times + 0.05 s")
    );
    assert!(
        trial.file["made_by_import"]
            .contains("x@mocap of a second file on the line between its samples")
    );

    let world = World::new();
    let file = motion(&world, 1);
    world.import(&map.replace("linear", "previous"), &[file]).unwrap();
    close(&world.column(1, Signal::Theta)[..5], &[0.0, 0.0, 0.0, 1.0, 1.0].map(f64::to_radians));
}

#[test]
fn nothing_is_put_between_samples_without_a_word() {
    let world = World::new();
    let file = motion(&world, 1);
    let map = trials_map(&[MOTION, ONE, FORCE, &column("theta_rad", "x@mocap", "deg")]);
    let silent = map.replace("resample = \"linear\"\n", "");
    let errors = refused(&world, &silent, std::slice::from_ref(&file));
    says(&errors, "'mocap' has no sample at 0.060000 s");
    says(&errors, "set resample = \"linear\"");
    // Where both have the same times nothing needs to be said.
    let same: Vec<String> = (0..60).map(|i| format!("{},{i}", i * 10)).collect();
    world.file("rig/motion_1.csv", format!("time,x\n{}\n", same.join("\n")));
    world.import(&silent.replace("0.05", "0.0"), &[file]).unwrap();
    close(&world.column(1, Signal::Theta)[..3], &[0.0, 1.0, 2.0].map(f64::to_radians));
}

#[test]
fn gaps_of_a_second_file_are_no_line_and_files_that_do_not_meet_or_meet_twice_are_refused() {
    let world = World::new();
    let file = motion(&world, 1);
    let map = trials_map(&[MOTION, ONE, FORCE, &column("theta_rad", "x@mocap", "deg")]);
    let rows = (0..20).filter(|i| !(4..12).contains(i));
    let rows: Vec<String> = rows.map(|i| format!("{},{i}", i * 25)).collect();
    world.file("rig/motion_1.csv", format!("time,x\n{}\n", rows.join("\n")));
    says(
        &refused(&world, &map, std::slice::from_ref(&file)),
        "it has no sample from 0.125000 s to 0.350000 s",
    );
    let drop = map.replace("[[with]]", "[file]\nmissing = \"drop\"\n[[with]]");
    world.import(&drop, std::slice::from_ref(&file)).unwrap();
    let trial = world.trial("P01", "S01", 1);
    assert!(trial.file[GAPS].contains("missing samples: 22 of 48"), "{:?}", trial.file);
    let world = World::new();
    let file = motion(&world, 1);
    let held = map.replace("linear", "previous");
    world.file("rig/motion_1.csv", format!("time,x\n{}\n", rows.join("\n")));
    world.import(&held, std::slice::from_ref(&file)).unwrap();
    assert!(
        world.trial("P01", "S01", 1).file[DOUBTS].contains("'mocap' has no sample for 0.225000 s")
    );

    let world = World::new();
    let file = motion(&world, 1);
    let errors = refused(&world, &map.replace("0.05", "99.0"), std::slice::from_ref(&file));
    says(
        &errors,
        "have no time in common: it lasts from 0.000000 s to 0.590000 s, and that, with offset_s, from 99.000000 s",
    );
    let one_for_all = map.replace("motion_{n}", "motion_1");
    let files = [file, motion(&world, 2)];
    says(&refused(&world, &one_for_all, &files), "are joined to two recordings");
    world.import(&map, &files).unwrap_err();
    world.file("rig/motion_1.csv", "time,x\n0,1\n50,2\n50,3\n");
    says(&refused(&world, &map, &files[..1]), "its times stand still or run backwards");
}

/// What a task presented, and what was answered, in columns of a log.
const PRESENTED: &str = "
[task]
id = \"stiffer\"
level = \"k@log\"
unit = \"N/rad\"
answer = { column = \"key@log\", translate = { m = \"more\", l = \"less\" } }
time = \"rt@log\"
time_unit = \"s\"
";

fn world_of_a_task() -> World {
    let text = template_once().replacen("schema = 2", "schema = 3", 1);
    let text = text.replacen("question = \"felt_spring\"\n", "", 1);
    World::with(&format!(
        "{text}\n[[tasks]]\nid = \"stiffer\"\ntext = \"What was it?\"\nasks = \"more_less\"\nenvironment = \"spring\"\n\
         varies = \"stiffness_n_per_rad\"\nstandard = 4.0\nmethod = \"constant\"\nlevels = [3.2, 3.6, 4.4]\ntrials = 20\n"
    ))
}

#[test]
fn levels_and_answers_of_a_task_belong_to_recorded_presentations() {
    let world = world_of_a_task();
    // Of the last presentation nobody knows the level: it is a trial, and no presentation.
    world.file(
        "log/P07.csv",
        "condition,trials.thisN,k,key,rt\nactive,0,4.4,m,0.5\nactive,1,3.6,m,0.75\nactive,2,None,None,\n",
    );
    let map = trials_map(&[NUMBERED, PRESENTED, FORCE]);
    let report = world.import(&map, &three(&world)).unwrap();
    assert_eq!((report.trials, report.answers), (3, 2));
    let data = world.load();
    let answers = data.task_answers().into_iter();
    let answers: Vec<(u32, u32, f64, bool, Option<u32>)> = answers
        .map(|a| (a.trial, a.presentation, a.level.value(), a.is_positive, a.time_ms))
        .collect();
    assert_eq!(answers, [(1, 1, 4.4, true, Some(500)), (2, 2, 3.6, true, Some(750))]);
    let presented = |n| world.trial("P07", "S01", n).meta.presented;
    assert_eq!(presented(2).unwrap().level.unwrap().value(), 3.6);
    assert!(presented(3).is_none());

    let other = world_of_a_task();
    other.file(
        "log/P07.csv",
        "condition,trials.thisN,k,key,rt\nactive,0,4.4,m,0.5\nactive,1,3.6,x,0.7\nactive,2,1,m,1\n",
    );
    let errors = refused(&other, &map, &three(&other));
    says(&errors, "P07.csv, column key, row 2");
    let wall = map.replace("environment = \"spring\"", "environment = \"spring_wall\"");
    says(
        &refused(&other, &wall, &three(&other)),
        "the task 'stiffer' is of spring, and the trial of spring_wall",
    );
}

#[test]
fn answers_in_json_that_count_from_0_and_decimal_commas_of_a_log_are_read_as_the_log_writes_them() {
    let world = World::new();
    world.file(
        "log/P07.csv",
        "condition;trials.thisN;response;rt\nactive;0;\"{\"\"Q0\"\":3}\";1,5\npassive;1;\"{\"\"Q0\"\":0}\";0,5\nhybrid;2;\"{\"\"Q0\"\":null}\";\n",
    );
    let answers = ANSWERS
        .replace("time_unit = \"s\"", "time_unit = \"s\"\nlowest = 0")
        .replace("\"slider.response@log\"", "{ column = \"response@log\", key = \"Q0\" }")
        .replace("slider.rt@log", "rt@log");
    let map = NUMBERED
        .replace("missing = \"drop\"", "missing = \"drop\"\ndelimiter = \";\"\ndecimal = \",\"");
    world.import(&trials_map(&[&map, &answers, FORCE]), &three(&world)).unwrap();
    let answered = world.events("P07", "S01").into_iter().filter_map(|event| match event {
        Event::Answer { trial, value, time_ms, .. } => Some((trial, value.get(), time_ms)),
        _ => None,
    });
    assert_eq!(answered.collect::<Vec<_>>(), [(1, 4.0, Some(1500)), (2, 1.0, Some(500))]);
}

#[test]
fn what_makes_no_sense_in_a_mapping_is_refused_with_its_line() {
    use super::super::check::tests::check;
    let good = trials_map(&[NUMBERED, ANSWERS, FORCE]);
    for (from, to, line, words) in [
        ("{who}", "{whom}", 6, "'{whom}' is not a named group"),
        ("trial = \"trials.thisN\"", "time = \"t\"\nunit = \"s\"", 5, "log.offset_s: is missing"),
        ("trial = \"trials.thisN\"\n", "", 5, "needs either trial"),
        ("add = 1", "add = 1\noffset_s = 1.0", 10, "is used with `time`, not with `trial`"),
        (
            "number = { name = \"n\" }",
            "number = { column = \"n@log\" }",
            8,
            "a label of the recording itself",
        ),
        ("from = \"t\"", "from = \"t@log\"", 27, "is joined by the recording's own time"),
    ] {
        check(&good, from, to, line, words);
    }
    let no_answers = trials_map(&[NUMBERED, FORCE]);
    check(&no_answers, "condition@log", "condition", 5, "no column is of it");
    let good = trials_map(&[MOTION, ONE, FORCE, &column("theta_rad", "x@mocap", "deg")]);
    for (from, to, line, words) in [
        ("offset_s = 0.05\n", "", 3, "with[0].offset_s: is missing"),
        ("\"mocap\"", "\"mo cap\"", 4, "must be of letters, digits and _"),
        ("\"mocap\"", "\"log\"", 4, "is the name of another file"),
        ("\"linear\"", "\"cubic\"", 9, "unknown variant `cubic`"),
        ("time = \"time\"\n", "", 3, "needs either time (a column) or rate_hz"),
    ] {
        check(&good, from, to, line, words);
    }
}
