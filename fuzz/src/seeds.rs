//! Writes `fuzz/seeds`: for each target small files as they should be, from which a fuzzer begins.
//! An unseeded one finds no magic bytes.

use flate2::write::{DeflateEncoder, ZlibEncoder};
use flate2::{Compression, Crc};
use std::io::Write as _;
use std::path::{Path, PathBuf};
use zwidth_device::TwinParameters;
use zwidth_device::mock::Mock;
use zwidth_link::Drive;
use zwidth_link::framed::message::{FromBoard, Seen, ToBoard};
use zwidth_link::{AngleAt, Board, Link, Settings, hostile as rig};
use zwidth_store::{
    Journal, Layout, Memory, Protocol, Quantity, Samples, Sweep, Trial, TrialFile, append_events,
    hostile, record_bytes, sweep_bytes, trial_bytes,
};
use zwidth_study::{
    Calibration, Event, Extra, Flags, Kind, PlannedTrial, Sample, SessionRecord, Source, Status,
    TrialForm, TrialMeta, Voltages, template,
};

const UTC: &str = "2026-01-01T00:00:00Z";

type Any = Box<dyn std::error::Error>;

/// A rig that speaks Firmata, with the angle there.
pub fn firmata_settings(angle: AngleAt) -> Settings {
    let can = zwidth_device::mock::capabilities();
    Settings::of_board(Link::Firmata, angle, 100.0, &can, Path::new("/dev/cell"))
}

/// A rig that prints lines.
pub fn text_settings() -> Settings {
    let can = zwidth_device::mock::capabilities();
    Settings::of_board(Link::Text, AngleAt::I2c, 100.0, &can, Path::new("/dev/cell"))
}

/// Writes them all, from the workspace's folder on.
pub fn write() -> Result<(), Any> {
    let seeds = Path::new("fuzz/seeds");
    let put = |target: &str, name: &str, bytes: &[u8]| -> Result<(), Any> {
        let folder = seeds.join(target);
        std::fs::create_dir_all(&folder)?;
        Ok(std::fs::write(folder.join(name), bytes)?)
    };
    let (disk, layout) = (Memory::new(), Layout::new(Path::new("/r"), "demo".parse()?));
    let study = template(layout.study()).into_bytes();
    disk.put(&layout.study_toml(), &study);

    let meta = meta()?;
    let mut journal =
        Journal::create(&disk, &layout, &meta, &TrialFile::new(), &Protocol::default())?;
    let rows: Vec<Sample> = (0..4).map(row).collect();
    journal.append(&rows)?;
    journal.end()?;
    put(
        "journal",
        "whole",
        &content(&disk, &layout.journal(&meta.participant, &meta.session, 1))?,
    )?;

    let log = layout.events(&meta.participant, &meta.session);
    let events = [
        Event::Note { trial: Some(1), text: "slowly".into() },
        Event::Recorded { trial: 1, blake3: "0".repeat(64) },
        Event::Excluded { trial: 1, reason: "the phone rang".into() },
    ];
    append_events(&disk, &log, UTC, &events)?;
    let (lines, head) = (content(&disk, &log)?, content(&disk, &hostile::head_of(&log))?);
    put("events", "three", &lines)?;
    put("head", "three", &[head, vec![0], lines.clone()].concat())?;

    let planned = PlannedTrial {
        trial: 1,
        repeat: 1,
        kind: Kind::Trial,
        environment: meta.environment.clone(),
        mode: meta.mode.clone(),
        samples: true,
        task: None,
    };
    let (participant, session) = (meta.participant.clone(), meta.session.clone());
    let hash = "0".repeat(64);
    let record =
        SessionRecord::new(participant, session, Source::Recorded, "seeds", hash, vec![planned]);
    let record = record_bytes(Path::new("P01_S01.json"), &record)?;
    put("record", "one_trial", &record)?;
    for (which, bytes) in [(0, &record), (1, &lines), (2, &study), (3, &study)] {
        put("whole", &which.to_string(), &[&[which], bytes.as_slice()].concat())?;
    }
    put("records", "one_job", RECORDS.as_bytes())?;

    put("study", "template", &study)?;
    let people = "participant,group,age_years\nP01,novice,24\nP02,expert,\n";
    put("people", "csv", &[&[0], people.as_bytes()].concat())?;
    let tables = "[P01]\ngroup = \"novice\"\nage_years = 24\n[P02]\ngroup = \"expert\"\n";
    put("people", "toml", &[&[1], tables.as_bytes()].concat())?;
    put("calibration", "thesis", Calibration::thesis().to_toml()?.as_bytes())?;
    put("twin", "default", toml::to_string(&TwinParameters::default())?.as_bytes())?;
    put("mapping", "axes", AXES.as_bytes())?;
    put("mapping", "joined", JOINED.as_bytes())?;
    for (target, file) in [
        ("mapping", "studies/brake_b5zd/map.toml"),
        ("mapping", "studies/tsa/map.toml"),
        ("mapping", "studies/likert_vr_shoes/map.toml"),
        ("scene", "scenes/sine_finger.toml"),
        ("scene", "scenes/two_actuators.toml"),
    ] {
        let name = file.trim_end_matches(".toml").replace('/', "_");
        put(target, &name, &std::fs::read(file)?)?;
    }

    let trial = Trial { meta, file: TrialFile::new(), samples: Samples::from_rows(&rows) };
    let trial = trial_bytes(&trial, &TrialForm::default(), Path::new("trial-001.parquet"))?;
    put("trial", "four_rows", &trial)?;
    put("parquet", "trial", &trial)?;
    let quantity = |name: &str, unit: &str| Quantity { name: name.into(), unit: unit.into() };
    let sweep = Sweep {
        actuator: "motor".parse()?,
        sweep: 1,
        source: Source::Recorded,
        command: quantity("voltage", "V"),
        response: quantity("force", "N"),
        t_s: Some(vec![0.0, 0.1, 0.2]),
        command_values: vec![0.0, 1.0, 2.0],
        response_values: vec![0.0, 0.26, 0.52],
        file: TrialFile::new(),
    };
    let sweep = sweep_bytes(&sweep, Path::new("sweep-001.parquet"))?;
    put("sweep", "three_rows", &sweep)?;
    put("parquet", "sweep", &sweep)?;

    let seen = FromBoard::Seen(Seen {
        t_us: 8300,
        counts: 2048,
        angle_age_us: 0,
        force: 8123,
        force_age_us: 4000,
        status: 0,
        drive: Drive { motor: 8192, brake: 0 },
    });
    for (name, frame) in [
        ("poll", ToBoard::Poll.frame(1)),
        ("hello", ToBoard::Hello.frame(2)),
        ("seen", seen.frame(1)),
    ] {
        let (bytes, length) = frame.encode();
        put("wire", name, &bytes[..length])?;
    }

    for (name, angle) in [("analog", AngleAt::Analog(0)), ("i2c", AngleAt::I2c)] {
        // What a host asks, what the board answers, what the host says to that, and readings.
        let settings = firmata_settings(angle);
        let mut board = Board::by(&settings, Mock::default(), Vec::new())?;
        let (asks, mut answers) = (b"\xf9\xf0\x79\xf7\xf0\x6b\xf7\xf0\x69\xf7", Vec::new());
        board.take(0.0, asks, &mut answers)?;
        let said = rig::hear(&settings, &answers)?.said;
        let mut readings = Vec::new();
        board.take(1.0, &said, &mut readings)?;
        put("firmata", &format!("{name}_asks"), asks)?;
        put("firmata", &format!("{name}_answers"), &[answers, readings].concat())?;
        put("firmata", &format!("{name}_says"), &said)?;
    }
    put("lines", "board", b"{t_us},{counts},{hx711}\n5,6,7\n8300,2048,-8123\r\n")?;
    put("lines", "host", b"t={t_ms} {any}; {counts}!\nM-255 B0\nK2 17\nt=3 x; 12!\n")?;

    put("participant", "answer", b"answer 3 -2\n")?;
    let numbers = "07".repeat(32);
    let hello = format!("zwidth-participant-2 {numbers}\n");
    put("participant", "hello", hello.as_bytes())?;
    put("participant", "place", format!("4711 {numbers}\n").as_bytes())?;
    put("participant", "sights", SIGHTS.as_bytes())?;

    put("csv", "plain", b"# made by hand\nt,angle,force\n0,0.1,1e-3\n0.01,\"0,2\",-2\n")?;
    put("csv", "crlf", b"\xef\xbb\xbft;\"a \"\"b\"\"\"\r\n1;2\r\n")?;
    put("txt", "blanks", b"# made by hand\n t   \"F in N\"\n 0.0\t 1\n 0.5  2\n")?;
    put(
        "txt",
        "labchart",
        b"Interval=\t0.001 s\nChannelTitle=\tF\tx\nRange=\t10 V\t1 V\n0\t1\t2\n0.001\t3\t4\t#* begin\n",
    )?;
    put(
        "jsonl",
        "plain",
        b"{\"t\":0,\"x\":1.5,\"who\":\"P01\"}\n{\"t\":0.1,\"x\":null,\"who\":\"\\u00e4\"}\n",
    )?;
    let data = matrix("data", &[[0.0, 1.0], [0.5, 2.0], [1.0, 3.0]]);
    let vector = matrix("theta", &[[0.0], [0.1], [0.2]]);
    put("mat", "plain", &[mat_header(), data.clone(), vector.clone()].concat())?;
    let header = "{'descr': '<f8', 'fortran_order': False, 'shape': (2,), }\n";
    let length = u16::try_from(header.len())?.to_le_bytes();
    let values = [0.0_f64, 0.5].map(f64::to_le_bytes).concat();
    let array = [b"\x93NUMPY\x01\x00", &length[..], header.as_bytes(), &values].concat();
    // h5py of two vectors, one in a group, and as MATLAB has them after a block of its own.
    put("h5", "two_vectors", include_bytes!("two_vectors.h5"))?;
    put("mat", "of_7_3", include_bytes!("of_7_3.mat"))?;
    put("mat", "objects", include_bytes!("../../crates/import/src/mat/objects.mat"))?;
    put("npy", "vector", &array)?;
    put("npz", "stored", &archive(&[("theta.npy", &array, &array)]))?;
    put("npz", "deflated", &archive(&[("theta.npy", &array, &deflated(&array)?)]))?;
    let stored = |parts: &[(&str, &str)]| {
        let parts = parts.iter().map(|(name, text)| (*name, text.as_bytes(), text.as_bytes()));
        archive(&parts.collect::<Vec<_>>())
    };
    put("xlsx", "two_rows", &stored(&XLSX))?;
    put("ods", "two_rows", &stored(&ODS))?;
    // pyarrow.feather.write_feather of numbers, texts and a dictionary, as it is and packed with
    // LZ4.
    put("arrow", "plain", include_bytes!("plain.arrow"))?;
    put("arrow", "packed", include_bytes!("packed.arrow"))?;
    put("xdf", "two_streams", &two_streams())?;
    put("tdms", "two_channels", &two_channels())?;
    put("c3d", "a_point", &a_point())?;
    put("mcap", "plain", &two_messages(""))?;
    put("mcap", "packed", &two_messages("zstd"))?;
    put(
        "sto",
        "motion",
        b"Coordinates\nversion=1\nnRows=2\nnColumns=2\ninDegrees=yes\nendheader\ntime\telbow\n0\t90\n0.1\tNaN\n",
    )?;
    put("mat", "packed", &[mat_header(), packed(&data)?, packed(&vector)?].concat())?;
    Ok(())
}

fn content(disk: &Memory, path: &PathBuf) -> Result<Vec<u8>, Any> {
    disk.below(path)
        .remove(path)
        .ok_or_else(|| format!("{} was not written", path.display()).into())
}

fn meta() -> Result<TrialMeta, Any> {
    Ok(TrialMeta {
        participant: "P01".parse()?,
        session: "S01".parse()?,
        trial: 1,
        repeat: 1,
        kind: Kind::Trial,
        status: Status::Complete,
        environment: "spring".parse()?,
        mode: "hybrid".parse()?,
        likert: Some(4),
        source: Source::Recorded,
        presented: None,
    })
}

fn row(i: u32) -> Sample {
    let x = f64::from(i);
    Sample {
        t_s: 1e-3 * x,
        t_device_s: None,
        theta_rad: 0.01 * x,
        theta_dot_rad_s: 10.0,
        force_ex_n: 0.1 * x,
        voltages: Voltages { motor_v: 0.1 * x, brake_v: 0.0 },
        force_age_s: Some(0.003),
        theta_raw: Some(7),
        force_cmd_n: 0.026 * x,
        flags: Flags::MOTOR_ON,
        extra: Extra::new(&[0.5]),
    }
}

/// An XDF file of a stream of two numbers with a comparison of clocks, and one of texts; a boundary
/// parts its samples.
fn two_streams() -> Vec<u8> {
    let chunk = |tag: u16, stream: Option<u32>, content: &[u8]| {
        let stream = stream.map(|stream| stream.to_le_bytes().to_vec()).unwrap_or_default();
        let inner = [&tag.to_le_bytes()[..], &stream, content].concat();
        [&[4][..], &(inner.len() as u32).to_le_bytes(), &inner].concat()
    };
    let header = |name: &str, channels: u32, rate: u32, format: &str, desc: &str| {
        format!(
            "<info><name>{name}</name><channel_count>{channels}</channel_count><nominal_srate>{rate}</nominal_srate>\
             <channel_format>{format}</channel_format><desc>{desc}</desc></info>"
        )
    };
    let labels = "<channels><channel><label>F</label></channel><channel/></channels>";
    let stamped = [&[1, 2, 8][..], &10.0_f64.to_le_bytes(), &[1, 2, 0, 3, 4]].concat();
    let marker = [&[1, 1, 8][..], &10.5_f64.to_le_bytes(), &[1, 2], b"go"].concat();
    let offset = [10.0_f64, 100.0].map(f64::to_le_bytes).concat();
    let boundary = b"\x43\xa5\x46\xdc\xcb\xf5\x41\x0f\xb3\x0e\xd5\x46\x73\x83\xcb\xe4";
    [
        b"XDF:".to_vec(),
        chunk(1, None, b"<info><version>1.0</version></info>"),
        chunk(2, Some(1), header("rig", 2, 100, "int8", labels).as_bytes()),
        chunk(2, Some(2), header("marks", 1, 0, "string", "").as_bytes()),
        chunk(3, Some(1), &stamped),
        chunk(3, Some(2), &marker),
        chunk(5, None, boundary),
        chunk(3, Some(1), &stamped),
        chunk(4, Some(1), &offset),
        chunk(6, Some(1), b"<info><sample_count>4</sample_count></info>"),
    ]
    .concat()
}

/// A TDMS file of two channels with a scale, in chunks, and a segment that says nothing new.
fn two_channels() -> Vec<u8> {
    let text = |text: &str| [&(text.len() as u32).to_le_bytes(), text.as_bytes()].concat();
    let words = |words: &[u32]| words.iter().flat_map(|word| word.to_le_bytes()).collect::<Vec<u8>>();
    let double = |name: &str, value: f64| [text(name), words(&[0x0A]), value.to_le_bytes().to_vec()].concat();
    let scale = [
        words(&[4]),
        double("wf_increment", 0.001),
        [text("NI_Scale[0]_Scale_Type"), words(&[0x20]), text("Linear")].concat(),
        double("NI_Scale[0]_Linear_Slope", 0.5),
        double("NI_Scale[0]_Linear_Y_Intercept", 1.0),
    ];
    let described = [
        words(&[3]),
        text("/'rig'"),
        words(&[u32::MAX, 0]),
        text("/'rig'/'F'"),
        words(&[20, 2, 1, 2, 0]),
        scale.concat(),
        text("/'rig'/'angle'"),
        words(&[20, 0x0A, 1, 2, 0, 0]),
    ]
    .concat();
    let raw = [&[1, 0, 2, 0][..], &[0.5_f64, 1.5].map(f64::to_le_bytes).concat()].concat();
    let lead_in = |toc: u32, next: usize, raw: usize| {
        [b"TDSm", &words(&[toc, 4713, next as u32, 0, raw as u32, 0])[..]].concat()
    };
    let first = lead_in(0b1110, described.len() + 2 * raw.len(), described.len());
    [first, described, raw.clone(), raw.clone(), lead_in(0b1000, raw.len(), 0), raw].concat()
}

/// A C3D file of a point and an analog channel, two frames.
fn a_point() -> Vec<u8> {
    let words = |words: &[u16]| words.iter().flat_map(|word| word.to_le_bytes()).collect::<Vec<u8>>();
    let mut bytes = [&[2, 0x50][..], &words(&[1, 1, 1, 2, 0])].concat();
    bytes.extend([&(-1_f32).to_le_bytes()[..], &words(&[3, 1]), &100_f32.to_le_bytes()].concat());
    bytes.resize(512, 0);
    bytes.extend([0, 0x50, 1, 84]);
    // A group and its number, then a parameter of a text in it.
    bytes.extend([&[5, 0xFF][..], b"POINT", &words(&[3]), &[0]].concat());
    bytes.extend([&[6, 1][..], b"LABELS", &words(&[10]), &[0xFF, 2, 4, 1], b"hand", &[0]].concat());
    bytes.extend([0, 0]);
    bytes.resize(1024, 0);
    bytes.extend((0..10_u8).flat_map(|i| f32::from(i).to_le_bytes()));
    bytes
}

/// An MCAP file of a message of ROS 2 and one in JSON, in a chunk that is packed so.
fn two_messages(packing: &str) -> Vec<u8> {
    let text = |text: &str| [&(text.len() as u32).to_le_bytes(), text.as_bytes()].concat();
    let record = |kind: u8, content: &[u8]| [&[kind][..], &(content.len() as u64).to_le_bytes(), content].concat();
    let channel = |id: u8, topic: &str, form: &str| {
        record(4, &[vec![id, 0, id, 0], text(topic), text(form), vec![0; 4]].concat())
    };
    let message = |channel: u8, data: &[u8]| record(5, &[&[channel, 0][..], &[0; 20], data].concat());
    let definition = "Header header\nfloat64[] f\n===\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring id\n";
    let schema = record(3, &[vec![1, 0], text("p/msg/F"), text("ros2msg"), text(definition)].concat());
    let cdr = [&[0, 1, 0, 0][..], &[0; 8], &[2, 0, 0, 0, b'a', 0, 0, 0], &[1, 0, 0, 0], &[0; 4], &1.5_f64.to_le_bytes()].concat();
    let records = [
        schema,
        channel(1, "data", "cdr"),
        channel(2, "other", "json"),
        message(1, &cdr),
        message(2, b"{\"f\":[1,2.5],\"who\":\"P01\"}"),
    ]
    .concat();
    let size = records.len();
    let packed = match packing {
        // A frame of one block, in which they stand as they are.
        "zstd" => {
            let sizes = [&(size as u16 - 256).to_le_bytes()[..], &(size as u32 * 8 + 1).to_le_bytes()[..3]];
            [b"\x28\xb5\x2f\xfd\x60", &sizes.concat()[..], &records].concat()
        }
        _ => records.clone(),
    };
    let head = [&[0; 16][..], &(records.len() as u64).to_le_bytes(), &[0; 4]].concat();
    let chunk = [head, text(packing), (packed.len() as u64).to_le_bytes().to_vec(), packed].concat();
    [b"\x89MCAP0\r\n".to_vec(), record(1, &[0; 8]), record(6, &chunk)].concat()
}

/// The parts of an Excel workbook: a sheet with a text, a number and a date.
const XLSX: [(&str, &str); 5] = [
    ("xl/workbook.xml", r#"<workbook><sheets><sheet name="a" r:id="r1"/></sheets></workbook>"#),
    (
        "xl/_rels/workbook.xml.rels",
        r#"<Relationships><Relationship Id="r1" Target="worksheets/sheet1.xml"/></Relationships>"#,
    ),
    ("xl/sharedStrings.xml", r#"<sst uniqueCount="1"><si><t>t &amp; x</t></si></sst>"#),
    (
        "xl/styles.xml",
        r#"<styleSheet><cellXfs><xf numFmtId="0"/><xf numFmtId="14"/></cellXfs></styleSheet>"#,
    ),
    (
        "xl/worksheets/sheet1.xml",
        r#"<worksheet><sheetData><row r="1"><c r="A1" t="s"><v>0</v></c><c t="inlineStr"><is><t>F</t></is></c></row><row r="2"><c r="A2"><v>0.5</v></c><c r="B2" s="1"><v>45351</v></c></row></sheetData></worksheet>"#,
    ),
];

/// The part of an OpenDocument workbook: a text, and numbers that are repeated.
const ODS: [(&str, &str); 1] = [(
    "content.xml",
    r#"<a><table:table table:name="a"><table:table-row><table:table-cell office:value-type="string"><text:p>t</text:p></table:table-cell></table:table-row><table:table-row table:number-rows-repeated="2"><table:table-cell table:number-columns-repeated="2" office:value-type="float" office:value="1.5"/></table:table-row></table:table></a>"#,
)];

const RECORDS: &str = r#"{"metrics P01 S01":{"stage":"metrics","version":1,"parameters":"{}",
"inputs":{"raw/demo/study.toml":"00"},"outputs":{"derived/demo/metrics.parquet":"11"},"problems":[],"origin":"22"}}"#;

/// A mapping of positions and forces in several axes, with their projections.
const AXES: &str = r#"kind = "trials"
[trial]
participant = "P01"
session = "S01"
environment = "spring"
mode = "hybrid"
[time]
from = 1
unit = "s"
[[column]]
to = "x_m"
from = 2
unit = "in"
zero = "first"
[[column]]
to = "force_x_n"
from = 3
unit = "lbf"
[[column]]
to = "theta_rad"
derive = "along push"
origin = [0.0, 0.1, -0.2]
[[column]]
to = "force_ex_n"
derive = "along push"
"#;

/// A mapping that joins a log and a second file to recordings.
const JOINED: &str = r#"kind = "trials"
[name]
pattern = '(?<n>\d+)'
[log]
path = "{n}.csv"
trial = "n"
number = { name = "n" }
add = 1
where = { who = "7" }
when = { screen = ["test"] }
unmatched = "drop"
[[with]]
id = "b"
path = "{n}.c3d"
file = { group = "points" }
time = "time_s"
unit = "s"
offset_s = 0.5
resample = "linear"
[trial]
participant = "P01"
session = "S01"
environment = "spring"
mode = { column = "m@log" }
[questions]
lowest = 0
[questions.columns]
easy = { column = "a@log", key = "Q0" }
[task]
id = "stiffer"
level = "k@log"
unit = "N/mm"
answer = { column = "r@log" }
[time]
from = 1
unit = "s"
[[column]]
to = "theta_rad"
from = "x@b"
unit = "deg"
"#;

/// What a session says to a participant's screen.
const SIGHTS: &str = r#"{"sight":{"now":"ready","environment":"Spring","practice":true,"done":1,"total":9}}
{"sight":{"now":{"question":{"number":3,"text":"How?","range":"1 to 2","choices":[{"value":1,"word":"no"},{"value":2,"word":null}]}},"environment":null,"practice":false,"done":1,"total":9}}
{"sight":{"now":{"pause":{"left_s":5}},"environment":null,"practice":false,"done":2,"total":9}}
"taken"
"#;

/// The header of a MAT file of version 5, little-endian.
fn mat_header() -> Vec<u8> {
    let mut header = b"MATLAB 5.0 MAT-file".to_vec();
    header.resize(124, b' ');
    header.extend_from_slice(&[0x00, 0x01, b'I', b'M']);
    header
}

/// A data element: type, length, bytes, padded to eight.
fn element(kind: u32, bytes: &[u8]) -> Vec<u8> {
    let length = u32::try_from(bytes.len()).unwrap_or_default();
    let mut all = [kind.to_le_bytes(), length.to_le_bytes()].concat();
    all.extend_from_slice(bytes);
    all.resize(all.len().next_multiple_of(8), 0);
    all
}

/// A matrix of doubles by rows.
fn matrix<const N: usize>(name: &str, rows: &[[f64; N]]) -> Vec<u8> {
    let dimensions = [rows.len() as u32, N as u32].map(u32::to_le_bytes).concat();
    let by_columns = (0..N).flat_map(|j| rows.iter().flat_map(move |row| row[j].to_le_bytes()));
    let parts = [
        element(6, &[6_u32.to_le_bytes(), [0; 4]].concat()),
        element(5, &dimensions),
        element(1, name.as_bytes()),
        element(9, &by_columns.collect::<Vec<u8>>()),
    ];
    element(14, &parts.concat())
}

fn packed(element: &[u8]) -> Result<Vec<u8>, Any> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(element)?;
    let bytes = encoder.finish()?;
    Ok([15_u32.to_le_bytes().to_vec(), (bytes.len() as u32).to_le_bytes().to_vec(), bytes].concat())
}

fn deflated(bytes: &[u8]) -> Result<Vec<u8>, Any> {
    let mut encoder = DeflateEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(bytes)?;
    Ok(encoder.finish()?)
}

/// A ZIP archive of files: name, content, and how it is kept, as it is or deflated.
fn archive(files: &[(&str, &[u8], &[u8])]) -> Vec<u8> {
    let (mut local, mut directory) = (Vec::new(), Vec::new());
    for (name, file, kept) in files {
        let mut crc = Crc::new();
        crc.update(file);
        let method: u16 = if kept == file { 0 } else { 8 };
        // What the file's own head and its entry in the directory share, from the version needed
        // on.
        let facts = [
            &[20, 0, 0, 0][..],
            &method.to_le_bytes(),
            &[0; 4],
            &crc.sum().to_le_bytes(),
            &(kept.len() as u32).to_le_bytes(),
            &(file.len() as u32).to_le_bytes(),
            &(name.len() as u16).to_le_bytes(),
            &[0; 2],
        ]
        .concat();
        let at = (local.len() as u32).to_le_bytes();
        let entry = [b"PK\x01\x02\x14\x00", facts.as_slice(), &[0; 10], &at, name.as_bytes()];
        directory.extend(entry.concat());
        local.extend([b"PK\x03\x04", facts.as_slice(), name.as_bytes(), kept].concat());
    }
    let count = (files.len() as u16).to_le_bytes();
    let end = [
        &b"PK\x05\x06\0\0\0\0"[..],
        &count,
        &count,
        &(directory.len() as u32).to_le_bytes(),
        &(local.len() as u32).to_le_bytes(),
        &[0; 2],
    ]
    .concat();
    [local, directory, end].concat()
}
