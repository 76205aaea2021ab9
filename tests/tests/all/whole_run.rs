//! The main job on the study that comes with the software, through the program.

use crate::binary::{zwidth, zwidth_line};
use crate::folders::{files, listing, workspace};
use crate::{shipped, small};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;
use zwidth_study::{Event, Source};
use zwidth_tables::{Format, Table};

const CONDITIONS: [&str; 6] = [
    "spring.active",
    "spring.passive",
    "spring.hybrid",
    "spring_wall.active",
    "spring_wall.passive",
    "spring_wall.hybrid",
];

/// What the main job made in this folder of the study's reports, by name.
fn made(folder: &str, extension: &str) -> BTreeSet<String> {
    stems(&shipped::folder().join("reports/thesis-twin").join(folder), extension)
}

/// Every figure of the study, by name.
fn figures() -> BTreeSet<String> {
    made("figures", "svg")
}

/// Every printed table of the study, by name.
fn tables() -> BTreeSet<String> {
    made("tables", "csv")
}

/// The records of a run: one for each job.
fn records(root: &Path) -> serde_json::Value {
    let records = root.join("derived/thesis-twin/records.json");
    serde_json::from_slice(&fs::read(records).unwrap()).unwrap()
}

/// Jobs of the study.
fn jobs() -> usize {
    records(shipped::folder()).as_object().unwrap().len()
}

#[test]
fn the_bytes_written_down_are_of_the_versions_that_stages_have() {
    let records = records(shipped::folder());
    let mut versions = BTreeMap::new();
    for record in records.as_object().unwrap().values() {
        versions.insert(record["stage"].as_str().unwrap(), record["version"].as_u64().unwrap());
    }
    let written = include_str!("../../thesis-twin.b3");
    let written: BTreeMap<&str, u64> = written
        .lines()
        .filter_map(|line| line.split_once(' '))
        .map(|(stage, rest)| (stage, rest.split(' ').next().unwrap().parse().unwrap()))
        .collect();
    assert_eq!(written, versions, "after a raised version: `cargo xtask bits renew`");
}

/// The stems of the files with this extension.
fn stems(folder: &Path, extension: &str) -> BTreeSet<String> {
    files(folder, extension)
        .iter()
        .map(|p| p.file_stem().unwrap().to_str().unwrap().to_owned())
        .collect()
}

fn strings(words: &[&str]) -> Vec<String> {
    words.iter().map(|w| (*w).to_owned()).collect()
}

#[test]
fn a_run_makes_every_figure_as_svg_png_pdf_and_data() {
    let folder = shipped::folder().join("reports/thesis-twin/figures");
    for (extension, begins) in
        [("svg", "<?xml".as_bytes()), ("png", b"\x89PNG"), ("pdf", b"%PDF"), ("parquet", b"PAR1")]
    {
        assert_eq!(stems(&folder, extension), figures(), "{extension}");
        for path in files(&folder, extension) {
            assert!(fs::read(&path).unwrap().starts_with(begins), "{}", path.display());
        }
    }
}

/// Schematics are drawn from the plan and from the study's scenes, Table 4 from the plan.
#[test]
fn a_run_draws_the_thesis_schematics_and_gathers_every_caption_in_each_format() {
    let reports = shipped::folder().join("reports/thesis-twin");
    let made = stems(&reports.join("figures"), "svg");
    for name in [
        "control_loop",
        "device",
        "displacement_control",
        "force_control",
        "lever_model",
        "lever_model_forces",
        "model",
        "model_forces",
        "translation",
    ] {
        assert!(made.contains(&format!("schematic.{name}")), "{name} is not in {made:?}");
    }
    let components = fs::read_to_string(reports.join("tables/components.md")).unwrap();
    assert!(components.contains("| motor | drives and resists | 16 |"), "{components}");
    let captions = |extension: &str| {
        fs::read_to_string(reports.join(format!("figures/captions.{extension}"))).unwrap()
    };
    let (tex, typ, md) = (captions("tex"), captions("typ"), captions("md"));
    for name in &made {
        assert!(tex.contains(&format!("\\@namedef{{zwidth@caption@{name}}}{{")), "{name}");
        assert_eq!(typ.matches(&format!("\n  \"{name}\": ")).count(), 2, "{name}");
        assert!(md.contains(&format!("## {}\n\n", name.replace('_', "\\_"))), "{name}");
    }
}

#[test]
fn a_run_makes_every_table_in_every_format_and_they_agree_on_the_number_of_rows() {
    let folder = shipped::folder().join("reports/thesis-twin/tables");
    for extension in Format::ALL.map(Format::extension) {
        assert_eq!(stems(&folder, extension), tables(), "{extension}");
    }
    for path in files(&folder, "parquet") {
        let rows = Table::from_parquet(&path).unwrap().height();
        let csv = fs::read_to_string(path.with_extension("csv")).unwrap();
        assert!(rows > 0 && csv.lines().count() == rows + 1, "{}", path.display());
    }
}

#[test]
fn the_summary_links_every_figure_and_table_and_names_what_was_left_out() {
    let reports = shipped::folder().join("reports/thesis-twin");
    let summary = fs::read_to_string(reports.join("summary.md")).unwrap();
    let links: BTreeSet<&str> =
        summary.split("](").skip(1).map(|s| s.split(')').next().unwrap()).collect();
    assert_eq!(links.len(), figures().len() + tables().len());
    for link in links {
        assert!(reports.join(link).is_file(), "{link}");
    }
    assert!(summary.contains("36 trials that count"), "{summary}");
    assert!(summary.contains("Nothing was left out."), "{summary}");
}

#[test]
fn a_run_leaves_the_raw_data_as_they_were() {
    assert_eq!(
        listing(&shipped::folder().join("raw")),
        listing(&shipped::raw().path().join("raw"))
    );
}

#[test]
fn a_second_run_makes_nothing_and_touches_nothing() {
    let root = shipped::finished();
    let before = listing(root.path());
    let told = format!("thesis-twin: 0 made, {} up to date", jobs());
    zwidth(root.path(), &["run"]).exits(0).prints(&[&told]);
    assert!(zwidth(root.path(), &["run", "--json"]).exits(0).made().is_empty());
    assert_eq!(listing(root.path()), before);
}

#[test]
fn one_thread_and_four_give_the_same_bytes() {
    let root = shipped::finished();
    let before = listing(root.path());
    let fresh = zwidth(root.path(), &["--threads", "1", "--json", "run", "thesis-twin", "--fresh"])
        .exits(0);
    assert_eq!(fresh.json()[0]["up_to_date"], 0);
    assert_eq!(fresh.made().len(), jobs());
    assert_eq!(listing(root.path()), before);
}

#[test]
fn a_superseded_trial_remakes_what_depends_on_it_and_nothing_else() {
    let root = shipped::finished();
    shipped::log(root.path(), Event::Superseded { trial: 4, by: 40 });
    let ran = zwidth(root.path(), &["run", "--json"]).exits(0);
    // The plant rests on all trials, and so do every figure of it, the metrics with it and the
    // replays of the fitted model. No other condition's mean, replays by eye and figures do, nor
    // anything about the actuators. What is compared rests on the metrics of all.
    let mut expect = strings(&[
        "agreement of model and recordings",
        "average P01 S01 spring hybrid",
        "captions",
        "courses P01 S01 spring",
        "courses P01 S01 spring_wall",
        "figure likert",
        "figure loops.P01.S01",
        "figure modes.P01.S01.spring",
        "figure modes.P01.S01.spring_wall", // its axes hold what was recorded with the spring too
        "figure repeats.P01.S01.spring.hybrid",
        "figure replay.P01.S01.spring",
        "figure replay.P01.S01.spring_wall",
        "figure trade_data",
        "identify",
        "less of P01 S01 spring hybrid",
        "less of the study's recordings",
        "likert tallies",
        "metrics P01 S01",
        "metrics by condition",
        "metrics of the study",
        "pros and cons",
        "replay P01 S01 spring hybrid",
        "replay of the study",
        "runs P01 S01 spring",
        "metrics P01 S01 with the plant",
        "runs P01 S01 spring_wall",
        "sliders P01 S01",
        "page",
        "summary",
        "table conditions",
        "table identify",
        "table identify.covariance",
        "table identify.held_out",
        "table identify.profile",
        "table identify.threshold",
        "table identify.trials",
        "table likert",
        "table metrics",
        "table pros_cons",
        "table replay",
        "table replay.agreement",
        "table thesis",
        "thesis' statements",
        "trials",
    ]);
    for condition in CONDITIONS.map(|c| c.replace('.', " ")) {
        expect.push(format!("replay P01 S01 {condition} fitted"));
    }
    // With the models' runs.
    expect.extend(["spring", "spring_wall"].map(|it| format!("samples P01 S01 {it}")));
    let compared = |name: &&String| {
        [
            "compare.",
            "comparison",
            "curve_tests",
            "curves.",
            "learning.",
            "means_",
            "contrasts_",
            "learning_",
            "orders_",
            "answers",
            "verdicts",
        ]
        .iter()
        .any(|begin| name.starts_with(begin))
    };
    expect.extend(figures().iter().filter(compared).map(|name| format!("figure {name}")));
    expect.extend(tables().iter().filter(compared).map(|name| format!("table {name}")));
    expect.extend(["compare metrics", "compare answers", "compare curves"].map(str::to_owned));
    expect.sort();
    assert_eq!(ran.made(), expect);
    let metrics =
        Table::from_parquet(&root.path().join("derived/thesis-twin/metrics.parquet")).unwrap();
    assert!(!metrics.integers("trial").unwrap().contains(&Some(4)));
    assert!(zwidth(root.path(), &["run", "--json"]).made().is_empty());
}

#[test]
fn a_changed_sweep_remakes_its_own_characteristic_and_what_rests_on_its_forces_and_nothing_else() {
    let root = shipped::finished();
    shipped::change_sweep(root.path(), "raw/thesis-twin/sweeps/actuator=motor/sweep-02.parquet");
    let ran = zwidth(root.path(), &["run", "--json"]).exits(0);
    let expect = [
        "calibration",
        "captions",
        "characteristic of motor",
        "figure characteristic.motor",
        "figure rendering_range",
        "modes and weights",
        "page",
        "pros and cons",
        "summary",
        "table characteristic.motor",
        "table modes",
        "table parameters.motor",
        "table pros_cons",
        "table thesis",
        "table weight",
        "thesis' statements",
    ];
    assert_eq!(ran.made(), expect);
    let why = ran.json()[0]["made"][0]["why"].as_str().unwrap().to_owned();
    assert_eq!(why, "input raw/thesis-twin/sweeps/actuator=motor/sweep-02.parquet changed");
}

#[test]
fn a_removed_result_is_made_again_to_the_same_bytes() {
    let root = shipped::finished();
    let before = listing(root.path());
    fs::remove_file(root.path().join("reports/thesis-twin/figures/likert.png")).unwrap();
    fs::write(root.path().join("reports/thesis-twin/tables/likert.csv"), "edited by hand\n")
        .unwrap();
    let ran = zwidth(root.path(), &["run", "--json"]).exits(0);
    assert_eq!(ran.made(), ["figure likert", "table likert"]);
    assert_eq!(listing(root.path()), before);
}

#[test]
fn only_makes_a_stage_a_figure_or_a_table_and_what_it_needs() {
    let root = shipped::raw();
    let only = |name: &str| zwidth(root.path(), &["run", "--json", "--only", name]).exits(0).made();
    assert_eq!(only("likert tallies"), ["likert tallies"]);
    let expect = [
        "identify",
        "metrics P01 S01",
        "metrics P01 S01 with the plant",
        "metrics by condition",
        "metrics of the study",
        "table conditions",
    ];
    assert_eq!(only("conditions"), expect);
    assert_eq!(only("repeats.P01.S01.spring.active"), ["figure repeats.P01.S01.spring.active"]);
    assert!(!root.path().join("reports/thesis-twin/summary.md").exists());
    let again = zwidth(root.path(), &["run", "--only", "likert tallies"]).exits(0);
    assert!(!again.out.contains("summary.md"), "it is not there to be looked at: {again:#?}");
    zwidth(root.path(), &["run", "--only", "nonsense"]).exits(1).says(&[
        "nonsense",
        "characterise",
        "`zwidth figure thesis-twin` lists the figures",
    ]);
}

/// A job by the records of a run: its stage, what it read and what it made.
struct Recorded {
    name: String,
    stage: String,
    inputs: BTreeSet<String>,
    outputs: BTreeSet<String>,
}

fn recorded(root: &Path) -> Vec<Recorded> {
    let paths = |of: &serde_json::Value| of.as_object().unwrap().keys().cloned().collect();
    let job = |(name, record): (&String, &serde_json::Value)| Recorded {
        name: name.clone(),
        stage: record["stage"].as_str().unwrap().to_owned(),
        inputs: paths(&record["inputs"]),
        outputs: paths(&record["outputs"]),
    };
    records(root).as_object().unwrap().iter().map(job).collect()
}

/// The jobs that are called so, by stage, name or the stem of an output, and those whose outputs they
/// read.
fn called(jobs: &[Recorded], name: &str) -> BTreeSet<String> {
    let is_stem = |path: &String| Path::new(path).file_stem().unwrap() == name;
    let is_called =
        |job: &&Recorded| job.stage == name || job.name == name || job.outputs.iter().any(is_stem);
    let mut found: Vec<&Recorded> = jobs.iter().filter(is_called).collect();
    let mut names = BTreeSet::new();
    while let Some(job) = found.pop() {
        if names.insert(job.name.clone()) {
            found.extend(jobs.iter().filter(|maker| !maker.outputs.is_disjoint(&job.inputs)));
        }
    }
    names
}

/// A run that is asked for a stage does not plan all others.
#[test]
fn only_a_stage_makes_what_a_whole_run_makes_of_it_and_for_it() {
    let root = shipped::finished();
    let jobs = recorded(root.path());
    let stages: BTreeSet<&str> = jobs.iter().map(|job| job.stage.as_str()).collect();
    assert!(stages.len() > 12, "{stages:?}");
    for stage in stages {
        let words = ["run", "--fresh", "--dry-run", "--json", "--only", stage];
        let found = zwidth(root.path(), &words).exits(0).made();
        assert_eq!(BTreeSet::from_iter(found), called(&jobs, stage), "{stage}");
    }
    let before = listing(root.path());
    let made = zwidth(root.path(), &["run", "--fresh", "--json", "--only", "metrics"]).exits(0);
    assert!(made.made().contains(&"table metrics".to_owned()));
    assert_eq!(listing(root.path()), before, "and the records of all others are kept");
}

#[test]
fn a_dry_run_says_what_would_be_made_and_makes_nothing() {
    let root = shipped::raw();
    let before = listing(root.path());
    let dry = zwidth(root.path(), &["run", "--dry-run", "--json"]).exits(0);
    assert_eq!(dry.made().len(), jobs());
    assert_eq!(listing(root.path()), before);
    zwidth(root.path(), &["run", "--dry-run"]).exits(0).says(&["metrics P01 S01: never made"]);
}

#[test]
fn every_listing_is_json_where_it_is_asked_for() {
    let root = shipped::finished();
    let excluded = Event::Excluded { trial: 20, reason: "slipped off".to_owned() };
    shipped::log(root.path(), excluded);
    let json = |arguments: &[&str]| zwidth(root.path(), arguments).exits(0).json();
    let list = json(&["list", "--json"]);
    assert_eq!(list[0]["sessions"][0]["trials_that_count"], 35);
    assert_eq!(list[0]["sessions"][0]["familiarisation"], 3);
    assert_eq!(list[0]["sessions"][0]["left_out"][0], "trial 20: excluded: slipped off");
    assert_eq!(list[0]["sweeps"]["motor"], 15);
    assert_eq!(json(&["verify", "--json"]), serde_json::json!([]));
    assert_eq!(json(&["table", "thesis-twin", "--json"]).as_array().unwrap().len(), tables().len());
}

#[test]
fn methods_in_words_count_what_was_recorded() {
    let root = shipped::finished();
    let words = ["1 participant, 1 session, 36 trials that count", "All data are simulated"];
    zwidth(root.path(), &["methods", "thesis-twin"]).exits(0).prints(&words);
    zwidth(root.path(), &["methods", "thesis-twin", "--format", "tex"])
        .exits(0)
        .prints(&["\\subsection{Statistics}"]);
    zwidth(root.path(), &["methods", "nowhere"]).exits(1).one_error();
}

#[test]
fn the_exit_code_is_1_where_it_failed_and_2_where_the_arguments_are_bad() {
    let empty = tempfile::tempdir().unwrap();
    zwidth(empty.path(), &["run"]).exits(1).one_error().says(&["raw", "--root"]);
    fs::create_dir(empty.path().join("raw")).unwrap();
    zwidth(empty.path(), &["run"]).exits(1).one_error().says(&["there is no study", "zwidth new"]);
    zwidth(empty.path(), &["run", "nothing"])
        .exits(1)
        .says(&["raw/nothing/study.toml", "zwidth new nothing"]);
    for bad in [
        &["run", "--nonsense"][..],
        &["nonsense"],
        &["--threads", "many", "run"],
        &["import", "demo"],
        &[],
    ] {
        zwidth(empty.path(), bad).exits(2);
    }
}

/// Whether a figure bears the mark of simulated data, in letters that are drawn.
fn is_marked(svg: &Path) -> bool {
    const MARK: &str = "SYNTHETIC: simulated, not measured";
    let text = fs::read_to_string(svg).unwrap();
    let Some((_, group)) = text.split_once(&format!("<g aria-label=\"{MARK}\"")) else {
        return false;
    };
    let letters = group.split_once("</g>").unwrap().0.matches("<use ").count();
    assert_eq!(letters, MARK.replace(' ', "").len(), "{}", svg.display());
    true
}

#[test]
fn every_figure_of_simulated_data_says_so_on_its_face() {
    let reports = shipped::folder().join("reports/thesis-twin");
    for svg in files(&reports, "svg") {
        // A drawing of the plan holds no data, and a model run says that it is one.
        let name = svg.file_name().unwrap().to_str().unwrap();
        let holds_none = ["environment.", "schematic.", "scenes.", "trade."]
            .iter()
            .any(|begin| name.starts_with(begin));
        assert_eq!(is_marked(&svg), !holds_none, "{}", svg.display());
    }
    let summary = fs::read_to_string(reports.join("summary.md")).unwrap();
    assert!(
        summary.contains("**All data are simulated: nothing here was measured.**"),
        "{summary}"
    );
}

#[test]
fn every_table_of_simulated_data_says_so_below_it() {
    // What is written in study.toml, and runs of models.
    const HOLD_NONE: [&str; 7] =
        ["components", "device", "model", "modes", "trade", "trade_summary", "weight"];
    let folder = shipped::folder().join("reports/thesis-twin/tables");
    for extension in ["md", "html", "tex", "typ"] {
        for table in files(&folder, extension) {
            let name = table.file_stem().unwrap().to_str().unwrap();
            let marks = fs::read_to_string(&table).unwrap().matches("SYNTHETIC").count();
            let expected = usize::from(!HOLD_NONE.contains(&name));
            assert_eq!(marks, expected, "{}", table.display());
        }
    }
}

#[test]
fn a_figure_is_marked_exactly_where_it_holds_simulated_data() {
    let study = small::Study::new("mixed");
    let answered =
        |trial| small::Draft { likert: Some(4), ..small::draft(trial, "spring", "hybrid") };
    study.session("P01", &[answered(1), answered(2)]);
    study.session(
        "P02",
        &[answered(1), answered(2)].map(|d| small::Draft { source: Source::Twin, ..d }),
    );
    study.sweep();
    zwidth(study.root(), &["run"]).exits(0);
    let marked = |svg: &std::path::PathBuf| {
        is_marked(svg).then(|| svg.file_stem().unwrap().to_str().unwrap().to_owned())
    };
    let all = files(&study.layout().reports(), "svg");
    let found: Vec<String> = all.iter().filter_map(marked).collect();
    assert_eq!(all.len(), 22);
    let simulated = [
        "likert",
        "loops.P02.S01",
        "mean_loops",
        "modes.P02.S01.spring",
        "repeats.P02.S01.spring.hybrid",
        "trade_data",
    ];
    assert_eq!(found, simulated);
}

#[test]
fn a_damaged_trial_is_told_skipped_and_listed_by_every_run() {
    let study = small::Study::new("demo2");
    study.session("P01", &small::repeats("spring", "hybrid", 1..=4));
    let path = study.trial("P01", 3);
    let root = study.root();
    zwidth(root, &["run"]).exits(0);
    // The first bytes after the magic number are those of the first column's pages.
    crate::folders::flip_bit(&path, 60);
    for run in 1..=2 {
        let ran = zwidth(root, &["run", "--json"]).exits(3);
        assert!(
            ran.left_out().iter().any(|l| l.contains("trial-003.parquet")),
            "run {run}: {ran:#?}"
        );
        assert_eq!(ran.made().is_empty(), run == 2, "{ran:#?}");
        zwidth(root, &["run"]).exits(3).says(&[
            "warning: left out: ",
            "trial-003.parquet",
            "restore the file",
        ]);
    }
    let metrics = Table::from_parquet(&root.join("derived/demo2/metrics.parquet")).unwrap();
    assert_eq!(metrics.integers("trial").unwrap(), [Some(1), Some(2), Some(4)]);
}

#[test]
fn the_study_that_comes_along_has_no_findings() {
    let found = zwidth(workspace(), &["verify", "thesis-twin"]).exits(0);
    assert_eq!(found.out, "thesis-twin: no findings (schema 2)\n");
}

/// Nothing of the machine, of the time or of the number of threads is in it.
#[test]
fn the_study_that_comes_along_follows_from_its_seed_byte_for_byte() {
    let root = tempfile::tempdir().unwrap();
    let twin = "twin thesis-twin --participants 1 --sessions 1 --seed 1 --rate 120";
    zwidth_line(root.path(), twin).exits(0);
    // The figures of scenes, and the scenes, are the study's own; that these are those of `scenes/`
    // is told elsewhere.
    let text = |root: &Path| fs::read_to_string(root.join("raw/thesis-twin/study.toml")).unwrap();
    let (made, shipped) = (text(root.path()), text(workspace()));
    let more = shipped.strip_prefix(&made).unwrap();
    assert!(more.starts_with("\n# The thesis' figures of its model"), "{more}");
    let is_made = |name: &String| name != "study.toml" && !name.starts_with("scenes");
    let raw = |root: &Path| {
        let mut found = listing(&root.join("raw/thesis-twin"));
        found.retain(|name, _| is_made(name));
        found
    };
    assert_eq!(raw(root.path()), raw(workspace()));
}
