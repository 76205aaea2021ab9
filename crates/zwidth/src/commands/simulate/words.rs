//! A summary as people read it: degrees, milliseconds.

use zwidth_simulate::{KnownMotion, StepSwings, Summary};

/// Milliseconds in a second.
const MS_PER_S: f64 = 1e3;

/// A few lines, the first a heading.
pub(super) fn summary_lines(summary: &Summary) -> String {
    let s = summary;
    let mut lines = vec![
        format!("{} ({}, {})", s.scene, s.environment, s.mode),
        format!("  solver    {}, {} samples, one every {}", s.solver, s.samples, ms(s.step_s)),
        format!("  largest θ {:.5}° at {:.4} s", s.theta_max_rad.to_degrees(), s.theta_max_s),
        format!("  motion    {}", motion(s)),
        format!("  verdict   {}", s.verdict),
        format!("            {}", s.swings.map(swings).join(", ")),
    ];
    lines.extend(s.reference.as_ref().map(|motion| format!("            {}", motion_line(motion))));
    if let Some(other) = &s.other_rest_rule {
        lines.push(format!("            with the other rule at rest: {}", motion_line(other)));
    }
    if !s.shows_the_reference {
        lines.push("            the step is too long to show it".to_owned());
    }
    if s.creep_rad > 0.0 {
        lines.push(format!(
            "            the lever creeps by {:.3}° where it should stand still",
            s.creep_rad.to_degrees()
        ));
    }
    if s.amplification > 1.0 {
        lines.push(format!(
            "            a step grows by {:.4} over the exact flow",
            s.amplification
        ));
    }
    if let Some(energy) = s.energy {
        let residual = energy.residual_j;
        let summed = energy.summed_j;
        let why =
            if s.finger == Some("thesis") { " (the finger's law leaves out a force)" } else { "" };
        lines.push(format!(
            "  energy    {residual:.1e} J of {summed:.4} J are not accounted for{why}"
        ));
    }
    let w = s.work;
    lines.push(format!(
        "  work      {} steps ({} rejected), {} evaluations, {} factorisations",
        w.steps, w.rejected, w.evaluations, w.factorisations
    ));
    lines.join("\n")
}

fn motion(s: &Summary) -> String {
    let changes = s.motion_changes.map_or(String::new(), |n| format!("{n} changes of motion, "));
    format!("{changes}{} reversals between samples", s.reversals)
}

fn swings(at: StepSwings) -> String {
    match at.count {
        0 => format!("no swings at {}", ms(at.step_s)),
        n => format!("{n} swings of ±{:.3}° at {}", at.amplitude_rad.to_degrees(), ms(at.step_s)),
    }
}

fn motion_line(motion: &KnownMotion) -> String {
    let nature = motion.nature;
    let count = motion.count;
    let size = motion.amplitude_rad.to_degrees();
    let largest = motion.theta_max_rad.to_degrees();
    format!("{}: {nature}, {count} swings of ±{size:.3}°, largest θ {largest:.5}°", motion.method)
}

/// A time in ms, without the digits that are rounding.
fn ms(time_s: f64) -> String {
    let digits = format!("{:.6}", time_s * MS_PER_S);
    format!("{} ms", digits.trim_end_matches('0').trim_end_matches('.'))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_lose_their_rounding_and_nothing_else() {
        assert_eq!(ms(0.0083), "8.3 ms");
        assert_eq!(ms(0.0083 / 4.0), "2.075 ms");
        assert_eq!(ms(1.0), "1000 ms");
    }
}
