//! What Modelica writes as expressions: the net force on each side, and rest at the edges between
//! zones.

use zwidth_dynamics::{Demand, ModelScene, Motion, System, Zone};

use super::parts::{Parts, law};
use super::signals::digits;

/// Adds the texts to a scene's parts.
pub(super) fn add(parts: &mut Parts, system: &System) {
    sums(parts, system.scene());
    edges(parts, system.scene());
    // As the state machine of a language of equations counts: a stop that is leant on is ±2.
    let first = match system.first_motion() {
        Motion::Forward => 1,
        Motion::Backward => -1,
        Motion::Rest if parts.has("on_low") => -2,
        Motion::Rest if parts.has("on_high") => 2,
        Motion::Rest => 0,
    };
    parts.text("first_motion", first.to_string());
}

/// The forces on each side as sums, for languages of equations.
fn sums(parts: &mut Parts, scene: &ModelScene) {
    let has_brake_level = parts.has("coulomb");
    let is_passive = parts.has("passive");
    parts.part("asked_motor", parts.has("motor"));
    parts.part("asked_brake", parts.has("brake"));
    parts.part("asked_back", is_passive && has_brake_level);
    let zones = &scene.environment.zones;
    let full = if parts.has("dead_zone") { "(brake_max + dead_zone)" } else { "brake_max" };
    parts.text("law_motor", modelica_law(zones, "motor_max", "-motor_max", true));
    let up = if has_brake_level { full } else { "-brake_max" };
    parts.text("law_brake", modelica_law(zones, full, up, true));
    parts.text("law_back", modelica_law(zones, full, full, false));
    let only_if = |has: bool, text: &str| if has { text.to_owned() } else { String::new() };
    parts.text("less_dead_zone", only_if(parts.has("dead_zone"), " - dead_zone"));
    let mut single = only_if(parts.has("motor_lag"), " + motor_force");
    single += &only_if(parts.has("friction"), " - viscous * omega");
    single += &only_if(parts.has("gravity"), " + weight * sin(theta)");
    let value = |name: &str| parts.value(name).unwrap_or_default().to_owned();
    if parts.has("terms") {
        let [constant, rad, rad_s] = ["term_constant", "term_rad", "term_rad_s"].map(value);
        single += &format!(" + ({constant}) + ({rad}) * theta + ({rad_s}) * omega");
    }
    if parts.has("pull") {
        single += &format!(" + {} * ({})", value("term_input"), value("pull_modelica"));
    }
    parts.text("single", single);
    let motor = if parts.has("motor_lag") { "" } else { " - asked_motor" };
    let forward = match (parts.has("active"), parts.has("brake_lag")) {
        (true, _) => motor,
        (false, true) => " - level",
        (false, false) => " - asked_brake",
    };
    let backward = match (is_passive, has_brake_level, parts.has("brake_lag")) {
        (false, ..) => motor,
        (true, false, _) => "",
        (true, true, true) => " + level",
        (true, true, false) => " + asked_back",
    };
    parts.text("forward", forward.to_owned());
    parts.text("backward", backward.to_owned());
    let [leaves_forward, leaves_backward] = match parts.has("friction") {
        true => ["leaving_forward > static", "leaving_backward < -static"],
        false => ["leaving_forward > 0", "leaving_backward < 0"],
    };
    let held = only_if(parts.has("let_go"), " and push < let_go");
    parts.text("leaves_forward", leaves_forward.to_owned());
    parts.text("leaves_backward", format!("{leaves_backward}{held}"));
}

/// Rest at the edges between zones, where both sides push back: variables, equations and
/// transitions of a language of equations. Actuators with a lag do not jump there.
fn edges(parts: &mut Parts, scene: &ModelScene) {
    let zones = &scene.environment.zones;
    parts.part("edges", zones.len() > 1 && !parts.has("lags"));
    let has_dead_zone = parts.has("dead_zone");
    let full = if has_dead_zone { "(brake_max + dead_zone)" } else { "brake_max" };
    let less = if has_dead_zone { " - dead_zone" } else { "" };
    let motor = |zone: &Zone, edge: &str| {
        let law = modelica_zone(zone, edge, "motor_max", "-motor_max", false);
        format!(" - max(-motor_max, min(motor_max, {law}))")
    };
    let level = |zone: &Zone, edge: &str, sign: char| {
        let law = modelica_zone(zone, edge, full, full, false);
        format!(" {sign} max(0, min(brake_max, {law}{less}))")
    };
    let signed = |zone: &Zone, edge: &str| {
        let law = modelica_zone(zone, edge, full, "-brake_max", false);
        format!(" - max(-brake_max, min(brake_max, {law}))")
    };
    let (is_active, is_passive, is_coulomb) =
        (parts.has("active"), parts.has("passive"), parts.has("coulomb"));
    let still = if parts.has("friction") { "static" } else { "0" };
    let [mut variables, mut equations, mut branches, mut snaps] = [const { String::new() }; 4];
    let [mut forward, mut backward] = [const { String::new() }; 2];
    for (i, pair) in zones.windows(2).enumerate() {
        let number = i + 1;
        let edge = digits(pair[1].from_rad);
        let up = match (is_active, is_coulomb) {
            (true, _) => motor(&pair[1], &edge),
            (false, true) => level(&pair[1], &edge, '-'),
            (false, false) => signed(&pair[1], &edge),
        };
        let down = match (is_passive, is_coulomb) {
            (false, _) => motor(&pair[0], &edge),
            (true, true) => level(&pair[0], &edge, '+'),
            (true, false) => String::new(),
        };
        variables += &format!(
            "  Real forward_{number}(unit = \"N\") \"the same on edge {number}\";\n  Real backward_{number}(unit = \"N\") \"the same on edge {number}\";\n"
        );
        equations +=
            &format!("  forward_{number} = single{up};\n  backward_{number} = single{down};\n");
        branches += &format!(
            "  elsewhen (pre(motion) == 1 or pre(motion) == -1) and abs(theta - ({edge})) < near and forward_{number} < {still} and backward_{number} > -{still} and M * L * omega ^ 2 < 2 * near * min({still} - forward_{number}, backward_{number} + {still}) then\n    motion = 0;\n    edge = {number};\n"
        );
        let when = if i == 0 { "when" } else { "elsewhen" };
        snaps += &format!("  {when} edge == {number} then\n    reinit(theta, {edge});\n");
        forward += &format!("if edge == {number} then forward_{number} else ");
        backward += &format!("if edge == {number} then backward_{number} else ");
    }
    parts.text("edge_variables", variables.trim_end().to_owned());
    parts.text("edge_equations", equations.trim_end().to_owned());
    parts.text("edge_branches", branches.trim_end().to_owned());
    parts.text("edge_snaps", format!("{snaps}  end when;"));
    parts.text("leaving_forward", format!("{forward}forward"));
    parts.text("leaving_backward", format!("{backward}backward"));
}

/// What a zone asks of an actuator at an angle, as an expression of Modelica; `full` and `up` stand
/// for all that the actuator has.
fn modelica_zone(zone: &Zone, theta: &str, full: &str, up: &str, is_damped: bool) -> String {
    match law(zone.demand) {
        Some((k, b, force)) => {
            let damping =
                if is_damped { format!(" + {} * omega", digits(b)) } else { String::new() };
            format!("{} * ({theta}) + ({}){damping}", digits(k), digits(force))
        }
        None if zone.demand == Demand::Full => full.to_owned(),
        None => up.to_owned(),
    }
}

/// The same of all zones at the lever's angle.
fn modelica_law(zones: &[Zone], full: &str, up: &str, is_damped: bool) -> String {
    let law_of = |zone: &Zone| modelica_zone(zone, "theta", full, up, is_damped);
    let mut expression = String::new();
    for (i, pair) in zones.windows(2).enumerate() {
        let word = if i == 0 { "if" } else { "elseif" };
        let edge = digits(pair[1].from_rad);
        expression += &format!("{word} theta < {edge} then {} ", law_of(&pair[0]));
    }
    let last = zones.last().map(law_of).unwrap_or_default();
    if zones.len() > 1 { format!("{expression}else {last}") } else { last }
}
