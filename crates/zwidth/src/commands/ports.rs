//! `zwidth ports`: which serial ports there are, and which board is at one.

use crate::exit::Exit;
use crate::screen::Screen;
use std::path::{Path, PathBuf};
use zwidth_link::discover::{Found, Port, bauds, ports as serial_ports, who_is_at};
use zwidth_link::firmata::Pins;
use zwidth_link::framed::message::Description;

/// Lists the ports; asks those that are named who is there.
pub(crate) fn ports(named: &[PathBuf], screen: &Screen) -> anyhow::Result<Exit> {
    if named.is_empty() {
        screen.result(list_lines(&serial_ports()?));
        return Ok(Exit::Fine);
    }
    let mut silent = false;
    for port in named {
        screen.say(format!("asking {}: up to 12 s", port.display()));
        let answer = who_is_at(port)?;
        silent |= answer.is_none();
        screen.result(answer_lines(port, answer.as_ref()));
    }
    Ok(if silent { Exit::Failed } else { Exit::Fine })
}

fn list_lines(ports: &[Port]) -> String {
    let Some(first) = ports.first() else {
        return "no serial port is there: plug the board in".to_owned();
    };
    let lines = ports.iter().map(|port| match &port.usb {
        Some(usb) => format!("{}  {usb}\n", port.path.display()),
        None => format!("{}\n", port.path.display()),
    });
    let lines: String = lines.collect();
    format!("{lines}\nzwidth ports {} asks who is at that one", first.path.display())
}

/// What answered at a port, and the lines that rig.toml needs for it.
fn answer_lines(port: &Path, answer: Option<&(u32, Found)>) -> String {
    let at = port.display();
    let Some((baud, board)) = answer else {
        let bauds: Vec<String> = bauds().iter().map(u32::to_string).collect();
        return format!(
            "{at}: nothing understood at {} baud; put a firmware on the board (docs/rig.md), or \
             close what else uses the port",
            bauds.join(", ")
        );
    };
    let (what, link, more) = match board {
        Found::Framed(board) => (framed(board), "framed", ""),
        Found::Firmata(pins) => {
            (firmata(pins), "firmata", "pins in [firmata], load cell in [hx711]")
        }
        Found::Lines(line) => (format!("prints lines such as {line:?}"), "text", "form in [text]"),
    };
    let more =
        if more.is_empty() { String::new() } else { format!("   # and {more}: docs/rig.md") };
    format!(
        "{at}: {what}\n\nrig.toml for it:\n\nport = {:?}\nlink = \"{link}\"{more}\nbaud = {baud}",
        port.to_string_lossy()
    )
}

fn framed(board: &Description) -> String {
    // A board that states no period must not be divided by zero.
    let [rate_hz, force_rate_hz] =
        [board.period_us, board.force_period_us].map(|us| 1e6 / f64::from(us.max(1)));
    let [motor_v, brake_v] = [board.motor_mv, board.brake_mv].map(|mv| f64::from(mv) * 1e-3);
    let watchdog = match board.watchdog_ms {
        0 => "no watchdog".to_owned(),
        ms => format!("watchdog {ms} ms"),
    };
    let simulated = if board.simulated { ", simulated" } else { "" };
    format!(
        "{}{simulated}\n  angle {} counts per turn, up to {rate_hz:.0} readings per second, force \
         {force_rate_hz:.0} per second\n  full pulses: motor {motor_v} V, brake {brake_v} V; {watchdog}",
        board.name, board.counts_per_turn,
    )
}

fn firmata(pins: &Pins) -> String {
    let pulses: Vec<String> = pins.pulses.iter().map(u8::to_string).collect();
    let channels = pins.analog.iter().map(|(channel, bits)| format!("A{channel} ({bits} bits)"));
    let channels: Vec<String> = channels.collect();
    let i2c = if pins.i2c { "an I²C bus" } else { "no I²C bus" };
    format!(
        "{} by Firmata\n  pulses on the pins {}\n  angle at {}, or {i2c}; no watchdog",
        pins.name,
        pulses.join(", "),
        channels.join(", ")
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ports_are_listed_with_their_usb_device_and_the_way_on() {
        assert!(list_lines(&[]).contains("plug the board in"));
        let port =
            |path: &str, usb: Option<&str>| Port { path: path.into(), usb: usb.map(str::to_owned) };
        let ports = [port("/dev/ttyACM0", Some("Uno, USB 2341:0043")), port("/dev/ttyS0", None)];
        assert_eq!(
            list_lines(&ports),
            "/dev/ttyACM0  Uno, USB 2341:0043\n/dev/ttyS0\n\nzwidth ports /dev/ttyACM0 asks who is \
             at that one"
        );
    }

    #[test]
    fn what_is_told_is_a_rig_toml() {
        let pins = Pins {
            name: "StandardFirmata.ino 2.5".to_owned(),
            analog: vec![(0, 10), (1, 10)],
            pulses: vec![3, 5],
            i2c: true,
        };
        let found = [(57_600, Found::Firmata(pins)), (115_200, Found::Lines("0,1".to_owned()))];
        for found in &found {
            let text = answer_lines(Path::new("/dev/ttyACM0"), Some(found));
            let table: toml::Table =
                text.split_once("rig.toml for it:").unwrap().1.parse().unwrap();
            assert_eq!(table["port"].as_str(), Some("/dev/ttyACM0"), "{text}");
            assert_eq!(table["baud"].as_integer(), Some(found.0.into()), "{text}");
        }
        let silent = answer_lines(Path::new("/dev/ttyACM0"), None);
        assert!(silent.contains("57600, 115200, 500000, 1000000 baud"), "{silent}");
    }
}
