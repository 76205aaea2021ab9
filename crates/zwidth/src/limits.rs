//! The limits of numbers on the command line, so that none of them can claim unlimited memory or
//! time.

use zwidth_results::WallQuantity;

/// Threads at most: more than any machine that is known to run this has cores.
pub(crate) const MOST_THREADS: i64 = 1024;
/// Sweeps at most that one command records.
pub(crate) const MOST_SWEEPS: i64 = 1000;
/// Participants at most of a simulated study, sessions of each, and times that its design is
/// repeated: a terabyte is reached before.
pub(crate) const MOST_PARTICIPANTS: i64 = 1000;
pub(crate) const MOST_SESSIONS: i64 = 100;
pub(crate) const MOST_SCALE: i64 = 10_000;
/// Cells at most of a side of a map: four million of them take some minutes.
pub(crate) const MOST_CELLS: i64 = 2000;
/// Rates of the control loop, Hz: one tick per second at least, and no more than study.toml can
/// have.
const RATES_HZ: [f64; 2] = [1.0, 100_000.0];
/// Relative errors per step that a solver can aim for: below, it would halve its steps until
/// rounding stops it.
const TOLERANCES: [f64; 2] = [1e-14, 1.0];

/// Quantities of a sampled wall, SI.
const QUANTITIES: [f64; 2] = [0.0, 1e12];

/// A number from one to the other.
fn within(text: &str, [least, most]: [f64; 2]) -> Result<f64, String> {
    let number: f64 = text.parse().map_err(|_| "it must be a number".to_owned())?;
    let fits = (least..=most).contains(&number);
    if fits { Ok(number) } else { Err(format!("it must be from {least:?} to {most:?}")) }
}

/// A rate of the control loop, Hz.
pub(crate) fn rate(text: &str) -> Result<f64, String> {
    within(text, RATES_HZ)
}

/// A relative error per step.
pub(crate) fn tolerance(text: &str) -> Result<f64, String> {
    within(text, TOLERANCES)
}

/// A quantity of the sampled wall, by its word.
fn quantity(word: &str) -> Result<WallQuantity, String> {
    WallQuantity::from_word(word).ok_or_else(|| {
        let words: Vec<_> = WallQuantity::ALL.iter().map(|quantity| quantity.as_str()).collect();
        format!("{word:?} is not a quantity; take one of {}", words.join(", "))
    })
}

/// Lengths on paper, mm: from a stamp to ISO A0.
const PAPER_MM: [f64; 2] = [20.0, 1189.0];

/// A width on paper, or width and height, mm: `85`, `175x120`.
pub(crate) fn size(text: &str) -> Result<(f64, Option<f64>), String> {
    let (width, height) = text.split_once('x').map_or((text, None), |(w, h)| (w, Some(h)));
    let height = height.map(|height| within(height, PAPER_MM)).transpose()?;
    Ok((within(width, PAPER_MM)?, height))
}

/// A quantity with its value: `delay=0.0083`.
pub(crate) fn setting(text: &str) -> Result<(WallQuantity, f64), String> {
    let (word, value) = text.split_once('=').ok_or("write QUANTITY=VALUE, as delay=0.0083")?;
    Ok((quantity(word)?, within(value, QUANTITIES)?))
}

/// A quantity with the ends of an axis, or without: `stiffness=10..2000`, `stiffness`.
pub(crate) fn span(text: &str) -> Result<(WallQuantity, Option<[f64; 2]>), String> {
    let Some((word, ends)) = text.split_once('=') else { return Ok((quantity(text)?, None)) };
    let (from, to) = ends.split_once("..").ok_or("write QUANTITY=FROM..TO, as delay=0..0.05")?;
    Ok((quantity(word)?, Some([within(from, QUANTITIES)?, within(to, QUANTITIES)?])))
}

/// A number above zero.
pub(crate) fn positive(text: &str) -> Result<f64, String> {
    let number: f64 = text.parse().map_err(|_| "it must be a number".to_owned())?;
    if number > 0.0 && number.is_finite() {
        Ok(number)
    } else {
        Err("it must be finite and above 0".to_owned())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::args::Args;
    use clap::Parser as _;

    #[test]
    fn a_number_that_would_take_all_memory_or_for_ever_is_refused_with_its_limits() {
        for (arguments, words) in [
            (&["--threads", "0", "list"][..], "1..=1024"),
            (&["--threads", "100000", "list"], "1..=1024"),
            (&["characterise", "s", "motor", "--sweeps", "0"], "1..=1000"),
            (&["characterise", "s", "motor", "--sweeps", "4000000000"], "1..=1000"),
            (&["twin", "s", "--participants", "4000000000"], "1..=1000"),
            (&["twin", "s", "--sessions", "4000000000"], "1..=100"),
            (&["stability", "--cells", "1000000"], "2..=2000"),
            (&["stability", "--at", "delay=-1"], "0.0 to 1000000000000.0"),
            (&["stability", "--at", "speed=1"], "take one of step, mass"),
            (&["stability", "--y", "mass", "--x", "delay=1"], "FROM..TO"),
            (&["twin", "s", "--scale", "4000000000"], "1..=10000"),
            (&["twin", "s", "--rate", "1e300"], "from 1.0 to 100000.0"),
            (
                &["acquire", "s", "-p", "P01", "-s", "S01", "--rate", "1e-300"],
                "from 1.0 to 100000.0",
            ),
            (&["check", "s", "--rate", "nan"], "from 1.0 to 100000.0"),
            (&["simulate", "a.toml", "--tolerance", "1e-300"], "from 1e-14 to 1.0"),
        ] {
            let typed = std::iter::once(&"zwidth").chain(arguments);
            let error = Args::try_parse_from(typed).unwrap_err();
            assert_eq!(error.exit_code(), 2, "{arguments:?}");
            assert!(error.to_string().contains(words), "{error}");
        }
    }

    #[test]
    fn what_is_not_above_zero_is_refused() {
        for text in ["0", "-1", "nan", "inf", "much"] {
            assert!(positive(text).is_err(), "{text}");
        }
    }
}
