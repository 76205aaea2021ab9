//! A whole session of tasks: a device's own participant answers, and what is recorded says which level was presented.

use super::*;
use std::collections::BTreeMap;
use zwidth_store::{Fault as DiskFault, Memory, Survives, verify_from};
use zwidth_study::TaskLevel;

/// Constant stimuli of two intervals and a staircase of one, in two modes of an environment, and nothing else.
fn study(blinded: bool) -> String {
    let text = small("small", blinded)
        .replace("\nschema = 2\n", "\nschema = 3\n")
        .replace("familiarisation = 1", "familiarisation = 0");
    let from = text.find("[[environments]]\nid = \"spring_wall\"").unwrap();
    let to = text[from..].find("# How it is rendered").unwrap() + from;
    let text = format!("{}{}", &text[..from], &text[to..]);
    let from = text.find("[[modes]]\nid = \"passive\"").unwrap();
    let to = text[from..].find("[[modes]]\nid = \"hybrid\"").unwrap() + from;
    let text = format!("{}{}", &text[..from], &text[to..]);
    let text = text.replace("question = \"felt_spring\"\n", "");
    format!(
        r#"{text}
[[tasks]]
id = "stiffer"
text = "Which one was stiffer?"
asks = "2ifc"
environment = "spring"
varies = "stiffness_n_per_rad"
standard = 4.0
method = "constant"
levels = [3.2, 4.0, 4.8]
trials = 2

[[tasks]]
id = "steps"
text = "Was it stiffer or softer than usual?"
asks = "more_less"
environment = "spring"
varies = "stiffness_n_per_rad"
standard = 4.0
method = "staircase"
rule = "1up1down"
start = 4.6
up = 0.4
down = 0.4
lowest = 2.0
highest = 8.0
reversals = 4
of_last = 2
most_trials = 24
"#
    )
}

/// A desk of which nothing lies on the real disk, whose device's participant answers.
fn desk(blinded: bool) -> (Desk, Memory) {
    let (mut desk, disk) = (Desk::with(study(blinded)), Memory::new());
    desk.plan.layout = Layout::new(Path::new("/nowhere"), "small".parse().unwrap());
    desk.plan.keys = PathBuf::from("/nowhere/keys");
    desk.options.answers = true;
    disk.put(&desk.plan.layout.study_toml(), &desk.plan.study_toml);
    (desk, disk)
}

fn data(desk: &Desk, disk: &Memory) -> StudyData {
    StudyData::load_from(disk, &desk.plan.layout).unwrap()
}

/// By task, mode, track and presentation: the level and the answer.
type Course = BTreeMap<(String, String, u8, u32), (TaskLevel, bool)>;

/// What was answered, and counts.
fn course(data: &StudyData) -> Course {
    let mut found = Course::new();
    for answer in data.task_answers() {
        let key = (
            answer.task.to_string(),
            answer.condition.mode.to_string(),
            answer.track,
            answer.presentation,
        );
        assert!(found.insert(key, (answer.level, answer.is_positive)).is_none());
    }
    found
}

fn auto() -> Auto<Nobody> {
    Auto::new(Nobody)
}

#[test]
fn a_session_of_tasks_comes_to_its_end_and_every_answer_has_its_level() {
    let (desk, disk) = desk(false);
    let outcome = desk.run(&mut Mock::default(), &disk, &mut auto()).unwrap();
    assert_eq!((outcome.stopped.clone(), outcome.done), (None, outcome.total));
    assert_eq!(verify_from(&disk, &desk.plan.layout), []);
    let data = data(&desk, &disk);
    assert!(outcome.total < data.sessions[0].record.trials.len(), "the staircases ended");
    let found = course(&data);
    let of_task = |id: &str| found.iter().filter(|((task, ..), _)| task == id).count();
    assert_eq!(of_task("stiffer"), 12);
    assert!((10..48).contains(&of_task("steps")), "{found:?}");
    for trial in &data.trials {
        let presented = trial.meta.presented.as_ref().unwrap();
        let planned = data.sessions[0].record.trials.iter().find(|t| t.trial == trial.meta.trial);
        let place = planned.unwrap().task.as_ref().unwrap();
        assert_eq!((&presented.task, presented.interval), (&place.task, place.interval));
        let standard = TaskLevel::nearest(4.0);
        let events = &data.sessions[0].events;
        let logged = events.iter().find_map(|event| match event {
            Event::Level { trial: own, level } if *own == trial.meta.trial => Some(*level),
            _ => None,
        });
        let expect =
            if place.is_standard == Some(true) { standard } else { place.level.or(logged) };
        assert_eq!(presented.level, expect, "trial {}", trial.meta.trial);
    }
    // Each step goes from the level before it.
    for mode in ["active", "hybrid"] {
        let own = found.iter().filter(|((task, m, ..), _)| task == "steps" && m == mode);
        let own: Vec<(TaskLevel, bool)> = own.map(|(_, found)| *found).collect();
        assert_eq!(own[0].0, TaskLevel::nearest(4.6).unwrap());
        for pair in own.windows(2) {
            let step = if pair[0].1 { -0.4 } else { 0.4 };
            assert_eq!(Some(pair[1].0), TaskLevel::nearest(pair[0].0.value() + step));
        }
    }
}

#[test]
fn ended_at_any_write_a_session_of_tasks_presents_the_same_levels_and_loses_no_answer() {
    for blinded in [false, true] {
        let (whole, disk) = desk(blinded);
        let before = disk.steps();
        whole.run(&mut Mock::default(), &disk, &mut auto()).unwrap();
        let steps = disk.steps() - before;
        let unsealed = |desk: &Desk, disk: &Memory| {
            let found = data(desk, disk);
            let log = &found.sessions[0];
            if blinded {
                let seal = crate::vault::find(
                    disk,
                    &desk.plan.keys,
                    desk.plan.layout.study(),
                    &log.record,
                );
                let event = seal.unwrap().event();
                append_events(disk, &log.events_path, UTC, &[event]).unwrap();
            }
            course(&data(desk, disk))
        };
        let expect = unsealed(&whole, &disk);
        assert!(expect.len() > 20, "{expect:?}");
        for (turn, at) in (0..40).step_by(13).chain((40..steps).step_by(1999)).enumerate() {
            let survives = [Survives::Everything, Survives::Synced][turn % 2];
            let (desk, disk) = desk(blinded);
            disk.fail_in(at, DiskFault::End);
            desk.run(&mut Mock::default(), &disk, &mut auto()).unwrap_err();
            disk.restart(survives);
            for found in recover(&disk, &desk.plan.layout, UTC) {
                found.unwrap_or_else(|e| panic!("{at} {survives:?}: {e}"));
            }
            let outcome = desk.run(&mut Mock::default(), &disk, &mut auto()).unwrap();
            assert_eq!(outcome.done, outcome.total, "{at}");
            assert_eq!(verify_from(&disk, &desk.plan.layout), [], "{at} {survives:?}");
            assert_eq!(unsealed(&desk, &disk), expect, "{at} {survives:?}");
        }
    }
}

#[test]
fn a_blinded_session_tells_neither_a_mode_nor_which_interval_holds_the_standard() {
    let (desk, disk) = desk(true);
    let mut views: Vec<View> = Vec::new();
    let mut front = somebody(|view: &View| {
        views.push(view.clone());
        None
    });
    let mut device = Mock::default();
    desk.run(&mut device, &disk, &mut front).unwrap();
    drop(front);
    assert!(views.iter().any(|view| view.task.as_ref().is_some_and(|t| t.interval == [2, 2])));
    let shown = format!("{views:?}");
    for word in ["active", "hybrid", "Active", "Hybrid", "standard"] {
        assert!(!shown.contains(word), "{word}");
    }
    let data = data(&desk, &disk);
    for trial in
        data.trials.iter().filter(|t| t.meta.presented.as_ref().unwrap().task.as_str() == "stiffer")
    {
        assert_eq!(trial.meta.presented.as_ref().unwrap().level, None);
    }
    let places = data.sessions[0].record.trials.iter().filter_map(|t| t.task.as_ref());
    assert!(places.clone().all(|place| place.is_standard.is_none()) && places.count() > 20);
}
