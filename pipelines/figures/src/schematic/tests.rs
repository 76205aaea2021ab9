//! Facts about every schematic.

use super::*;
use zwidth_draw::{Layer, Range, draw, markup};
use zwidth_dynamics::{Friction, ModelScene};
use zwidth_study::{Coordinate, Resistances, Scene, Spring, Study, VelocityFilter};

const FINGER: &str = include_str!("../../../../scenes/sine_finger.toml");
const NO_FINGER: &str = include_str!("../../../../scenes/sine.toml");

fn scene(text: &str) -> ModelScene {
    ModelScene::from_toml(text).unwrap()
}

fn modelled(scene: ModelScene) -> Modelled {
    Modelled::new(scene, "scenes/a_b.toml", "rk4_per_step", None).unwrap()
}

fn of_model(scene: ModelScene) -> Vec<(&'static str, Figure)> {
    let of = modelled(scene);
    OF_MODEL.iter().map(|(kind, draw)| (kind.stem, draw(&of))).collect()
}

fn of_device(study: &Study) -> Vec<(&'static str, Figure)> {
    let of = Setup::of(study);
    OF_DEVICE.iter().filter_map(|(kind, draw)| Some((kind.stem, draw(&of)?))).collect()
}

/// Every schematic there is, and what is left of the model without a finger.
fn all() -> Vec<(&'static str, Figure)> {
    let model = of_model(scene(FINGER)).into_iter().chain(of_model(scene(NO_FINGER)));
    model.chain(of_device(&zwidth_testing::study())).collect()
}

/// The words on a drawing, without markup, a line each.
fn words(figure: &Figure) -> Vec<String> {
    let layers = figure.panels.iter().flat_map(|panel| &panel.layers);
    let texts = layers.filter_map(|l| if let Layer::Text(t) = l { Some(&t.lines) } else { None });
    texts.flatten().map(|line| markup::plain(line).replace('\u{a0}', " ")).collect()
}

fn has(figures: &[(&str, Figure)], stem: &str, says: &str) -> bool {
    let (_, figure) = figures.iter().find(|(name, _)| *name == stem).unwrap();
    words(figure).iter().any(|line| line.contains(says))
}

/// A box around letters, in pt: left, top, right, bottom.
type Extent = [f64; 4];

/// The words of a drawing with their letters' extents, as its SVG has them.
fn extents(figure: &Figure) -> Vec<(String, Extent)> {
    let svg = draw(figure).unwrap().svg_with_text(None).unwrap();
    let texts = svg.split("<text ").skip(1).map(|rest| {
        let (tag, rest) = rest.split_once('>').unwrap();
        let number = |key: &str| -> f64 {
            let value = format!(" {tag}").split_once(&format!(" {key}=\"")).unwrap().1.to_owned();
            value.split_once('"').unwrap().0.parse().unwrap()
        };
        let (x, y, size) = (number("x"), number("y"), number("font-size"));
        let extent = [x, y - 0.72 * size, x + number("textLength"), y + 0.05 * size];
        (rest.split_once('<').unwrap().0.to_owned(), extent)
    });
    texts.collect()
}

#[test]
fn no_two_words_of_a_schematic_overlap() {
    for (name, figure) in all() {
        let found = extents(&figure);
        assert!(found.len() > 5, "{name}: {found:?}");
        for (i, (a, left)) in found.iter().enumerate() {
            for (b, right) in &found[..i] {
                let apart = left[2] <= right[0] + 0.1
                    || right[2] <= left[0] + 0.1
                    || left[3] <= right[1] + 0.1
                    || right[3] <= left[1] + 0.1;
                assert!(apart, "{name}: \"{a}\" and \"{b}\" overlap");
            }
        }
    }
}

#[test]
fn nothing_lies_beyond_the_edges_of_its_drawing() {
    for (name, figure) in all() {
        for panel in &figure.panels {
            let (Range::Fixed(left, right), Range::Fixed(low, high)) =
                (panel.x.range, panel.y.range)
            else {
                panic!("{name}: {panel:?}");
            };
            for (x, y) in panel.layers.iter().flat_map(points) {
                let inside = (left..=right).contains(&x) && (low..=high).contains(&y);
                assert!(inside, "{name}: ({x}, {y})");
            }
        }
    }
}

fn points(layer: &Layer) -> Vec<(f64, f64)> {
    match layer {
        Layer::Line(l) => l.x.iter().copied().zip(l.y.iter().copied()).collect(),
        Layer::Points(p) => p.x.iter().copied().zip(p.y.iter().copied()).collect(),
        _ => Vec::new(),
    }
}

#[test]
fn numbers_of_the_model_are_those_of_its_scene() {
    let figures = of_model(scene(FINGER));
    for (stem, says) in [
        ("schematic.model", "KO = 4 N/rad"),
        ("schematic.model", "BF = 1.53 N·s/m"),
        ("schematic.model", "21 g"),
        ("schematic.lever_model", "KF = 584.6 N/m"),
        ("schematic.lever_model", "1 N·s/rad"),
        ("schematic.force_control", "h = 8.3 ms"),
    ] {
        assert!(has(&figures, stem, says), "{says} is not in {stem}");
    }
    let mut changed = scene(FINGER);
    (changed.plant.mass_kg, changed.step_s) = (0.1, 1e-3);
    let figures = of_model(changed);
    assert!(has(&figures, "schematic.model", "100 g"));
    assert!(has(&figures, "schematic.force_control", "h = 1 ms"));
    let own_step = Modelled::new(scene(FINGER), "a.toml", "exact", Some(2e-3)).unwrap();
    assert!(words(&control::force_control(&own_step)).contains(&"h = 2 ms".to_owned()));
    for (_, figure) in &figures {
        let note = figure.footnotes.last().unwrap();
        assert!(
            markup::plain(note).contains("Numbers: scenes/a_b.toml (Sine, with finger)"),
            "{note}"
        );
    }
}

#[test]
fn what_the_scene_has_and_the_drawing_does_not_is_told() {
    let friction = Friction { static_n: 0.2, kinetic_n: 0.15, viscous_ns_per_rad: 0.0 };
    let with = ModelScene { friction: Some(friction), ..scene(FINGER) };
    let told =
        |scene| of_model(scene)[0].1.footnotes.last().unwrap().contains("Not drawn: friction");
    assert!(told(with) && !told(scene(FINGER)));
}

#[test]
fn a_scene_without_a_finger_has_none_on_any_drawing() {
    for (name, figure) in of_model(scene(NO_FINGER)) {
        let of_finger =
            |line: &String| ["KF", "BF", "MF", "FF", "x2"].iter().any(|s| line.contains(s));
        assert!(!words(&figure).iter().any(of_finger), "{name}: {:?}", words(&figure));
        assert!(words(&figure).iter().any(|line| line.contains("Fex")), "{name}");
    }
}

#[test]
fn a_scene_that_cannot_be_run_is_no_drawing() {
    let mut bad = scene(FINGER);
    bad.plant.stops_rad = Some([0.0, f64::INFINITY]);
    assert!(Modelled::new(bad, "a.toml", "exact", None).is_err());
    assert!(Modelled::new(scene(FINGER), "a.toml", "exact", Some(f64::NAN)).is_err());
}

#[test]
fn numbers_of_the_device_are_those_of_the_study() {
    let mut study = zwidth_testing::study();
    let spring = Spring { stiffness_n_per_rad: 3.25, rest_rad: -0.5 };
    study.environments[0].scene = Scene::Spring(spring);
    study.control.rate_hz = 444.0;
    study.control.force_limit_n = 7.5;
    study.control.let_go_n = 1.25;
    study.control.velocity = VelocityFilter::SecondOrder { cutoff_hz: 33.0 };
    study.device.lever_m = Some(0.055);
    study.device.force_rate_hz = Some(85.0);
    study.device.theta_max_rad = Some(0.5);
    study.modes[0].motor_max_v = Some(14.5);
    study.resistances = Resistances { motor_ohm: None, brake_ohm: Some(21.5) };
    let figures = of_device(&study);
    for (stem, says) in [
        ("schematic.control_loop", "3.25 N/rad from −28.6°"),
        ("schematic.control_loop", "444 ticks/s"),
        ("schematic.control_loop", "Fex > 7.5 N"),
        ("schematic.control_loop", "brake lets go below 1.25 N"),
        ("schematic.control_loop", "second-order low-pass, 33 Hz"),
        ("schematic.control_loop", "85 values/s"),
        ("schematic.control_loop", "up to 14.5 V"),
        ("schematic.control_loop", "55 mm"),
        ("schematic.control_loop", "28.6°"),
        ("schematic.translation", "3.25 N/rad"),
        ("schematic.translation", "28.6°"),
        ("schematic.device", "21.5 Ω"),
        ("schematic.device", "55 mm"),
    ] {
        assert!(has(&figures, stem, says), "{says} is not in {stem}");
    }
}

#[test]
fn a_constant_force_and_a_delay_stand_in_the_control_loop() {
    let mut study = zwidth_testing::study();
    study.environments[0].scene = Scene::Force { force_n: 2.25 };
    study.environments[1].delay_s = 0.0125;
    let figures = of_device(&study);
    for says in ["2.25 N", "12.5 ms late"] {
        assert!(has(&figures, "schematic.control_loop", says), "{says}");
    }
}

#[test]
fn what_the_study_does_not_know_has_no_number() {
    let mut study = zwidth_testing::study();
    (study.masses, study.resistances) = (None, Resistances::default());
    (study.device.lever_m, study.device.force_rate_hz) = (None, None);
    let figures = of_device(&study);
    for (name, figure) in &figures {
        let known =
            |line: &String| [" g", " Ω", " mm", "values/s"].iter().any(|unit| line.ends_with(unit));
        assert!(!words(figure).iter().any(known), "{name}: {:?}", words(figure));
    }
    assert!(has(&figures, "schematic.control_loop", "force sensor"));
}

#[test]
fn an_actuator_that_no_mode_uses_is_on_no_drawing() {
    let mut study = zwidth_testing::study();
    study.modes.retain(|mode| mode.brake_max_v.is_none());
    for (name, figure) in of_device(&study) {
        let is_there = |what: &str| words(&figure).iter().any(|line| line.starts_with(what));
        assert!(is_there("Tm") && !is_there("Tb") && !is_there("brake"), "{name}");
    }
    let mut study = zwidth_testing::study();
    study.modes.retain(|mode| mode.motor_max_v.is_none());
    let figures = of_device(&study);
    assert!(figures.iter().all(|(_, f)| !words(f).iter().any(|l| l == "Tm" || l == "motor")));
}

#[test]
fn a_slide_has_its_loop_in_millimetres_and_no_lever() {
    let mut study = zwidth_testing::study();
    study.coordinate = Coordinate::Linear { lever_m: 1.0 };
    let figures = of_device(&study);
    assert_eq!(
        figures.iter().map(|(name, _)| *name).collect::<Vec<_>>(),
        ["schematic.control_loop"]
    );
    assert!(has(&figures, "schematic.control_loop", "N/mm from "));
    let without_angle = words(&figures[0].1).iter().all(|line| !line.contains(['θ', '°']));
    assert!(without_angle, "{:?}", words(&figures[0].1));
}

/// Names are text whatever they hold, and drawn however long they are.
#[test]
fn the_solver_is_told_in_words_and_not_by_its_name_in_files() {
    let (_, figure) = of_model(scene(FINGER))
        .into_iter()
        .find(|(stem, _)| stem.ends_with("force_control"))
        .unwrap();
    let notes = figure.footnotes.join(" ");
    assert!(notes.contains("Solver: RK4, switched per step."), "{notes}");
    assert!(!notes.contains("per_step"), "{notes}");
}

#[test]
fn a_hostile_name_is_shown_as_text() {
    const NAME: &str = "<script>alert('x')</script> *a* _{b} ^{c} \\frac{1}{2} #eval $x$ %";
    let mut study = zwidth_testing::study();
    study.device.name = NAME.to_owned();
    study.environments[0].label = NAME.to_owned();
    study.modes[0].label = NAME.to_owned();
    let figures = of_device(&study);
    let title = |stem: &str| {
        let (_, figure) = figures.iter().find(|(name, _)| *name == stem).unwrap();
        markup::plain(figure.title.as_deref().unwrap())
    };
    assert_eq!(title("schematic.device"), NAME);
    assert!(title("schematic.translation").starts_with(NAME));
    assert!(has(&figures, "schematic.control_loop", &format!("{NAME}: motor")));
    for (_, figure) in figures {
        let svg = draw(&figure).unwrap().svg().unwrap();
        assert!(!svg.contains("<script"));
    }
    study.environments[0].label = "W".repeat(1000);
    study.modes[0].label = "a b ".repeat(250);
    let figures = of_device(&study);
    assert!(draw(&figures[2].1).is_ok(), "cut off in its box");
}
