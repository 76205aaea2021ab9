//! A lever that is upright at θ = 0 and turns about the origin, and what surrounds it.

use super::pieces::{amid, arrow, disc, line, over, right_of};
use super::way::{Point, Way, polar};
use crate::words::Words;
use zwidth_draw::Layer;
use zwidth_draw::style::{self, Dash, Stroke};

/// Length of a lever that has a figure for itself, mm.
pub(crate) const UPRIGHT_MM: f64 = 30.0;
// Distances from the axis, in lengths of the lever.
/// The arc of the work space: just beyond the lever's tip.
const ARC: f64 = 1.12;
/// The numbers at the arc.
const NUMBERS: f64 = 1.22;
/// The lever is drawn at this share of its work space: the spring is seen at length, and a wall
/// ahead.
const LEVER_AT: f64 = 0.33;

/// A lever; distances from its axis are in its lengths.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Lever {
    /// Length on paper, mm.
    pub(crate) length_mm: f64,
    /// Where it stands, rad.
    pub(crate) theta_rad: f64,
}

impl Lever {
    /// A lever somewhere in its work space.
    pub(crate) fn between(length_mm: f64, low_rad: f64, high_rad: f64) -> Self {
        Self { length_mm, theta_rad: low_rad + LEVER_AT * (high_rad - low_rad) }
    }

    /// The point at that distance from its axis, in a direction from upright.
    pub(crate) fn at(&self, distance: f64, theta_rad: f64) -> Point {
        polar((0.0, 0.0), distance * self.length_mm, theta_rad)
    }

    /// Its end.
    pub(crate) fn tip(&self) -> Point {
        self.at(1.0, self.theta_rad)
    }

    /// Along the circle at that distance.
    pub(crate) fn arc(&self, distance: f64, from_rad: f64, to_rad: f64) -> Way {
        Way::arc((0.0, 0.0), distance * self.length_mm, from_rad, to_rad)
    }

    /// Straight outwards, between two distances.
    pub(crate) fn ray(&self, (from, to): (f64, f64), theta_rad: f64) -> Way {
        Way::through([self.at(from, theta_rad), self.at(to, theta_rad)])
    }

    /// The arc between the stops, with numbers at its ends and upright.
    pub(crate) fn work_space(&self, words: Words, low: f64, high: f64) -> Vec<Layer> {
        let thin = style::single(style::GREY);
        let mut layers = vec![line(self.arc(ARC, low, high).points(), thin)];
        let upright = (low < 0.0 && high > 0.0).then_some(0.0);
        for theta in [low, high].into_iter().chain(upright) {
            let tick = self.ray((ARC - 0.03, ARC + 0.03), theta);
            layers.push(line(tick.points(), thin));
            layers.push(amid(vec![words.signed_place(theta)], self.at(NUMBERS, theta)));
        }
        let ray = upright.map(|theta| self.ray((0.0, ARC), theta));
        layers.extend(ray.map(|ray| line(ray.points(), style::reference())));
        layers
    }

    /// The lever itself, on its axis.
    pub(crate) fn bar(&self) -> Vec<Layer> {
        let bar = Stroke { width_pt: 3.2, ..style::mean(style::INK) };
        let axis = [disc((0.0, 0.0), 9.0, style::INK), disc((0.0, 0.0), 4.0, style::PAPER)];
        [line([(0.0, 0.0), self.tip()], bar)].into_iter().chain(axis).collect()
    }

    /// Where it stands when the spring rests.
    pub(crate) fn rest(&self, rest_rad: f64) -> Vec<Layer> {
        /// How far the word stands beside the line, mm.
        const BESIDE_MM: f64 = 5.4;
        let ray = self.ray((0.0, 1.0), rest_rad);
        let pen = style::reference().dashed(Dash::Dotted);
        let words = over("rest", self.at(0.66, rest_rad - BESIDE_MM / (0.66 * self.length_mm)));
        vec![line(ray.points(), pen), words]
    }

    /// The angle from upright, at that distance; nothing where it is too small to be drawn.
    pub(crate) fn angle(&self, distance: f64) -> Vec<Layer> {
        /// Distance of the arrow's tip from the lever, rad, and the smallest angle drawn.
        const OFF_RAD: f64 = 0.05;
        let to = self.theta_rad;
        if to.abs() <= OFF_RAD {
            return Vec::new();
        }
        let way = self.arc(distance, 0.0, to - OFF_RAD * to.signum());
        let mut layers = arrow(&way, style::single(style::GREY));
        layers.push(over("*θ*", self.at(distance + 0.02, to / 2.0)));
        layers
    }

    /// The device's torque, which resists, at that distance.
    pub(crate) fn torque(&self, distance: f64) -> Vec<Layer> {
        let way = self.arc(distance, self.theta_rad + 1.1, self.theta_rad - 1.1);
        let mut layers = arrow(&way, style::mean(style::MOTOR));
        let place = self.at(distance, self.theta_rad + 1.25);
        layers.push(right_of(vec!["*T*_{O}".to_owned()], place));
        layers
    }

    /// The user's push at its end.
    pub(crate) fn push(&self) -> Vec<Layer> {
        /// How far the words stand below the arrow, mm.
        const UNDER_MM: f64 = 3.0;
        let way = self.arc(0.93, self.theta_rad - 0.42, self.theta_rad - 0.04);
        let mut layers = arrow(&way, style::mean(style::INK));
        let below = 0.93 - UNDER_MM / self.length_mm;
        layers.push(amid(vec!["*F*_{ex}".to_owned()], self.at(below, self.theta_rad - 0.36)));
        layers
    }
}
