//! Energy observers: does the device give more energy than it received, at a wall or over a closed
//! loop?

use crate::MetricsError;
use crate::compliance::range;
use crate::resolution::resolution_rad;
use crate::signals::Signals;
use crate::wall::{Contact, REBOUND_SHARE, contacts};
use zwidth_numerics::local::Derivator;
use zwidth_numerics::zigzag::{Leg, zigzag};

/// θ̇ and θ̈ are those of a parabola through the angles of this time to either side, s: long
/// against the counts of the angle sensor, short against the movement of a hand.
pub(crate) const HALF_S: f64 = 0.025;

/// This share of the work exchanged may be a sensor's scale and the straight lines between samples.
const WORK_SHARE: f64 = 0.01;
/// And this share of the lever's energy of motion the error of its speed: a parabola through 50 ms
/// of angles where the lever meets something.
const MOTION_SHARE: f64 = 0.1;

/// As fast as before: to this share of the square.
const SAME_SPEED: f64 = 0.05;

/// Energy observers (Hannaford & Ryu 2002, IEEE Trans. Robot. Autom. 18:1, between the user and the
/// whole device): the user's work ∫F dx, x = L θ, plus what the lever brought in by its speed less
/// what it takes out, ½ M L² (θ̇_from² − θ̇²), M the plant's mass. A passive device never has less
/// than 0 of it, where nothing but the lever stores energy at the beginning that it has not at the
/// end.
///
/// θ̇_from is the speed at the beginning, of a contact the largest within 25 ms before it: where a
/// lever is stopped at once, a parabola has half of its speed. At the end of a contact it is that
/// between the two samples there: a spring that goes on pushing outside is not the wall.
///
/// * A **contact** with the wall lasts from passing θ_wall to the last return before a retreat of
///   more than 1 % of the angles travelled, or to an end of the recording. The lowest value of the
///   observer from its first sample on counts: the spring under the wall and the wall itself push
///   out, so that what they store is more than at the beginning.
/// * A **closed loop** begins at a turn of θ (by more than 1 % of the angles travelled; the first
///   sample counts as one) and ends where θ is first back at that angle; where the recording does
///   not come back to its first angle, it is closed backwards from its end. Springs and walls
///   have at its end what they had at its beginning.
///
/// One is **active** below −(1 % of ∫|F dx| + L δ (F_max − F_min) + 10 % of ½ M L² θ̇_from²), δ the
/// smallest step between recorded angles. Without a known mass the observer has a value only where
/// the lever is as fast as at the beginning (to 5 % of the square) or faster: less speed could
/// explain any energy given. All null without angle, force or lever length.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct EnergyObserver {
    /// Contacts with the wall; null without a wall.
    pub wall_contacts: Option<i64>,
    /// Of them those that are active.
    pub wall_contacts_active: Option<i64>,
    /// Lowest value of the observer over all contacts, J; below 0 the wall has given. Null without
    /// one.
    pub wall_contact_energy_min_j: Option<f64>,
    /// Closed loops of the recording.
    pub closed_loops: Option<i64>,
    /// Of them those that are active.
    pub closed_loops_active: Option<i64>,
    /// Lowest value of the observer over all loops, J; below 0 the device has given. Null without
    /// one.
    pub closed_loop_energy_min_j: Option<f64>,
}

pub(crate) fn energy_observer(
    signals: &Signals,
    wall_rad: Option<f64>,
    mass_kg: Option<f64>,
) -> Result<EnergyObserver, MetricsError> {
    let (Some(theta), Some(lever_m)) = (signals.theta(), signals.lever_m) else {
        return Ok(EnergyObserver::default());
    };
    // How fast the lever is, by time and angle, before the work, by angle and force.
    let t = signals.t()?;
    let derivator = Derivator::new(&t, &theta, HALF_S);
    let mut motion = Motion { t: &t, theta: &theta, derivator };
    let at_wall: Option<Vec<Exchange>> = wall_rad
        .map(|wall| contacts(&theta, wall).iter().map(|c| motion.contact(c, wall)).collect());
    let closed = loops(&theta, REBOUND_SHARE * range(&theta));
    let closed: Vec<Exchange> = closed.iter().map(|closed| motion.closed_loop(closed)).collect();
    // No more than three columns at a time (`signals`).
    drop(t);
    let count_m = lever_m * resolution_rad(&theta);
    let Some(force) = signals.force() else { return Ok(EnergyObserver::default()) };
    let work = Work { theta: &theta, force: &force, lever_m, mass_kg, count_m };
    let at_wall = at_wall.map(|contacts| tally(&contacts, &work));
    let closed = tally(&closed, &work);
    Ok(EnergyObserver {
        wall_contacts: at_wall.map(|tally| tally.all),
        wall_contacts_active: at_wall.map(|tally| tally.active),
        wall_contact_energy_min_j: at_wall.and_then(|tally| tally.least_j),
        closed_loops: Some(closed.all),
        closed_loops_active: Some(closed.active),
        closed_loop_energy_min_j: closed.least_j,
    })
}

/// An observer's lowest value, and down to where it counts as nothing, J.
struct Observed {
    least_j: f64,
    bound_j: f64,
}

/// All contacts, or all loops, together.
#[derive(Debug, Clone, Copy)]
struct Tally {
    all: i64,
    active: i64,
    least_j: Option<f64>,
}

fn tally(exchanges: &[Exchange], work: &Work) -> Tally {
    let observed: Vec<Observed> =
        exchanges.iter().filter_map(|exchange| work.observed(exchange)).collect();
    Tally {
        all: exchanges.len() as i64,
        active: observed.iter().map(|o| i64::from(o.least_j < -o.bound_j)).sum(),
        least_j: observed.iter().map(|o| o.least_j).reduce(f64::min),
    }
}

/// A place on the path: so far after a sample, as a share of the way to the next.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Place {
    i: usize,
    share: f64,
}

impl Place {
    fn sample(i: usize) -> Self {
        Self { i, share: 0.0 }
    }

    /// The value of a signal there, with straight lines between its samples.
    fn value(self, values: &[f64]) -> f64 {
        let next = values[(self.i + 1).min(values.len() - 1)];
        values[self.i] + self.share * (next - values[self.i])
    }
}

/// A place on the path, and how fast the lever is there.
#[derive(Debug, Clone, Copy)]
struct Passed {
    at: Place,
    speed_rad_s: f64,
}

/// A contact or a closed loop: where it begins, and where the observer is looked at.
struct Exchange {
    from: Passed,
    /// The speed at each sample from this one on: of a contact all of its samples.
    samples: (usize, Vec<f64>),
    /// After them: of a contact where it is left, of a loop where it is closed.
    to: Option<Passed>,
    /// The sample up to which energy is exchanged.
    last: usize,
}

/// The lever's angle over time.
struct Motion<'a> {
    t: &'a [f64],
    theta: &'a [f64],
    derivator: Derivator<'a>,
}

impl Motion<'_> {
    fn speed_rad_s(&mut self, i: usize) -> f64 {
        self.derivator.at(i).0
    }

    /// A place that is passed at the speed there.
    fn passed(&mut self, at: Place) -> Passed {
        let here = self.speed_rad_s(at.i);
        let next = self.speed_rad_s((at.i + 1).min(self.t.len() - 1));
        Passed { at, speed_rad_s: here + at.share * (next - here) }
    }

    fn contact(&mut self, contact: &Contact, wall: f64) -> Exchange {
        let last = self.theta.len() - 1;
        let from = match contact.first.checked_sub(1) {
            Some(before) => crossing(self.theta, before, wall),
            None => Place::sample(0),
        };
        let began_s = from.value(self.t);
        let end = contact.last;
        let t = self.t;
        let before = (0..=from.i).rev().take_while(|i| t[*i] >= began_s - HALF_S);
        let fastest = before.map(|i| self.speed_rad_s(i).abs()).fold(0.0, f64::max);
        let left = (end < last).then(|| {
            let at = crossing(self.theta, end, wall);
            let way = self.theta[end + 1] - self.theta[end];
            Passed { at, speed_rad_s: way.abs() / (self.t[end + 1] - self.t[end]) }
        });
        let speeds = (contact.first..=end).map(|i| self.speed_rad_s(i)).collect();
        Exchange {
            from: Passed { at: from, speed_rad_s: fastest },
            samples: (contact.first, speeds),
            to: left,
            last: (end + 1).min(last),
        }
    }

    fn closed_loop(&mut self, closed: &[Place; 2]) -> Exchange {
        let [from, to] = closed.map(|at| self.passed(at));
        let last = (to.at.i + 1).min(self.theta.len() - 1);
        Exchange { from, samples: (0, Vec::new()), to: Some(to), last }
    }
}

/// The user's force on the path.
struct Work<'a> {
    theta: &'a [f64],
    force: &'a [f64],
    lever_m: f64,
    mass_kg: Option<f64>,
    /// A step between recorded angles, at the lever's end, m.
    count_m: f64,
}

impl Work<'_> {
    /// ∫F dx from a sample to the next, F a straight line between them, J.
    fn step_j(&self, i: usize) -> f64 {
        let way = self.theta[i + 1] - self.theta[i];
        self.lever_m * way * (self.force[i] + self.force[i + 1]) / 2.0
    }

    /// ∫F dx from a place's sample to the place, J.
    fn beyond_j(&self, at: Place) -> f64 {
        let way = at.value(self.theta) - self.theta[at.i];
        self.lever_m * way * (self.force[at.i] + at.value(self.force)) / 2.0
    }

    /// The observer after some work, J; `None` where it cannot be told.
    fn observer_j(&self, work_j: f64, began_rad_s: f64, now_rad_s: f64) -> Option<f64> {
        let [began, now] = [began_rad_s, now_rad_s].map(|speed| speed * speed);
        let brought_j = match self.mass_kg {
            Some(mass_kg) => mass_kg * self.lever_m * self.lever_m * (began - now) / 2.0,
            None if began - now <= SAME_SPEED * began => 0.0,
            None => return None,
        };
        Some(work_j + brought_j)
    }

    fn observed(&self, exchange: &Exchange) -> Option<Observed> {
        let Exchange { from, samples: (first, speeds), to, last } = exchange;
        let began = from.speed_rad_s;
        let mut least_j: Option<f64> = None;
        // From the sample before the beginning on: the way up to it is taken off again.
        let mut work_j = -self.beyond_j(from.at);
        let mut exchanged_j = 0.0;
        for i in from.at.i..=*last {
            let speed = i.checked_sub(*first).and_then(|place| speeds.get(place));
            let at_sample = speed.map(|speed| (work_j, *speed));
            let at_end = to.filter(|to| to.at.i == i);
            let at_end = at_end.map(|to| (work_j + self.beyond_j(to.at), to.speed_rad_s));
            for (work_j, speed_rad_s) in at_sample.into_iter().chain(at_end) {
                let observed_j = self.observer_j(work_j, began, speed_rad_s);
                least_j = least_j.into_iter().chain(observed_j).reduce(f64::min);
            }
            if i < *last {
                let step_j = self.step_j(i);
                (work_j, exchanged_j) = (work_j + step_j, exchanged_j + step_j.abs());
            }
        }
        let speed_m_s = self.lever_m * began;
        let motion_j = self.mass_kg.unwrap_or(0.0) * speed_m_s * speed_m_s / 2.0;
        let force = range(&self.force[from.at.i..=*last]);
        let bound_j = WORK_SHARE * exchanged_j + self.count_m * force + MOTION_SHARE * motion_j;
        Some(Observed { least_j: least_j?, bound_j })
    }
}

/// Where θ is at `level` between sample `i` and the next.
fn crossing(theta: &[f64], i: usize, level: f64) -> Place {
    let way = theta[i + 1] - theta[i];
    let share = if way == 0.0 { 0.0 } else { ((level - theta[i]) / way).clamp(0.0, 1.0) };
    Place { i, share }
}

/// The closed loops of a path: from each turn to where the angle is first met again, and backwards
/// from the end where the whole does not close.
fn loops(theta: &[f64], least: f64) -> Vec<[Place; 2]> {
    let legs = zigzag(theta, least);
    let closed: Vec<Option<[Place; 2]>> = legs.iter().map(|leg| closed(theta, *leg)).collect();
    let open = closed.first().is_some_and(Option::is_none) && legs.len() > 1;
    let backwards = legs.last().filter(|_| open).and_then(|last| closed_backwards(theta, *last));
    closed.into_iter().flatten().chain(backwards).collect()
}

fn closed(theta: &[f64], leg: Leg) -> Option<[Place; 2]> {
    let level = theta[leg.from];
    let met = (leg.to + 1..theta.len())
        .find(|i| if leg.up { theta[*i] <= level } else { theta[*i] >= level })?;
    Some([Place::sample(leg.from), crossing(theta, met - 1, level)])
}

fn closed_backwards(theta: &[f64], last: Leg) -> Option<[Place; 2]> {
    let end = theta.len() - 1;
    let met = (0..last.from)
        .rev()
        .find(|i| if last.up { theta[*i] >= theta[end] } else { theta[*i] <= theta[end] })?;
    Some([crossing(theta, met, theta[end]), Place::sample(end)])
}

#[cfg(test)]
mod tests;
