//! Facts about scenes as other programs read them; `tests/interop/others.py` runs what is written.

use super::parts::Parts;
use super::template::filled;
use super::{OtherFormat, OtherScene, parts_of, write_as, writer};
use std::collections::BTreeSet;
use zwidth_dynamics::{
    BrakeLaw, Demand, DriveMode, FingerLaw, Friction, Gravity, Input, ModelScene, Pull, Series,
    System, Zone, table3,
};

/// Table 3's spring by the motor alone, on a lever of 45 mm, with a change.
fn scene(change: impl Fn(&mut ModelScene)) -> ModelScene {
    let mut scene = table3::scene(DriveMode::Active, Input::sine(1.0));
    scene.plant.lever_m = 0.045;
    change(&mut scene);
    scene
}

fn dry(static_n: f64, kinetic_n: f64) -> Option<Friction> {
    Some(Friction { static_n, kinetic_n, viscous_ns_per_rad: 0.3 })
}

fn series() -> Input {
    Input::Series(Series { t_s: vec![0.0, 0.5, 0.5, 2.0], value: vec![0.0, 1.0, 2.0, 0.5] })
}

fn add_wall(scene: &mut ModelScene) {
    scene.environment.zones.push(Zone { from_rad: 0.25, demand: Demand::Full });
    scene.environment.zones.push(Zone { from_rad: 0.5, demand: Demand::FullUp });
}

/// Scenes that have every part among them.
fn scenes() -> Vec<ModelScene> {
    let mut scenes = vec![
        scene(|_| ()),
        scene(|s| s.plant.stops_rad = None),
        scene(|s| s.friction = dry(0.5, 0.5)),
        scene(|s| s.friction = dry(0.6, 0.4)),
        scene(|s| s.plant.mass_kg = 1e-13),
        scene(|s| s.motor.lag_s = Some(0.01)),
        scene(|s| s.input = series()),
        scene(|s| s.input = Input::Ramp { magnitude: 1.0, period_s: 2.0 }),
        scene(|s| s.input = Input::Step { magnitude: 1.0, period_s: 2.0 }),
        scene(|s| s.input = Input::Line { value: 1.0, rate: -0.5 }),
        scene(|s| s.start.theta_rad = table3::HALF_STROKE_RAD),
        scene(|s| s.start.theta_dot_rad_s = 0.5),
        scene(|s| s.environment = zwidth_dynamics::Environment::free()),
        scene(|s| s.environment = zwidth_dynamics::Environment::force(0.5)),
        scene(add_wall),
        scene(|s| s.terms.set(Gravity { mass_kg: 0.02, radius_m: 0.02 })),
        scene(|s| s.terms.set(Pull { stiffness_n_per_rad: 8.0, displacement: series() })),
    ];
    for mode in [DriveMode::Passive, DriveMode::Hybrid] {
        for law in [BrakeLaw::Coulomb, BrakeLaw::Thesis] {
            let braked = |change: &dyn Fn(&mut ModelScene)| {
                scene(|s| {
                    s.mode = mode;
                    s.brake.law = law;
                    change(s);
                })
            };
            scenes.push(braked(&|_| ()));
            scenes.push(braked(&|s| s.brake.dead_zone_n = 0.2));
            scenes.push(braked(&|s| s.motor.lag_s = Some(0.01)));
            scenes.push(braked(&|s| s.brake.let_go_n = Some(1.0)));
            scenes.push(braked(&add_wall));
            if law == BrakeLaw::Coulomb {
                scenes.push(braked(&|s| s.brake.lag_on_off_s = Some([0.015, 0.01])));
            }
        }
    }
    for law in [FingerLaw::Consistent, FingerLaw::Thesis] {
        for length_m in [None, Some(0.006)] {
            scenes.push(scene(|s| {
                s.finger = Some(zwidth_dynamics::Finger { length_m, ..table3::finger(law) });
            }));
        }
    }
    scenes
}

/// Each scene in each format that can say it.
fn written() -> Vec<(OtherFormat, ModelScene, OtherScene)> {
    let mut written = Vec::new();
    for scene in scenes() {
        for format in OtherFormat::ALL {
            if let Ok(other) = write_as(scene.clone(), format) {
                written.push((format, scene.clone(), other));
            }
        }
    }
    assert!(written.len() > 4 * scenes().len(), "{} of {}", written.len(), scenes().len());
    written
}

/// What stands before the bars of a format's templates.
fn asked(format: OtherFormat) -> BTreeSet<&'static str> {
    let writer = writer(format);
    let templates = writer.files.iter().flat_map(|form| form.templates.iter());
    let mut conditions: Vec<&str> = writer.refused.iter().map(|(asked, _)| *asked).collect();
    let mut lines: Vec<&str> = writer.remarks.lines().collect();
    for (asked, template) in templates {
        conditions.push(asked);
        lines.extend(template.lines());
    }
    conditions.extend(lines.iter().filter_map(|line| Some(line.split_once('|')?.0)));
    let words = conditions.into_iter().flat_map(str::split_whitespace);
    words.map(|word| word.trim_start_matches('!')).collect()
}

#[test]
fn every_part_that_a_line_asks_for_is_one_that_some_scene_has() {
    let parts: Vec<Parts> =
        scenes().into_iter().map(|s| parts_of(&System::new(s).unwrap()).unwrap()).collect();
    for format in OtherFormat::ALL {
        for part in asked(format) {
            let is_known = parts.iter().any(|parts| parts.has(part));
            assert!(is_known, "{}: no scene has '{part}'", format.as_str());
        }
    }
}

#[test]
fn every_line_of_a_template_has_its_bar() {
    for format in OtherFormat::ALL {
        let writer = writer(format);
        let templates = writer.files.iter().flat_map(|form| form.templates.iter());
        for text in templates.map(|(_, template)| *template).chain([writer.remarks]) {
            for line in text.lines().filter(|line| !line.trim().is_empty()) {
                assert!(line.contains('|'), "{}: {line}", format.as_str());
            }
        }
    }
}

#[test]
fn every_value_that_a_line_asks_for_is_there() {
    let is_name =
        |text: &str| !text.is_empty() && text.chars().all(|c| c.is_ascii_lowercase() || c == '_');
    for (format, scene, other) in written() {
        let texts = other.files.iter().map(|file| &file.text).chain(&other.remarks);
        for text in texts {
            let left = text.lines().find(|line| line.split('@').skip(1).any(is_name));
            // A decorator of Python has no second sign.
            let left = left.filter(|line| line.matches('@').count() > 1);
            assert_eq!(left, None, "{} of {}", format.as_str(), scene.name);
            for word in ["NaN", "inf)", "inf "] {
                let rest = text.replace("math.inf", "");
                assert!(!rest.contains(word), "{}: {word}", format.as_str());
            }
        }
    }
}

#[test]
fn a_line_is_written_where_its_parts_are_and_others_are_not() {
    let parts = parts_of(&System::new(scene(|s| s.friction = dry(0.5, 0.5))).unwrap()).unwrap();
    let text = filled(
        "|a @mass@ @b@\nfriction|b\n!friction|c\nfriction !stops|d\n\nstops friction|",
        &parts,
    );
    assert_eq!(text, "a 0.005 @b@\nb\n\n");
}

/// All files of a scene in a format, one behind the other.
fn text(format: OtherFormat, change: impl Fn(&mut ModelScene)) -> String {
    let other = write_as(scene(change), format).unwrap();
    other.files.into_iter().map(|file| file.text).collect()
}

#[test]
fn a_remark_appears_where_the_scene_has_what_the_format_cannot_say_and_only_there() {
    type Change = fn(&mut ModelScene);
    let cases: [(OtherFormat, Change, &str); 13] = [
        (OtherFormat::Mujoco, |s| s.friction = dry(0.5, 0.5), "creeps"),
        (OtherFormat::Mujoco, |s| s.friction = dry(0.6, 0.4), "That of rest (0.6 N) is left out"),
        (OtherFormat::Mujoco, |s| s.mode = DriveMode::Passive, "no brake whose level follows"),
        (OtherFormat::Mujoco, |s| s.mode = DriveMode::Hybrid, "turns back and forth"),
        (OtherFormat::Mujoco, add_wall, "no zones of angle"),
        (OtherFormat::Urdf, |s| s.friction = dry(0.6, 0.4), "one level of friction"),
        (OtherFormat::Urdf, |s| s.motor.lag_s = Some(0.01), "lag of 0.01 s is left out"),
        (OtherFormat::Sdf, |s| s.mode = DriveMode::Passive, "no brake"),
        (OtherFormat::Sdf, |s| s.brake.let_go_n = Some(1.0), ""),
        (OtherFormat::Modelica, add_wall, "is rest"),
        (OtherFormat::Modelica, |s| s.input = series(), "without events"),
        (OtherFormat::Python, add_wall, "is rest"),
        (OtherFormat::Drake, add_wall, "is rest"),
    ];
    for (format, change, words) in cases {
        let remarks = |change: &dyn Fn(&mut ModelScene)| {
            write_as(scene(change), format).unwrap().remarks.join("\n")
        };
        let [with, without] = [remarks(&change), remarks(&|_| ())];
        if words.is_empty() {
            // What is no part of this mode is no remark.
            assert_eq!(with, without, "{}", format.as_str());
        } else {
            assert!(
                with.contains(words) && !without.contains(words),
                "{}: {words}",
                format.as_str()
            );
        }
    }
}

#[test]
fn remarks_stand_in_every_file() {
    for (format, _, other) in written() {
        for file in &other.files {
            let flat: Vec<&str> =
                file.text.split_whitespace().filter(|w| *w != "#" && *w != "//").collect();
            let flat = flat.join(" ");
            for remark in &other.remarks {
                let remark: Vec<&str> = remark.split_whitespace().collect();
                assert!(flat.contains(&remark.join(" ")), "{}: {remark:?}", format.as_str());
            }
        }
    }
}

/// The value of an attribute of the first element of a name that has it.
fn attribute(text: &str, element: &str, name: &str) -> Vec<f64> {
    let start = format!("<{element}");
    let mut elements = text.split(&start).skip(1);
    let value = elements.find_map(|rest| {
        let rest = rest.split_once('>')?.0.split_once(&format!(" {name}=\""))?.1;
        rest.split_once('"').map(|(value, _)| value)
    });
    value.unwrap().split(' ').map(|number| number.parse().unwrap()).collect()
}

fn close(found: f64, expect: f64) {
    assert!((found - expect).abs() <= 1e-14 * expect.abs(), "{found} is not {expect}");
}

#[test]
fn mjcf_has_the_scene_s_numbers_about_the_axis() {
    let text = text(OtherFormat::Mujoco, |s| s.friction = dry(0.5, 0.5));
    for moment in attribute(&text, "inertial", "diaginertia") {
        close(moment, 0.005 * 0.045 * 0.045);
    }
    assert_eq!(attribute(&text, "inertial", "mass"), [0.005]);
    assert_eq!(
        attribute(&text, "joint", "range"),
        [-table3::HALF_STROKE_RAD, table3::HALF_STROKE_RAD]
    );
    close(attribute(&text, "joint", "frictionloss")[0], 0.5 * 0.045);
    close(attribute(&text, "joint", "damping")[0], 0.3 * 0.045);
    assert_eq!(attribute(&text, "option", "timestep"), [0.0083]);
    // −(K (θ − rest) + B θ̇) over the length L θ.
    let law = attribute(&text, "general", "biasprm");
    close(law[0], -4.0 * table3::HALF_STROKE_RAD);
    close(law[1], -4.0 / 0.045);
    close(law[2], -1.0 / 0.045);
    assert_eq!(attribute(&text, "general", "forcerange"), [-3.25, 3.25]);
    assert_eq!(attribute(&text, "key", "qpos"), [-table3::HALF_STROKE_RAD]);
}

#[test]
fn a_weight_turns_the_body_as_it_turns_the_lever_however_heavy_it_is() {
    for (mass_kg, radius_m) in [(0.02, 0.02), (0.2, 0.05), (5.0, 0.5)] {
        let text = text(OtherFormat::Mujoco, |s| s.terms.set(Gravity { mass_kg, radius_m }));
        let mass = attribute(&text, "inertial", "mass")[0];
        let radius = attribute(&text, "inertial", "pos")[2];
        let own = attribute(&text, "inertial", "diaginertia")[0];
        close(mass * radius, mass_kg * radius_m);
        assert!(own > 0.0, "{own}");
        let about_axis = own + mass * radius * radius;
        assert!((about_axis / (0.005 * 0.045 * 0.045) - 1.0).abs() < 1e-12, "{about_axis}");
        assert_eq!(attribute(&text, "option", "gravity"), [0.0, 0.0, -9.80665]);
    }
}

#[test]
fn xml_is_well_formed_whatever_the_scene_is_called() {
    let name = "a --> b ]]> <lever> & \"c\" -- - \u{7} \n @mass@ --";
    for mut scene in scenes() {
        scene.name = name.to_owned();
        for format in [OtherFormat::Mujoco, OtherFormat::Urdf, OtherFormat::Sdf] {
            let Ok(other) = write_as(scene.clone(), format) else { continue };
            let text = &other.files[0].text;
            let mut reader = quick_xml::Reader::from_str(text);
            reader.config_mut().check_comments = true;
            let mut depth = 0;
            loop {
                match reader.read_event().unwrap() {
                    quick_xml::events::Event::Start(_) => depth += 1,
                    quick_xml::events::Event::End(_) => depth -= 1,
                    quick_xml::events::Event::Eof => break,
                    _ => {}
                }
            }
            assert_eq!(depth, 0, "{}", format.as_str());
        }
    }
}

#[test]
fn a_name_never_leaves_its_comment() {
    for (format, comment) in
        [(OtherFormat::Python, "# "), (OtherFormat::Drake, "# "), (OtherFormat::Modelica, "// ")]
    {
        let name = "a\nimport os\r\u{2028}\u{85}\"\"\" end Lever; @head@";
        let text = text(format, |s| s.name = name.to_owned());
        let head: Vec<&str> = text.lines().take_while(|line| line.starts_with(comment)).collect();
        assert!(head[0].contains("a import os") && head[0].contains("@head@"), "{}", head[0]);
        assert_eq!(text.matches("import os").count(), 1, "{text}");
    }
}

#[test]
fn a_scene_that_a_format_cannot_say_is_refused_with_what_to_do() {
    let thesis = |s: &mut ModelScene| s.finger = Some(table3::finger(FingerLaw::Thesis));
    let consistent = |s: &mut ModelScene| s.finger = Some(table3::finger(FingerLaw::Consistent));
    let error = |format, change: &dyn Fn(&mut ModelScene)| {
        write_as(scene(change), format).unwrap_err().to_string()
    };
    for format in [OtherFormat::Mujoco, OtherFormat::Urdf, OtherFormat::Sdf] {
        let error = error(format, &thesis);
        assert!(error.contains(format.as_str()) && error.contains("set finger.law"), "{error}");
        assert!(write_as(scene(consistent), format).is_ok());
    }
    let tiny = error(OtherFormat::Mujoco, &|s| s.plant.mass_kg = 1e-13);
    assert!(tiny.contains("plant.mass_kg"), "{tiny}");
    let blow = error(OtherFormat::Modelica, &consistent);
    assert!(blow.contains("leave finger.length_m out"), "{blow}");
    let lag = error(OtherFormat::Modelica, &|s| {
        s.mode = DriveMode::Hybrid;
        s.motor.lag_s = Some(0.01);
    });
    assert!(lag.contains("leave the lag out"), "{lag}");
    let wrong = error(OtherFormat::Python, &|s| s.plant.mass_kg = -1.0);
    assert!(wrong.contains("plant.mass_kg is -1"), "{wrong}");
}
