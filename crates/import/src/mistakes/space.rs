//! Recordings of a device with several axes.

use super::super::world::{ONE, column, trials_map};
use super::{Row, mapped_csv};
use std::fmt::Write as _;

/// Of a study with axes.
pub(super) const AXES: &str =
    "\n[axes]\nframe = \"x right, y up, z to the person\"\npush = [0, 0, -1]\n";

/// Columns of positions, in this unit, and of forces.
fn pose(unit: &str) -> String {
    let positions = ["x", "y", "z"].map(|axis| column(&format!("{axis}_m"), axis, unit));
    let forces =
        ["x", "y", "z"].map(|axis| column(&format!("force_{axis}_n"), &format!("f{axis}"), "N"));
    positions.concat() + &forces.concat()
}

fn map(columns: &str) -> String {
    trials_map(&[ONE, "[time]\nfrom = \"t\"\nunit = \"s\"\n", columns])
}

/// Two seconds of a circle of 50 mm at 100 Hz, in mm, with a force along it.
fn circle(change: fn(usize, [f64; 3]) -> [f64; 3]) -> String {
    let mut text = String::from("t,x,y,z,fx,fy,fz,roll,tx\n");
    for i in 0..200_u32 {
        let t = f64::from(i) / 100.0;
        let (sin, cos) = libm::sincos(5.0 * t);
        let [x, y, z] = change(i as usize, [50.0 * cos, 50.0 * sin, 10.0 * t]);
        let _ = writeln!(text, "{t},{x},{y},{z},{},{cos},{},0,0", -sin, 0.5 * cos);
    }
    text
}

pub(super) fn axes() -> Vec<Row> {
    let good = || circle(|_, place| place);
    let along = "[[column]]\nto = \"theta_rad\"\nderive = \"along push\"\n";
    let x_alone = column("x_m", "x", "mm") + &column("y_m", "y", "mm") + along;
    let rows = vec![
        mapped_csv("positions in several axes", map(&pose("mm")), good()),
        mapped_csv("an orientation for a column", map(&column("roll_rad", "roll", "rad")), good()),
        mapped_csv("a moment for a force", map(&column("force_x_n", "tx", "N·m")), good()),
        mapped_csv(
            "a projection on a push along an axis that is not mapped",
            map(&x_alone),
            good(),
        ),
        mapped_csv("millimetres of a position taken for metres", map(&pose("m")), good()),
        mapped_csv(
            "a lost marker",
            map(&pose("mm")),
            circle(|i, [x, y, z]| if i == 70 { [800.0, y, z] } else { [x, y, z] }),
        ),
        mapped_csv(
            "an axis that stands still",
            map(&pose("mm")),
            circle(|_, [x, y, _]| [x, y, 12.5]),
        ),
    ];
    let rows = rows.into_iter().map(|row| Row { has_axes: true, ..row });
    let without = "positions in several axes, in a study without axes";
    rows.chain([mapped_csv(without, map(&pose("mm")), good())]).collect()
}
