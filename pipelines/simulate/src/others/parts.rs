//! What a scene has, as words that templates ask for and values that they take.

use std::collections::{BTreeMap, BTreeSet};

use zwidth_dynamics::{Affine, BrakeLaw, Demand, DriveMode, FingerLaw, Input, ModelScene, System};

use super::signals::{self, digits};
use crate::SimulateError;

/// The one term with a curved part that the formats can say.
const GRAVITY: &str = "gravity";
/// Standard gravity, m/s² (CGPM 1901): what a world's gravity has to be in a file for a weight.
const STANDARD_GRAVITY: f64 = 9.806_65;

/// A scene's parts and values, each under its name.
#[derive(Debug, Default)]
pub(super) struct Parts {
    has: BTreeSet<&'static str>,
    values: BTreeMap<&'static str, String>,
}

impl Parts {
    /// What a checked scene has.
    ///
    /// # Errors
    /// A term whose force no format can say.
    pub(super) fn of(system: &System) -> Result<Self, SimulateError> {
        let scene = system.scene();
        let mut parts = Self::default();
        parts.scene(scene);
        parts.actuators(scene);
        parts.environment(scene);
        parts.input(scene);
        parts.friction_and_finger(scene);
        parts.terms(scene)?;
        parts.inertias(scene);
        Ok(parts)
    }

    pub(super) fn has(&self, part: &str) -> bool {
        self.has.contains(part)
    }

    pub(super) fn value(&self, name: &str) -> Option<&str> {
        self.values.get(name).map(String::as_str)
    }

    /// Adds a part if the scene has it.
    pub(super) fn part(&mut self, name: &'static str, has: bool) {
        if has {
            self.has.insert(name);
        }
    }

    /// The shortest digits that read back as the same number; every format takes them.
    fn number(&mut self, name: &'static str, value: f64) {
        self.values.insert(name, digits(value));
    }

    pub(super) fn text(&mut self, name: &'static str, text: String) {
        self.values.insert(name, text);
    }

    fn scene(&mut self, scene: &ModelScene) {
        self.text("scene", one_line(&scene.name));
        self.text("version", env!("CARGO_PKG_VERSION").to_owned());
        self.number("mass", scene.plant.mass_kg);
        self.number("lever", scene.plant.lever_m);
        self.number("theta", scene.start.theta_rad);
        self.number("omega", scene.start.theta_dot_rad_s);
        self.number("duration", scene.duration_s);
        self.number("step", scene.step_s);
        self.part("stops", scene.plant.stops_rad.is_some());
        if let Some([low, high]) = scene.plant.stops_rad {
            self.number("low", low);
            self.number("high", high);
            let at_rest = scene.start.theta_dot_rad_s == 0.0;
            self.part("on_low", at_rest && scene.start.theta_rad <= low);
            self.part("on_high", at_rest && scene.start.theta_rad >= high);
        }
    }

    fn actuators(&mut self, scene: &ModelScene) {
        let mode = scene.mode;
        self.part("active", mode == DriveMode::Active);
        self.part("passive", mode == DriveMode::Passive);
        self.part("hybrid", mode == DriveMode::Hybrid);
        let has_motor = mode != DriveMode::Passive;
        let has_brake = mode != DriveMode::Active;
        let is_coulomb = scene.brake.law == BrakeLaw::Coulomb;
        self.part("motor", has_motor);
        self.part("brake", has_brake);
        self.part("coulomb", has_brake && is_coulomb);
        self.part("signed", has_brake && !is_coulomb);
        self.part("dead_zone", has_brake && is_coulomb && scene.brake.dead_zone_n > 0.0);
        self.number("motor_max", scene.motor.max_n);
        self.number("brake_max", scene.brake.max_n);
        self.number(
            "motor_nm",
            if has_motor { scene.motor.max_n * scene.plant.lever_m } else { 0.0 },
        );
        self.number("dead_zone", scene.brake.dead_zone_n);
        let motor_lag = scene.motor.lag_s.filter(|_| has_motor);
        let brake_lag = scene.brake.lag_on_off_s.filter(|_| has_brake);
        let let_go = scene.brake.let_go_n.filter(|_| mode == DriveMode::Hybrid);
        self.part("motor_lag", motor_lag.is_some());
        self.part("brake_lag", brake_lag.is_some());
        self.part("lags", motor_lag.is_some() || brake_lag.is_some());
        self.part("let_go", let_go.is_some());
        let shares = mode == DriveMode::Hybrid && motor_lag.is_some() && brake_lag.is_none();
        self.part("shares", shares);
        let mut entries = if scene.finger.is_some() { 4 } else { 2 };
        if let Some(lag) = motor_lag {
            self.number("motor_lag", lag);
            self.text("motor_at", entries.to_string());
            entries += 1;
        }
        if let Some([on, off]) = brake_lag {
            self.number("brake_on", on);
            self.number("brake_off", off);
            self.text("level_at", entries.to_string());
            entries += 1;
        }
        if let Some(let_go) = let_go {
            self.number("let_go", let_go);
        }
        self.text("entries", entries.to_string());
    }

    fn environment(&mut self, scene: &ModelScene) {
        let zones = &scene.environment.zones;
        let is_free = zones.iter().all(|zone| law(zone.demand) == Some((0.0, 0.0, 0.0)));
        let one_law = zones.len() == 1 && !is_free;
        self.part("zones", zones.len() > 1);
        self.part("free", is_free);
        // What a spring with a limit can say by itself.
        let is_affine =
            one_law && matches!(zones[0].demand, Demand::Spring { .. } | Demand::Force { .. });
        let is_direct = scene.mode == DriveMode::Active && scene.motor.lag_s.is_none();
        if let Demand::Spring { stiffness_n_per_rad, damping_ns_per_rad, rest_rad } =
            zones[0].demand
        {
            let lever = scene.plant.lever_m;
            let viscous = scene.friction.map_or(0.0, |friction| friction.viscous_ns_per_rad);
            self.part("spring", is_affine && is_direct);
            self.number("spring_rest", rest_rad);
            self.number("spring_nm_rad", stiffness_n_per_rad * lever);
            self.number("spring_damping_nms", (damping_ns_per_rad + viscous) * lever);
        }
        self.part("affine", is_affine && is_direct);
        self.part("driven", !(is_free || is_affine && is_direct));
        let rows: Vec<String> =
            zones.iter().map(|zone| zone_row(zone.from_rad, zone.demand)).collect();
        self.text("zones", rows.join(", "));
        let words: Vec<String> = zones
            .iter()
            .enumerate()
            .map(|(i, zone)| zone_words(i, zone.from_rad, zone.demand))
            .collect();
        self.text("asks", words.join("; "));
        if let Some((k, b, force)) = law(zones[0].demand) {
            let lever = scene.plant.lever_m;
            // As an actuator of gear L has them: over its length L θ.
            self.number("law_force", -force);
            self.number("law_per_m", -k / lever);
            self.number("law_per_m_s", -b / lever);
        }
    }

    fn input(&mut self, scene: &ModelScene) {
        let input = &scene.input;
        let pull = scene.terms.iter().find_map(|term| Some(term.input()?.1));
        let is_series = |input: &Input| matches!(input, Input::Series(_));
        self.part("series", is_series(input) || pull.is_some_and(is_series));
        let mut functions = signals::modelica_function("external_series", input);
        functions += &pull
            .map_or(String::new(), |pull| signals::modelica_function("displacement_series", pull));
        self.text("functions", functions.trim_end().to_owned());
        self.text(
            "input",
            signals::python("external", "User's force on the lever's end, N", input),
        );
        self.text("input_words", signals::words(input, "N"));
        self.text("input_modelica", signals::modelica("external_series", input));
    }

    fn friction_and_finger(&mut self, scene: &ModelScene) {
        self.part("friction", scene.friction.is_some());
        let lever = scene.plant.lever_m;
        let (mut kinetic_n, mut viscous) = (0.0, 0.0);
        if let Some(friction) = scene.friction {
            self.part("dry", friction.static_n > 0.0);
            self.part("stiction", friction.static_n > friction.kinetic_n);
            self.number("static", friction.static_n);
            self.number("kinetic", friction.kinetic_n);
            self.number("viscous", friction.viscous_ns_per_rad);
            kinetic_n = friction.kinetic_n;
            viscous = friction.viscous_ns_per_rad;
        }
        self.part("holds", self.has("dry") || self.has("coulomb"));
        // About the axis: N m, N m s/rad.
        self.number("kinetic_nm", kinetic_n * lever);
        self.number("viscous_nms", viscous * lever);
        // Arguments that the programs' functions have only where they are needed.
        let bottoms = scene.finger.is_some_and(|finger| finger.length_m.is_some());
        let only_if = |has: bool, text: &str| if has { text.to_owned() } else { String::new() };
        self.text("contact", only_if(bottoms, ", contact"));
        self.text("contact_argument", only_if(bottoms, ", contact=0"));
        self.text("region_contact", only_if(bottoms, ", region.contact"));
        let let_go = self.has("let_go");
        self.text("held", only_if(let_go, ", held"));
        self.text("held_argument", only_if(let_go, ", held=None"));
        let Some(finger) = scene.finger else { return };
        self.part("finger", true);
        self.part("consistent", finger.law == FingerLaw::Consistent);
        self.part("bottoms", finger.length_m.is_some());
        self.number("finger_mass", finger.mass_kg);
        self.number("finger_stiffness", finger.stiffness_n_per_m);
        self.number("finger_damping", finger.damping_ns_per_m);
        // As a joint on the lever's axis, whose angle is x2 / L.
        self.number("finger_inertia", finger.mass_kg * lever * lever);
        self.number("finger_nm_rad", finger.stiffness_n_per_m * lever * lever);
        self.number("finger_nms_rad", finger.damping_ns_per_m * lever * lever);
        if let Some(length) = finger.length_m {
            self.number("finger_length", length);
            self.number("finger_rad", length / lever);
            self.number("finger_low", -length / lever);
        }
    }

    fn terms(&mut self, scene: &ModelScene) -> Result<(), SimulateError> {
        let plant = &scene.plant;
        let mut sum = Affine::default();
        for term in scene.terms.iter() {
            let affine = term.affine(plant);
            sum.constant_n += affine.constant_n;
            sum.per_rad_n += affine.per_rad_n;
            sum.per_rad_s_n += affine.per_rad_s_n;
            let quarter = std::f64::consts::FRAC_PI_2;
            match term.curve(plant, quarter, 0.0) {
                Some(curve) if term.name() == GRAVITY => {
                    self.part("gravity", curve.force_n > 0.0);
                    self.number("weight", curve.force_n);
                }
                Some(_) => return Err(SimulateError::TermNotSaid { term: term.name() }),
                None => {}
            }
            if let Some((_, input)) = term.input() {
                self.part("pull", true);
                self.number("term_input", affine.per_input_n);
                self.text(
                    "pull_input",
                    signals::python(
                        "displacement",
                        "Where the moved spring's far end is, rad",
                        input,
                    ),
                );
                self.text("pull_words", signals::words(input, "rad"));
                self.text("pull_modelica", signals::modelica("displacement_series", input));
            }
        }
        self.part("terms", sum != Affine::default());
        self.number("term_constant", sum.constant_n);
        self.number("term_rad", sum.per_rad_n);
        self.number("term_rad_s", sum.per_rad_s_n);
        self.number("term_per_m", sum.per_rad_n / plant.lever_m);
        self.number("term_per_m_s", sum.per_rad_s_n / plant.lever_m);
        Ok(())
    }

    /// The lever as a rigid body: about the axis it has M L², and its weight turns it as the scene's
    /// does. Without a weight its mass lies on the axis, where it does not show; with one, so far
    /// out that m g r is the scene's. A mass that would then have more than M L² is replaced by a
    /// heavier one further in.
    fn inertias(&mut self, scene: &ModelScene) {
        /// mjMINVAL of MuJoCo, kg m²: it takes no moment of inertia that is not above it.
        const LEAST: f64 = 1e-15;
        let lever = scene.plant.lever_m;
        let about_axis = scene.plant.mass_kg * lever * lever;
        let weight_n: f64 = self.value("weight").and_then(|text| text.parse().ok()).unwrap_or(0.0);
        let mass_radius = weight_n * lever / STANDARD_GRAVITY;
        // At least half of M L² is left for the body itself.
        let lightest = 2.0 * mass_radius * mass_radius / about_axis;
        let mass_kg = scene.plant.mass_kg.max(lightest);
        let radius_m = mass_radius / mass_kg;
        self.number("body_mass", mass_kg);
        self.number("body_radius", radius_m);
        self.number("body_inertia", about_axis - mass_kg * radius_m * radius_m);
        let finger = scene.finger.map_or(f64::INFINITY, |f| f.mass_kg * lever * lever);
        // Of the lever's own there may be no more than half.
        self.part("tiny", about_axis.min(finger) <= 2.0 * LEAST);
        let g = if weight_n > 0.0 { STANDARD_GRAVITY } else { 0.0 };
        self.number("g", g);
        self.number("g_z", -g);
        self.number("shown_width", lever / 40.0);
        self.number("shown_half", lever / 2.0);
    }
}

/// A name from a file on one line, without characters that end a comment or cannot be printed.
fn one_line(name: &str) -> String {
    let spaced = name
        .chars()
        .map(|c| if c.is_control() || "\u{2028}\u{2029}".contains(c) { ' ' } else { c });
    let mut line: String = spaced.collect();
    // Ends a comment of XML; one pass may leave another.
    while line.contains("--") {
        line = line.replace("--", "- -");
    }
    line.trim_end_matches('-').to_owned()
}

/// Stiffness, damping and force at θ = 0 that a zone asks for; none where it asks for all there is.
pub(super) fn law(demand: Demand) -> Option<(f64, f64, f64)> {
    match demand {
        Demand::Spring { stiffness_n_per_rad: k, damping_ns_per_rad: b, rest_rad } => {
            Some((k, b, -k * rest_rad))
        }
        Demand::Force { force_n } => Some((0.0, 0.0, force_n)),
        Demand::Full | Demand::FullUp => None,
    }
}

/// A zone as a row of the programs' table.
fn zone_row(from_rad: f64, demand: Demand) -> String {
    let from = digits(from_rad);
    match law(demand) {
        Some((k, b, force)) => format!("({from}, {}, {}, {})", digits(k), digits(b), digits(force)),
        None if demand == Demand::Full => format!("({from}, 0.0, 0.0, math.inf)"),
        None => format!("({from}, 0.0, 0.0, -math.inf)"),
    }
}

/// A zone in words.
fn zone_words(i: usize, from_rad: f64, demand: Demand) -> String {
    let place = if i == 0 { String::new() } else { format!("from {} rad on ", digits(from_rad)) };
    let law = match demand {
        Demand::Spring { stiffness_n_per_rad: k, damping_ns_per_rad: b, rest_rad } => {
            let sign = if rest_rad < 0.0 { '+' } else { '-' };
            format!(
                "u = {} (theta {sign} {}) + {} omega",
                digits(k),
                digits(rest_rad.abs()),
                digits(b)
            )
        }
        Demand::Force { force_n } => format!("u = {}", digits(force_n)),
        Demand::Full => "all that the actuators have, towards -theta".to_owned(),
        Demand::FullUp => "all that the actuators have, towards +theta".to_owned(),
    };
    format!("{place}{law}")
}
