//! Where the ticks of a numeric axis are, and what is written there.

use crate::figure;

/// A tick: its place on the axis, its label.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Tick {
    pub(crate) at: f64,
    pub(crate) label: String,
}

/// Ticks of an axis; their labels count in units of 10^`exponent`.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Ticks {
    pub(crate) ticks: Vec<Tick>,
    pub(crate) exponent: i32,
}

/// A step of 1, 2 or 5 × 10ⁿ.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Step {
    digit: i64,
    power: i32,
}

impl Step {
    fn size(self) -> f64 {
        multiple(self, 1)
    }

    fn next(self) -> Self {
        match self.digit {
            1 => Self { digit: 2, ..self },
            2 => Self { digit: 5, ..self },
            _ => Self { digit: 1, power: self.power + 1 },
        }
    }
}

/// `count` steps, rounded once, so that 3 × 0.1 is 0.3.
fn multiple(step: Step, count: i64) -> f64 {
    let whole = (step.digit * count) as f64;
    // `libm`'s powers are the same bits on every machine, those of `std` are not.
    if step.power < 0 {
        whole / libm::exp10(f64::from(-step.power))
    } else {
        whole * libm::exp10(f64::from(step.power))
    }
}

/// More ticks than this crowd any axis.
const MOST_TICKS: f64 = 12.0;

/// The densest ticks from `low` to `high` (`low < high`, both finite) that `fits` accepts. All
/// kinds but plain numbers and logarithms keep to whole numbers.
pub(crate) fn choose(
    low: f64,
    high: f64,
    kind: &figure::Ticks,
    fits: impl Fn(&Ticks) -> bool,
) -> Ticks {
    match kind {
        figure::Ticks::Logarithms => of_logarithms(libm::exp(low), libm::exp(high), &fits),
        _ => in_steps(low, high, kind, &fits),
    }
}

/// The densest ticks in equal steps.
fn in_steps(low: f64, high: f64, kind: &figure::Ticks, fits: &dyn Fn(&Ticks) -> bool) -> Ticks {
    let power = libm::floor(libm::log10((high - low) / MOST_TICKS)) as i32;
    let whole = *kind != figure::Ticks::Numbers;
    let mut step = Step { digit: 1, power: if whole { power.max(0) } else { power } };
    while (high - low) / step.size() > MOST_TICKS {
        step = step.next();
    }
    let mut denser = every(step, low, high, kind);
    while denser.ticks.len() > 2 && !fits(&denser) {
        step = step.next();
        let sparser = every(step, low, high, kind);
        // One number alone says nothing about an axis: of the denser ticks the outermost two stay.
        if sparser.ticks.len() < 2 {
            let ends = [denser.ticks.first().cloned(), denser.ticks.last().cloned()];
            return Ticks { ticks: ends.into_iter().flatten().collect(), ..denser };
        }
        denser = sparser;
    }
    denser
}

/// Up to so large a ratio of its ends an axis of logarithms has numbers in equal steps.
const MOST_IN_STEPS: f64 = 5.0;

/// Ticks at the logarithms of numbers from `from` to `to`, both above 0.
fn of_logarithms(from: f64, to: f64, fits: &dyn Fn(&Ticks) -> bool) -> Ticks {
    let placed = |numbers: &Ticks| {
        let ticks = numbers.ticks.iter().filter(|tick| tick.at > 0.0);
        let ticks = ticks.map(|tick| Tick { at: libm::log(tick.at), label: tick.label.clone() });
        Ticks { ticks: ticks.collect(), exponent: numbers.exponent }
    };
    if to / from < MOST_IN_STEPS {
        let fits = |own: &Ticks| fits(&placed(own));
        return placed(&in_steps(from, to, &figure::Ticks::Numbers, &fits));
    }
    let powers = [from, to].map(|end| libm::floor(libm::log10(end)) as i32);
    let of = |digits: &[i64]| {
        let all = (powers[0]..=powers[1])
            .flat_map(|power| digits.iter().map(move |digit| Step { digit: *digit, power }));
        let ticks = all
            .filter(|step| (from..=to).contains(&step.size()))
            .map(|step| Tick { at: libm::log(step.size()), label: write(step.digit, step.power) });
        Ticks { ticks: ticks.collect(), exponent: 0 }
    };
    let [dense, sparse] = [of(&[1, 2, 5]), of(&[1])];
    match fits(&dense) || sparse.ticks.len() < 2 {
        true => ends_where_crowded(dense, fits),
        false => ends_where_crowded(sparse, fits),
    }
}

/// Ticks, of which the outermost two stay where all have no room.
fn ends_where_crowded(all: Ticks, fits: &dyn Fn(&Ticks) -> bool) -> Ticks {
    if fits(&all) || all.ticks.len() < 3 {
        return all;
    }
    let ends = [all.ticks.first().cloned(), all.ticks.last().cloned()];
    Ticks { ticks: ends.into_iter().flatten().collect(), ..all }
}

fn every(step: Step, low: f64, high: f64, kind: &figure::Ticks) -> Ticks {
    /// Share of a step by which an axis may miss its last tick and still have it: rounding of the
    /// ends.
    const SLACK: f64 = 1e-9;
    let first = libm::ceil(low / step.size() - SLACK) as i64;
    let last = libm::floor(high / step.size() + SLACK) as i64;
    let powers = *kind == figure::Ticks::Powers;
    // Labels that are powers of ten need none taken out.
    let exponent = if powers { 0 } else { shared_exponent(low.abs().max(high.abs())) };
    let mut ticks = Vec::new();
    for count in first..=last {
        let shown = if *kind == figure::Ticks::Magnitudes { count.abs() } else { count };
        let number = write(shown * step.digit, step.power - exponent);
        let label = if powers { format!("10^{{{number}}}") } else { number };
        ticks.push(Tick { at: multiple(step, count), label });
    }
    Ticks { ticks, exponent }
}

/// Places of the two- to ninefold of every power of ten between 10^`low` and 10^`high`, as
/// logarithms.
pub(crate) fn between_powers(low: f64, high: f64) -> impl Iterator<Item = f64> {
    let powers = libm::floor(low) as i64..=libm::floor(high) as i64;
    let places = powers.flat_map(|n| (2..=9).map(move |k| n as f64 + libm::log10(f64::from(k))));
    places.filter(move |at| (low..=high).contains(at))
}

/// The power of ten taken out of the labels: none from 0.01 up to 99,999, else a multiple of three.
fn shared_exponent(largest: f64) -> i32 {
    let power = libm::floor(libm::log10(largest)) as i32;
    if (-2..5).contains(&power) { 0 } else { power.div_euclid(3) * 3 }
}

/// `digits` × 10^`power` in decimals, exactly, with a true minus sign.
fn write(digits: i64, power: i32) -> String {
    let sign = if digits < 0 { "−" } else { "" };
    let size = digits.unsigned_abs();
    if power >= 0 {
        let zeros = if size == 0 { 0 } else { power as usize };
        return format!("{sign}{size}{}", "0".repeat(zeros));
    }
    let places = power.unsigned_abs() as usize;
    let padded = format!("{size:0>width$}", width = places + 1);
    let (whole, rest) = padded.split_at(padded.len() - places);
    format!("{sign}{whole}.{rest}")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(low: f64, high: f64, most: usize, expect: &str) {
        let ticks = choose(low, high, &figure::Ticks::Numbers, |ticks| ticks.ticks.len() <= most);
        let labels: Vec<_> = ticks.ticks.iter().map(|tick| tick.label.as_str()).collect();
        assert_eq!(labels.join(" "), expect, "{low} … {high}");
    }

    #[test]
    fn ticks_step_by_one_two_or_five() {
        check(0.0, 4.16, 6, "0 1 2 3 4");
        check(0.0, 32.0, 5, "0 10 20 30");
        check(-0.04, 1.04, 6, "0.0 0.2 0.4 0.6 0.8 1.0");
        check(0.0, 45.0, 6, "0 10 20 30 40");
        check(0.0, 20.0, 5, "0 5 10 15 20");
    }

    #[test]
    fn negative_numbers_have_a_true_minus_and_zero_has_none() {
        check(-210.0, 205.0, 6, "−200 −100 0 100 200");
        check(-0.3, 0.3, 3, "−0.2 0.0 0.2");
    }

    #[test]
    fn ticks_stand_at_the_decimal_number_they_name() {
        let ticks = choose(0.0, 1.0, &figure::Ticks::Numbers, |_| true);
        assert!(ticks.ticks.iter().any(|tick| tick.at == 0.3 && tick.label == "0.3"), "{ticks:?}");
    }

    #[test]
    fn very_small_and_very_large_numbers_share_a_power_of_ten() {
        let small = choose(0.0, 4.2e-4, &figure::Ticks::Numbers, |ticks| ticks.ticks.len() <= 5);
        assert_eq!((small.exponent, small.ticks[1].label.as_str()), (-6, "100"));
        let large = choose(0.0, 2.5e6, &figure::Ticks::Numbers, |ticks| ticks.ticks.len() <= 4);
        assert_eq!((large.exponent, large.ticks[1].label.as_str()), (6, "1"));
    }

    #[test]
    fn counts_are_whole_and_without_sign() {
        let ticks = choose(-3.4, 3.4, &figure::Ticks::Magnitudes, |_| true);
        let labels: Vec<_> = ticks.ticks.iter().map(|tick| tick.label.as_str()).collect();
        assert_eq!(labels, ["3", "2", "1", "0", "1", "2", "3"]);
    }

    #[test]
    fn an_axis_of_logarithms_has_round_numbers_at_their_logarithms() {
        let check = |from: f64, to: f64, most: usize, expect: &str| {
            let kind = figure::Ticks::Logarithms;
            let ticks = choose(from.ln(), to.ln(), &kind, |ticks| ticks.ticks.len() <= most);
            let labels: Vec<_> = ticks.ticks.iter().map(|tick| tick.label.as_str()).collect();
            assert_eq!(labels.join(" "), expect, "{from} … {to}");
            for tick in &ticks.ticks {
                assert!((tick.at.exp() - tick.label.parse::<f64>().unwrap()).abs() < 1e-9);
            }
        };
        check(0.85, 1.65, 6, "1.0 1.2 1.4 1.6");
        check(22.0, 34.0, 6, "25 30");
        check(0.3, 30.0, 9, "0.5 1 2 5 10 20");
        check(0.03, 300.0, 5, "0.1 1 10 100");
        check(0.03, 3e4, 3, "0.1 10000");
        check(1.2, 8.0, 6, "2 5");
    }

    #[test]
    fn logarithms_are_written_as_powers_of_ten_and_skip_some_where_there_is_no_room_for_all() {
        let powers = |low, high, most: usize| {
            let ticks =
                choose(low, high, &figure::Ticks::Powers, |ticks| ticks.ticks.len() <= most);
            assert!(
                ticks.exponent == 0 && ticks.ticks.iter().all(|tick| tick.at == tick.at.round())
            );
            ticks.ticks.into_iter().map(|tick| tick.label).collect::<Vec<_>>().join(" ")
        };
        assert_eq!(powers(-1.3, 1.0, 9), "10^{−1} 10^{0} 10^{1}");
        assert_eq!(powers(-6.0, 2.0, 5), "10^{−6} 10^{−4} 10^{−2} 10^{0} 10^{2}");
    }

    #[test]
    fn between_two_powers_of_ten_stand_their_multiples() {
        let found: Vec<f64> = between_powers(0.5, 1.5).map(|at| 10_f64.powf(at).round()).collect();
        assert_eq!(found, [4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 20.0, 30.0]);
    }

    #[test]
    fn an_axis_with_room_for_two_keeps_its_outermost_ticks() {
        check(-0.9, 1.9, 2, "0 1");
        check(-0.9, 0.9, 2, "−0.5 0.5");
    }

    #[test]
    fn an_axis_far_from_zero_still_has_ticks() {
        check(1e6, 1e6 + 0.1, 3, "1.00000000 1.00000005 1.00000010");
    }
}
