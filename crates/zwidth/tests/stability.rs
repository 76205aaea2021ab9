//! `zwidth stability` and `zwidth characterise STUDY impedance` as a person types them.

#![allow(clippy::unwrap_used)] // helpers outside of a test function are test code too

mod common;

use common::{fresh, text, zwidth};

#[test]
fn a_map_a_table_of_limits_and_the_textbook_that_is_unsafe() {
    let root = fresh("stability_map");
    let beside = root.join("KB.csv");
    std::fs::write(&beside, "K,B\n4.0,0.0\n2.0,0.5\n0.0,1.0\n").unwrap();
    let pair = ["--x", "wall_damping=0..6", "--y", "stiffness", "--cells", "9"];
    let at = ["--at", "delay=0.0083", "--at", "wall_damping=2"];
    let asked = [&["stability"][..], &pair, &at, &["--beside", beside.to_str().unwrap()]].concat();
    let output = zwidth(&root, &asked);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let told = text(&output.stdout);
    assert!(told.contains("UNSAFE") && told.contains("KB, measured by others: K(0) 4"), "{told}");
    assert!(told.contains("(their units), 50.0 % of the rectangle"), "{told}");
    let reports = root.join("reports/stability");
    for name in ["twin.svg", "twin.limits.csv", "twin.curves.parquet", "measured_by_others.png"] {
        assert!(reports.join(name).exists(), "{name}");
    }
    let cells = std::fs::read_to_string(reports.join("twin.wall_damping_stiffness.csv")).unwrap();
    assert_eq!(cells.lines().filter(|line| !line.starts_with('#')).count(), 1 + 81);
}

#[test]
fn a_boundary_of_known_units_is_a_line_on_the_map() {
    let root = fresh("stability_beside");
    let beside = root.join("lab.csv");
    std::fs::write(&beside, "K_n_per_m,B_ns_per_m\n700,0\n500,2\n0,5\n").unwrap();
    let pair = ["--x", "wall_damping=0..6", "--y", "stiffness", "--cells", "5"];
    let asked = [&["stability"][..], &pair, &["--beside", beside.to_str().unwrap()]].concat();
    let output = zwidth(&root, &asked);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert!(text(&output.stdout).contains("(N/m and N s/m)"), "{}", text(&output.stdout));
    let curves = std::fs::read_to_string(root.join("reports/stability/twin.curves.csv")).unwrap();
    assert_eq!(curves.lines().filter(|line| line.contains(",lab,others,")).count(), 2);
}

#[test]
fn what_makes_no_sense_is_one_error() {
    let root = fresh("stability_bad");
    for (arguments, words) in [
        (&["--at", "mass=0"][..], "mass_kg is 0"),
        (&["--x", "delay", "--y", "delay"], "both axes are delay"),
        (&["--at", "delay=1"], "at most 25 periods"),
        (&["--beside", "no.csv"], "no.csv"),
    ] {
        let output = zwidth(&root, &[&["stability"], arguments].concat());
        assert_eq!(output.status.code(), Some(1), "{arguments:?}");
        assert!(text(&output.stderr).contains(words), "{}", text(&output.stderr));
    }
}

#[test]
fn a_z_width_test_that_was_cut_short_goes_on_where_it_was_left_with_the_same_result() {
    let root = fresh("zwidth_test");
    assert_eq!(zwidth(&root, &["new", "lab"]).status.code(), Some(0));
    let asked = ["characterise", "lab", "impedance"];
    let first = zwidth(&root, &asked);
    assert_eq!(first.status.code(), Some(0), "{}", text(&first.stderr));
    assert!(text(&first.stdout).contains("active, push 5 mm: K(0) "), "{}", text(&first.stdout));
    let table = root.join("reports/lab/impedance/zwidth.csv");
    let known = std::fs::read(&table).unwrap();
    let sweeps = root.join("raw/lab/sweeps/actuator=impedance");
    let again = zwidth(&root, &asked);
    assert!(text(&again.stderr).contains("searches were there"), "{}", text(&again.stderr));
    assert_eq!(std::fs::read(&table).unwrap(), known);
    assert!(std::fs::read_dir(&sweeps).unwrap().count() >= 48);
    let verified = zwidth(&root, &["verify", "lab"]);
    assert_eq!(verified.status.code(), Some(0), "{}", text(&verified.stderr));
}

#[test]
fn a_study_s_trials_are_asked_whether_what_swings_in_them_was_real() {
    let root = fresh("stability_recorded");
    let twin = ["twin", "lab", "--participants", "1", "--sessions", "1", "--seed", "2"];
    assert_eq!(zwidth(&root, &twin).status.code(), Some(0));
    let all = zwidth(&root, &["stability", "--study", "lab"]);
    assert_eq!(all.status.code(), Some(0), "{}", text(&all.stderr));
    let told = text(&all.stdout);
    assert!(
        told.contains(" no oscillation") && told.contains("plant is the thesis', by eye"),
        "{told}"
    );
    let table =
        std::fs::read_to_string(root.join("reports/lab/stability/oscillations.csv")).unwrap();
    let rows = table.lines().filter(|line| line.starts_with("P01,S01,")).count();
    assert!(told.contains(&format!("{rows} trials: ")) && rows > 10, "{told}");
    let one = ["stability", "--study", "lab", "-p", "P01", "-s", "S01", "--trial", "4", "--json"];
    let one = zwidth(&root, &one);
    assert!(text(&one.stdout).contains("\"trial\": 4"), "{}", text(&one.stdout));
    let none = ["stability", "--study", "lab", "-p", "P01", "-s", "S01", "--trial", "999"];
    let none = zwidth(&root, &none);
    assert_eq!(none.status.code(), Some(1));
    assert!(text(&none.stderr).contains("no trial that counts: P01 S01 trial 999"));
    let alone = zwidth(&root, &["stability", "--trial", "3"]);
    assert_eq!(alone.status.code(), Some(2));
}
