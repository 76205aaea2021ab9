//! Whole maps of the simulated device without friction.

use super::*;
use zwidth_dynamics::{DryLimits, SampledWall};
use zwidth_results::{
    BoundaryExtent, LimitKind, LimitName, LimitPoint, StiffestWall, WallLimit, WallQuantity,
};

fn point() -> Point {
    let wall = SampledWall { stiffness_n_per_m: 300.0, ..SampledWall::bare(0.0972, 2.6, 8.3e-3) };
    let dry = Some(DryLimits { friction_n: 0.15, count_m: 1e-5 });
    Point { wall, lever_m: 0.045, step_s: 8.3e-3, dry }
}

fn spans(x: WallQuantity, y: WallQuantity, cells: usize) -> [Span; 2] {
    [Span::usual(x, cells), Span::usual(y, cells)]
}

#[test]
fn the_line_of_the_lifted_map_goes_through_the_stiffest_wall_at_each_delay() {
    let [x, y] = spans(WallQuantity::Delay, WallQuantity::Stiffness, 31);
    let map = map(&point(), x, y).unwrap();
    let curves = curves(&map);
    let exact = curves.iter().find(|curve| curve.kind == LimitKind::Exact).unwrap();
    let points = exact.pieces.concat();
    assert!(points.len() > 25);
    for [delay_s, k] in points.iter().step_by(5) {
        let wall = SampledWall { delay_s: *delay_s, ..point().wall };
        let stiffest = wall.stiffest_stable().unwrap().unwrap();
        assert!((k / stiffest - 1.0).abs() < 2e-3, "{delay_s}: {k}, not {stiffest}");
    }
    let has = |limit| curves.iter().any(|curve| curve.limit == LimitName::Computed(limit));
    assert!(has(WallLimit::Diolaiti) && has(WallLimit::Hulin), "{curves:?}");
    let rows = limit_points(&map, &curves);
    assert_eq!(curves_table(&rows).unwrap().to_rows::<LimitPoint>().unwrap(), rows);
}

#[test]
fn the_stable_area_ends_at_the_line_of_the_lifted_map() {
    let [x, y] = spans(WallQuantity::Delay, WallQuantity::Stiffness, 61);
    let map = map(&point(), x, y).unwrap();
    let areas = map.stable();
    assert_eq!(areas.len(), 1, "stable below, unstable above");
    let step = libm::log(y.ends[1] / y.ends[0]) / 60.0;
    for i in (0..61).step_by(6) {
        let wall = SampledWall { delay_s: areas[0].x[i], ..point().wall };
        let stiffest = wall.stiffest_stable().unwrap().unwrap();
        let below = libm::log(stiffest / areas[0].high[i]);
        assert!((0.0..=step).contains(&below), "{}: {below}", areas[0].x[i]);
        assert!((areas[0].low[i] / y.ends[0] - 1.0).abs() < 1e-12);
    }
}

#[test]
fn the_measured_points_lie_on_the_line_to_half_a_percent() {
    let [x, y] = spans(WallQuantity::WallDamping, WallQuantity::Stiffness, 24);
    let x = Span { ends: [0.0, 6.0], ..x };
    let map = map(&point(), x, y).unwrap();
    let points = measured(&map).unwrap().pieces.concat();
    assert!(points.len() >= 9, "{points:?}");
    for [b, k] in points {
        let wall = SampledWall { wall_damping_ns_per_m: b, ..point().wall };
        let stiffest = wall.stiffest_stable().unwrap().unwrap();
        if stiffest > 100.0 {
            assert!((k / stiffest - 1.0).abs() < 5e-3, "B = {b}: {k}, not {stiffest}");
        }
    }
}

#[test]
fn each_limit_has_its_error_and_the_textbook_that_allows_too_much_is_named() {
    let late = SampledWall { wall_damping_ns_per_m: 2.0, delay_s: 8.3e-3, ..point().wall };
    let limits = limits(&Point { wall: late, ..point() }).unwrap();
    let of = |wanted| limits.iter().find(|limit| limit.limit == wanted).unwrap();
    assert!((of(WallLimit::LiftedMap).stiffness_n_per_m.unwrap() - 328.583_824).abs() < 1e-4);
    assert!((of(WallLimit::Hulin).stiffness_n_per_m.unwrap() - 369.477_9).abs() < 1e-3);
    assert_eq!(of(WallLimit::Hulin).is_unsafe, Some(true));
    assert_eq!(of(WallLimit::Passivity).is_unsafe, Some(false));
    assert_eq!(of(WallLimit::AbbottOkamura).stiffness_n_per_m, None);
    assert!(of(WallLimit::Measured).error_share.unwrap().abs() < 5e-3);
    assert_eq!(of(WallLimit::Measured).is_unsafe, None);
    assert_eq!(limits.len(), 7);
    assert_eq!(limits_table(&limits).unwrap().to_rows::<StiffestWall>().unwrap(), limits);
}

#[test]
fn a_lever_twice_as_long_is_half_as_stiff_at_its_end() {
    let long = point().with(WallQuantity::Lever, 0.09);
    assert!((long.wall.stiffness_n_per_m - 150.0).abs() < 1e-12);
    assert!((long.wall.damping_ns_per_m - 1.3).abs() < 1e-12);
}

#[test]
fn an_axis_that_makes_no_sense_is_an_error_that_says_so() {
    let [x, y] = spans(WallQuantity::Delay, WallQuantity::Stiffness, 5);
    let error = |x, y| map(&point(), x, y).unwrap_err().to_string();
    assert!(error(x, x).contains("both axes are delay"));
    assert!(error(x, Span { ends: [0.0, 5.0], ..y }).contains("stiffness from 0 to 5"));
    assert!(error(Span { cells: 1, ..x }, y).contains("1 cells"));
}

#[test]
fn a_cell_without_a_limit_is_empty_in_the_table_and_nothing_is_no_number() {
    let [x, y] = spans(WallQuantity::Delay, WallQuantity::Rate, 9);
    let map = map(&point(), x, y).unwrap();
    let rows = cells(&map);
    assert_eq!(rows.len(), 81);
    assert!(rows.iter().any(|cell| cell.lifted_map.is_none()), "more than 25 periods of delay");
    let table = cells_table(&map).unwrap();
    assert_eq!((table.height(), table.title()), (81, "rate against delay"));
    let of_places: Vec<_> = table.fields().take(2).map(|f| (&*f.name, &*f.unit)).collect();
    assert_eq!(of_places, [("delay", "s"), ("rate", "Hz")]);
}

#[test]
fn the_extent_of_a_boundary_comes_back_from_its_table() {
    let boundary = Boundary::from_csv("K,B\n4.0,0.0\n2.0,0.5\n0.0,1.0\n", 1.0).unwrap();
    let rows = [extent("triangle", &boundary)];
    assert_eq!((rows[0].fullness, rows[0].is_si), (Some(0.5), false));
    assert_eq!(extents_table(&rows).unwrap().to_rows::<BoundaryExtent>().unwrap(), rows);
}
