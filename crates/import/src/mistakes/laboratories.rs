//! Files of laboratories: TDMS, C3D, MCAP and OpenSim's, as they are cut off, mixed up or mistaken.

use super::super::c3d::tests as c3d;
use super::super::mcap::tests as mcap;
use super::super::tdms::tests as tdms;
use super::super::world::{FORCE, ONE, trials_map};
use super::{Row, mapped};

pub(super) fn laboratories() -> Vec<Row> {
    let renamed = |keys: &str, time: &str, force: &str| {
        let columns = FORCE
            .replace("\"t\"", &format!("\"{time}\""))
            .replace("\"f\"", &format!("\"{force}\""));
        trials_map(&[keys, ONE, &columns])
    };
    let of_two = tdms::of_two(0.5, &[0.1, 0.2, 0.3], &[1.5, -2.0, 4.0]);
    let both = tdms::of_two_rates();
    let rig = renamed("[file]\ngroup = \"rig\"\n", "time_s", "F");
    let points = c3d::of_points_and_forces();
    let analog = renamed("[file]\ngroup = \"analog\"\n", "time_s", "Fx");
    let stamps = |unit: &str| {
        renamed("", "header.stamp", "wrench.force.x")
            .replace("unit = \"s\"", &format!("unit = \"{unit}\"\nzero = \"first\""))
    };
    let motion = |head: &str| {
        format!("Coordinates\n{head}endheader\nt\telbow\tf\n0\t1\t1.5\n0.5\t2\t-2\n1\t3\t4\n")
    };
    let angle = "[[column]]\nto = \"theta_rad\"\nfrom = \"elbow\"\nunit = \"rad\"\n";
    let usual = trials_map(&[ONE, FORCE]);
    vec![
        mapped("a TDMS file of a rig", rig.clone(), "a.tdms", &of_two),
        mapped("a TDMS file that LabVIEW never closed", rig, "a.tdms", &of_two[..of_two.len() - 4]),
        mapped(
            "TDMS channels of two rates in one trial",
            renamed("", "time_s", "fast/F").replace(FORCE_UNIT, SLOW),
            "a.tdms",
            both,
        ),
        mapped("C3D forces at a rate of their own", analog.clone(), "a.c3d", &points),
        mapped("a C3D file that is cut off", analog, "a.c3d", &points[..points.len() - 1]),
        mapped(
            "C3D points and forces of two rates in one trial",
            renamed("", "time_s", "analog/Fx").replace(FORCE_UNIT, POINT),
            "a.c3d",
            points,
        ),
        mapped("a wrench of ROS 2 at its stamps", stamps("ns"), "a.mcap", mcap::of_two_wrenches()),
        mapped("stamps of ROS 2 taken for seconds", stamps("s"), "a.mcap", mcap::of_two_wrenches()),
        mapped("an MCAP file whose recorder was killed", stamps("ns"), "a.mcap", mcap::killed()),
        mapped("an OpenSim file", usual.clone(), "a.sto", motion("nRows=3\nnColumns=3\n")),
        mapped(
            "an OpenSim file in degrees, taken for radians",
            trials_map(&[ONE, FORCE, angle]),
            "a.mot",
            motion("inDegrees=yes\n"),
        ),
        mapped("an OpenSim file whose head counts wrong", usual, "a.sto", motion("nRows=4\n")),
    ]
}

/// The end of a mapping of a force, and a second column behind it.
const FORCE_UNIT: &str = "unit = \"N\"\n";
const SLOW: &str =
    "unit = \"N\"\n[[column]]\nto = \"theta_rad\"\nfrom = \"slow/angle\"\nunit = \"rad\"\n";
const POINT: &str =
    "unit = \"N\"\n[[column]]\nto = \"theta_rad\"\nfrom = \"points/hand.x\"\nunit = \"rad\"\n";
