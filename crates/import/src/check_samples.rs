//! Checks of a mapping's samples: time, columns, units, derivatives.

use super::axes::{FORCES, POSITIONS, not_recorded};
use super::check::Check;
use super::convert::{Linear, Zero};
use super::limits::RATES_HZ;
use super::mapping::{ChannelFrom, ColumnFrom, Mend, Origin, PushOrigin, Rule, SignalFrom, Time};
use super::shape::{
    ChannelShape, ColumnShape, OriginShape, RestShape, TimeShape, ZeroShape, ZeroWord,
};
use super::unit::{self, Dimension, Unit};
use zwidth_store::{COLUMNS, Signal};
use zwidth_study::ChannelId;

impl Check<'_> {
    pub(super) fn time(&mut self, t: TimeShape) -> Option<Time> {
        if t.wrap.is_some_and(|wrap| !(wrap.is_finite() && wrap > 0.0)) {
            self.error(
                "time.wrap",
                "must be a number above 0: the value at which the time starts over",
            );
        }
        if let Some(rate_hz) = t.rate_hz {
            self.rate("time.rate_hz", rate_hz);
        }
        let mend = Mend { wrap: t.wrap, equal: t.equal, counts_at_hz: None };
        let is_placed = t.unit.is_some() || t.offset.is_some() || t.zero.is_some();
        match (t.from, t.counter, t.rate_hz) {
            (Some(from), None, None) => {
                let unit = self.unit("time.unit", t.unit.as_deref(), Signal::Time)?;
                let zero = if t.zero.is_some() { Zero::First } else { Zero::None };
                let line = self.line("time", None, None, t.offset, zero)?;
                let unit_text = t.unit.unwrap_or_default();
                Some(Time::Column { column: ColumnFrom { from, unit, unit_text, line }, mend })
            }
            (None, Some(from), Some(rate_hz)) => {
                if is_placed {
                    let what = "unit, offset and zero are not used beside counter; remove them";
                    self.error("time", what);
                }
                let unit = unit::find("s")?;
                // The line makes seconds of counts, whatever unit they have.
                let line = Linear { scale: 1.0 / rate_hz, zero: Zero::First, ..Linear::IDENTITY };
                let mend = Mend { counts_at_hz: Some(rate_hz), ..mend };
                let unit_text = "samples".to_owned();
                Some(Time::Column { column: ColumnFrom { from, unit, unit_text, line }, mend })
            }
            (None, None, Some(rate_hz)) => {
                if is_placed || t.wrap.is_some() || t.equal.is_some() || t.backwards.is_some() {
                    let what = "unit, offset, zero, wrap, equal and backwards are not used beside rate_hz alone; \
                                remove them";
                    self.error("time", what);
                }
                Some(Time::Rate { rate_hz })
            }
            (None, Some(_), None) => {
                self.error(
                    "time",
                    "counter needs rate_hz: how many samples are counted in a second",
                );
                None
            }
            _ => {
                self.error(
                    "time",
                    "needs either from (a column) or rate_hz; counter goes with rate_hz alone",
                );
                None
            }
        }
    }

    /// A rate of samples that a device may have, Hz.
    pub(super) fn rate(&mut self, key: &str, rate_hz: f64) -> Option<f64> {
        let [low, high] = [RATES_HZ.start(), RATES_HZ.end()];
        let rate = RATES_HZ.contains(&rate_hz).then_some(rate_hz);
        self.keep(
            key,
            rate.ok_or_else(|| format!("{rate_hz:?} must be a number from {low} to {high}")),
        )
    }

    pub(super) fn unit(
        &mut self,
        key: &str,
        text: Option<&str>,
        to: Signal,
    ) -> Option<&'static Unit> {
        let choices = format!("use one of {}", unit::choices(to));
        let Some(text) = text else {
            self.error(key, format!("is missing; {choices}"));
            return None;
        };
        let unit = unit::find(text);
        let unit = unit.ok_or_else(|| format!("the unit '{text}' is unknown; {choices}"));
        let unit = self.keep(key, unit)?;
        if !unit::may_become(unit, to) {
            let problem = format!(
                "the unit '{text}' does not fit {}, which is in {}; {choices}",
                to.name(),
                to.column().unit
            );
            self.error(key, problem);
            return None;
        }
        Some(unit)
    }

    pub(super) fn line(
        &mut self,
        at: &str,
        sign: Option<f64>,
        scale: Option<f64>,
        offset: Option<f64>,
        zero: Zero,
    ) -> Option<Linear> {
        let same = Linear::IDENTITY;
        let sign = sign.unwrap_or(same.sign);
        let scale = scale.unwrap_or(same.scale);
        let offset = offset.unwrap_or(same.offset);
        // All three are checked, so that every problem is reported at once.
        let before = self.errors.len();
        #[allow(clippy::float_cmp)] // exactly one of the two
        if sign.abs() != 1.0 {
            self.error(&format!("{at}.sign"), format!("{sign} must be 1 or -1"));
        }
        if !scale.is_finite() || scale == 0.0 {
            self.error(
                &format!("{at}.scale"),
                format!("{scale} must be a finite number other than 0"),
            );
        }
        if !offset.is_finite() {
            self.error(&format!("{at}.offset"), format!("{offset} must be a finite number"));
        }
        (self.errors.len() == before).then_some(Linear { sign, scale, offset, zero })
    }

    /// Checks what is subtracted from a column of a trial.
    fn zero(&mut self, at: &str, zero: Option<ZeroShape>) -> Zero {
        match zero {
            None => Zero::None,
            Some(ZeroShape::Word(ZeroWord::First)) => Zero::First,
            Some(ZeroShape::Rest(RestShape { from_s, to_s })) => {
                if !(from_s >= 0.0 && to_s.is_finite() && to_s > from_s) {
                    let what = "needs 0 ≤ from_s < to_s: a stretch of the trial, in seconds from its first sample";
                    self.error(&format!("{at}.zero"), what);
                }
                Zero::Rest { from_s, to_s }
            }
        }
    }

    pub(super) fn column(
        &mut self,
        at: &str,
        c: ColumnShape,
        mapped: &[SignalFrom],
        above: &[Signal],
    ) -> Option<SignalFrom> {
        let key = format!("{at}.to");
        let to = self.keep(
            &key,
            Signal::from_name(&c.to).ok_or_else(|| {
                if let Some(why) = not_recorded(&c.to) {
                    return why;
                }
                let names = COLUMNS.iter().map(|c| c.name).filter(|n| *n != Signal::Time.name());
                format!(
                    "'{}' is not a column of a trial; use one of {}",
                    c.to,
                    names.collect::<Vec<_>>().join(", ")
                )
            }),
        )?;
        if to == Signal::Time {
            self.error(&key, "the time is mapped in [time]");
        }
        if mapped.iter().any(|other| other.to == to) {
            self.error(&key, format!("'{}' is mapped twice", c.to));
        }
        let place = c.origin;
        let origin = match (c.from, c.derive) {
            (Some(from), None) => {
                if place.is_some() {
                    self.error(&format!("{at}.origin"), "is used beside derive = \"along push\" alone; a column has zero and offset");
                }
                // All are checked before the first `?`, so that every problem is reported at once.
                let unit = self.unit(&format!("{at}.unit"), c.unit.as_deref(), to);
                let zero = self.zero(at, c.zero);
                let line = self.line(at, c.sign, c.scale, c.offset, zero);
                if c.wrap.is_some_and(|wrap| !(wrap.is_finite() && wrap > 0.0)) {
                    let what =
                        "must be a number above 0, in the unit of the column: 360 for degrees";
                    self.error(&format!("{at}.wrap"), what);
                }
                let unit_text = c.unit.unwrap_or_default();
                let column = ColumnFrom { from, unit: unit?, unit_text, line: line? };
                Origin::Column { column, wrap: c.wrap }
            }
            (None, Some(rule)) => {
                if [c.sign, c.scale, c.offset].iter().any(Option::is_some)
                    || c.unit.is_some()
                    || c.zero.is_some()
                    || c.wrap.is_some()
                {
                    self.error(
                        at,
                        "unit, sign, scale, offset, zero and wrap are not used beside derive; remove them",
                    );
                }
                let key = format!("{at}.derive");
                let rule = derived(&rule, to, above, place);
                Origin::Derived(self.keep(&key, rule)?)
            }
            _ => {
                self.error(at, "needs either from (a column) or derive");
                return None;
            }
        };
        Some(SignalFrom { to, origin })
    }

    pub(super) fn channel(
        &mut self,
        at: &str,
        c: ChannelShape,
        mapped: &[ChannelFrom],
    ) -> Option<ChannelFrom> {
        let key = format!("{at}.to");
        let to = self.keep(&key, ChannelId::new(c.to).map_err(|e| e.to_string()))?;
        if mapped.iter().any(|other| other.to == to) {
            self.error(&key, format!("'{}' is mapped twice", to.as_str()));
        }
        let zero = self.zero(at, c.zero);
        let line = self.line(at, c.sign, c.scale, c.offset, zero)?;
        Some(ChannelFrom { to, from: c.from, unit: c.unit, line })
    }
}

/// What `derive` asks for: `derivative of theta_rad`, `integral of theta_dot_rad_s`; `above` is what
/// the columns before it are to become, those with an error of their own included.
fn derived(
    rule: &str,
    to: Signal,
    above: &[Signal],
    origin: Option<OriginShape>,
) -> Result<Rule, String> {
    let form = "write \"derivative of …\" or \"integral of …\" with a column of a trial, for instance theta_rad, or \
                \"along push\"";
    if rule == "along push" {
        return along_push(to, above, origin);
    }
    if origin.is_some() {
        return Err("origin is used beside derive = \"along push\" alone; remove it".to_owned());
    }
    let (is_derivative, name) = match rule.split_once(" of ") {
        Some(("derivative", name)) => (true, name),
        Some(("integral", name)) => (false, name),
        _ => return Err(format!("'{rule}' is not understood; {form}")),
    };
    let source = Signal::from_name(name)
        .ok_or_else(|| format!("'{name}' is not a column of a trial; {form}"))?;
    if !above.contains(&source) {
        return Err(format!("'{name}' must be mapped by a [[column]] above this one"));
    }
    // Either way the one is the rate of the other.
    let (low, high) = if is_derivative { (source, to) } else { (to, source) };
    let fits = matches!(
        (unit::dimension(low), unit::dimension(high)),
        (Some(Dimension::Angle), Some(Dimension::AngularVelocity))
            | (Some(Dimension::AngularVelocity), Some(Dimension::AngularAcceleration))
    );
    if !fits {
        let to_unit = to.column().unit;
        let source_unit = source.column().unit;
        return Err(format!(
            "'{rule}' is not in {to_unit}, the unit of {}: {name} is in {source_unit}",
            to.name()
        ));
    }
    Ok(if is_derivative { Rule::DerivativeOf(source) } else { Rule::IntegralOf(source) })
}

/// The projection of positions or forces that are mapped above.
fn along_push(to: Signal, above: &[Signal], origin: Option<OriginShape>) -> Result<Rule, String> {
    let axes = match to {
        Signal::Theta => POSITIONS,
        Signal::ForceEx => FORCES,
        other => {
            return Err(format!(
                "\"along push\" makes theta_rad of positions or force_ex_n of forces, and not {}; a velocity is the \
                 derivative of theta_rad",
                other.name()
            ));
        }
    };
    if !axes.iter().any(|axis| above.contains(axis)) {
        let names = axes.map(Signal::name).join(", ");
        return Err(format!(
            "\"along push\" needs {names}, each mapped by a [[column]] above this one"
        ));
    }
    match origin {
        None => Ok(Rule::AlongPush(PushOrigin::Place([0.0; 3]))),
        Some(_) if to == Signal::ForceEx => {
            Err("a force has no origin; remove it, and give the force's columns a zero".to_owned())
        }
        Some(OriginShape::Word(ZeroWord::First)) => Ok(Rule::AlongPush(PushOrigin::First)),
        Some(OriginShape::Place(place)) if place.iter().all(|part| part.is_finite()) => {
            Ok(Rule::AlongPush(PushOrigin::Place(place)))
        }
        Some(OriginShape::Place(_)) => {
            Err("origin must be three finite numbers, in metres".to_owned())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::check::tests::check;
    use super::super::mapping::Mapping;
    use super::super::world::{FORCE, ONE, trials_map};
    use std::path::Path;

    #[test]
    fn a_derivative_must_be_one() {
        let slope = "[[column]]\nto = \"theta_dot_rad_s\"\nderive = \"derivative of theta_rad\"\n";
        let good = trials_map(&[ONE, FORCE, slope]);
        let other = "is not in rad/s, the unit of theta_dot_rad_s: force_ex_n is in N";
        for (from, to, line, words) in [
            ("x", "x", 18, "'theta_rad' must be mapped by a [[column]] above this one"),
            ("theta_rad", "force_ex_n", 18, other),
            ("theta_rad", "thta_rad", 18, "'thta_rad' is not a column of a trial"),
            ("derivative of", "slope of", 18, "write \"derivative of …\""),
            ("derive =", "unit = \"rad/s\"\nderive =", 16, "are not used beside derive"),
        ] {
            check(&good, from, to, line, words);
        }
    }

    #[test]
    fn what_is_mended_must_make_sense() {
        let good = trials_map(&[ONE, FORCE]);
        let time = "from = \"t\"\nunit = \"s\"";
        let wrap = format!("{time}\nwrap = 0");
        let both = format!("{time}\ncounter = \"n\"");
        let placed = "rate_hz = 1.0\ncounter = 1\nunit = \"s\"";
        let force = "unit = \"N\"";
        let zero = |zero: &str| format!("{force}\nzero = {zero}");
        for (from, to, line, words) in [
            (time, wrap.as_str(), 12, "the value at which the time starts over"),
            (time, "counter = \"n\"", 9, "counter needs rate_hz"),
            (time, both.as_str(), 9, "needs either from (a column) or rate_hz"),
            (time, placed, 9, "not used beside counter"),
            (time, "rate_hz = 1.0\nwrap = 16", 9, "not used beside rate_hz alone"),
            (force, zero("{ from_s = 1, to_s = 0.5 }").as_str(), 16, "needs 0 ≤ from_s < to_s"),
            (force, zero("{ to = 1 }").as_str(), 16, "a stretch at rest"),
            (force, zero("\"last\"").as_str(), 16, "a stretch at rest"),
            (force, "unit = \"N\"\nwrap = -1", 16, "360 for degrees"),
        ] {
            check(&good, from, to, line, words);
        }
    }

    #[test]
    fn a_column_whose_unit_is_wrong_is_told_of_once_and_not_missed_by_what_is_derived_from_it() {
        const ANGLE: &str = "[[column]]\nto = \"theta_rad\"\nfrom = \"a\"\nunit = \"degg\"\n";
        const SLOPE: &str =
            "[[column]]\nto = \"theta_dot_rad_s\"\nderive = \"derivative of theta_rad\"\n";
        let map = trials_map(&[ONE, FORCE, ANGLE, SLOPE]);
        let told = Mapping::from_toml(&map, Path::new("map.toml")).unwrap_err();
        assert_eq!(told.len(), 1, "{told:?}");
        assert!(told[0].to_string().contains("'degg' is unknown"), "{told:?}");
    }
}
