use super::super::limits::tests::everything;
use super::super::table::Cell;
use super::chunks::BOUNDARY;
use super::*;

pub(in super::super) fn length(n: usize) -> Vec<u8> {
    let n = u32::try_from(n).unwrap();
    [&[4][..], &n.to_le_bytes()].concat()
}

pub(in super::super) fn chunk(tag: u16, stream: Option<u32>, content: &[u8]) -> Vec<u8> {
    let stream = stream.map(|stream| stream.to_le_bytes().to_vec()).unwrap_or_default();
    let inner = [&tag.to_le_bytes()[..], &stream, content].concat();
    [length(inner.len()), inner].concat()
}

fn boundary() -> Vec<u8> {
    chunk(5, None, &BOUNDARY)
}

pub(in super::super) fn header(
    number: u32,
    name: &str,
    channels: usize,
    rate: f64,
    format: &str,
    desc: &str,
) -> Vec<u8> {
    let xml = format!(
        "<?xml version=\"1.0\"?>\n<info>\n <name>{name}</name><type>EEG</type>\n <channel_count>{channels}</channel_count>\n\
         <nominal_srate>{rate}</nominal_srate><channel_format>{format}</channel_format><desc>{desc}</desc>\n</info>"
    );
    chunk(2, Some(number), xml.as_bytes())
}

/// Samples of `f32`, with a time where one is given.
pub(in super::super) fn samples(number: u32, rows: &[(Option<f64>, &[f32])]) -> Vec<u8> {
    let mut content = length(rows.len());
    for (time, values) in rows {
        match time {
            Some(t) => content.extend([&[8][..], &t.to_le_bytes()].concat()),
            None => content.push(0),
        }
        content.extend(values.iter().flat_map(|v| v.to_le_bytes()));
    }
    chunk(3, Some(number), &content)
}

pub(in super::super) fn offset(number: u32, t: f64, value: f64) -> Vec<u8> {
    chunk(4, Some(number), &[t.to_le_bytes(), value.to_le_bytes()].concat())
}

const LABELS: &str =
    "<channels><channel><label>F &amp; x</label><unit>N</unit></channel><channel/></channels>";

/// A stream of two channels without a rate, in two chunks with a boundary between, and one of
/// markers.
pub(in super::super) fn parts() -> Vec<Vec<u8>> {
    let marker = [&length(1)[..], &[8], &10.5_f64.to_le_bytes(), &[1, 4], b"go\xc3\xa4"].concat();
    vec![
        b"XDF:".to_vec(),
        chunk(1, None, b"<info><version>1.0</version></info>"),
        header(1, "rig", 2, 0.0, "float32", LABELS),
        header(7, "marks", 1, 0.0, "string", ""),
        samples(1, &[(Some(10.0), &[0.5, 1.0]), (Some(10.5), &[1.5, 2.0])]),
        chunk(3, Some(7), &marker),
        boundary(),
        samples(1, &[(Some(11.0), &[2.5, 3.0])]),
        offset(1, 10.0, 100.0),
        chunk(6, Some(1), b"<info><sample_count>3</sample_count></info>"),
    ]
}

/// One stream at 100 Hz whose samples have these times, and these clock offsets.
pub(in super::super) fn steady(
    times: impl Iterator<Item = f64>,
    offsets: &[(f64, f64)],
) -> Vec<u8> {
    steady_of("<channel><label>load</label></channel>", times, offsets)
}

/// The same with a channel that is described so.
pub(in super::super) fn steady_of(
    channel: &str,
    times: impl Iterator<Item = f64>,
    offsets: &[(f64, f64)],
) -> Vec<u8> {
    let values: Vec<(f64, [f32; 1])> =
        times.enumerate().map(|(i, t)| (t, [(i as f32 * 0.1).sin()])).collect();
    let rows: Vec<(Option<f64>, &[f32])> =
        values.iter().map(|(t, value)| (Some(*t), value.as_slice())).collect();
    let channels = format!("<channels>{channel}</channels>");
    let mut file =
        [b"XDF:".to_vec(), chunk(1, None, b"<info><version>1.0</version></info>")].concat();
    file.extend(header(1, "rig", 1, 100.0, "float32", &channels));
    file.extend(samples(1, &rows));
    offsets.iter().for_each(|(t, value)| file.extend(offset(1, *t, *value)));
    file
}

fn try_read(bytes: &[u8], stream: Option<&str>) -> Result<Table, StoreError> {
    everything(|take| {
        super::read(Path::new("a.xdf"), bytes, stream, XdfClock::Corrected, true, take)
    })
}

fn rig(parts: &[Vec<u8>]) -> Table {
    try_read(&parts.concat(), Some("rig")).unwrap()
}

fn column(table: &Table, place: usize) -> Vec<f64> {
    let cells = &table.columns[place];
    let number = |row| match cells.cell(row) {
        Cell::Number(value) => value,
        other => panic!("{other:?}"),
    };
    (0..cells.len()).map(number).collect()
}

#[test]
fn a_stream_is_its_times_on_the_recorders_clock_and_its_channels_by_label() {
    let table = rig(&parts());
    assert_eq!(table.names.as_ref().unwrap()[..], ["time_s", "F & x", "channel_2"]);
    assert_eq!(column(&table, 0), [110.0, 110.5, 111.0]);
    assert_eq!((column(&table, 1), column(&table, 2)), (vec![0.5, 1.5, 2.5], vec![1.0, 2.0, 3.0]));
    assert_eq!(table.told, Vec::<String>::new());
    let marks = try_read(&parts().concat(), Some("7")).unwrap();
    assert_eq!(marks.columns[1].cell(0), Cell::Text("goä"));
    assert_eq!(marks.told, ["no clock offsets were recorded: times are on the stream's own clock"]);
}

#[test]
fn a_regular_stream_whose_samples_have_no_times_goes_by_its_rate() {
    let parts = [
        b"XDF:".to_vec(),
        header(3, "rig", 1, 4.0, "float32", ""),
        samples(3, &[(Some(2.0), &[0.0]), (None, &[0.0]), (None, &[0.0])]),
    ];
    let table = try_read(&parts.concat(), None).unwrap();
    assert_eq!(column(&table, 0), [2.0, 2.25, 2.5]);
}

#[test]
fn which_stream_is_meant_must_be_plain() {
    let check = |bytes: &[u8], stream, words: &str| {
        let error = try_read(bytes, stream).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    };
    let whole = parts().concat();
    check(&whole, None, "2 streams have samples: 1 'rig', 7 'marks'; set stream in [file]");
    check(&whole, Some("x"), "there is no stream 'x'; the file has 1 'rig', 7 'marks'");
    check(b"XDF:", None, "the file has no stream");
    check(b"t,f\n", None, "does not begin with 'XDF:'");
    check(b"\x1f\x8b\x08", None, "compressed with gzip (.xdfz); unpack it");
}

#[test]
fn a_file_cut_anywhere_is_read_as_far_as_it_goes_and_says_so() {
    let parts = parts();
    let whole = parts.concat();
    let from = parts[..4].concat().len();
    let ends: Vec<usize> = (0..=parts.len()).map(|n| parts[..n].concat().len()).collect();
    for cut in from..whole.len() {
        let table = try_read(&whole[..cut], Some("rig")).unwrap();
        assert_eq!(ends.contains(&cut), !table.told.iter().any(|told| told.contains("cut off")));
        let times = column(&table, 0);
        assert!(times.len() <= 3 && times.len() == column(&table, 1).len());
    }
    // Its second sample lacks its last byte.
    let cut = parts[..5].concat().len() - 1;
    let table = try_read(&whole[..cut], Some("rig")).unwrap();
    assert_eq!(column(&table, 1), [0.5]);
    assert!(table.told.contains(&"1 samples of damaged chunks are lost, 1 are read".to_owned()));
}

#[test]
fn what_is_damaged_is_passed_by_up_to_the_next_boundary() {
    let mut parts = parts();
    // A length that is none, in the first chunk of samples.
    parts[4][0] = 3;
    let bytes = parts[4..7].concat().len();
    let table = rig(&parts);
    assert_eq!(column(&table, 1), [2.5]);
    let told = table.told.join("\n");
    assert!(told.contains(&format!("damaged: {bytes} bytes from byte")), "{told}");
    assert!(told.contains("footer counts 3 samples, and 1 are read"), "{told}");
}

#[test]
fn no_claim_takes_memory_or_time() {
    let mut long = length(0);
    long[1..].copy_from_slice(&u32::MAX.to_le_bytes());
    let claims = chunk(3, Some(1), &long);
    let parts = [b"XDF:".to_vec(), header(1, "rig", 1, 0.0, "int8", ""), claims];
    let table = try_read(&parts.concat(), Some("rig")).unwrap();
    assert!(
        table
            .told
            .contains(&"4294967295 samples of damaged chunks are lost, 0 are read".to_owned())
    );
    for (channels, rate, format) in
        [(0, "1", "int8"), (1, "x", "int8"), (1, "1", "cf64"), (1 << 20, "1", "int8")]
    {
        let xml = format!(
            "<info><channel_count>{channels}</channel_count><nominal_srate>{rate}</nominal_srate><channel_format>{format}</channel_format></info>"
        );
        let parts = [b"XDF:".to_vec(), chunk(2, Some(1), xml.as_bytes())];
        let error = try_read(&parts.concat(), Some("1")).unwrap_err().to_string();
        assert!(error.contains("the header of stream 1 cannot be read: its "), "{error}");
    }
}

#[test]
fn a_flipped_bit_never_ends_the_program() {
    let whole = parts().concat();
    for i in 0..whole.len() {
        let mut bad = whole.clone();
        bad[i] ^= 1 << (i % 8);
        let _ = try_read(&bad, Some("rig"));
        let _ = try_read(&bad, None);
    }
}

#[test]
fn times_are_those_that_the_mapping_asks_for() {
    let file = steady(
        (0..200).map(|i| 0.01 * f64::from(i) + if i >= 100 { 0.5 } else { 0.0 }),
        &[(0.0, 7.0)],
    );
    let last = |clock, dejitter| {
        let table =
            everything(|take| super::read(Path::new("a.xdf"), &file, None, clock, dejitter, take));
        let table = table.unwrap();
        let Cell::Number(last) = table.columns[0].cell(199) else { panic!("no number") };
        (last, table.doubts)
    };
    let near = |found: f64, expect: f64| assert!((found - expect).abs() < 1e-6, "{found} {expect}");
    let (recorded, doubts) = last(XdfClock::Recorded, false);
    near(recorded, 2.49);
    assert!(doubts.is_empty(), "a gap stays in the times: {doubts:?}");
    let (nominal, doubts) = last(XdfClock::Nominal, false);
    near(nominal, 1.99);
    assert!(doubts[0].contains("its samples take 1.99 s, and by their times 2.49 s"), "{doubts:?}");
    let (corrected, doubts) = last(XdfClock::Corrected, true);
    near(corrected, 9.49);
    assert!(
        doubts[0].contains("0.50 s (50 samples at 100 Hz) are missing behind sample 100"),
        "{doubts:?}"
    );
}

/// Some number from 0 to 1 for each place.
fn scattered(i: usize) -> f64 {
    (((i as f64 + 1.0) * 12.9898).sin() * 43_758.545_3).rem_euclid(1.0)
}

/// Clock offsets at these values, one each 2.5 s.
fn offsets_of(values: &[f64]) -> Vec<(f64, f64)> {
    values.iter().enumerate().map(|(i, value)| (2.5 * i as f64, *value)).collect()
}

/// Reads a stream at 100 Hz, whose times are as expected from its first sample on; what is told of
/// it.
fn reads_as(
    stamps: &[f64],
    offsets: &[(f64, f64)],
    within_s: f64,
    expect: impl Fn(usize) -> f64,
) -> String {
    let file = steady(stamps.iter().copied(), offsets);
    let table = try_read(&file, None).unwrap();
    let times = column(&table, 0);
    for (i, time) in times.iter().enumerate() {
        let (time, expect) = (time - times[0], expect(i) - expect(0));
        assert!((time - expect).abs() < within_s, "sample {i}: {time} is not {expect}");
    }
    table.doubts.join("\n")
}

const STEADY_CLOCK: [(f64, f64); 2] = [(0.0, 5.0), (20.0, 5.0)];

#[test]
fn single_samples_lost_within_a_movement_are_gaps_and_each_is_counted_once() {
    // Every second one of 220 is lost; then two of each three.
    for (keep, samples, gaps) in [(2, 110, 110), (3, 148, 74)] {
        let is_kept = |i: &usize| !(1000..1000 + 2 * 110 + 2).contains(i) || i % keep == 1;
        let kept: Vec<usize> = (0..2500).filter(is_kept).collect();
        let at = |i: usize| 0.01 * kept[i] as f64;
        let stamps: Vec<f64> = (0..kept.len()).map(at).collect();
        let told = reads_as(&stamps, &STEADY_CLOCK, 1e-6, at);
        let lost = 2500 - kept.len();
        assert!(lost.abs_diff(samples) < 3, "{lost}");
        let expect = format!("{:.2} s ({lost} samples at 100 Hz)", 0.01 * lost as f64);
        assert!(told.contains(&expect), "{told}");
        let found: usize =
            told.split(" in ").nth(1).unwrap().split(' ').next().unwrap().parse().unwrap();
        assert!(found.abs_diff(gaps) < 3 && told.contains("the first behind sample 100"), "{told}");
    }
}

#[test]
fn samples_lost_among_jitter_that_hides_them_are_told_by_their_count() {
    // Each fifth of four seconds, of stamps that scatter by two intervals.
    let kept: Vec<usize> = (0..2000).filter(|i| !(800..1200).contains(i) || i % 5 != 0).collect();
    let late = |i: usize| (0..4).map(|n| 0.03 * scattered(4 * kept[i] + n)).sum::<f64>();
    let stamps: Vec<f64> = (0..kept.len()).map(|i| 0.01 * kept[i] as f64 + late(i)).collect();
    let told = reads_as(&stamps, &STEADY_CLOCK, 1.0, |i| 0.01 * kept[i] as f64);
    assert!(told.contains("1920 samples were recorded in a time for 200"), "{told}");
    assert!(told.contains("dejitter = false in [time] keeps the recorded ones"), "{told}");
}

#[test]
fn chunks_that_come_late_and_stalls_lose_nothing() {
    let even = |i: usize| 0.01 * i as f64;
    for chunk in [1, 4, 10, 20] {
        let stamps: Vec<f64> = (0..2000).map(|i| even(i) + 0.05 * scattered(i / chunk)).collect();
        assert_eq!(reads_as(&stamps, &STEADY_CLOCK, 0.01, even), "", "chunks of {chunk}");
    }
    // Held up for half a second and for 1.5 s, and sent at once then, or twice as fast as sampled.
    for (held, pace) in [(50, 1e-5), (150, 1e-6), (150, 0.005)] {
        let stamp = |i: usize| {
            if i < 850 { even(i) } else { even(i).max(even(850 + held) + pace * (i - 850) as f64) }
        };
        let stamps: Vec<f64> = (0..2000).map(stamp).collect();
        assert_eq!(reads_as(&stamps, &STEADY_CLOCK, 0.02, even), "", "{held} held, {pace} s");
    }
}

#[test]
fn clock_offsets_that_are_wrong_are_left_out_and_told() {
    let even = |i: usize| 0.01 * i as f64;
    let stamps: Vec<f64> = (0..2000).map(even).collect();
    let check = |values: &[f64], expect: &str| {
        let told = reads_as(&stamps, &offsets_of(values), 1e-6, even);
        assert!(told.contains(expect) && !told.contains('\n'), "{told}");
    };
    check(
        &[0.0, 0.0, 0.0, 0.44],
        "clock offset 4 of 4 lies 0.440 s off those beside it, and is left",
    );
    check(&[0.0, 0.4, 0.0, 0.0, 0.0], "clock offset 2 of 5 lies 0.400 s off");
    check(&[-5e3, 0.0, 0.0, 0.0], "clock offset 1 of 4 lies -5000.000 s off");
    check(
        &[0.0, 0.0, 50.0, 50.1, 0.0, 0.0],
        "clock offset 3 of 6 lies 50.000 s off those beside it, and is left out, as is 1 more",
    );
    check(
        &[0.0, 0.0, 0.0, 0.0, 0.2, 0.2, 0.2],
        "clock offsets 5 to 7 of 7 lie 0.200 s off those beside them, and are left",
    );
    check(&[0.0, f64::NAN, 0.0], "clock offset 2 of 3 is not a number, and is left out");
    let two = [(0.0, 0.01), (10.0, 300.0)];
    let told = reads_as(&stamps, &two, 1e-6, even);
    assert!(told.starts_with("clock offset 2 of 2 lies 299.9"), "{told}");
    // A comparison that is wrong has a wrong time too: it is the recorder's less the offset.
    let back = [(0.0, 0.0), (5.0, 0.0), (-290.0, 300.0), (15.0, 0.0)];
    let told = reads_as(&stamps, &back, 1e-6, even);
    assert!(told.starts_with("clock offset 3 of 4 lies 299."), "{told}");
}

#[test]
fn clock_offsets_that_scatter_and_drift_as_those_of_a_network_do_are_no_finding() {
    let even = |i: usize| 0.01 * i as f64;
    let stamps: Vec<f64> = (0..2000).map(even).collect();
    for seed in 0..200 {
        let n = 2 + seed % 20;
        let value = |i: usize| 3.0 + 1e-4 * 2.5 * i as f64 + 0.02 * scattered(100 * seed + i);
        let values: Vec<f64> = (0..n).map(value).collect();
        let told = reads_as(&stamps, &offsets_of(&values), 0.2, even);
        assert_eq!(told, "", "{values:?}");
    }
}
