//! Figure 32: the flow from the user's force to the voltages of motor and brake and back again,
//! tick by tick.

use super::setup::{brake, force_sensor, motor, name, words};
use crate::FigureKind;
use crate::schematic::sketch::{Block, Point, flow, line, over, panel, right_of, tint, within};
use crate::words::plain;
use zwidth_draw::style;
use zwidth_draw::{Cell, Figure, Layer, LegendPlace, TWO_COLUMNS_MM};
use zwidth_study::{ActuatorKind, Coordinate, Setup, VelocityFilter};
use zwidth_tables::{given, number, with_unit};

/// The figure [`control_loop`].
pub(crate) const CONTROL_LOOP: FigureKind = FigureKind::new(
    "schematic.control_loop",
    "what flows through device and control loop in a tick",
    "trial",
);

/// Corners of the drawing, of what the device does in it, and of what the computer does, mm.
const WHOLE: [Point; 2] = [(0.0, 0.0), (173.5, 75.0)];
const DEVICE: [Point; 2] = [(32.2, 0.5), (95.5, 74.5)];
const COMPUTER: [Point; 2] = [(99.0, 0.5), (173.0, 74.5)];
/// Height of what a group is called, mm.
const NAME_MM: f64 = 4.5;
/// At most so many environments or modes are listed; of more, only their number is given.
const MOST_LISTED: usize = 3;

/// Every box of the drawing.
struct Boxes {
    participant: Block,
    lever: Block,
    force: Block,
    angle: Block,
    velocity: Block,
    recorded: Block,
    environment: Block,
    mode: Block,
    voltage: Block,
    safety: Block,
    /// Those that are used, with where their torque comes to the lever beside its middle, mm, and its
    /// symbol.
    actuators: Vec<(Block, f64, &'static str)>,
}

impl Boxes {
    fn of(setup: &Setup) -> Self {
        let [theta, theta_dot] = symbols(setup);
        let limit = with_unit(&number(setup.control.force_limit_n, None), "N");
        let recorded = format!("{theta}, {theta_dot}, *F*_{{ex}}, voltages");
        let angle = match setup.coordinate {
            Coordinate::Rotational => "angle sensor",
            Coordinate::Linear { .. } => "position sensor",
        };
        let motor = Block::new((80.0, 25.0), (28.0, 12.0), motor(setup)).coloured(style::MOTOR);
        let brake = Block::new((80.0, 9.5), (28.0, 12.0), brake(setup)).coloured(style::BRAKE);
        let mut actuators = Vec::new();
        if setup.uses(ActuatorKind::Motor) {
            actuators.push((motor, 3.0, "*T*_{m}"));
        }
        if setup.uses(ActuatorKind::Brake) {
            actuators.push((brake, -3.0, "*T*_{b}"));
        }
        Self {
            actuators,
            participant: Block::new((11.5, 39.0), (22.0, 12.0), ["participant"]),
            lever: Block::new((45.0, 39.0), (22.0, 18.0), lever(setup)),
            force: Block::new((80.0, 64.5), (28.0, 9.0), force_sensor(setup))
                .coloured(style::FINGER),
            angle: Block::new((80.0, 53.5), (28.0, 8.0), [angle]).coloured(style::FINGER),
            velocity: Block::new((113.0, 53.5), (25.0, 13.0), velocity(setup)),
            recorded: Block::new((113.0, 34.0), (25.0, 12.0), ["recorded:".to_owned(), recorded]),
            environment: Block::new((150.5, 53.5), (36.0, 17.0), environments(setup)),
            mode: Block::new((150.5, 31.5), (36.0, 19.0), modes(setup)),
            voltage: Block::new(
                (150.5, 9.5),
                (36.0, 13.0),
                ["voltage that gives this force", "by the actuator's characteristic"],
            ),
            safety: Block::new(
                (113.0, 9.5),
                (25.0, 13.0),
                ["safety:".to_owned(), format!("0 V where *F*_{{ex}} > {limit}")],
            )
            .coloured(style::MARK),
        }
    }

    fn all(&self) -> impl Iterator<Item = &Block> {
        let always = [
            &self.participant,
            &self.lever,
            &self.force,
            &self.angle,
            &self.velocity,
            &self.recorded,
            &self.environment,
            &self.mode,
            &self.voltage,
            &self.safety,
        ];
        always.into_iter().chain(self.actuators.iter().map(|(block, ..)| block))
    }
}

/// The way from the user's force through device and computer and back, as the study has it.
pub(crate) fn control_loop(setup: &Setup) -> Figure {
    let boxes = Boxes::of(setup);
    let rate = format!("**control loop**, {} ticks/s", number(setup.control.rate_hz, None));
    let mut layers = group(DEVICE, name(setup));
    layers.extend(group(COMPUTER, rate));
    layers.extend(boxes.all().flat_map(Block::layers));
    layers.extend(through_device(&boxes, setup));
    layers.extend(through_computer(&boxes, setup));
    Figure {
        title: Some("What flows through device and control loop".to_owned()),
        description: "A loop: the participant's force moves the lever; force and angle sensor; \
                      velocity from angles; the environment asks for a force, the mode chooses the \
                      actuator, its characteristic gives the voltage, safety may take it away; motor \
                      and brake act on the lever, which the participant feels."
            .to_owned(),
        width_mm: TWO_COLUMNS_MM,
        panels: vec![panel(Cell::at(0, 0), WHOLE[0], WHOLE[1], layers)],
        legend: LegendPlace::Hidden,
        footnotes: vec![
            "Boards, amplifier and supply are not drawn: the study does not know them.".to_owned(),
        ],
        ..Figure::default()
    }
}

/// A light ground under what belongs together, with its name.
fn group([low, high]: [Point; 2], name: String) -> Vec<Layer> {
    let name = within(vec![name], (low.0, high.1 - NAME_MM), high);
    let corners = [low, (high.0, low.1), high, (low.0, high.1), low];
    vec![tint(low, high, style::GRID), line(corners, style::reference()), name]
}

/// From the participant to the sensors, and from the actuators back.
fn through_device(b: &Boxes, setup: &Setup) -> Vec<Layer> {
    let [theta, _] = symbols(setup);
    let hand = b.participant.right();
    let lever = b.lever.left();
    let mut layers = flow([(hand.0, hand.1 + 3.0), (lever.0, lever.1 + 3.0)]);
    layers.extend(flow([(lever.0, lever.1 - 3.0), (hand.0, hand.1 - 3.0)]));
    let middle = f64::midpoint(hand.0, lever.0);
    layers.push(over("*F*_{ex}", (middle, hand.1 + 3.0)));
    layers.push(over("feels", (middle, hand.1 - 8.2)));
    let top = b.lever.top();
    let bottom = b.lever.bottom();
    for (x, sensor) in [(top.0 - 3.0, &b.force), (top.0 + 3.0, &b.angle)] {
        layers.extend(flow([(x, top.1), (x, sensor.at.1), sensor.left()]));
    }
    layers.push(over("*F*_{ex}", (57.0, b.force.at.1)));
    layers.push(over(theta, (57.0, b.angle.at.1)));
    for (actuator, aside, symbol) in &b.actuators {
        let from = actuator.left();
        let x = bottom.0 + aside;
        layers.extend(flow([from, (x, from.1), (x, bottom.1)]));
        layers.push(over(*symbol, (57.0, from.1)));
    }
    layers
}

/// From the sensors through the computer to the actuators.
fn through_computer(b: &Boxes, setup: &Setup) -> Vec<Layer> {
    let [theta, theta_dot] = symbols(setup);
    let mut layers = flow([b.angle.right(), b.velocity.left()]);
    layers.push(over(theta, (97.2, b.angle.at.1)));
    layers.extend(flow([b.velocity.right(), b.environment.left()]));
    let gap = f64::midpoint(b.velocity.right().0, b.environment.left().0);
    layers.push(over(format!("{theta}, {theta_dot}"), (gap - 0.4, b.velocity.at.1)));
    layers.extend(flow([b.velocity.bottom(), b.recorded.top()]));
    layers.extend(flow([b.environment.bottom(), b.mode.top()]));
    layers.extend(flow([b.mode.bottom(), b.voltage.top()]));
    layers.extend(flow([b.voltage.left(), b.safety.right()]));
    let force = b.force.right();
    let mode = b.mode.right();
    let beyond = mode.0 + 3.2;
    layers.extend(flow([force, (beyond, force.1), (beyond, mode.1), mode]));
    layers.push(over("*F*_{ex}", (113.0, force.1)));
    let split = (97.2, b.safety.at.1);
    layers.push(line([b.safety.left(), split], style::mean(style::INK)));
    for (actuator, ..) in &b.actuators {
        let to = actuator.right();
        layers.extend(flow([split, (split.0, to.1), to]));
    }
    layers.push(right_of(vec!["voltages".to_owned()], (split.0 + 1.5, 20.0)));
    layers
}

/// Position and velocity, as axes have them.
fn symbols(setup: &Setup) -> [&'static str; 2] {
    match setup.coordinate {
        Coordinate::Rotational => ["*θ*", "*θ̇*"],
        Coordinate::Linear { .. } => ["*x*", "*ẋ*"],
    }
}

/// What the user holds, and how far it goes.
fn lever(setup: &Setup) -> Vec<String> {
    let what = match setup.coordinate {
        Coordinate::Rotational => "lever",
        Coordinate::Linear { .. } => "slide",
    };
    let length = setup.device.lever_m.filter(|_| setup.coordinate == Coordinate::Rotational);
    let length = length.map(|m| given(m * 1e3, "mm", setup.coordinate));
    let ends = setup.device.theta_min_rad.zip(setup.device.theta_max_rad);
    let ends = ends.map(|(low, high)| format!("{} to {}", place(setup, low), place(setup, high)));
    [Some(what.to_owned()), length, ends].into_iter().flatten().collect()
}

fn place(setup: &Setup, theta_rad: f64) -> String {
    words(setup).signed_place(theta_rad)
}

fn velocity(setup: &Setup) -> Vec<String> {
    let how = match setup.control.velocity {
        VelocityFilter::Difference => "difference of the last two".to_owned(),
        VelocityFilter::SecondOrder { cutoff_hz } => {
            format!("second-order low-pass, {}", with_unit(&number(cutoff_hz, None), "Hz"))
        }
    };
    vec!["velocity:".to_owned(), how]
}

/// What each environment asks for.
fn environments(setup: &Setup) -> Vec<String> {
    let mut items = Vec::new();
    for environment in &setup.environments {
        let spring = environment.scene.spring().map(|spring| {
            let stiffness = given(spring.stiffness_n_per_rad, "N/rad", setup.coordinate);
            format!("{stiffness} from {}", place(setup, spring.rest_rad))
        });
        let wall = environment.scene.wall_rad();
        let wall = wall.map(|at| format!("all from {} on", place(setup, at)));
        let constant = environment.scene.constant_n();
        let constant = constant.map(|force_n| given(force_n, "N", setup.coordinate));
        let late = (environment.delay_s > 0.0)
            .then(|| format!("{} late", with_unit(&number(environment.delay_s * 1e3, None), "ms")));
        let parts: Vec<String> =
            spring.into_iter().chain(constant).chain(wall).chain(late).collect();
        let force = if parts.is_empty() { "none".to_owned() } else { parts.join(", ") };
        items.push(format!("{}: {force}", plain(&environment.label)));
    }
    listed("force asked for:", "environments", items)
}

/// Which actuator each mode has in charge.
fn modes(setup: &Setup) -> Vec<String> {
    let mut items = Vec::new();
    for mode in &setup.modes {
        let Some(law) = mode.law() else { continue };
        let [forward, back] = law.drives().map(ActuatorKind::as_str);
        let drive = match forward == back {
            true => forward.to_owned(),
            false => format!("{forward} in, {back} back"),
        };
        items.push(format!("{}: {drive}", plain(&mode.label)));
    }
    let mut lines = listed("actuator in charge:", "modes", items);
    if setup.modes.iter().any(|mode| mode.has(ActuatorKind::Brake)) {
        let let_go = with_unit(&number(setup.control.let_go_n, None), "N");
        lines.push(format!("brake lets go below {let_go}"));
    }
    lines
}

/// A heading and what it lists, or how many there are.
fn listed(heading: &str, what: &str, items: Vec<String>) -> Vec<String> {
    let items = match items.len() {
        0 => vec!["none".to_owned()],
        n if n > MOST_LISTED => vec![format!("that of {n} {what}")],
        _ => items,
    };
    [heading.to_owned()].into_iter().chain(items).collect()
}
