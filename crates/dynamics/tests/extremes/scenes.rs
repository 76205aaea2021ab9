//! Random and adversarial scenes: a number draws each, the same on any machine.

use zwidth_dynamics::{
    BrakeLaw, DriveMode, Environment, FingerLaw, Friction, Gravity, Input, ModelScene, Pull,
    Series, table3,
};

/// How far from usual a scene's numbers are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Kind {
    /// Within a factor of ten.
    Near,
    /// Within nine powers of ten either way.
    Far,
    /// Far, and rounded to single precision.
    Single,
    /// Near, but one number is what no equation likes.
    Hostile,
    /// All numbers tiny, down to denormals.
    Tiny,
    /// All numbers huge.
    Huge,
}

impl Kind {
    /// Every kind.
    pub(crate) const ALL: [Self; 6] =
        [Self::Near, Self::Far, Self::Single, Self::Hostile, Self::Tiny, Self::Huge];

    /// Its words in tables.
    pub(crate) fn as_str(self) -> &'static str {
        match self {
            Self::Near => "within a factor of ten",
            Self::Far => "1e-9 … 1e9 of usual",
            Self::Single => "the same, rounded to `f32`",
            Self::Hostile => "one hostile number",
            Self::Tiny => "tiny, denormals too",
            Self::Huge => "huge",
        }
    }
}

/// Numbers that equations do not like.
const HOSTILE: [f64; 14] = [
    0.0,
    -0.0,
    -1.0,
    f64::NAN,
    f64::INFINITY,
    f64::NEG_INFINITY,
    f64::MIN_POSITIVE,
    5e-324,
    f64::MAX,
    f64::MIN,
    1e-30,
    1e30,
    1e-300,
    1e300,
];

/// SplitMix64 (Steele, Lea & Flood 2014).
pub(crate) struct Draw(u64);

impl Draw {
    /// The stream of a scene.
    pub(crate) fn of(seed: u64, number: u64) -> Self {
        let mut draw = Self(seed ^ number.wrapping_mul(0xd134_2543_de82_ef95));
        draw.bits();
        draw
    }

    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Uniform from 0 to below 1.
    fn share(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// One of so many.
    pub(crate) fn below(&mut self, count: usize) -> usize {
        (self.bits() % count as u64) as usize
    }

    fn coin(&mut self) -> bool {
        self.bits() & 1 == 1
    }

    /// 10^x for x uniform between two exponents.
    fn power(&mut self, low: f64, high: f64) -> f64 {
        libm::pow(10.0, low + (high - low) * self.share())
    }

    /// A number of a kind that is usually of this size.
    fn number(&mut self, kind: Kind, usual: f64) -> f64 {
        match kind {
            Kind::Near | Kind::Hostile => usual * self.power(-1.0, 1.0),
            Kind::Far => usual * self.power(-9.0, 9.0),
            Kind::Single => f64::from((usual * self.power(-9.0, 9.0)) as f32),
            Kind::Tiny => usual * self.power(-323.0, -9.0),
            Kind::Huge => usual * self.power(9.0, 307.0),
        }
    }
}

/// Scene `number` of a seed, and its kind.
pub(crate) fn scene(seed: u64, number: u64) -> (Kind, ModelScene) {
    let mut draw = Draw::of(seed, number);
    let kind = Kind::ALL[draw.below(Kind::ALL.len())];
    let mode = [DriveMode::Active, DriveMode::Passive, DriveMode::Hybrid][draw.below(3)];
    let input = input(&mut draw, kind);
    let mut scene = table3::scene(mode, input);
    scene.brake.law = if draw.below(4) == 0 { BrakeLaw::Thesis } else { BrakeLaw::Coulomb };
    scene.plant.lever_m = 0.045;
    parts(&mut draw, &mut scene);
    let hostile = draw.below(HOSTILE.len());
    let mut places = places(&mut scene);
    let one = draw.below(places.len());
    for (i, place) in places.iter_mut().enumerate() {
        let mixes = matches!(kind, Kind::Tiny | Kind::Huge) && draw.coin();
        // Of a tiny or huge scene every other number is usual: else it is refused at its first.
        **place = if mixes { **place } else { draw.number(kind, **place) };
        if kind == Kind::Hostile && i == one {
            **place = HOSTILE[hostile];
        }
    }
    (kind, scene)
}

fn input(draw: &mut Draw, kind: Kind) -> Input {
    let magnitude = draw.number(kind, 2.0);
    match draw.below(5) {
        0 => Input::Step { magnitude, period_s: draw.number(kind, 0.2) },
        1 => Input::Ramp { magnitude, period_s: draw.number(kind, 0.2) },
        2 => Input::Sine { magnitude, omega_rad_s: draw.number(kind, 20.0) },
        3 => Input::constant(magnitude),
        _ => {
            let mut t = 0.0;
            let mut series = Series { t_s: vec![0.0], value: vec![magnitude] };
            for _ in 0..1 + draw.below(12) {
                t += draw.number(kind, 0.03);
                series.t_s.push(t);
                series.value.push(draw.number(kind, 2.0));
            }
            Input::Series(series)
        }
    }
}

/// Each part of a model, there or not.
fn parts(draw: &mut Draw, scene: &mut ModelScene) {
    let spring = Environment::spring(4.0, 0.5, -table3::HALF_STROKE_RAD);
    scene.environment = if draw.coin() { spring.with_wall(0.3) } else { spring };
    if draw.coin() {
        let law = if draw.coin() { FingerLaw::Consistent } else { FingerLaw::Thesis };
        scene.finger = Some(table3::finger(law));
    }
    if draw.coin() {
        scene.friction =
            Some(Friction { static_n: 0.2, kinetic_n: 0.15, viscous_ns_per_rad: 0.02 });
    }
    scene.motor.lag_s = draw.coin().then_some(0.002);
    scene.brake.lag_on_off_s = draw.coin().then_some([0.015, 0.01]);
    scene.brake.let_go_n = draw.coin().then_some(1.0);
    if draw.below(8) == 0 {
        scene.terms.set(Gravity { mass_kg: 0.02, radius_m: 0.04 });
    }
    if draw.below(8) == 0 {
        let displacement = Input::Line { value: 0.0, rate: 0.3 };
        scene.terms.set(Pull { stiffness_n_per_rad: 1.0, displacement });
    }
    if draw.coin() {
        scene.plant.stops_rad = None;
    }
    scene.start.theta_dot_rad_s = if draw.coin() { 1.0 } else { 0.0 };
}

/// The numbers that are drawn; a friction at rest below that in motion is a scene of its own kind.
fn places(scene: &mut ModelScene) -> Vec<&mut f64> {
    let mut places = vec![
        &mut scene.plant.mass_kg,
        &mut scene.plant.lever_m,
        &mut scene.motor.max_n,
        &mut scene.brake.max_n,
        &mut scene.brake.dead_zone_n,
        &mut scene.start.theta_dot_rad_s,
    ];
    if let Some(finger) = &mut scene.finger {
        places.push(&mut finger.mass_kg);
        places.push(&mut finger.stiffness_n_per_m);
        places.push(&mut finger.damping_ns_per_m);
        places.extend(finger.length_m.as_mut());
    }
    if let Some(friction) = &mut scene.friction {
        places.push(&mut friction.static_n);
        places.push(&mut friction.viscous_ns_per_rad);
    }
    places.extend(scene.motor.lag_s.as_mut());
    places.extend(scene.brake.lag_on_off_s.iter_mut().flatten());
    places.extend(scene.brake.let_go_n.as_mut());
    places
}
