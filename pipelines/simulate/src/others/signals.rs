//! Numbers and signals of time as other languages write them.

use zwidth_dynamics::{Input, Series};

/// A signal in words.
pub(super) fn words(input: &Input, unit: &str) -> String {
    match input {
        Input::Line { value, rate } if *rate == 0.0 => format!("{} {unit}", digits(*value)),
        Input::Line { value, rate } => format!("{} + {} t {unit}", digits(*value), digits(*rate)),
        Input::Step { magnitude, period_s } => format!(
            "{} {unit} and 0 in turn, each for {} s",
            digits(2.0 * magnitude),
            digits(period_s / 4.0)
        ),
        Input::Ramp { magnitude, period_s } => format!(
            "from 0 to {} {unit} and back in straight lines of {} s each",
            digits(2.0 * magnitude),
            digits(period_s / 4.0)
        ),
        Input::Sine { magnitude, omega_rad_s } => {
            format!("{0} + {0} sin({1} t) {unit}", digits(*magnitude), digits(*omega_rad_s))
        }
        Input::Series(Series { t_s, .. }) => format!("a series of {} samples in {unit}", t_s.len()),
    }
}

/// A signal as two functions of Python: its value at `t` in the stretch that `inside` lies in, and
/// where that stretch ends.
pub(super) fn python(name: &str, about: &str, input: &Input) -> String {
    let (value, end, constants) = match input {
        Input::Line { value, rate } => (
            format!("    return {} + {} * t", digits(*value), digits(*rate)),
            "    return math.inf".to_owned(),
            String::new(),
        ),
        Input::Sine { magnitude, omega_rad_s } => (
            format!(
                "    return {0} + {0} * math.sin({1} * t)",
                digits(*magnitude),
                digits(*omega_rad_s)
            ),
            "    return math.inf".to_owned(),
            String::new(),
        ),
        Input::Step { magnitude, period_s } => (
            format!(
                "    return {} if math.floor(4 * inside / {}) % 2 == 0 else 0.0",
                digits(2.0 * magnitude),
                digits(*period_s)
            ),
            quarters(*period_s),
            String::new(),
        ),
        Input::Ramp { magnitude, period_s } => (
            format!(
                "    number = math.floor(4 * inside / {0})\n    passed = 4 * t / {0} - number\n    return {1} * (passed if number % 2 == 0 else 1.0 - passed)",
                digits(*period_s),
                digits(2.0 * magnitude)
            ),
            quarters(*period_s),
            String::new(),
        ),
        Input::Series(series) => {
            let upper = name.to_uppercase();
            (
                format!(
                    "    i = bisect.bisect_right({upper}_T, inside) - 1\n    if i + 1 == len({upper}_T):\n        return {upper}[-1]\n    \
                     t0, t1 = {upper}_T[i : i + 2]\n    return {upper}[i] + (t - t0) / (t1 - t0) * ({upper}[i + 1] - {upper}[i])"
                ),
                format!(
                    "    i = bisect.bisect_right({upper}_T, t)\n    return {upper}_T[i] if i < len({upper}_T) else math.inf"
                ),
                format!(
                    "{upper}_T = [{}]\n{upper} = [{}]\n\n\n",
                    list(&series.t_s),
                    list(&series.value)
                ),
            )
        }
    };
    format!(
        "{constants}def {name}(t, inside):\n    \"\"\"{about}: at t, in the stretch of time that `inside` lies in.\"\"\"\n{value}\n\n\n\
         def {name}_end(t):\n    \"\"\"Where the stretch after t ends, s.\"\"\"\n{end}"
    )
}

/// The end of a quarter of a period, by its number: sums of quarters would drift.
fn quarters(period_s: f64) -> String {
    let period = digits(period_s);
    format!(
        "    number = math.floor(4 * t / {period})\n    while number * {period} / 4 <= t:\n        number += 1\n    return number * {period} / 4"
    )
}

/// A signal as an expression of Modelica; a series is a function of that name.
pub(super) fn modelica(name: &str, input: &Input) -> String {
    match input {
        Input::Line { value, rate } => format!("{} + {} * time", digits(*value), digits(*rate)),
        Input::Sine { magnitude, omega_rad_s } => {
            format!("{0} + {0} * sin({1} * time)", digits(*magnitude), digits(*omega_rad_s))
        }
        Input::Step { magnitude, period_s } => format!(
            "(if mod(floor(4 * time / {}), 2) < 0.5 then {} else 0)",
            digits(*period_s),
            digits(2.0 * magnitude)
        ),
        Input::Ramp { magnitude, period_s } => format!(
            "{} * (1 - abs(1 - 4 * mod(time, {}) / {}))",
            digits(2.0 * magnitude),
            digits(period_s / 2.0),
            digits(*period_s)
        ),
        Input::Series(_) => format!("{name}(time)"),
    }
}

/// The function that a series is in Modelica; nothing for other signals.
pub(super) fn modelica_function(name: &str, input: &Input) -> String {
    let Input::Series(Series { t_s, value }) = input else { return String::new() };
    format!(
        r#"  function {name} "straight lines between samples"
    input Real t;
    output Real y;
  protected
    constant Real times[:] = {{{}}};
    constant Real values[:] = {{{}}};
    Integer i;
  algorithm
    i := 1;
    while i < size(times, 1) and times[min(i + 1, size(times, 1))] <= t loop
      i := i + 1;
    end while;
    y := if i == size(times, 1) then values[i] else values[i] + (t - times[i]) / (times[i + 1] - times[i]) * (values[i + 1] - values[i]);
  end {name};
"#,
        list(t_s),
        list(value)
    )
}

/// Numbers with commas between them.
fn list(values: &[f64]) -> String {
    values.iter().map(|x| digits(*x)).collect::<Vec<_>>().join(", ")
}

/// The shortest digits that read back as the same number.
pub(super) fn digits(value: f64) -> String {
    // A zero has no sign that anything depends on.
    format!("{:?}", value + 0.0)
}
