//! A cable that is pulled and plugged in again.

use super::{environments, settings};
use crate::simulated::{Bench, Trouble, Way};
use crate::{AngleAt, Board, Link, Settings, over};
use zwidth_device::Device;
use zwidth_device::mock::{self, Mock, Motion};
use zwidth_study::Voltages;

const ON: Voltages = Voltages { motor_v: 3.0, brake_v: 0.0 };
/// The cable is out for so long, s.
const OUT_S: f64 = 1.0;

fn at_rest() -> Mock {
    const REST: Motion = |_| (-std::f64::consts::FRAC_PI_4, 0.0);
    Mock::new(REST)
}

fn every() -> [Settings; 3] {
    let of = |link| {
        Settings::of_board(link, AngleAt::I2c, 100.0, &mock::capabilities(), "/dev/cell".as_ref())
    };
    [settings(), of(Link::Firmata), of(Link::Text)]
}

type Connected = (Bench, Box<dyn Device>);

fn connect(settings: &Settings) -> Connected {
    let board = Board::by(settings, at_rest(), environments()).unwrap();
    let bench = Bench::new(board, settings.baud(), 115_200, 0.0);
    let cell = settings.hx711.is_some().then(|| bench.cell());
    let mut rig = over(bench.wire(), cell, settings, Vec::new()).unwrap();
    rig.home(bench.now_s()).unwrap();
    rig.write(bench.now_s(), ON).unwrap();
    bench.wait(0.01);
    assert!(bench.drive().motor > 0);
    (bench, rig)
}

/// Pulls a cable while a command is said, and has the host find out.
fn pull((bench, rig): &mut Connected, way: Way) -> String {
    bench.trouble(way, bench.said(way), Trouble::Unplug(OUT_S));
    for _ in 0..100 {
        bench.wait(0.01);
        if let Err(error) = rig.write(bench.now_s(), ON) {
            return error.to_string();
        }
        if let Err(error) = rig.read(bench.now_s()) {
            return error.to_string();
        }
    }
    panic!("nobody noticed");
}

#[test]
fn a_cable_that_is_out_is_told_and_once_it_is_in_again_homing_goes_on() {
    for settings in every() {
        let mut connected = connect(&settings);
        let told = pull(&mut connected, Way::ToBoard);
        assert!(told.contains("home again"), "{told}");
        let (bench, mut rig) = connected;
        let refused = rig.home(bench.now_s()).unwrap_err().to_string();
        assert!(refused.contains("plug the board in"), "{refused}");
        bench.wait(0.1);
        let watched = rig.capabilities().watchdog_s.is_some();
        assert_eq!(bench.drive().motor == 0, watched, "{settings:?}");
        bench.wait(OUT_S);
        rig.home(bench.now_s()).unwrap();
        assert_eq!(bench.drive().motor, 0);
        rig.write(bench.now_s(), ON).unwrap();
        bench.wait(0.01);
        rig.read(bench.now_s()).unwrap();
        assert!(bench.drive().motor > 0);
    }
}

#[test]
fn a_load_cell_s_cable_is_one_of_them() {
    let settings = every()[1].clone();
    let mut connected = connect(&settings);
    let told = pull(&mut connected, Way::Cell);
    assert!(told.contains("load cell"), "{told}");
    let (bench, mut rig) = connected;
    bench.wait(2.0 * OUT_S);
    rig.home(bench.now_s()).unwrap();
    rig.read(bench.now_s()).unwrap();
}

#[test]
fn another_board_at_the_same_port_is_refused() {
    let mut connected = connect(&settings());
    pull(&mut connected, Way::ToBoard);
    let (bench, mut rig) = connected;
    let mut other = at_rest();
    other.capabilities.name = "another".to_owned();
    bench.replace(Board::new(other, environments()));
    bench.wait(2.0 * OUT_S);
    let refused = rig.home(bench.now_s()).unwrap_err().to_string();
    assert!(refused.contains("another board") && refused.contains("began with"), "{refused}");
    bench.replace(Board::new(at_rest(), environments()));
    rig.home(bench.now_s()).unwrap();
}
