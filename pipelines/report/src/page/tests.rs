use super::*;
use crate::Summary;
use crate::compared::tests::{
    between_groups, difference, mean, metric, unestimated, without_results,
};
use crate::{ComparedMetric, Made, Matrix, MatrixRow, Remark, Told};
use std::collections::BTreeMap;
use zwidth_results::{
    EffectDifference, GivenAnswer, GroupDifference, GroupMember, Mean, ModeDifference, PersonValue,
    Row as _, TrialKey, UnitOfAnalysis, Verdict,
};
use zwidth_study::{AnswerValue, Effect, Families, Setup, Source, Weight};
use zwidth_tables::{Column, Measured, Table};

/// What nobody should be able to put into a page.
const HOSTILE: &str = "</script><script>alert('x')</script>\"'&\u{7}\\ {{}} <!-- %";

fn planned() -> Setup {
    Setup::of(&zwidth_testing::study())
}

fn summary() -> Summary {
    Summary {
        title: "A spring".to_owned(),
        device: "lever".to_owned(),
        participants: 1,
        sessions: 1,
        trials: 2,
        sources: BTreeMap::from([(Source::Twin, 2)]),
        matrix: Matrix {
            modes: vec![("active".parse().unwrap(), "Active".to_owned())],
            rows: vec![MatrixRow {
                metric: "largest angle (°)".to_owned(),
                environment: "spring".parse().unwrap(),
                label: "Spring".to_owned(),
                cells: vec![Some("30 ± 1 (2)".to_owned())],
            }],
            caption: "Mean ± standard deviation.".to_owned(),
        },
        shown: vec![
            Made::new("figures/modes.P01.png", "The modes differ."),
            Made::new("tables/metrics.md", "It was smooth."),
        ],
        figures: vec![Made::new("figures/modes.P01.png", "modes (P01)")],
        tables: vec![Made::new("tables/metrics.md", "Metrics")],
        left_out: vec![Remark { what: "trial 7".to_owned(), why: "excluded".to_owned() }],
        ..Summary::default()
    }
}

/// Two trials, the first with a metric and an answer.
fn metrics() -> Measured {
    let key = |(trial, repeat): (u32, u32)| TrialKey {
        participant: "P01".parse().unwrap(),
        session: "S01".parse().unwrap(),
        trial,
        repeat,
        environment: "spring".parse().unwrap(),
        mode: "active".parse().unwrap(),
        source: Source::Twin,
    };
    let mut columns = TrialKey::columns(&[(4, 1), (3, 2)].map(key));
    columns.push(Column::float("theta_max_rad", "rad", "largest angle", [Some(0.5), None]));
    Measured::of(Table::new("metrics", "Metrics", columns).unwrap()).unwrap()
}

fn recorded(metrics: &Measured) -> TrialValues<'_> {
    TrialValues { recorded: Some(metrics), scores: &[] }
}

fn estimating() -> Estimating {
    Estimating {
        level: 0.95,
        alpha: 0.05,
        families: Families::Metric,
        curve_claims: 0,
        has_groups: false,
        perception: zwidth_study::Perception::default(),
        of_plant: Vec::new(),
        effects: Vec::new(),
        items: BTreeMap::new(),
    }
}

fn with_answer(planned: &Setup, title: &str, answer: AnswerValue) -> Contents {
    let of = UnitOfAnalysis::TrialsOf("P01".parse().unwrap());
    let metric = metric("theta_max_rad", "rad", "largest angle", of);
    // The upper ends of the intervals are not known.
    let (low, high) = (Some(0.25), None);
    let active = Mean { ci_low: low, ci_high: high, ..mean(&metric, "active", 0.5, None) };
    let contrast = ModeDifference {
        difference: 0.5,
        difference_ci_low: low,
        difference_ci_high: high,
        ..difference(&metric, Verdict::Undecided)
    };
    let compared =
        ComparedMetric { means: &[active], contrasts: &[contrast], ..without_results(&metric) };
    let given = GivenAnswer {
        participant: "P01".parse().unwrap(),
        session: "S01".parse().unwrap(),
        trial: 4,
        environment: "spring".parse().unwrap(),
        mode: "active".parse().unwrap(),
        question: planned.questions[0].id.clone(),
        answer,
        answer_time_s: None,
        counts: true,
        why_not: None,
    };
    Contents::of("s", title, planned, &estimating(), recorded(&metrics()), &[compared], &[given])
}

fn page(summary: &Summary) -> String {
    let planned = planned();
    let contents = with_answer(&planned, &summary.title, 5.into());
    written(&Page {
        summary,
        planned: &planned,
        study: "s",
        contents: Some(&contents),
        origin: Some("zwidth:page:1:00"),
        version: "0.1.0",
    })
}

fn written(page: &Page) -> String {
    let mut html = Vec::new();
    page_html(page).write(page.contents, &mut html).unwrap();
    String::from_utf8(html).unwrap()
}

/// The JSON that the script reads.
fn data_of(html: &str) -> serde_json::Value {
    let (_, rest) = html.split_once("id=\"study-data\" type=\"application/json\">").unwrap();
    serde_json::from_str(rest.split_once("</script>").unwrap().0).unwrap()
}

#[test]
fn a_table_that_is_there_for_programs_alone_is_linked_as_that() {
    let links = |summary: &Summary| -> Vec<String> {
        let text = page(summary);
        let links = text.split("href=\"").skip(1).filter_map(|rest| rest.split('"').next());
        links.filter(|link| link.starts_with("tables/metrics")).map(str::to_owned).collect()
    };
    let mut long = summary();
    assert_eq!(links(&long).len(), 7, "a sentence, and six forms");
    for made in long.shown.iter_mut().chain(&mut long.tables) {
        made.path = made.path.replace(".md", ".csv");
    }
    let [csv, parquet] = ["csv", "parquet"].map(|form| format!("tables/metrics.{form}"));
    assert_eq!(links(&long), [csv.clone(), csv.clone(), csv, parquet]);
}

#[test]
fn the_parts_stand_in_their_order_and_the_simulated_are_marked() {
    let html = page(&summary());
    let ids = [
        "id=\"top\"",
        "class=\"synthetic\"",
        "id=\"matrix\"",
        "id=\"dots\"",
        "id=\"answers\"",
        "id=\"findings\"",
        "id=\"trials\"",
        "id=\"quality\"",
        "id=\"figures\"",
        "id=\"tables\"",
        "id=\"provenance\"",
        "id=\"study-data\"",
        "zwidth:page:1:00 (",
    ];
    let places: Vec<usize> = ids.map(|id| html.find(id).expect(id)).to_vec();
    assert!(places.is_sorted(), "{places:?}");
    assert!(!html.contains("id=\"statements\""), "nothing was judged");
}

#[test]
fn a_cell_opens_its_trials_and_a_sentence_leads_to_its_figure() {
    let html = page(&summary());
    let cell =
        "<a href=\"#trials\" data-environment=\"spring\" data-mode=\"active\">30 ± 1 (2)</a>";
    assert!(html.contains(cell), "{html}");
    assert!(html.contains("The modes differ. (<a href=\"#figure-modes.P01\">figure</a>)"));
    assert!(
        html.contains("id=\"figure-modes.P01\"") && html.contains("src=\"figures/modes.P01.svg\"")
    );
    assert!(html.contains("It was smooth. (<a href=\"tables/metrics.html\">table</a>)"));
}

#[test]
fn the_script_has_a_whole_answer_as_one_and_another_with_its_decimals() {
    for (answer, shown) in [(5.0, "[5,"), (47.273, "[47.273,")] {
        let answer = AnswerValue::new(answer).unwrap();
        let contents = serde_json::to_string(&with_answer(&planned(), "", answer)).unwrap();
        assert!(contents.contains(&format!("\"answers\":{shown}")), "{contents}");
    }
}

#[test]
fn the_script_knows_each_trial_with_its_metrics_and_answers() {
    let data = data_of(&page(&summary()));
    let expect = serde_json::json!([
        {"participant": "P01", "session": "S01", "environment": "spring", "mode": "active", "repeat": 1, "trial": 4,
         "data": "P01.S01.spring.active", "metrics": [0.5], "answers": data["trials"][0]["answers"]},
        {"participant": "P01", "session": "S01", "environment": "spring", "mode": "active", "repeat": 2, "trial": 3,
         "data": "P01.S01.spring.active", "metrics": [null], "answers": []},
    ]);
    assert_eq!(data["trials"], expect);
    assert_eq!(data["trials"][0]["answers"][0], 5);
    let metric = &data["metrics"][0];
    assert_eq!(
        (metric["label"].as_str(), metric["unit"].as_str()),
        (Some("largest angle"), Some("°"))
    );
    assert_eq!(metric["scale"].as_f64(), Some(1_f64.to_degrees()));
}

#[test]
fn any_text_is_text() {
    let hostile = |made: &Made| Made { caption: HOSTILE.into(), ..made.clone() };
    let plain = summary();
    let remark = Remark { what: HOSTILE.to_owned(), why: HOSTILE.to_owned() };
    let all = Summary {
        title: HOSTILE.to_owned(),
        device: HOSTILE.to_owned(),
        shown: plain.shown.iter().map(hostile).collect(),
        figures: plain.figures.iter().map(hostile).collect(),
        tables: plain.tables.iter().map(hostile).collect(),
        statements: HOSTILE.to_owned(),
        judged: vec![Told {
            statement: HOSTILE.to_owned(),
            source: HOSTILE.to_owned(),
            verdict: HOSTILE.to_owned(),
            evidence: HOSTILE.to_owned(),
            path: "figures/modes.P01.png".to_owned(),
        }],
        left_out: vec![remark.clone()],
        care: vec![remark],
        limits: vec![HOSTILE.to_owned()],
        ..plain.clone()
    };
    let (html, without) = (page(&all), page(&plain));
    let scripts = |html: &str| html.matches("<script").count();
    assert_eq!(scripts(&html), scripts(&without));
    assert!(!html.contains("<script>alert"), "{html}");
    assert_eq!(data_of(&html)["title"], HOSTILE);
}

#[test]
fn a_study_without_trials_has_no_browser_and_a_page_still() {
    let html = written(&Page {
        summary: &Summary { title: "Empty".to_owned(), ..Summary::default() },
        planned: &planned(),
        study: "s",
        contents: None,
        origin: None,
        version: "0.1.0",
    });
    assert!(!html.contains("id=\"trials\"") && !html.contains("study-data\" type"));
    assert!(html.contains("There is no trial that counts"), "{html}");
}

#[test]
fn one_file_holds_pictures_and_samples_and_is_else_the_same() {
    let html = page(&summary());
    let course = |key: &str| condition_script(key, &[], &[], &[]).unwrap() + "// origin\n";
    let one = single_file(&html, |path| match path {
        "figures/modes.P01.svg" => Ok(b"<svg/>".to_vec()),
        "report-data/P01.S01.spring.js" => Ok(course("P01.S01.spring.active").into_bytes()),
        other => panic!("{other}"),
    })
    .unwrap();
    assert!(
        one.contains("src=\"data:image/svg+xml;base64,PHN2Zy8+\"")
            && !one.contains("src=\"figures/")
    );
    let data =
        "data-key=\"P01.S01.spring.active\">{\"trials\":[],\"means\":{},\"replay\":{}}</script>";
    assert!(one.contains(data), "{one}");
    assert_eq!(
        (data_of(&html)["single_file"].as_bool(), data_of(&one)["single_file"].as_bool()),
        (Some(false), Some(true))
    );
    let other = single_file(&html, |_| Ok(b"something else".to_vec())).unwrap_err();
    assert!(other.to_string().contains("run it again"), "{other}");
    // It loads nothing any more, and shows what is in it alone.
    assert!(one.contains("; img-src data:;") && !one.contains("strict-dynamic"), "{one}");
}

#[test]
fn a_page_that_is_not_ours_or_shows_what_is_no_figure_does_not_become_one_file() {
    let html = page(&summary());
    let nothing = |path: &str| -> io::Result<Vec<u8>> { panic!("{path} was read") };
    let figure = " src=\"figures/modes.P01.svg\"";
    assert_eq!(html.matches(figure).count(), 1);
    for other in ["../secret.svg", "https://example.org/x.svg", "report-data/x.js", ""] {
        let edited = html.replace(figure, &format!(" src=\"{other}\""));
        let error = single_file(&edited, nothing).unwrap_err().to_string();
        assert!(error.contains(&format!("'{other}'")) && error.contains("zwidth run"), "{error}");
    }
    let without_policy = html.replace("Content-Security-Policy", "").replace("default-src", "");
    let error = single_file(&without_policy, nothing).unwrap_err().to_string();
    assert!(error.contains("zwidth run"), "{error}");
}

#[test]
fn the_policy_stands_before_all_that_it_is_about_and_names_the_page_s_own_script_and_style() {
    let html = page(&summary());
    let (before, after) = html.split_once("http-equiv=\"Content-Security-Policy\"").unwrap();
    assert!(
        !before.contains("<script") && !before.contains("<style") && !before.contains("<title")
    );
    let policy = after.split('"').nth(1).unwrap();
    assert!(policy.starts_with("default-src 'none'; script-src 'sha256-"), "{policy}");
    assert!(!policy.contains("unsafe") && !policy.contains("http"), "{policy}");
    assert!(!html.contains(" style=\""), "an attribute that the policy forbids");
}

#[test]
fn the_script_gets_means_and_differences_with_their_intervals_as_the_tables_have_them() {
    let data = data_of(&page(&summary()));
    let mean = serde_json::json!([{
        "environment": "spring", "of": "active", "value": 0.5, "low": 0.25, "high": null, "sd": null,
        "n": 6, "unit_of_analysis": "trials of P01",
    }]);
    let difference = serde_json::json!([{
        "environment": "spring", "of": "hybrid − active", "mode": "hybrid", "against": "active",
        "value": 0.5, "error": 0.02, "low": 0.25, "high": null, "n": 6,
        "unit_of_analysis": "trials of P01", "means": [0.1, 0.2], "verdict": "undecided",
        "size": null, "p_adjusted": 0.0123, "bound": null, "jnd": null, "is_commanded": false,
    }]);
    assert_eq!(data["metrics"][0]["means"], mean);
    assert_eq!(data["metrics"][0]["differences"], difference);
    assert_eq!((&data["level"], &data["families"]), (&0.95.into(), &"metric".into()));
}

#[test]
fn the_script_knows_how_many_claims_on_curves_share_alpha_with_primary_metrics() {
    let with_curves = serde_json::to_value(with_score(None)).unwrap();
    assert_eq!(
        (&with_curves["families"], &with_curves["curve_claims"]),
        (&"study".into(), &6.into())
    );
    assert_eq!(data_of(&page(&summary()))["curve_claims"], 0);
}

/// A score after trials 4 and 9, of which the first is recorded where `recorded` has it.
fn with_score(recorded: Option<&Measured>) -> Contents {
    let metric = metric("score_comfort", "points", "comfort", UnitOfAnalysis::Participants);
    let length =
        self::metric("theta_max_rad", "rad", "largest angle", UnitOfAnalysis::Participants);
    let key = |trial: u32| TrialKey { trial, ..metrics().trials()[0].clone() };
    let mut columns = TrialKey::columns(&[4, 9].map(key));
    columns.push(Column::float("score_comfort", "points", "comfort", [Some(2.0), Some(5.0)]));
    let scores = [Measured::of(Table::new("scores", "Scores", columns).unwrap()).unwrap()];
    let planned = planned();
    let questions: Vec<_> = planned.questions.iter().rev().map(|own| own.id.clone()).collect();
    let estimating = Estimating {
        families: Families::Study,
        curve_claims: 6,
        items: BTreeMap::from([("score_comfort".to_owned(), questions)]),
        ..estimating()
    };
    let compared = [without_results(&metric), without_results(&length)];
    let values = TrialValues { recorded, scores: &scores };
    Contents::of("s", "Scores", &planned, &estimating, values, &compared, &[])
}

#[test]
fn a_score_is_a_metric_with_its_questions_and_what_was_not_recorded_has_no_samples() {
    let metrics = metrics();
    let both = with_score(Some(&metrics));
    let data = serde_json::to_value(&both).unwrap();
    let items: Vec<usize> = (0..planned().questions.len()).rev().collect();
    assert_eq!(data["metrics"][0]["items"], serde_json::json!(items));
    assert_eq!(data["metrics"][1]["items"], serde_json::Value::Null);
    let of = |place: usize| {
        let trial = &data["trials"][place];
        [&trial["trial"], &trial["data"], &trial["metrics"]].map(ToString::to_string)
    };
    let samples = "\"P01.S01.spring.active\"";
    // Recorded trials first, in their order; the score of trial 4 stands beside its angle.
    assert_eq!(of(0), ["4", samples, "[2.0,0.5]"]);
    assert_eq!(of(1), ["3", samples, "[null,null]"]);
    assert_eq!(of(2), ["9", "null", "[5.0,null]"]);
    assert!(both.has_recordings());

    let alone = with_score(None);
    let summary = summary();
    let planned = planned();
    let html = written(&Page {
        summary: &summary,
        planned: &planned,
        study: "s",
        contents: Some(&alone),
        origin: None,
        version: "0.1.0",
    });
    assert_eq!(data_of(&html)["trials"].as_array().unwrap().len(), 2);
    assert_eq!(data_of(&html)["metrics"].as_array().unwrap().len(), 1);
    for absent in ["id=\"trials\"", "href=\"#trials", "Order of conditions", "Each number opens"] {
        assert!(!html.contains(absent), "{absent}");
    }
    assert!(html.contains("id=\"dots\""));
    // As one file it needs no script of samples.
    let one = single_file(&html, |path| match path.strip_prefix("figures/") {
        Some(_) => Ok(b"<svg/>".to_vec()),
        None => panic!("{path} was read"),
    });
    assert!(!one.unwrap().contains("trial-data\" data-key"));
}

/// An effect that was shown, one that cannot be estimated, and a claim about groups beside a description.
fn with_claims() -> Contents {
    let metric = metric("force_mean_n", "N", "mean force", UnitOfAnalysis::Participants);
    let effect = |levels: &str, difference: Option<f64>, verdict| EffectDifference {
        levels: Some(levels.parse().unwrap()),
        difference,
        difference_std_error: difference.map(|_| 0.1),
        difference_ci_low: difference.map(|d| d - 0.25),
        difference_ci_high: difference.map(|d| d + 0.25),
        df: difference.map(|_| 3.0),
        verdict,
        ..unestimated(&metric)
    };
    let groups = |effect: &str, verdict| GroupDifference {
        effect: effect.parse().unwrap(),
        verdict,
        ..between_groups(&metric)
    };
    let effects = [
        effect("yes − no", Some(0.5), Verdict::Different),
        effect("later − no", None, Verdict::NotTested),
    ];
    let groups = [groups("hybrid − active", Some(Verdict::Undecided)), groups("hybrid", None)];
    let value = |effect: &str, participant: &str, value| PersonValue {
        metric: metric.metric.clone(),
        unit: metric.unit.clone(),
        environment: Some("spring".parse().unwrap()),
        effect: effect.parse().unwrap(),
        participant: participant.parse().unwrap(),
        value,
    };
    // Another effect, and who has no group, are in none of them. One novice is too few for values of their own.
    let values = [
        value("motor: yes − no", "P01", 0.375),
        value("motor: yes − no", "P02", 0.625),
        value("brake: yes − no", "P01", 9.0),
        value("hybrid − active", "P01", 0.5),
        value("hybrid − active", "P02", 0.25),
        value("hybrid − active", "P03", 0.125),
        value("hybrid − active", "P04", 9.0),
        value("hybrid − active", "P05", 0.25),
    ];
    let member = |participant: &str, group: &str| GroupMember {
        participant: participant.parse().unwrap(),
        group: group.parse().unwrap(),
    };
    let members = [("P01", "expert"), ("P02", "novice"), ("P03", "expert"), ("P05", "expert")]
        .map(|(participant, group)| member(participant, group));
    let compared = ComparedMetric {
        effects: &effects,
        groups: &groups,
        group_members: &members,
        person_values: &values,
        ..without_results(&metric)
    };
    let weight = |mode: &str, weight| Weight {
        session: None,
        environment: "spring".parse().unwrap(),
        mode: mode.parse().unwrap(),
        weight,
    };
    let motor = Effect {
        term: "motor".parse().unwrap(),
        levels: vec!["yes − no".parse().unwrap()],
        environment: Some("spring".parse().unwrap()),
        weights: vec![weight("hybrid", 1.0), weight("passive", 0.0), weight("active", -1.0)],
        over: None,
        is_claimed: true,
        lacks: None,
    };
    let mut columns = TrialKey::columns(metrics().trials());
    columns.push(Column::float("force_mean_n", "N", "mean force", [Some(0.5), None]));
    let metrics = Measured::of(Table::new("metrics", "Metrics", columns).unwrap()).unwrap();
    let estimating = Estimating { has_groups: true, effects: vec![motor], ..estimating() };
    Contents::of("s", "Claims", &planned(), &estimating, recorded(&metrics), &[compared], &[])
}

#[test]
fn of_a_metric_of_logarithms_the_script_gets_the_unit_of_jnds_and_what_compares_ratios() {
    let metric = crate::compared::tests::ln_jnd();
    let effect = |effect: &str, levels: &str| EffectDifference {
        effect: effect.parse().unwrap(),
        levels: Some(levels.parse().unwrap()),
        ..unestimated(&metric)
    };
    let effects = [effect("motor", "yes − no"), effect("motor:brake", "(yes − no) × (yes − no)")];
    let groups = ["hybrid", "hybrid − active"].map(|effect| GroupDifference {
        effect: effect.parse().unwrap(),
        ..between_groups(&metric)
    });
    let compared =
        ComparedMetric { effects: &effects, groups: &groups, ..without_results(&metric) };
    let mut columns = TrialKey::columns(metrics().trials());
    columns.push(Column::float("ln_jnd_stiffer", "ln N/rad", "JND", [Some(-0.5), None]));
    let values = Measured::of(Table::new("metrics", "Metrics", columns).unwrap()).unwrap();
    let contents =
        Contents::of("s", "JNDs", &planned(), &estimating(), recorded(&values), &[compared], &[]);
    let data = serde_json::to_value(contents).unwrap();
    let own = &data["metrics"][0];
    assert_eq!((&own["label"], &own["unit"]), (&"JND".into(), &"N/rad".into()));
    assert_eq!((&own["is_logarithm"], &own["scale"]), (&true.into(), &1.0.into()));
    let claims = own["claims"].as_array().unwrap().iter();
    let claims = claims.map(|own| (own["of"].as_str().unwrap(), own["is_of_ratios"] == true));
    let expected = [
        ("Spring: motor: yes / no", false),
        ("Spring: motor × brake: (yes / no) × (yes / no)", true),
        ("Spring: expert / novice in hybrid", false),
        ("Spring: expert / novice in the ratio Hybrid / Active", true),
    ];
    assert_eq!(claims.collect::<Vec<_>>(), expected);
}

#[test]
fn effects_and_groups_stand_below_the_matrix_of_modes_and_only_where_they_are_claimed() {
    let contents = with_claims();
    let words = "Effects of factors are shown in 1 of 2 comparisons in all metrics: 1 of which it is not known what is \
                 felt. Groups differ in 0 of 1 comparisons in all metrics.";
    assert_eq!(contents.verdicts_in_words().as_deref(), Some(words));
    let mut summary = summary();
    summary.figures.push(Made::new(crate::VERDICTS_FIGURE, "the answer"));
    let planned = planned();
    let html = written(&Page {
        summary: &summary,
        planned: &planned,
        study: "s",
        contents: Some(&contents),
        origin: None,
        version: "0.1.0",
    });
    let data = data_of(&html);
    let claims = serde_json::json!([
        {"of": "Spring: motor: yes − no", "environment": "spring", "is_of_groups": false, "value": 0.5, "error": 0.1,
         "low": 0.25, "high": 0.75, "n": 4, "n_against": null, "verdict": "different", "size": null,
         "p_adjusted": null, "jnd": null, "deviation": 0.2, "remark": null,
         "people": [{"participant": "P01", "value": 0.375}, {"participant": "P02", "value": 0.625}],
         "conditions": [{"environment": "spring", "modes": ["hybrid", "active"]}]},
        {"of": "Spring: motor: later − no", "environment": "spring", "is_of_groups": false, "value": null,
         "error": null, "low": null, "high": null, "n": 4, "n_against": null, "verdict": "not tested",
         "size": null, "p_adjusted": null, "jnd": null, "deviation": null, "remark": null},
        {"of": "Spring: expert − novice in the difference Hybrid − Active", "environment": "spring",
         "is_of_groups": true, "value": 0.25, "error": null, "low": null, "high": null, "n": 5, "n_against": 7,
         "verdict": "undecided", "size": null, "p_adjusted": 0.5, "jnd": null, "deviation": 0.5, "remark": null,
         "groups": [{"label": "expert", "mean": 1.25, "sd": 0.5, "values": [0.125, 0.25, 0.5]},
                    {"label": "novice", "mean": 1.0, "sd": 0.5, "values": []}]},
    ]);
    assert_eq!(data["metrics"][0]["claims"], claims);
    assert!(html.contains("<div id=\"claims\"></div>") && html.contains("claimRows("));
    // The page in one file names the same script.
    let one = single_file(&html, |path| match path.strip_prefix("figures/") {
        Some(_) => Ok(b"<svg/>".to_vec()),
        None => Ok(condition_script("P01.S01.spring.active", &[], &[], &[]).unwrap().into_bytes()),
    });
    let policy = |html: &str| html.split("script-src 'sha256-").nth(1).unwrap()[..44].to_owned();
    assert_eq!(policy(&one.unwrap()), policy(&html));
    let without = page(&self::summary());
    assert!(!without.contains("id=\"claims\"") && !without.contains("claimRows("));
    assert_ne!(policy(&without), policy(&html));
}
