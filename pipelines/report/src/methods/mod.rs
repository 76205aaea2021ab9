//! The methods of a study in words, ready for a thesis' methods chapter: what was recorded, what
//! was computed from it, with which numbers, and the source of each method.
//!
//! The text covers only what the study has: without a wall, it has no sentence about one. It gives
//! no reasons for the choices.

mod form;
mod recorded;
mod sources;
mod statistics;
mod tasks;
#[cfg(test)]
mod tests;

pub use form::MethodsForm;
pub use recorded::Recorded;

use crate::people::{amounts, sources as origins};
use recorded::plain;
use sources::Cited;
use zwidth_study::{
    ActuatorKind, Coordinate, Environment, Mode, ModeLaw, OrderScheme, ReplayModel, Scene, Study,
    VelocityFilter, counted,
};
use zwidth_tables::{given, in_coordinate};

/// A heading and the text below it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MethodsPart {
    heading: &'static str,
    paragraphs: Vec<String>,
}

/// The methods of `study`, as computed by this program of that version.
pub fn methods(study: &Study, recorded: &Recorded, version: &str) -> Vec<MethodsPart> {
    let mut cited = Cited::default();
    // How the analysis differs from the deposited plan.
    let plan = (!recorded.plan.is_empty()).then(|| {
        let sentences = recorded.plan.join(" ");
        format!("The analysis was planned in a file that lies beside the recordings. {sentences}")
    });
    let software = format!(
        "All numbers, figures and tables were made from the raw files of the study '{}' by zwidth \
         {version}, with intervals at {} %.",
        study.id,
        plain(100.0 * study.analysis.confidence)
    );
    let parts = [
        ("Apparatus", apparatus(study, recorded)),
        ("Conditions", conditions(study)),
        ("Procedure", procedure(study, recorded)),
        ("Data", data(recorded)),
        ("Measures", measures(study, recorded, &mut cited)),
        ("Model", model(study, recorded, &mut cited)),
        ("Thresholds", tasks::paragraphs(study, recorded, &mut cited)),
        ("Statistics", statistics::paragraphs(study, recorded, &mut cited)),
        ("Plan", plan.into_iter().collect()),
        ("Software", vec![software]),
    ];
    let mut parts: Vec<MethodsPart> = parts
        .into_iter()
        .filter(|(_, paragraphs)| !paragraphs.is_empty())
        .map(|(heading, paragraphs)| {
            // The model's equations are those of a lever, whose x is L θ.
            let axis = match heading {
                "Model" => Coordinate::Rotational,
                _ => study.coordinate,
            };
            let paragraphs = paragraphs.iter().map(|text| in_coordinate(text, axis));
            MethodsPart { heading, paragraphs: paragraphs.collect() }
        })
        .collect();
    let sources = cited.listed();
    if !sources.is_empty() {
        parts.push(MethodsPart { heading: "Sources", paragraphs: sources });
    }
    parts
}

fn apparatus(study: &Study, recorded: &Recorded) -> Vec<String> {
    let device = &study.device;
    let control = &study.control;
    let axis = study.coordinate;
    // A questionnaire has no device.
    if study.environments.iter().all(|e| e.scene == Scene::None) {
        return Vec::new();
    }
    // A name that ends in a full stop must not get a second one.
    let mut sentences = vec![format!("The device: {}.", device.name.trim_end_matches('.'))];
    if axis != Coordinate::Rotational {
        sentences.push("It moved along a straight line.".to_owned());
    } else if let Some(lever) = device.lever_m {
        sentences.push(format!(
            "The lever was {} mm long from its axis to the finger.",
            plain(lever * 1e3)
        ));
    }
    if let (Some(low), Some(high)) = (device.theta_min_rad, device.theta_max_rad) {
        sentences.push(format!(
            "Its work space reached from {} to {}.",
            given(low, "rad", axis),
            given(high, "rad", axis)
        ));
    }
    // What follows is this program's own loop, which took no part in the recordings of others.
    if recorded.is_foreign() {
        return vec![sentences.join(" ")];
    }
    sentences.push(format!("The control loop ran at {} Hz.", plain(control.rate_hz)));
    if let Some(rate) = device.force_rate_hz {
        sentences.push(format!("The force sensor gave {} new values per second.", plain(rate)));
    }
    sentences.push(match control.velocity {
        VelocityFilter::Difference => {
            "Velocity was the difference of the last two angles over their time.".to_owned()
        }
        VelocityFilter::SecondOrder { cutoff_hz } => format!(
            "Velocity was the angle through a differentiator with a critically damped second-order \
             low-pass of {} Hz, which delays it by {:.1} ms.",
            plain(cutoff_hz),
            1e3 / (core::f64::consts::PI * cutoff_hz)
        ),
    });
    sentences.push(format!(
        "A trial stopped where the measured force exceeded {} N.",
        plain(control.force_limit_n)
    ));
    vec![sentences.join(" ")]
}

fn conditions(study: &Study) -> Vec<String> {
    let environments: Vec<String> =
        study.environments.iter().filter_map(|e| environment(e, study.coordinate)).collect();
    let modes: Vec<String> = study.modes.iter().filter_map(mode).collect();
    let mut sentences = Vec::new();
    if !environments.is_empty() {
        sentences.push(environments.join(" "));
    }
    if !modes.is_empty() && !environments.is_empty() {
        let let_go = study.modes.iter().any(|mode| mode.has(ActuatorKind::Brake)).then(|| {
            format!(
                " The brake let go where the user's force fell below {} N while the lever did not \
                 move on.",
                plain(study.control.let_go_n)
            )
        });
        sentences.push(modes.join(" ") + &let_go.unwrap_or_default());
    }
    sentences
}

fn environment(environment: &Environment, axis: Coordinate) -> Option<String> {
    let spring = environment.scene.spring().map(|spring| {
        format!(
            "a virtual spring of {} that rests at {}",
            given(spring.stiffness_n_per_rad, "N/rad", axis),
            given(spring.rest_rad, "rad", axis)
        )
    });
    let wall = environment.scene.wall_rad().map(|wall_rad| given(wall_rad, "rad", axis));
    let force = environment.scene.constant_n().map(|force_n| {
        let way = if force_n < 0.0 { "into the object" } else { "against a push into the object" };
        format!("a constant force of {} {way}", given(force_n.abs(), "N", axis))
    });
    let rendered = match (spring.or(force), wall) {
        (Some(spring), Some(wall)) => format!("{spring}, with a wall from {wall} on"),
        (Some(spring), None) => spring,
        (None, Some(wall)) => format!("no force up to a wall at {wall}"),
        (None, None) if environment.scene == Scene::None => return None,
        (None, None) => "no force".to_owned(),
    };
    let late = match environment.delay_s > 0.0 {
        true => format!(
            ", {} ms late (to the nearest tick of the control loop)",
            plain(environment.delay_s * 1e3)
        ),
        false => String::new(),
    };
    Some(format!("The environment '{}' rendered {rendered}{late}.", environment.label))
}

fn mode(mode: &Mode) -> Option<String> {
    let [motor, brake] = [mode.motor_max_v, mode.brake_max_v]
        .map(|max_v| max_v.map(|v| format!(" (up to {} V)", plain(v))).unwrap_or_default());
    let law = match mode.law()? {
        ModeLaw::Active => format!("the motor{motor} gave the force on both ways"),
        ModeLaw::Passive => format!("the brake{brake} gave the force on both ways"),
        ModeLaw::Hybrid => format!(
            "the brake{brake} gave the force while the lever moved into the object, and the \
             motor{motor} while it was held or moved back"
        ),
    };
    Some(format!("In mode '{}' {law}.", mode.label))
}

fn procedure(study: &Study, recorded: &Recorded) -> Vec<String> {
    let design = &study.design;
    // How others ran their sessions is not known.
    if recorded.is_foreign() {
        return answered(study, recorded).into_iter().collect();
    }
    let mut sentences = vec![format!(
        "Each condition (environment and mode) was to be presented {} per session.",
        match design.repeats {
            1 => "once".to_owned(),
            n => format!("{n} times"),
        }
    )];
    if study.modes.len() > 1 {
        let drawn = match design.order {
            OrderScheme::Williams => "from Williams squares, a row for each repeat",
            OrderScheme::Constrained => "at random, no mode more than twice in a row",
        };
        sentences.push(format!(
            "The order of the modes was drawn {drawn}; blocks of one environment followed each \
             other, counterbalanced."
        ));
    }
    if design.familiarisation > 0 {
        sentences.push(match design.familiarisation {
            1 => "1 practice trial came first and was not analysed.".to_owned(),
            n => format!("{n} practice trials came first and were not analysed."),
        });
    }
    sentences.push(format!(
        "A trial took at most {} s, with at least {} s until the next.",
        plain(design.trial_limit_s),
        plain(design.pause_s)
    ));
    if design.redo_unmet > 0 {
        let times = match design.redo_unmet {
            1 => "once".to_owned(),
            n => format!("{n} times"),
        };
        let befell = match recorded.unmet.is_empty() {
            true => "no trial".to_owned(),
            false => {
                let by_mode = recorded
                    .unmet
                    .iter()
                    .map(|(mode, n)| format!("{} of '{mode}'", counted(*n, "trials")));
                by_mode.collect::<Vec<_>>().join(", ")
            }
        };
        sentences.push(format!(
            "A trial that was not one movement forward and one back, within {} s and inside the work space, did not \
             count and was done again after all others, at most {times}; this befell {befell}.",
            plain(design.trial_limit_s)
        ));
    }
    if design.blinded {
        sentences.push("Modes were sealed until the session was over.".to_owned());
    }
    sentences.extend(answered(study, recorded));
    vec![sentences.join(" ")]
}

/// What participants answered or, before the first answer, are to answer. Questions of others are
/// only known by their answers.
fn answered(study: &Study, recorded: &Recorded) -> Option<String> {
    let answered = match (recorded.answers || recorded.guesses, recorded.is_foreign()) {
        (true, _) => "Participants answered",
        (false, false) => "Participants were to answer",
        (false, true) => return None,
    };
    let questions = study.questions.iter().map(|question| {
        let text = question.text.trim_end_matches('.');
        match question.is_pair() {
            true => {
                format!("“{text}” (once in a session, of each two of the questions of a score)")
            }
            false => format!("“{text}” ({})", question.scale.name()),
        }
    });
    let mut questions: Vec<String> = questions.collect();
    // A score's pairs stand beside each other, and have one wording.
    questions.dedup();
    (!questions.is_empty()).then(|| format!("{answered}: {}.", questions.join("; ")))
}

fn data(recorded: &Recorded) -> Vec<String> {
    let Recorded { participants, sessions, trials, sweeps, .. } = *recorded;
    let counts = [participants, sessions, trials, sweeps];
    let amounts = amounts(counts, "sweeps of an actuator or sensor");
    if amounts.is_empty() {
        return Vec::new();
    }
    let origin = origins(&recorded.sources).map(|origins| {
        format!("{} {}", origins.mark.unwrap_or_default(), origins.text).trim().to_owned()
    });
    let sentence = format!("The data comprise {}.", amounts.join(", "));
    let foreign = "[TODO: describe how they were taken; the program does not know it.]".to_owned();
    let foreign = recorded.is_foreign().then_some(foreign);
    let computed: Vec<&str> = recorded.made_by_import.iter().map(String::as_str).collect();
    let computed = (!computed.is_empty()).then(|| {
        let list = computed.join("; ");
        format!("Not recorded but computed when the recordings were imported: {list}.")
    });
    let sentences = [origin, Some(sentence), foreign, computed].into_iter().flatten();
    vec![sentences.collect::<Vec<_>>().join(" ")]
}

fn measures(study: &Study, recorded: &Recorded, cited: &mut Cited) -> Vec<String> {
    if !recorded.sampled {
        return Vec::new();
    }
    let analysis = &study.analysis;
    let axis = study.coordinate;
    let onset = given(analysis.onset_rad_s, "rad/s", axis);
    let offset = given(analysis.offset_rad_s, "rad/s", axis);
    let has_wall = study.environments.iter().any(|e| e.scene.wall_rad().is_some());
    let has_spring = study.environments.iter().any(|e| e.scene.spring().is_some());
    let wall = if has_wall { "wall contact, " } else { "" };
    let along = match study.axes {
        Some(_) => "θ and F are the projections of position and force on the push. ",
        None => "",
    };
    // Of positions in several axes that nothing projects there is no θ.
    let has_theta = study.axes.is_none()
        || recorded.made_by_import.iter().any(|made| made.starts_with("theta_rad"));
    let mut sentences = Vec::new();
    if has_theta {
        sentences.push(format!(
        "{along}A movement began where |θ̇| first exceeded {onset} and ended where it fell below {offset} \
         after it had last exceeded {onset}. Compression is the way from its beginning to the first sample of \
         the largest θ, decompression the way back to the end. Smoothness is the spectral arc length \
         of |θ̇| {}.",
        cited.cite("balasubramanian")
        ));
    }
    if let Some(axes) = &study.axes {
        sentences.push(format!(
            "Positions in space went through a low-pass without lag (Butterworth, fourth order in both passes together, \
             cut off at {} Hz; {}). The movement in space lasted from where its speed first exceeded {} m/s to where it \
             fell below {} m/s after it had last exceeded that; path length is the way travelled in it, completion time \
             its length. Forces were not filtered; the magnitude of the force at rest is its mean before and after \
             the movement.",
            plain(axes.low_pass_hz),
            cited.cite("winter").trim_start_matches('(').trim_end_matches(')'),
            plain(axes.onset_m_s),
            plain(axes.offset_m_s)
        ));
    }
    if study.environments.iter().any(|e| !matches!(e.scene, Scene::None | Scene::Free)) {
        sentences.push(format!(
            "Repeats were averaged over time from the onset of movement, and over the angle with time \
             stretched so that start, {wall}reversal and end coincide."
        ));
    }
    if recorded.compared.iter().any(|metric| metric.starts_with("step_")) {
        sentences.push(format!(
            "The step response is that of θ after the first step of its set-point: from θ₀, the angle \
             at the step, to θ_f, its mean over the last tenth of the time until the set-point changes \
             again or the recording ends. Rise time is that from 10 % to 90 % of the way, overshoot the \
             largest excursion beyond θ_f over |θ_f − θ₀|, settling time that until θ stays within 2 % \
             of the way {}; the steady error is the set-point minus θ_f.",
            cited.cite("ogata")
        ));
    }
    if has_spring {
        sentences.push(format!(
            "Force discrepancy is D(θ) = F(compression) − F(decompression) of the user's force at {} \
             equally spaced angles that both ways cover; its interval is that of a line through D with standard \
             errors that allow for correlated samples {}. Stiffness is the slope of F against θ over \
             the compression by least squares; where the force saturates, that of the line in the \
             continuous pair of a line and a plateau with the least sum of squares {}.",
            analysis.grid_points,
            cited.cite("newey"),
            cited.cite("hudson")
        ));
    }
    if has_wall {
        sentences.push(
            "Penetration of the wall is the largest θ − θ_wall, with straight lines between samples."
                .to_owned(),
        );
    }
    sentences
}

fn model(study: &Study, recorded: &Recorded, cited: &mut Cited) -> Vec<String> {
    let mut sentences = Vec::new();
    if recorded.identified {
        sentences.push(format!(
            "Mass, damping, dry friction and lags of the actuators were fitted to every other repeat \
             of each condition by the balance of forces in weak form: the equation of motion times \
             hats of 100 ms, integrated, where the lever moved in one direction. Their standard \
             errors are from leaving out each trial in turn, with Satterthwaite's degrees of freedom \
             {}.",
            cited.cite("bell")
        ));
    }
    if recorded.replayed {
        let plant = match study.replay {
            ReplayModel::ByEye => {
                "a mass of 0.1 kg and a damping of 1 N s/rad, chosen by eye for the thesis' device"
            }
            ReplayModel::Auto => "the cheapest model that a person could not tell from the fullest",
        };
        let fitted = if recorded.identified { ", and with the fitted plant" } else { "" };
        sentences.push(format!(
            "The recorded force of each trial was put into M L θ̈ = F_O + F_ex − B θ̇ with {plant}{fitted}; \
             between switches the equation is linear and was solved by its exact flow. Model and \
             recording were compared by limits of agreement over trials {}.",
            cited.cite("bland")
        ));
    }
    sentences
}
