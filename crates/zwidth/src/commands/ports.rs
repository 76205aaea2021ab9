//! `zwidth ports`: which serial ports there are, and which board is at one.

use crate::exit::Exit;
use crate::screen::Screen;
use std::path::{Path, PathBuf};
use zwidth_link::discover::{Found, Port, bauds, ports as known, who_is_at};
use zwidth_link::firmata::Pins;
use zwidth_link::framed::message::Description;

/// Lists the ports; asks those that are named who is there.
pub(crate) fn ports(named: &[PathBuf], screen: &Screen) -> anyhow::Result<Exit> {
    if named.is_empty() {
        screen.result(listed(&known()?));
        return Ok(Exit::Fine);
    }
    let mut silent = false;
    for port in named {
        screen.say(format!("asking {}: up to 12 s", port.display()));
        let found = who_is_at(port)?;
        silent |= found.is_none();
        screen.result(told(port, found.as_ref()));
    }
    Ok(if silent { Exit::Failed } else { Exit::Fine })
}

fn listed(ports: &[Port]) -> String {
    let Some(first) = ports.first() else {
        return "no serial port is there: plug the board in".to_owned();
    };
    let line = |port: &Port| match &port.usb {
        Some(usb) => format!("{}  {usb}\n", port.path.display()),
        None => format!("{}\n", port.path.display()),
    };
    let lines: String = ports.iter().map(line).collect();
    format!("{lines}\nzwidth ports {} asks who is at that one", first.path.display())
}

/// What was found at a port, and what rig.toml says for it.
fn told(port: &Path, found: Option<&(u32, Found)>) -> String {
    let at = port.display();
    let Some((baud, found)) = found else {
        let bauds: Vec<String> = bauds().iter().map(u32::to_string).collect();
        return format!(
            "{at}: nothing understood at {} baud; put a firmware on the board (docs/rig.md), or \
             close what else uses the port",
            bauds.join(", ")
        );
    };
    let (what, link, more) = match found {
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
    let hz = |period_us: u32| 1e6 / f64::from(period_us.max(1));
    let volts = |millivolts: u32| f64::from(millivolts) * 1e-3;
    let watchdog = match board.watchdog_ms {
        0 => "no watchdog".to_owned(),
        ms => format!("watchdog {ms} ms"),
    };
    let simulated = if board.simulated { ", simulated" } else { "" };
    format!(
        "{}{simulated}\n  angle {} counts per turn, up to {:.0} readings per second, force {:.0} per \
         second\n  full pulses: motor {} V, brake {} V; {watchdog}",
        board.name,
        board.counts_per_turn,
        hz(board.period_us),
        hz(board.force_period_us),
        volts(board.motor_mv),
        volts(board.brake_mv)
    )
}

fn firmata(pins: &Pins) -> String {
    let list = |pins: &[u8]| pins.iter().map(u8::to_string).collect::<Vec<_>>().join(", ");
    let channels = pins.analog.iter().map(|(channel, bits)| format!("A{channel} ({bits} bits)"));
    let channels: Vec<String> = channels.collect();
    let i2c = if pins.i2c { "an I²C bus" } else { "no I²C bus" };
    format!(
        "{} by Firmata\n  pulses on the pins {}\n  angle at {}, or {i2c}; no watchdog",
        pins.name,
        list(&pins.pulses),
        channels.join(", ")
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ports_are_listed_with_their_usb_device_and_the_way_on() {
        assert!(listed(&[]).contains("plug the board in"));
        let port =
            |path: &str, usb: Option<&str>| Port { path: path.into(), usb: usb.map(str::to_owned) };
        let ports = [port("/dev/ttyACM0", Some("Uno, USB 2341:0043")), port("/dev/ttyS0", None)];
        assert_eq!(
            listed(&ports),
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
            let text = told(Path::new("/dev/ttyACM0"), Some(found));
            let table: toml::Table =
                text.split_once("rig.toml for it:").unwrap().1.parse().unwrap();
            assert_eq!(table["port"].as_str(), Some("/dev/ttyACM0"), "{text}");
            assert_eq!(table["baud"].as_integer(), Some(found.0.into()), "{text}");
        }
        let silent = told(Path::new("/dev/ttyACM0"), None);
        assert!(silent.contains("57600, 115200, 500000, 1000000 baud"), "{silent}");
    }
}
