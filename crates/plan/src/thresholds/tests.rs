//! A study of eight people whose answers to two tasks come from formulas, from its sessions to the summary.

use crate::thresholds::{answered, fits, over_people, perception};
use std::fs;
use std::path::Path;
use std::sync::Mutex;
use zwidth_results::{LevelMethod, Mean, PeopleThreshold, PsychometricFit};
use zwidth_runner::{JobEnd, Options, Results};
use zwidth_store::{Answer, Findings, Layout, RealFiles, SessionLog, StudyData};
use zwidth_study::{
    AnswerScale, Asks, Condition, Kind, Method, Perception, PlannedTrial, Question, QuestionId,
    SessionRecord, Source, StaircasePlan, Study, Task, TaskEstimate, TaskFit, TaskLevel, TaskPlace,
    TaskQuantity,
};
use zwidth_tables::Table;

/// (h³ mod 9941)/9941 − ½ with h = 1 + 131 a + 173 b + 197 c + 211 d.
fn scattered([a, b, c, d]: [u64; 4]) -> f64 {
    let h = 1 + 131 * a + 173 * b + 197 * c + 211 * d;
    (h.pow(3) % 9941) as f64 / 9941.0 - 0.5
}

fn level(value: f64) -> TaskLevel {
    TaskLevel::nearest(value).unwrap()
}

fn task(id: &str, text: &str, method: Method) -> Task {
    Task {
        id: id.parse().unwrap(),
        text: text.to_owned(),
        asks: Asks::MoreLess,
        environment: "spring".parse().unwrap(),
        varies: "stiffness_n_per_rad".to_owned(),
        standard: Some(level(300.0)),
        method,
        catch: 0.0,
        feedback: false,
        fit: TaskFit::default(),
        estimate: TaskEstimate::Likelihood,
    }
}

/// Which of seven stiffnesses is more than 300 N/rad, 20 times each; and a staircase that looks for the same.
fn study() -> Study {
    let mut study = zwidth_testing::study();
    study.modes.retain(|mode| matches!(mode.id.as_str(), "active" | "hybrid"));
    study.environments.truncate(1);
    study.compare.contrasts = vec!["hybrid − active".parse().unwrap()];
    let levels = (0..7).map(|l| level(210.0 + 30.0 * f64::from(l))).collect();
    let constant = Method::Constant { levels, trials: 20 };
    let staircase = Method::Staircase(StaircasePlan {
        up_after: 1,
        down_after: 1,
        starts: vec![level(390.0), level(210.0)],
        up: 15.0,
        down: 15.0,
        is_factor: false,
        bounds: [level(150.0), level(450.0)],
        reversals: 10,
        of_last: 6,
        most_trials: 60,
    });
    study.tasks = vec![
        task("stiffer", "Was it stiffer than before?", constant),
        task("equal", "Was it more?", staircase),
    ];
    for task in &study.tasks {
        study.questions.push(Question {
            id: task.id.clone(),
            text: task.text.clone(),
            group: None,
            scale: AnswerScale::Task(task.asks),
            reversed: false,
            label: None,
            is_weight: false,
        });
    }
    study
}

/// PSE and σ of a person in a mode.
fn person(p: u64, m: u64) -> [f64; 2] {
    let pse =
        300.0 + 30.0 * scattered([p, 1, 0, 0]) + 12.0 * m as f64 + 20.0 * scattered([p, 2, m, 0]);
    let grown = 0.8 * scattered([p, 3, 0, 0]) + 0.25 * m as f64 + 0.5 * scattered([p, 4, m, 0]);
    [pse, 1.4826 * 30.0 * libm::exp(grown)]
}

/// Level and answer of every presentation of a person in a mode: of constant stimuli, then of two staircases that take
/// turns.
fn presented(p: u64, m: u64) -> Vec<(&'static str, u8, f64, bool)> {
    let [pse, sigma] = person(p, m);
    let share = |x: f64| {
        let z = (x - pse) / sigma;
        0.02 + 0.96 * 0.5 * libm::erfc(-z * core::f64::consts::FRAC_1_SQRT_2)
    };
    let mut all = Vec::new();
    for l in 0..7 {
        let x = 210.0 + 30.0 * l as f64;
        let counted = 20.0 * share(x) + 0.5 + 2.0 * scattered([p, 10 + m, l, 0]);
        let stiffer = counted.floor().clamp(0.0, 20.0) as u64;
        all.extend((0..20).map(|number| ("stiffer", 0, x, number < stiffer)));
    }
    for track in 0..2_u8 {
        let mut x = if track == 0 { 390.0 } else { 210.0 };
        let (mut turns, mut last, mut number) = (0, None, 0);
        while turns < 10 {
            number += 1;
            let is_more = share(x) > scattered([p, 30 + m, number, u64::from(track)]) + 0.5;
            all.push(("equal", track, x, is_more));
            turns += usize::from(last == Some(!is_more));
            last = Some(is_more);
            x += if is_more { -15.0 } else { 15.0 };
            x = x.clamp(150.0, 450.0);
        }
    }
    all
}

/// The study with its sessions: trials without samples, and answers.
fn data(root: &Path) -> StudyData {
    let mut data = crate::tests::data();
    data.study = study();
    data.layout = Layout::new(root, "demo".parse().unwrap());
    data.trials.clear();
    for p in 1..=8 {
        let participant: zwidth_study::ParticipantId = format!("P{p:02}").parse().unwrap();
        let session: zwidth_study::SessionId = "S01".parse().unwrap();
        let mut trials = Vec::new();
        for (m, mode) in ["active", "hybrid"].into_iter().enumerate() {
            let mut number_of = std::collections::BTreeMap::new();
            for (id, track, x, is_more) in presented(p, m as u64) {
                let presentation = number_of.entry(id).or_insert(0);
                *presentation += 1;
                let trial = trials.len() as u32 + 1;
                let task: QuestionId = id.parse().unwrap();
                trials.push(PlannedTrial {
                    trial,
                    repeat: *presentation,
                    kind: Kind::Trial,
                    environment: "spring".parse().unwrap(),
                    mode: mode.parse().unwrap(),
                    samples: false,
                    task: Some(TaskPlace {
                        task: task.clone(),
                        presentation: *presentation,
                        track,
                        interval: 1,
                        level: Some(level(x)),
                        is_standard: None,
                    }),
                });
                data.answers.push(Answer {
                    participant: participant.clone(),
                    session: session.clone(),
                    trial,
                    condition: Condition {
                        environment: "spring".parse().unwrap(),
                        mode: mode.parse().unwrap(),
                    },
                    question: task,
                    value: if is_more { 1.into() } else { 2.into() },
                    time_ms: None,
                });
            }
        }
        let [path, events_path] =
            ["json", "events.jsonl"].map(|end| root.join(format!("{participant}_S01.{end}")));
        for file in [&path, &events_path] {
            fs::write(file, "").unwrap();
        }
        let record = SessionRecord::new(
            participant,
            session,
            Source::Simulated,
            "zwidth",
            "",
            trials.clone(),
        );
        data.sessions.push(SessionLog {
            record,
            path,
            events: Vec::new(),
            events_path,
            trials,
            seal: None,
            study: None,
        });
    }
    data
}

fn run(data: &StudyData) {
    let jobs = crate::jobs(data, &Findings::default());
    let failed = Mutex::new(Vec::new());
    let results = Results::new(&data.layout, &RealFiles);
    let done = zwidth_runner::run(&jobs, &results, &Options::default(), &|report| {
        if matches!(report.verdict, JobEnd::Failed(_) | JobEnd::Blocked(_)) {
            failed.lock().unwrap().push((report.name.clone(), report.verdict.clone()));
        }
    });
    let failed = failed.into_inner().unwrap();
    assert!(done.is_ok() && failed.is_empty(), "{failed:#?}");
}

/// The numbers over people are those that Python and R found of the same answers.
#[test]
fn thresholds_go_from_answers_to_the_comparison_and_the_summary() {
    let folder = tempfile::tempdir().unwrap();
    // A folder that stays, to look at what is drawn.
    let kept = std::env::var_os("ZWIDTH_KEPT").map(std::path::PathBuf::from);
    let root = kept.as_deref().unwrap_or(folder.path());
    let data = data(root);
    assert_eq!(answered(&data).len(), data.answers.len());
    run(&data);
    let fits: Vec<PsychometricFit> = fits(&data).unwrap().read().unwrap();
    assert_eq!(fits.len(), 8 * 2 * 2);
    let of_staircases = fits.iter().filter(|fit| fit.method == LevelMethod::Staircase);
    assert!(of_staircases.clone().all(|fit| fit.verdict.is_estimated() && fit.jnd.is_none()));
    let rows: Vec<PeopleThreshold> = over_people(&data).unwrap().read().unwrap();
    let jnd = |row: &&PeopleThreshold| row.quantity == TaskQuantity::Jnd && row.contrast.is_some();
    let ratio = rows.iter().find(jnd).unwrap();
    let near = |found: f64, expected: f64| {
        assert!((found - expected).abs() < 1e-5 * expected, "{found} instead of {expected}");
    };
    near(ratio.estimate, 1.398_102_38);
    near(ratio.ci_low.unwrap(), 1.242_896_06);
    near(ratio.ci_high.unwrap(), 1.572_690_05);
    near(ratio.statistic.unwrap(), 6.734_186_76);
    assert_eq!(ratio.n, 8);
    let mean: Vec<Mean> = crate::compare::of_study(&data).unwrap().table().read().unwrap();
    let metrics: Vec<&str> = mean.iter().map(|row| row.metric.as_str()).collect();
    assert_eq!(metrics.len(), 3 * 2, "{metrics:?}");
    let summary = fs::read_to_string(data.layout.reports().join("summary.md")).unwrap();
    let told = "the JND with hybrid is 1.40 times that with active [1.24, 1.57], t(7) = 6.7, p < 0.001; \
                Weber fractions 0.13 and 0.09";
    // Brackets are escaped in Markdown.
    assert!(summary.replace('\\', "").contains(told), "{summary}");
    let tables = data.layout.reports().join("tables");
    for table in ["psychometric", "thresholds", "answers_by_level"] {
        let table = Table::from_parquet(&tables.join(format!("{table}.parquet"))).unwrap();
        assert!(table.height() > 0);
    }
    let figures = data.layout.reports().join("figures");
    for stem in [
        "psychometric.P01.S01.stiffer",
        "staircases.P01.S01.equal",
        "thresholds.stiffer",
        "thresholds.equal",
        "verdicts",
    ] {
        assert!(figures.join(format!("{stem}.png")).exists(), "{stem}");
    }
}

#[test]
fn a_study_without_tasks_has_no_job_of_this_stage() {
    let data = crate::tests::data();
    let jobs = crate::jobs(&data, &Findings::default());
    assert!(jobs.iter().all(|job| job.stage.name != "thresholds"));
    assert!(super::printed(&data).is_empty());
}

#[test]
fn one_person_is_told_and_not_tested() {
    let folder = tempfile::tempdir().unwrap();
    let mut data = data(folder.path());
    data.sessions.truncate(1);
    data.answers.retain(|answer| answer.participant.as_str() == "P01");
    run(&data);
    let rows: Vec<PeopleThreshold> = over_people(&data).unwrap().read().unwrap();
    assert_eq!(rows.len(), 3 * 3);
    assert!(rows.iter().all(|row| row.n == 1 && row.p_adjusted.is_none()), "{rows:?}");
    let summary = fs::read_to_string(data.layout.reports().join("summary.md")).unwrap();
    assert!(summary.contains("the JND with hybrid is 1.38 times that with active"), "{summary}");
}

#[test]
fn what_people_notice_takes_the_place_of_others_findings_where_it_is_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let mut data = data(folder.path());
    assert_eq!(perception(&data), data.study.perception);
    data.study.perception.is_measured = true;
    let own = perception(&data);
    let expected = (0.090_121_635_1_f64 * 0.125_999_272).sqrt();
    assert!((own.compliance_share - expected).abs() < 1e-6, "{own:?}");
    let source = own.source("N/rad").unwrap();
    assert!(source.contains("measured: 8 participants of this study"), "{source}");
    let usual = Perception::default();
    assert_eq!(own.source("N"), usual.source("N"));
}
