//! What `rig.toml` must say of a board in software.

use super::device::{NEWTONS_PER_COUNT, ZERO_COUNTS};
use crate::{AngleAt, Firmata, Hx711, Link, Settings, Text, Turning};
use std::path::Path;
use zwidth_device::Capabilities;

/// What a host must be told of a board with this device behind it: `angle` where Firmata has it,
/// `rate_hz` readings a second of a link that streams, and `cell` the port of the load cell where
/// it has one of its own.
pub fn settings(
    link: Link,
    angle: AngleAt,
    rate_hz: f64,
    can: &Capabilities,
    cell: &Path,
) -> Settings {
    let (motor_max_v, brake_max_v) = (can.motor_max_v, can.brake_max_v);
    let firmata = || Firmata {
        rate_hz,
        angle,
        motor_pwm: 5,
        motor_direction: 4,
        motor_reversed: false,
        brake_pwm: 6,
        motor_max_v,
        brake_max_v,
    };
    let text = || Text {
        rate_hz,
        line: "{t_us},{counts},{hx711}".to_owned(),
        command: "M{motor_pwm} B{brake_pwm}\n".to_owned(),
        mark: Some("K{code} {number}\n".to_owned()),
        pwm_full: 255,
        counts_per_turn: can.counts_per_turn.map_or(0, |counts| counts as u16),
        motor_max_v,
        brake_max_v,
    };
    let hx711 = || Hx711 {
        port: cell.to_owned(),
        baud: 115_200,
        line: "{hx711}".to_owned(),
        rate_hz: can.force_rate_hz,
    };
    Settings {
        port: None,
        link,
        baud: None,
        newtons_per_count: NEWTONS_PER_COUNT,
        zero_counts: ZERO_COUNTS,
        shaft_per_lever: can.shaft_per_lever,
        turning: Turning::Up,
        // Neither frames nor Firmata need it: there the board says so itself.
        simulated: link == Link::Text,
        firmata: (link == Link::Firmata).then(firmata),
        text: (link == Link::Text).then(text),
        hx711: (link == Link::Firmata).then(hx711),
    }
}
