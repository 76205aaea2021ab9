//! What an environment may render: the one list of kinds.

use crate::words::words;
use serde::Serialize;

/// A virtual spring: resisting force `K (θ − θ_rest)` (thesis (8), with a rest angle).
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Spring {
    /// Stiffness K at the lever, N/rad.
    pub stiffness_n_per_rad: f64,
    /// Angle without force, rad.
    pub rest_rad: f64,
}

/// What an environment renders.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Scene {
    /// Nothing is rendered by a device (a questionnaire about something else).
    None,
    /// Free motion.
    Free,
    /// A spring.
    Spring(Spring),
    /// Free motion, and from `wall_rad` on a wall.
    Wall {
        /// Where the wall begins, rad.
        wall_rad: f64,
    },
    /// A spring, and from `wall_rad` on a wall.
    SpringWall {
        /// The spring.
        spring: Spring,
        /// Where the wall begins, rad.
        wall_rad: f64,
    },
    /// The same force everywhere.
    Force {
        /// Resisting force, N: above 0 it pushes towards −θ.
        force_n: f64,
    },
}

words! {
    /// A kind of scene, as `study.toml` names it; the one without a scene first.
    SceneKind {
        /// [`Scene::None`].
        None = "none",
        /// [`Scene::Free`].
        Free = "free",
        /// [`Scene::Spring`].
        Spring = "spring",
        /// [`Scene::Wall`].
        Wall = "wall",
        /// [`Scene::SpringWall`].
        SpringWall = "spring_wall",
        /// [`Scene::Force`].
        Force = "force",
    }
}

/// What an environment takes: a number of `study.toml`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum SceneNumber {
    /// Stiffness K at the lever, N/rad.
    Stiffness,
    /// Angle without force, rad.
    Rest,
    /// Where the wall begins, rad.
    Wall,
    /// A constant resisting force, N.
    Force,
    /// By how much the rendering is late, s. It is the environment's and no scene's: what is rendered is the same.
    Delay,
}

/// The force that a scene asks for, `F + K (θ − θ_rest) + B θ̇` (thesis (8), with a constant F), up to its wall,
/// where there is one; from there on it asks for all that the mode's actuators have.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ForceLaw {
    /// F, N.
    pub constant_n: f64,
    /// K, N/rad.
    pub stiffness_n_per_rad: f64,
    /// B, N s/rad.
    pub damping_ns_per_rad: f64,
    /// θ_rest, rad.
    pub rest_rad: f64,
    /// Where the wall begins, rad.
    pub wall_rad: Option<f64>,
}

impl ForceLaw {
    /// No force anywhere.
    const FREE: Self = Self {
        constant_n: 0.0,
        stiffness_n_per_rad: 0.0,
        damping_ns_per_rad: 0.0,
        rest_rad: 0.0,
        wall_rad: None,
    };

    fn spring(spring: Spring) -> Self {
        let Spring { stiffness_n_per_rad, rest_rad } = spring;
        Self { stiffness_n_per_rad, rest_rad, ..Self::FREE }
    }

    /// The resisting force short of the wall, N: above 0 it pushes towards −θ.
    pub fn force_n(&self, theta_rad: f64, theta_dot_rad_s: f64) -> f64 {
        let mut force_n = self.stiffness_n_per_rad * (theta_rad - self.rest_rad);
        // Added only where there is one: 0 added to −0 is another number.
        if self.constant_n != 0.0 {
            force_n += self.constant_n;
        }
        // Without damping no velocity counts, not even one that is no number.
        if self.damping_ns_per_rad != 0.0 {
            force_n += self.damping_ns_per_rad * theta_dot_rad_s;
        }
        force_n
    }

    /// Whether an angle is past the wall.
    pub fn is_past_wall(&self, theta_rad: f64) -> bool {
        self.wall_rad.is_some_and(|wall_rad| theta_rad >= wall_rad)
    }
}

impl SceneKind {
    /// Whether something is there to move against: a movement has a course then, which repeats share.
    fn pushes_back(self) -> bool {
        !matches!(self, Self::None | Self::Free)
    }

    /// Whether an environment of that kind takes a number: one of its scene, or, where there is something to be late,
    /// a delay.
    pub(crate) fn takes(self, number: SceneNumber) -> bool {
        self.quantities().contains(&number) || (number == SceneNumber::Delay && self.pushes_back())
    }

    /// The numbers that its scene is made of.
    pub(crate) fn quantities(self) -> &'static [SceneNumber] {
        match self {
            Self::None | Self::Free => &[],
            Self::Spring => &[SceneNumber::Stiffness, SceneNumber::Rest],
            Self::Wall => &[SceneNumber::Wall],
            Self::SpringWall => &[SceneNumber::Stiffness, SceneNumber::Rest, SceneNumber::Wall],
            Self::Force => &[SceneNumber::Force],
        }
    }

    /// The scene of that kind with these numbers, in SI units.
    pub(crate) fn scene(self, value: impl Fn(SceneNumber) -> f64) -> Scene {
        let spring = || Spring {
            stiffness_n_per_rad: value(SceneNumber::Stiffness),
            rest_rad: value(SceneNumber::Rest),
        };
        match self {
            Self::None => Scene::None,
            Self::Free => Scene::Free,
            Self::Spring => Scene::Spring(spring()),
            Self::Wall => Scene::Wall { wall_rad: value(SceneNumber::Wall) },
            Self::SpringWall => {
                Scene::SpringWall { spring: spring(), wall_rad: value(SceneNumber::Wall) }
            }
            Self::Force => Scene::Force { force_n: value(SceneNumber::Force) },
        }
    }
}

impl Scene {
    /// Its kind.
    pub fn kind(&self) -> SceneKind {
        match self {
            Self::None => SceneKind::None,
            Self::Free => SceneKind::Free,
            Self::Spring(_) => SceneKind::Spring,
            Self::Wall { .. } => SceneKind::Wall,
            Self::SpringWall { .. } => SceneKind::SpringWall,
            Self::Force { .. } => SceneKind::Force,
        }
    }

    /// Whether something is there to move against: a movement has a course then, which repeats share.
    pub fn pushes_back(&self) -> bool {
        self.kind().pushes_back()
    }

    /// The force it asks for; `None` if nothing is rendered.
    pub fn law(&self) -> Option<ForceLaw> {
        match *self {
            Self::None => None,
            Self::Free => Some(ForceLaw::FREE),
            Self::Spring(spring) => Some(ForceLaw::spring(spring)),
            Self::Wall { wall_rad } => {
                Some(ForceLaw { wall_rad: Some(wall_rad), ..ForceLaw::FREE })
            }
            Self::SpringWall { spring, wall_rad } => {
                Some(ForceLaw { wall_rad: Some(wall_rad), ..ForceLaw::spring(spring) })
            }
            Self::Force { force_n } => Some(ForceLaw { constant_n: force_n, ..ForceLaw::FREE }),
        }
    }

    /// The scene's spring, if it has one.
    pub fn spring(&self) -> Option<Spring> {
        match *self {
            Self::Spring(spring) | Self::SpringWall { spring, .. } => Some(spring),
            _ => None,
        }
    }

    /// The scene's constant resisting force, N, if that is what it renders.
    pub fn constant_n(&self) -> Option<f64> {
        match *self {
            Self::Force { force_n } => Some(force_n),
            _ => None,
        }
    }

    /// Where the scene's wall begins, rad.
    pub fn wall_rad(&self) -> Option<f64> {
        self.law()?.wall_rad
    }

    /// One of its numbers, in SI units; `None` if it does not take it.
    pub(crate) fn value(&self, quantity: SceneNumber) -> Option<f64> {
        let law = self.law().filter(|_| self.kind().quantities().contains(&quantity))?;
        match quantity {
            SceneNumber::Stiffness => Some(law.stiffness_n_per_rad),
            SceneNumber::Rest => Some(law.rest_rad),
            SceneNumber::Wall => law.wall_rad,
            SceneNumber::Force => Some(law.constant_n),
            SceneNumber::Delay => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A scene of each kind, whose numbers are all different.
    fn scenes() -> impl Iterator<Item = Scene> {
        SceneKind::ALL.into_iter().map(|kind| kind.scene(|q| 2.0 + f64::from(q as u8)))
    }

    #[test]
    fn a_scene_made_of_its_kind_and_its_numbers_is_the_same_scene() {
        for scene in scenes() {
            let again = scene.kind().scene(|q| scene.value(q).unwrap());
            assert_eq!(again, scene);
        }
    }

    #[test]
    fn a_scene_without_numbers_asks_for_no_force_and_one_with_them_for_some() {
        for scene in scenes() {
            let Some(law) = scene.law() else { continue };
            let asks = law.force_n(5.0, 7.0) != 0.0 || law.wall_rad.is_some();
            assert_eq!(asks, !scene.kind().quantities().is_empty(), "{scene:?}");
        }
    }

    #[test]
    fn a_spring_pulls_back_to_its_rest_and_damping_against_the_velocity() {
        let law = ForceLaw { stiffness_n_per_rad: 4.0, damping_ns_per_rad: 0.5, ..ForceLaw::FREE };
        assert!((law.force_n(0.5, 0.2) - 2.1).abs() < 1e-15);
        let spring = ForceLaw { damping_ns_per_rad: 0.0, ..law };
        assert!((spring.force_n(0.5, f64::NAN) - 2.0).abs() < 1e-15);
    }

    #[test]
    fn a_constant_force_is_the_same_everywhere_and_adds_to_a_springs() {
        let law = Scene::Force { force_n: -1.5 }.law().unwrap();
        for (theta_rad, theta_dot_rad_s) in [(0.5, 3.0), (-0.7, f64::NAN)] {
            assert!((law.force_n(theta_rad, theta_dot_rad_s) + 1.5).abs() < 1e-15);
        }
        let both = ForceLaw { stiffness_n_per_rad: 4.0, ..law };
        assert!((both.force_n(0.5, 0.0) - 0.5).abs() < 1e-15);
        // As a spring's always was: the sign of nothing is not lost.
        let spring = ForceLaw { stiffness_n_per_rad: 4.0, ..ForceLaw::FREE };
        assert!(spring.force_n(-0.0, 0.0).is_sign_negative());
    }

    #[test]
    fn what_pushes_back_can_be_late_and_nothing_else() {
        let late = SceneKind::ALL.into_iter().filter(|kind| kind.takes(SceneNumber::Delay));
        let words: Vec<&str> = late.map(SceneKind::as_str).collect();
        assert_eq!(words, ["spring", "wall", "spring_wall", "force"]);
    }
}
