//! Scenes whose behaviour is known in closed form. No truth here comes from running a solver.

use std::f64::consts::{PI, TAU};

use serde::Serialize;
use zwidth_dynamics::RunVerdict::{
    self, DependsOnRestRule, Failed, Forced, FreeUndamped, Growing, LimitCycle,
    NumericalChattering, NumericalCreep, Smooth, Transient, UnstableStep,
};
use zwidth_dynamics::{
    Affine, Controller, Curve, Demand, DriveMode, Environment, Friction, Gravity, Input, Model,
    ModelScene, Parameter, Plant, Pull, SampledLoop, Start, System, Term, Zone, table3,
};

/// A scene, its truth, and why.
pub(crate) struct Case {
    pub(crate) name: String,
    pub(crate) model: Box<dyn Model>,
    /// What the motion is.
    pub(crate) nature: RunVerdict,
    pub(crate) reason: &'static str,
    pub(crate) steps_s: [f64; 4],
    /// (k, c) of θ̈ = −k θ − c θ̇ where the lever moves, for the explicit methods' limits.
    poles: Vec<(f64, f64)>,
    /// Methods that cannot hold a lever which a set-valued force holds, and swing instead.
    chatters: Vec<&'static str>,
    /// Methods that let such a lever creep.
    creeps: Vec<&'static str>,
    /// A curved term: `exact` and `moreau_jean` refuse the scene by name.
    curved: bool,
}

/// Inertia M_O L of every scene but the sampled ones, kg m.
const INERTIA: f64 = 0.005;

impl Case {
    /// What a solver's run with a step must be called.
    pub(crate) fn truth(&self, solver: &str, h: f64) -> RunVerdict {
        /// The largest state that is followed, as a power of ten, and where a run starts.
        const LARGEST: f64 = 100.0;
        const START: f64 = -1.0;
        let explicit = solver.starts_with("rk4") || solver == "symplectic_euler";
        if self.curved && (solver == "exact" || solver == "moreau_jean") {
            return Failed;
        }
        let radius = |&(k, c): &(f64, f64)| {
            if solver.starts_with("rk4") { rk4_radius(k, c, h) } else { euler_radius(k, c, h) }
        };
        let growth = self.poles.iter().map(radius).fold(0.0, f64::max);
        if explicit && growth > 1.0 + 1e-6 {
            let steps = self.model.plant().scene().duration_s / h;
            let endless = self.model.plant().scene().plant.stops_rad.is_none() && !self.curved;
            let size = START + steps * growth.log10();
            return if endless && size > LARGEST { Failed } else { UnstableStep };
        }
        let rings = self.poles.iter().any(|&(k, c)| rings(solver, k, c, h));
        if rings || self.chatters.contains(&solver) {
            NumericalChattering
        } else if self.creeps.contains(&solver) {
            NumericalCreep
        } else {
            self.nature
        }
    }
}

/// |R(hλ)| of RK4, R(z) = 1 + z + z²/2 + z³/6 + z⁴/24, for the worse root of λ² + c λ + k = 0.
fn rk4_radius(k: f64, c: f64, h: f64) -> f64 {
    let d = c * c / 4.0 - k;
    let roots = if d < 0.0 {
        vec![(-c / 2.0, (-d).sqrt())]
    } else {
        vec![(-c / 2.0 + d.sqrt(), 0.0), (-c / 2.0 - d.sqrt(), 0.0)]
    };
    let size = |&(re, im): &(f64, f64)| {
        let (x, y) = (h * re, h * im);
        let (mut a, mut b) = (1.0, 0.0); // Horner: R = 1 + z (1 + z/2 (1 + z/3 (1 + z/4)))
        for n in [4.0, 3.0, 2.0, 1.0] {
            (a, b) = (1.0 + (x * a - y * b) / n, (x * b + y * a) / n);
        }
        a.hypot(b)
    };
    roots.iter().map(size).fold(0.0, f64::max)
}

/// The same for ω' = ω − h (k θ + c ω), θ' = θ + h ω': trace 2 − h c − h² k, determinant 1 − h c.
fn euler_radius(k: f64, c: f64, h: f64) -> f64 {
    let (half, det) = (1.0 - h * c / 2.0 - h * h * k / 2.0, 1.0 - h * c);
    let d = half * half - det;
    if d < 0.0 { det.sqrt() } else { half.abs() + d.sqrt() }
}

/// Whether a multiplier of a creeping motion is real, below 0, and as large as the others: the
/// method jumps to and fro where the motion creeps. The trapezoidal rule of `moreau_jean` has
/// (1 + z/2)/(1 − z/2), below 0 for z = hλ < −2; symplectic Euler has a root below 0 for h c > 1.
fn rings(solver: &str, k: f64, c: f64, h: f64) -> bool {
    /// Share of the largest multiplier that lasts for six swings.
    const AS_LARGE: f64 = 0.9;
    let d = c * c / 4.0 - k;
    if k <= 0.0 || d <= 0.0 {
        return false;
    }
    let roots = match solver {
        "moreau_jean" => [-c / 2.0 + d.sqrt(), -c / 2.0 - d.sqrt()]
            .map(|l| (1.0 + h * l / 2.0) / (1.0 - h * l / 2.0)),
        "symplectic_euler" => {
            let (half, det) = (1.0 - h * c / 2.0 - h * h * k / 2.0, 1.0 - h * c);
            let root = (half * half - det).max(0.0).sqrt();
            [half + root, half - root]
        }
        _ => return false,
    };
    let [large, negative] = [roots[0].abs().max(roots[1].abs()), roots[0].min(roots[1])];
    negative < -AS_LARGE * large
}

/// Turns, and mean velocity, of RK4 that looks at the sign of the velocity v in every stage, for
/// m v̇ = push − F sgn v (sgn 0 = 0), in units of h F/m: a map of one number.
fn per_stage_turns(push: f64, friction: f64, steps: usize) -> (usize, f64) {
    let slope =
        |v: f64| push / friction - if v > 0.0 { 1.0 } else { -f64::from(u8::from(v < 0.0)) };
    let (mut v, mut last, mut turns, mut sum) = (0.0, 0.0, 0, 0.0);
    for _ in 0..steps {
        let k1: f64 = slope(v);
        let k2 = slope(v + k1 / 2.0);
        let k3 = slope(v + k2 / 2.0);
        let k4 = slope(v + k3);
        v += (k1 + 2.0 * k2 + 2.0 * k3 + k4) / 6.0;
        turns += usize::from(v * last < 0.0);
        last = if v == 0.0 { last } else { v };
        sum += v;
    }
    (turns, sum / steps as f64)
}

/// Methods that switch on the sign of θ̇.
const SWITCHING: [&str; 3] = ["symplectic_euler", "rk4_per_stage", "rk4_per_step"];

fn case(scene: ModelScene, nature: RunVerdict, reason: &'static str) -> Case {
    let name = scene.name.clone();
    let curved = scene.terms.iter().any(|t| t.curve(&scene.plant, 1.0, 1.0).is_some());
    let model = Box::new(System::new(scene).unwrap());
    let steps_s = [1e-4, 5e-4, 1e-3, 2e-3];
    Case {
        name,
        model,
        nature,
        reason,
        steps_s,
        poles: vec![],
        chatters: vec![],
        creeps: vec![],
        curved,
    }
}

impl Case {
    fn at(self, steps_s: [f64; 4]) -> Self {
        Self { steps_s, ..self }
    }

    /// Poles of one zone, and four steps in units of 1/ω.
    fn swinging(self, k: f64, c: f64, shares: [f64; 4]) -> Self {
        let steps_s = shares.map(|share| share / k.sqrt());
        Self { poles: vec![(k, c)], steps_s, ..self }
    }

    fn poles(self, poles: &[(f64, f64)]) -> Self {
        Self { poles: poles.to_vec(), ..self }
    }

    fn chattering(self, solvers: &[&'static str]) -> Self {
        Self { chatters: solvers.to_vec(), ..self }
    }
}

/// From far inside every explicit method's limit to beyond it: RK4's is at 2.83, Euler's at 2.
const SHARES: [f64; 4] = [0.05, 0.3, 1.0, 3.2];

/// Where zones make a limit in closed form impossible.
const MILD: [f64; 4] = [0.05, 0.1, 0.3, 0.6];

/// A lever of 1 m and 5 g without stops under a motor without limit, from an angle on.
fn lever(name: String, input: Input, theta_rad: f64, duration_s: f64) -> ModelScene {
    let mut scene = table3::scene(DriveMode::Active, input);
    scene.name = name;
    scene.environment = Environment::free();
    scene.motor.max_n = 1e9;
    scene.plant.stops_rad = None;
    scene.start = Start { theta_rad, theta_dot_rad_s: 0.0 };
    scene.duration_s = duration_s;
    scene
}

/// The same on a spring K of damping ratio ζ for so many periods; with its (k, c).
fn spring(name: &str, k: f64, zeta: f64, periods: f64) -> (ModelScene, f64, f64) {
    let (square, c) = (k / INERTIA, 2.0 * zeta * (k / INERTIA).sqrt());
    let mut scene = lever(
        format!("{name}, K {k} N/rad, ζ {zeta}"),
        Input::constant(0.0),
        0.1,
        periods * TAU / square.sqrt(),
    );
    scene.environment = Environment::spring(k, c * INERTIA, 0.0);
    (scene, square, c)
}

pub(crate) fn all() -> Vec<Case> {
    let mut list = Vec::new();
    decaying(&mut list);
    creeping(&mut list);
    forced(&mut list);
    undamped(&mut list);
    growing(&mut list);
    stick_slip(&mut list);
    sticking(&mut list);
    slipping(&mut list);
    bouncing(&mut list);
    sampled(&mut list);
    pendulums(&mut list);
    lagging(&mut list);
    rule_at_rest(&mut list);
    list
}

fn decaying(list: &mut Vec<Case>) {
    const REASON: &str = "θ = θ₀ e^(−ζωt) cos ω_d t: each swing e^(−πζ/√(1−ζ²)) of the one before";
    let mut add = |k: f64, zeta: f64| {
        let (scene, square, c) = spring("damped spring", k, zeta, 40.0);
        list.push(case(scene, Transient, REASON).swinging(square, c, SHARES));
    };
    for zeta in [0.01, 0.020_011, 0.05, 0.1, 0.2, 0.35] {
        add(400.0, zeta); // ζ 0.020011 is B 0.0566 N s/rad
    }
    add(40.0, 0.02);
    add(40.0, 0.1);
}

fn creeping(list: &mut Vec<Case>) {
    for (zeta, longest, reason) in [
        (0.9, 2.0, "a swing is e^(−6.5) of the one before: three of them are above 1e-9 rad"),
        (1.0, 1.9, "a double real root: no turn"),
        (1.5, 2.0, "two real roots: no turn"),
        (2.0, 2.0, "two real roots: no turn"),
    ] {
        let (scene, square, c) = spring("damped spring", 400.0, zeta, 10.0);
        list.push(case(scene, Smooth, reason).swinging(square, c, [0.05, 0.3, 0.6, longest]));
    }
}

fn forced(list: &mut Vec<Case>) {
    const REASON: &str = "linear and damped: what is left has the input's period";
    for hz in [10.0, 20.0, 40.0, 60.0, 80.0] {
        let (mut scene, square, c) = spring("shaken spring", 400.0, 0.2, 40.0);
        scene.name = format!("{} at {hz} Hz", scene.name);
        scene.input = Input::Sine { magnitude: 1.0, omega_rad_s: TAU * hz };
        list.push(case(scene, Forced, REASON).swinging(square, c, SHARES));
    }
    for hz in [20.0, 40.0] {
        let (mut scene, _, c) = spring("spring with a shaken end", 300.0, 0.2, 40.0);
        scene.name = format!("{} at {hz} Hz", scene.name);
        let displacement = Input::Sine { magnitude: 0.01, omega_rad_s: TAU * hz };
        scene.terms.set(Pull { stiffness_n_per_rad: 100.0, displacement });
        list.push(case(scene, Forced, REASON).swinging(400.0 / INERTIA, c, SHARES));
    }
    let (mut scene, square, c) = spring("step after step", 400.0, 0.2, 40.0);
    scene.input = Input::Step { magnitude: 1.0, period_s: scene.duration_s };
    scene.start = Start::default();
    list.push(case(scene, Forced, REASON).swinging(square, c, SHARES));
}

fn undamped(list: &mut Vec<Case>) {
    const REASON: &str = "the force depends on θ alone: energy is kept";
    for k in [40.0, 400.0, 4000.0] {
        let (scene, square, c) = spring("spring", k, 0.0, 40.0);
        list.push(case(scene, FreeUndamped, REASON).swinging(square, c, SHARES));
    }
    let (mut scene, square, c) = spring("spring under a weight", 400.0, 0.0, 40.0);
    scene.input = Input::constant(5.0);
    list.push(case(scene, FreeUndamped, REASON).swinging(square, c, SHARES));
    let (mut scene, square, c) = spring("spring of a motor that saturates", 400.0, 0.0, 60.0);
    scene.motor.max_n = 10.0;
    list.push(case(scene, FreeUndamped, REASON).swinging(square, c, MILD));
    let mut scene = lever("two springs".to_owned(), Input::constant(0.0), 0.1, 1.0);
    let demand =
        |k| Demand::Spring { stiffness_n_per_rad: k, damping_ns_per_rad: 0.0, rest_rad: 0.0 };
    let zones = [400.0, 1600.0].map(|k| Zone { from_rad: 0.0, demand: demand(k) });
    scene.environment = Environment { name: "two springs".to_owned(), zones: zones.to_vec() };
    let squares = [400.0 / INERTIA, 1600.0 / INERTIA];
    list.push(
        case(scene, FreeUndamped, REASON)
            .swinging(squares[1], 0.0, MILD)
            .poles(&squares.map(|k| (k, 0.0))),
    );
}

/// A force −B θ̇ with B below 0: an amplifier.
#[derive(Debug, Serialize)]
struct Drive {
    per_rad_s_n: f64,
}

impl Term for Drive {
    fn name(&self) -> &'static str {
        "drive"
    }
    fn about(&self) -> &'static str {
        "force along the motion"
    }
    fn parameters(&self) -> Vec<Parameter> {
        vec![Parameter::any("per_rad_s_n", self.per_rad_s_n, 1.0)]
    }
    fn affine(&self, _: &Plant) -> Affine {
        Affine { per_rad_s_n: self.per_rad_s_n, ..Affine::default() }
    }
}

fn growing(list: &mut Vec<Case>) {
    const REASON: &str = "negative damping: θ₀ e^(+|ζ|ωt) cos ω_d t";
    for zeta in [-0.01, -0.03, -0.05] {
        let (mut scene, square, _) = spring("driven spring", 400.0, 0.0, 20.0);
        scene.name = format!("driven spring, ζ {zeta}");
        scene.terms.set(Drive { per_rad_s_n: -2.0 * zeta * square.sqrt() * INERTIA });
        let steps_s = [0.02, 0.05, 0.2, 1.0].map(|share| share / square.sqrt());
        list.push(case(scene, Growing, REASON).at(steps_s));
    }
}

fn stick_slip(list: &mut Vec<Case>) {
    const REASON: &str = "Rabinowicz: F_s > F_k, pulled slowly and undamped: it sticks until the spring \
                          holds F_s, and overshoots to 2 F_k − F_s each time";
    for (k, rate, static_n, kinetic_n) in [
        (4000.0, 0.02, 0.5, 0.2),
        (4000.0, 0.05, 1.0, 0.3),
        (1000.0, 0.05, 0.5, 0.2),
        (400.0, 0.05, 0.5, 0.1),
    ] {
        let name = format!("stick–slip, K {k} N/rad at {rate} rad/s, {static_n} and {kinetic_n} N");
        let mut scene = lever(name, Input::constant(0.0), 0.0, 2.0);
        scene.friction = Some(Friction { static_n, kinetic_n, viscous_ns_per_rad: 0.0 });
        let displacement = Input::Line { value: 0.0, rate };
        scene.terms.set(Pull { stiffness_n_per_rad: k, displacement });
        list.push(case(scene, LimitCycle, REASON).at([5e-5, 1e-4, 2e-4, 5e-4]));
    }
}

fn sticking(list: &mut Vec<Case>) {
    const HELD: &str = "between the motor's and the brake's force θ̇ = 0 is a sliding mode: forward, \
                        stick, backward, forward";
    let steps_s = [2e-4, 0.83e-3, 2e-3, 4e-3];
    for magnitude in [2.15, 2.3, 2.4] {
        let mut scene = table3::scene(DriveMode::Hybrid, Input::sine(magnitude));
        scene.name = format!("thesis, hybrid, sine of {magnitude} N");
        list.push(case(scene, Smooth, HELD).at(steps_s).chattering(&SWITCHING));
    }
    for magnitude in [1.0, 2.15] {
        let mut scene = table3::scene(DriveMode::Passive, Input::sine(magnitude));
        scene.name = format!("thesis, passive, sine of {magnitude} N");
        const REASON: &str = "a brake holds what it has stopped: forward, then rest";
        list.push(case(scene, Smooth, REASON).at(steps_s).chattering(&SWITCHING));
    }
    for push in [0.1, 0.3, 0.45] {
        let mut scene = lever(format!("{push} N against 0.5 N"), Input::constant(push), 0.0, 1.0);
        scene.friction = Some(Friction { static_n: 0.5, kinetic_n: 0.5, viscous_ns_per_rad: 0.0 });
        const REASON: &str = "a push within the friction cone moves nothing";
        // Per stage the lever creeps to one side where the four stages do not cancel.
        let (turns, mean) = per_stage_turns(push, 0.5, 200);
        let chatters: Vec<&str> =
            SWITCHING.into_iter().filter(|name| *name != "rk4_per_stage" || turns > 6).collect();
        let case = case(scene, Smooth, REASON).at([1e-4, 5e-4, 2e-3, 5e-3]).chattering(&chatters);
        let creeps = if mean.abs() > 1e-3 { vec!["rk4_per_stage"] } else { vec![] };
        list.push(Case { creeps, ..case });
    }
}

fn slipping(list: &mut Vec<Case>) {
    for push in [0.6, 1.0, 3.0] {
        let mut scene = lever(
            format!("{push} N against 0.2 N and 0.5 N s/rad"),
            Input::constant(push),
            0.0,
            0.5,
        );
        let viscous = 0.5;
        scene.friction =
            Some(Friction { static_n: 0.5, kinetic_n: 0.2, viscous_ns_per_rad: viscous });
        let c = viscous / INERTIA;
        const REASON: &str = "above F_s it leaves, and nears (F − F_k)/b from below: no turn";
        list.push(
            case(scene, Smooth, REASON)
                .at([0.05, 0.3, 1.0, 3.0].map(|share| share / c))
                .poles(&[(0.0, c)]),
        );
    }
}

fn bouncing(list: &mut Vec<Case>) {
    for push in [1.0, 2.0, 2.5] {
        let mut scene =
            lever(format!("{push} N against a wall of 3.25 N"), Input::constant(push), -0.05, 0.6);
        scene.environment = Environment::free().with_wall(0.0);
        scene.motor.max_n = 3.25;
        const REASON: &str = "parabolas on both sides of the edge: energy is kept";
        list.push(case(scene, FreeUndamped, REASON).at([1e-5, 2e-5, 5e-5, 1e-4]));
    }
    for k in [500.0, 2000.0] {
        let mut scene =
            lever(format!("1 N against a wall of {k} N/rad"), Input::constant(1.0), -0.02, 1.5);
        let (b, square) = (0.3, k / INERTIA);
        let zone = |k, b| Zone {
            from_rad: 0.0,
            demand: Demand::Spring { stiffness_n_per_rad: k, damping_ns_per_rad: b, rest_rad: 0.0 },
        };
        let zones = vec![zone(0.0, 0.0), zone(k, b)];
        scene.environment = Environment { name: "wall".to_owned(), zones };
        const REASON: &str = "each bounce loses in the wall's damper; in the end it swings within the wall \
                              and dies out";
        list.push(case(scene, Transient, REASON).swinging(
            square,
            b / INERTIA,
            [0.02, 0.1, 0.3, 1.0],
        ));
    }
}

/// Plant of the sampled walls: 0.0972 kg on a lever of 1 m with b = 2.6 N s/rad, T = 8.3 ms.
const SAMPLED: (f64, f64, f64) = (0.0972, 2.6, 8.3e-3);

/// ρ of x' = A x on (θ, θ before, θ̇, delayed commands), by 2^30 products scaled to size 1.
///
/// Over a tick θ̇' = e θ̇ + (1 − e) F/b and θ' = θ + T_1 θ̇ + (T − T_1) F/b with e = e^(−bT/M) and
/// T_1 = (1 − e) M/b.
fn sampled_radius(k: f64, b_virtual: f64, delay: usize) -> f64 {
    let (m, b, t) = SAMPLED;
    let e = (-b * t / m).exp();
    let t1 = (1.0 - e) * m / b;
    let n = 3 + delay;
    let command = |j: usize| match j {
        0 => -k - b_virtual / t,
        1 => b_virtual / t,
        _ => 0.0,
    };
    let force = |j: usize| if delay == 0 { command(j) } else { f64::from(u8::from(j == n - 1)) };
    let entry = |i: usize, j: usize| match (i, j) {
        (0, _) => {
            f64::from(u8::from(j == 0)) + if j == 2 { t1 } else { 0.0 } + (t - t1) / b * force(j)
        }
        (1, _) => f64::from(u8::from(j == 0)),
        (2, _) => (if j == 2 { e } else { 0.0 }) + (1.0 - e) / b * force(j),
        (3, _) => command(j),
        _ => f64::from(u8::from(j == i - 1)),
    };
    let mut a: Vec<Vec<f64>> = (0..n).map(|i| (0..n).map(|j| entry(i, j)).collect()).collect();
    let (mut log, mut power) = (0.0, 1.0);
    for _ in 0..30 {
        let product = |i: usize, j: usize| (0..n).map(|m| a[i][m] * a[m][j]).sum::<f64>();
        let next: Vec<Vec<f64>> = (0..n).map(|i| (0..n).map(|j| product(i, j)).collect()).collect();
        let size = next.iter().flatten().fold(0.0_f64, |s, x| s.max(x.abs()));
        power *= 2.0;
        log += size.ln() / power;
        a = next.iter().map(|row| row.iter().map(|x| x / size).collect()).collect();
    }
    log.exp()
}

fn sampled(list: &mut Vec<Case>) {
    const LINEAR: &str = "ρ of x' = A x on (θ, θ before, θ̇, delayed commands), in closed form: below 1 it \
                          dies out, above 1 it grows";
    const BOUNDED: &str = "ρ > 1, so that it cannot rest, and what the motor can give is bounded while \
                           friction is not: it stays";
    let (mass_kg, viscous, period_s) = SAMPLED;
    let mut add = |k: f64, b: f64, delay: usize, max_n: f64| {
        let delayed = ["", ", a tick late", ", two ticks late"][delay];
        let bounded = max_n < 1e3;
        let limit = if bounded { format!(", at most {max_n} N") } else { String::new() };
        let name = format!("wall of {k} N/rad and {b} N s/rad{delayed}{limit}");
        let mut scene = lever(name.clone(), Input::constant(0.0), 0.01, 4.0);
        scene.plant.mass_kg = mass_kg;
        scene.friction =
            Some(Friction { static_n: 0.0, kinetic_n: 0.0, viscous_ns_per_rad: viscous });
        let controller = Controller {
            period_s,
            stiffness_n_per_rad: k,
            damping_ns_per_rad: b,
            rest_rad: 0.0,
            one_sided: false,
            delay_ticks: delay,
            max_n,
        };
        let radius = sampled_radius(k, b, delay);
        let nature = match (radius > 1.0, bounded) {
            (true, true) => LimitCycle,
            (true, false) => Growing,
            (false, _) => Transient,
        };
        list.push(Case {
            name,
            model: Box::new(SampledLoop::new(scene, controller).unwrap()),
            nature,
            reason: if bounded { BOUNDED } else { LINEAR },
            steps_s: [1e-3, 2.7e-3, 4e-3, 8.3e-3],
            poles: vec![(0.0, viscous / mass_kg)],
            chatters: vec![],
            creeps: vec![],
            curved: false,
        });
    };
    const FREE: f64 = 1e12;
    for (k, b, delay) in [
        (300.0, 0.0, 0),
        (500.0, 0.0, 0),
        (600.0, 0.0, 0),
        (700.0, 0.0, 0),
        (800.0, 0.0, 0),
        (150.0, 0.0, 1),
        (200.0, 0.0, 1),
        (250.0, 0.0, 1),
        (900.0, 2.0, 0),
        (1050.0, 2.0, 0),
        (300.0, 2.0, 1),
        (350.0, 2.0, 1),
    ] {
        add(k, b, delay, FREE);
    }
    add(800.0, 0.0, 0, 5.0);
    add(300.0, 0.0, 1, 5.0);
}

/// A hanging lever with ω = 20 rad/s, turned away by some angle.
fn pendulum(name: &str, turned_rad: f64, periods: f64) -> ModelScene {
    let mut scene =
        lever(name.to_owned(), Input::constant(0.0), PI + turned_rad, periods * TAU / 20.0);
    let radius_m = 400.0 * INERTIA / (2.0 * 9.806_65);
    scene.terms.set(Gravity { mass_kg: 2.0, radius_m });
    scene
}

/// Van der Pol: F = μ (1 − θ²/a²) θ̇.
#[derive(Debug, Serialize)]
struct VanDerPol {
    mu: f64,
    a_rad: f64,
}

impl Term for VanDerPol {
    fn name(&self) -> &'static str {
        "van_der_pol"
    }
    fn about(&self) -> &'static str {
        "force of the tube"
    }
    fn parameters(&self) -> Vec<Parameter> {
        vec![Parameter::any("mu", self.mu, 1.0)]
    }
    fn curve(&self, _: &Plant, theta: f64, omega: f64) -> Option<Curve> {
        let share = theta / self.a_rad;
        Some(Curve {
            force_n: self.mu * (1.0 - share * share) * omega,
            per_rad_n: -2.0 * self.mu * share / self.a_rad * omega,
            per_rad_s_n: self.mu * (1.0 - share * share),
        })
    }
}

fn pendulums(list: &mut Vec<Case>) {
    const KEPT: &str = "weight alone: energy is kept";
    for turned in [0.01, 0.5, 2.0] {
        let scene = pendulum(&format!("pendulum from {turned} rad"), turned, 30.0);
        list.push(case(scene, FreeUndamped, KEPT).swinging(400.0, 0.0, SHARES));
    }
    let mut scene = pendulum("damped pendulum", 0.5, 30.0);
    let c = 2.0;
    scene.friction =
        Some(Friction { static_n: 0.0, kinetic_n: 0.0, viscous_ns_per_rad: c * INERTIA });
    const LOST: &str = "viscous damping takes energy at every swing";
    list.push(case(scene, Transient, LOST).swinging(400.0, c, SHARES));
    let (mut scene, square, _) = spring("van der Pol", 400.0, 0.0, 40.0);
    scene.name = "van der Pol, μ/(M L ω) 0.1".to_owned();
    let a_rad = 0.05;
    scene.start.theta_rad = 2.0 * a_rad;
    scene.terms.set(VanDerPol { mu: 0.1 * square.sqrt() * INERTIA, a_rad });
    const KEPT_UP: &str = "averaging: the amplitude 2a is a stable cycle";
    let steps_s = [0.02, 0.05, 0.2, 0.5].map(|share| share / square.sqrt());
    list.push(case(scene, LimitCycle, KEPT_UP).at(steps_s));
}

fn lagging(list: &mut Vec<Case>) {
    const REASON: &str =
        "Routh on M L τ s³ + (M L + b τ) s² + b s + K: stable where b (M L + b τ) > M L τ K";
    for (lag_s, b) in [(1e-3, 0.3), (1e-3, 0.5), (2e-3, 0.5), (2e-3, 0.8)] {
        let k = 400.0;
        let name = format!("motor {lag_s} s late, K {k} N/rad, b {b} N s/rad");
        let mut scene = lever(name, Input::constant(0.0), 0.01, 0.4);
        scene.environment = Environment::spring(k, 0.0, 0.0);
        scene.motor.lag_s = Some(lag_s);
        scene.friction = Some(Friction { static_n: 0.0, kinetic_n: 0.0, viscous_ns_per_rad: b });
        let stable = b * (INERTIA + b * lag_s) > INERTIA * lag_s * k;
        let nature = if stable { Transient } else { Growing };
        list.push(case(scene, nature, REASON).at([1e-5, 2e-5, 5e-5, 1e-4]));
    }
}

fn rule_at_rest(list: &mut Vec<Case>) {
    const REASON: &str =
        "at rest the brake either lets go, and the motor is too weak to hold, or it holds";
    for lags in [[0.015, 0.010], [0.03, 0.02], [0.008, 0.006]] {
        let mut scene = table3::scene(DriveMode::Hybrid, Input::sine(2.15));
        scene.brake.lag_on_off_s = Some(lags);
        scene.name = format!("thesis, hybrid, brake {lags:?} s late");
        list.push(case(scene, DependsOnRestRule, REASON).at([2e-4, 5e-4, 1e-3, 2e-3]));
    }
}
