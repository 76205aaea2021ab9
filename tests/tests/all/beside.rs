//! Streams beside a session: a session whose markers another program heard, and the recording that it made.

use crate::acquire::Desk;
use crate::binary::{zwidth, zwidth_line};
use serde_json::Value;
use std::fs;
use std::io::{BufRead as _, BufReader};
use std::net::TcpListener;
use std::path::Path;
use std::thread;

fn chunk(tag: u16, stream: u32, content: &[u8]) -> Vec<u8> {
    let inner = [&tag.to_le_bytes()[..], &stream.to_le_bytes(), content].concat();
    [&[4][..], &u32::try_from(inner.len()).unwrap().to_le_bytes(), &inner].concat()
}

/// A stream of one channel, each sample with its time.
fn stream(number: u32, name: &str, format: &str, samples: &[(f64, Vec<u8>)]) -> Vec<u8> {
    let xml = format!(
        "<info><name>{name}</name><channel_count>1</channel_count><nominal_srate>0</nominal_srate><channel_format>{format}</channel_format></info>"
    );
    let each = samples.iter().map(|(t_s, value)| {
        let sample = [&[1, 1, 8][..], &t_s.to_le_bytes(), value].concat();
        chunk(3, number, &sample)
    });
    [chunk(2, number, xml.as_bytes()), each.collect::<Vec<_>>().concat()].concat()
}

/// A recording of these markers, trial after trial 100 s apart, and of a stream that counts tenths of a second.
fn recording(path: &Path, markers: &[String]) {
    let marker = |line: &String| {
        let own: Value = serde_json::from_str(line).unwrap();
        let at_s = 100.0 * own["trial"].as_f64().unwrap() + own["t_s"].as_f64().unwrap();
        let text = [&[4][..], &u32::try_from(line.len()).unwrap().to_le_bytes(), line.as_bytes()];
        (at_s, text.concat())
    };
    let marked: Vec<_> = markers.iter().map(marker).collect();
    let counted: Vec<_> =
        (0..10_000_i32).map(|i| (0.1 * f64::from(i), i.to_le_bytes().to_vec())).collect();
    let file = [
        b"XDF:".to_vec(),
        stream(1, "zwidth", "string", &marked),
        stream(2, "EMG of the arm", "int32", &counted),
    ];
    fs::write(path, file.concat()).unwrap();
}

#[test]
fn a_recording_beside_a_session_is_kept_once_listed_withdrawn_and_verified() {
    let desk = Desk::new(false);
    let root = desk.root();
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let to = format!("tcp:{}", listener.local_addr().unwrap());
    let heard = thread::spawn(move || {
        let lines = BufReader::new(listener.accept().unwrap().0).lines();
        lines.map_while(Result::ok).collect::<Vec<_>>()
    });
    desk.acquire("", &["--auto", "--markers", &to]).exits(0);
    let markers = heard.join().unwrap();
    let path = root.join("lab.xdf");
    recording(&path, &markers);
    let from = path.to_str().unwrap();
    let beside = |more: &[&str]| zwidth(root, &[&["beside", "small"], more].concat());
    let session = ["-p", "P01", "-s", "S01"];
    let given = |more: &[&str]| beside(&[&["--from", from], &session[..], more].concat());
    beside(&["--list"]).exits(0).prints(&["no stream was given"]);
    given(&["--dry-run"]).exits(0).prints(&["1 stream beside P01 S01", "nothing was written"]);
    given(&["--stream", "EMG of the arm=emg"]).exits(0).prints(&[
        "by the arrival of their first marker",
        "emg: 10000 samples",
        "raw/small/beside/participant=P01/session=S01/emg.0001.parquet",
    ]);
    given(&["--stream", "2=emg"]).one_error().says(&["was given from this file already"]);
    given(&["--stream", "gaze"]).one_error().says(&["there is no stream 'gaze'", "--stream"]);
    given(&["--markers", "other"]).one_error().says(&["there is no stream 'other'", "--markers"]);
    beside(&["--from", from, "-p", "P09", "-s", "S01"]).one_error().says(&["zwidth list small"]);
    recording(&path, &markers[..0]);
    given(&[]).one_error().says(&["the stream of markers has no sample"]);
    let listed = beside(&["--list", "--json"]).exits(0).json();
    assert_eq!((&listed[0]["stream"], &listed[0]["table"]), (&"emg".into(), &1.into()));
    zwidth_line(root, "verify small").exits(0);
    beside(&[&session[..], &["--withdraw", "emg", "electrodes were off"]].concat()).exits(0);
    beside(&["--list"]).exits(0).prints(&["does not count: withdrawn: electrodes were off"]);
    fs::remove_file(root.join("raw/small/beside/participant=P01/session=S01/emg.0001.parquet"))
        .unwrap();
    zwidth_line(root, "verify small").exits(1).prints(&["its file is missing"]);
}
