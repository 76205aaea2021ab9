use super::super::limits::tests::{everything, everything_turned, only};
use super::*;
use hdf5_pure::{
    AttrValue, CharacterSet, CompoundTypeBuilder, FileBuilder, FloatingPointLayout, StringPadding,
};

/// Two vectors, one of them in a group and one as MATLAB has columns; a matrix, a text, and a
/// whole number.
pub(in super::super) fn written(userblock: &[u8]) -> Vec<u8> {
    let mut file = FileBuilder::new();
    if !userblock.is_empty() {
        file.with_userblock(512).with_userblock_content(userblock);
    }
    file.create_dataset("t").with_f64_data(&[0.0, 0.5, 1.0]).with_shape(&[3]);
    file.create_dataset("m").with_i32_data(&[1, 2, 3, 4, 5, 6]).with_shape(&[2, 3]);
    let mut rig = file.create_group("rig");
    let force = rig.create_dataset("f").with_f64_data(&[1.5, -2.0, 4.0]);
    force.with_shape(&[1, 3]);
    file.add_group(rig.finish());
    file.finish().unwrap()
}

fn read(bytes: Vec<u8>, matrix: Option<&str>, order: Order) -> Result<Table, StoreError> {
    everything(|take| super::read(Path::new("a.h5"), bytes, matrix, order, take))
}

fn numbers(cells: &Cells) -> Vec<f64> {
    match cells {
        Cells::Numbers(values) => values.values().to_vec(),
        other => panic!("{other:?}"),
    }
}

#[test]
fn vectors_come_by_their_path_and_a_matrix_is_told() {
    for userblock in [&b""[..], b"MATLAB 7.3 MAT-file"] {
        let table = read(written(userblock), None, Order::Rows).unwrap();
        let names = table.names.unwrap();
        let of = |name: &str| &table.columns[names.iter().position(|n| n == name).unwrap()];
        assert_eq!(numbers(of("t")), [0.0, 0.5, 1.0]);
        assert_eq!(numbers(of("rig/f")), [1.5, -2.0, 4.0]);
        let Cells::Other(why) = of("m") else { panic!("{:?}", of("m")) };
        assert!(why.contains("a 2 × 3 matrix"), "{why}");
    }
}

#[test]
fn a_matrix_has_its_columns_by_the_order_of_who_wrote_it() {
    let by_rows = read(written(b""), Some("m"), Order::Rows).unwrap();
    let found: Vec<_> = by_rows.columns.iter().map(numbers).collect();
    assert_eq!(found, [[1.0, 4.0], [2.0, 5.0], [3.0, 6.0]]);
    let by_columns = read(written(b""), Some("m"), Order::Columns).unwrap();
    let found: Vec<_> = by_columns.columns.iter().map(numbers).collect();
    assert_eq!(found, [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]);
    let turned =
        |take: &Take| super::read(Path::new("a.h5"), written(b""), Some("m"), Order::Rows, take);
    let turned = everything_turned(turned).unwrap();
    let found: Vec<_> = turned.columns.iter().map(numbers).collect();
    assert_eq!(found, [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]);
    let error = read(written(b""), Some("x"), Order::Rows).unwrap_err();
    assert!(error.what.contains("the file has") && error.what.contains("rig/f"), "{error}");
}

#[test]
fn a_file_cut_or_damaged_anywhere_is_an_error_or_a_table_and_never_a_panic() {
    let whole = written(b"");
    for cut in (0..whole.len()).step_by(7) {
        let _ = read(whole[..cut].to_vec(), None, Order::Rows);
    }
    for place in 0..whole.len() {
        let mut damaged = whole.clone();
        damaged[place] ^= 0xff;
        let found = read(damaged, None, Order::Rows);
        assert!(found.is_ok() || found.unwrap_err().remedy.contains("python -c"), "{place}");
    }
}

/// A chunked data set of 2⁴⁰ values of which none is written: its claim alone.
#[test]
fn a_claim_of_more_than_is_read_takes_no_memory() {
    let mut file = FileBuilder::new();
    file.create_dataset("t").with_f64_data(&[0.5; 8]).with_shape(&[8]);
    let mut bytes = file.finish().unwrap();
    // The dataspace' only dimension, as it is written: 8 in eight bytes.
    let size = 8_u64.to_le_bytes();
    let places: Vec<usize> = (0..bytes.len() - 8).filter(|i| bytes[*i..*i + 8] == size).collect();
    for place in places {
        let before = bytes.clone();
        bytes[place..place + 8].copy_from_slice(&(1_u64 << 40).to_le_bytes());
        let _ = read(bytes, None, Order::Rows);
        bytes = before;
    }
}

/// What a group of [`old_form`] has.
enum Child {
    Data(&'static [f64]),
    Soft(&'static str),
    Group(Vec<(String, Child)>),
    /// A group of the new form, with a soft link and one to another file.
    NewGroup,
}

/// A file as h5py and MATLAB write it by default: groups are symbol tables, whose entries are objects
/// or soft links.
fn old_form(children: Vec<(String, Child)>) -> Vec<u8> {
    const NONE: [u8; 8] = [0xff; 8];
    let mut bytes = vec![0; 96];
    let root = put_group(&mut bytes, children);
    let end = bytes.len() as u64;
    let head = [
        &b"\x89HDF\r\n\x1a\n"[..],
        &[0, 0, 0, 0, 0, 8, 8, 0, 4, 0, 16, 0, 0, 0, 0, 0],
        &[0; 8],
        &NONE,
        &end.to_le_bytes(),
        &NONE,
        &[0; 8],
        &root.to_le_bytes(),
        &[0; 24],
    ]
    .concat();
    bytes[..96].copy_from_slice(&head);
    bytes
}

/// Adds a block; its address.
fn put(bytes: &mut Vec<u8>, block: &[u8]) -> u64 {
    let address = bytes.len() as u64;
    bytes.extend_from_slice(block);
    bytes.resize(bytes.len().next_multiple_of(8), 0);
    address
}

/// Adds an object's header of these messages; its address.
fn put_header(bytes: &mut Vec<u8>, messages: &[(u16, Vec<u8>)]) -> u64 {
    let mut block = Vec::new();
    for (kind, content) in messages {
        let size = content.len().next_multiple_of(8);
        block.extend([kind.to_le_bytes(), u16::try_from(size).unwrap().to_le_bytes()].concat());
        block.extend([0; 4]);
        block.extend(content);
        block.resize(block.len() + size - content.len(), 0);
    }
    let (count, size) = (messages.len() as u16, block.len() as u32);
    let head = [&[1, 0][..], &count.to_le_bytes(), &[1, 0, 0, 0], &size.to_le_bytes(), &[0; 4]];
    put(bytes, &[head.concat(), block].concat())
}

fn put_data(bytes: &mut Vec<u8>, values: &[f64]) -> u64 {
    let content: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
    let (at, size) = (put(bytes, &content), content.len() as u64);
    let space = [&[1, 1, 0, 0, 0, 0, 0, 0][..], &(values.len() as u64).to_le_bytes()].concat();
    let float = [0x11, 0x20, 0x3f, 0, 8, 0, 0, 0, 0, 0, 64, 0, 52, 11, 0, 52, 0xff, 3, 0, 0];
    let layout = [&[3, 1][..], &at.to_le_bytes(), &size.to_le_bytes()].concat();
    put_header(bytes, &[(1, space), (3, float.to_vec()), (8, layout)])
}

/// A message of a link: its kind and what it leads to.
fn link(name: &str, kind: u8, value: &[u8]) -> (u16, Vec<u8>) {
    let head = [1, 0x08, kind, u8::try_from(name.len()).unwrap()];
    (6, [&head[..], name.as_bytes(), value].concat())
}

fn put_group(bytes: &mut Vec<u8>, mut children: Vec<(String, Child)>) -> u64 {
    children.sort_by(|a, b| a.0.cmp(&b.0));
    let mut names = vec![0; 8];
    let mut entries = Vec::new();
    for (name, child) in children {
        let mut text = |text: &str| {
            let at = names.len();
            names.extend(text.as_bytes());
            names.resize((names.len() + 1).next_multiple_of(8), 0);
            at
        };
        let at = text(&name) as u64;
        let (address, kind, scratch) = match child {
            Child::Soft(target) => (u64::MAX, 2_u32, text(target) as u32),
            Child::Data(values) => (put_data(bytes, values), 0, 0),
            Child::Group(children) => (put_group(bytes, children), 0, 0),
            Child::NewGroup => {
                let data = put_data(bytes, &[7.0, 8.0]);
                let away = b"\x0f\0\0other.h5\0/f\0\0\0";
                let messages = [
                    link("g", 0, &data.to_le_bytes()),
                    link("soft", 1, b"\x01\0g"),
                    link("away", 64, away),
                ];
                (put_header(bytes, &messages), 0, 0)
            }
        };
        let entry =
            [&at.to_le_bytes()[..], &address.to_le_bytes(), &kind.to_le_bytes(), &[0; 4]].concat();
        entries.push([&entry[..], &scratch.to_le_bytes(), &[0; 12]].concat());
    }
    let mut tree = [&b"TREE\0\0"[..], &[0; 2], &[0xff; 16], &[0; 8]].concat();
    for (i, node) in entries.chunks(8).enumerate() {
        let head = [&b"SNOD\x01\0"[..], &(node.len() as u16).to_le_bytes()].concat();
        let at = put(bytes, &[head, node.concat()].concat());
        tree[6..8].copy_from_slice(&(i as u16 + 1).to_le_bytes());
        tree.extend([at.to_le_bytes(), (names.len() as u64 - 8).to_le_bytes()].concat());
    }
    let (names, size) = (put(bytes, &names), names.len() as u64);
    let free = 1_u64.to_le_bytes();
    let heap = [&b"HEAP\0\0\0\0"[..], &size.to_le_bytes(), &free, &names.to_le_bytes()].concat();
    let (heap, tree) = (put(bytes, &heap), put(bytes, &tree));
    put_header(bytes, &[(0x11, [tree.to_le_bytes(), heap.to_le_bytes()].concat())])
}

/// Two vectors, and links to them, to nothing, and to other files.
pub(in super::super) fn with_links() -> Vec<u8> {
    let owned = |children: Vec<(&str, Child)>| {
        children.into_iter().map(|(name, child)| (name.to_owned(), child)).collect::<Vec<_>>()
    };
    let rig = owned(vec![
        ("f", Child::Data(&[1.5, -2.0, 4.0])),
        ("near", Child::Soft("f")),
        ("up", Child::Soft("/t")),
    ]);
    old_form(owned(vec![
        ("again", Child::Soft("rig/near")),
        ("circle", Child::Soft("/circle")),
        ("gone", Child::Soft("/nothing/there")),
        ("new", Child::NewGroup),
        ("rig", Child::Group(rig)),
        ("self", Child::Soft("/")),
        ("short", Child::Soft("rig")),
        ("t", Child::Data(&[0.0, 0.5, 1.0])),
    ]))
}

/// A file of which the columns of these names are taken.
fn take_named(bytes: Vec<u8>, names: &[&str]) -> Result<Table, StoreError> {
    only(names, |take| super::read(Path::new("a.h5"), bytes, None, Order::Rows, take))
}

/// The place of a column in a table, or why it cannot be used.
fn place(table: &Table, name: &str) -> Result<usize, String> {
    table.find(&ColumnRef::Name(name.to_owned()))
}

/// The columns of these names.
fn read_named(bytes: Vec<u8>, names: &[&str]) -> Result<Vec<Vec<f64>>, StoreError> {
    let table = take_named(bytes, names)?;
    let values = |name: &&str| numbers(&table.columns[place(&table, name).unwrap()]);
    Ok(names.iter().map(values).collect())
}

#[test]
fn links_that_are_not_asked_for_do_not_matter() {
    let table = read(with_links(), None, Order::Rows).unwrap();
    let mut names = table.names.unwrap();
    names.sort();
    assert_eq!(names, ["new/g", "rig/f", "t"]);
    let found = read_named(with_links(), &["t", "rig/f"]).unwrap();
    assert_eq!(found, [[0.0, 0.5, 1.0], [1.5, -2.0, 4.0]]);
}

#[test]
fn a_soft_link_that_is_asked_for_is_followed_within_the_file() {
    for (name, expect) in [
        ("rig/near", vec![1.5, -2.0, 4.0]),
        ("again", vec![1.5, -2.0, 4.0]),
        ("short/near", vec![1.5, -2.0, 4.0]),
        ("self/short/up", vec![0.0, 0.5, 1.0]),
        ("new/soft", vec![7.0, 8.0]),
    ] {
        assert_eq!(read_named(with_links(), &[name]).unwrap()[0], expect, "{name}");
        let table = read(with_links(), Some(name), Order::Rows).unwrap();
        assert_eq!(numbers(&table.columns[0]), expect, "{name}");
    }
}

#[test]
fn a_link_that_leads_to_nothing_or_to_another_file_is_refused_by_its_name() {
    for (name, words) in [
        ("gone", "it is a link to 'nothing/there', which is no data set of the file"),
        ("short", "it is a link to 'rig', which is no data set of the file"),
        ("circle", "'circle' is a link that leads in a circle"),
        ("new/away", "'new/away' is a link to another file, other.h5"),
    ] {
        let error = read_named(with_links(), &[name]).unwrap_err();
        assert!(error.what.contains(words), "{error}");
        assert_eq!(error.column.as_deref(), Some(name));
        assert!(error.remedy.contains("copy it into this file"), "{error}");
    }
}

#[test]
fn damaged_links_are_an_error_or_a_table_and_never_a_panic() {
    let whole = with_links();
    for place in 0..whole.len() {
        for change in [0xff, 0x02, 0x80] {
            let mut damaged = whole.clone();
            damaged[place] ^= change;
            let _ = take_named(damaged, &["t", "again"]);
        }
        let _ = take_named(whole[..place].to_vec(), &["t", "again"]);
    }
}

#[test]
fn of_many_data_sets_in_a_group_few_and_many_are_read_alike() {
    let children = (0..3000).map(|i| (format!("d{i:05}"), Child::Data(&[1.0, 2.0]))).collect();
    let bytes = old_form(children);
    let names: Vec<String> = (0..3000).step_by(7).map(|i| format!("d{i:05}")).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let many = read_named(bytes.clone(), &names).unwrap();
    assert!(names.len() > MOST_BY_NAME && many.iter().all(|values| *values == [1.0, 2.0]));
    assert_eq!(read_named(bytes, &names[..3]).unwrap(), many[..3]);
}

/// A data set of whole numbers with these attributes, in a group.
fn with_attributes(attributes: &[(&str, AttrValue)]) -> Vec<u8> {
    let mut file = FileBuilder::new();
    let mut rig = file.create_group("rig");
    let data = rig.create_dataset("data").with_i16_data(&[1, -2, 3, 4, 5, 6]).with_shape(&[3, 2]);
    for (name, value) in attributes {
        data.set_attr(name, value.clone());
    }
    let one = rig.create_dataset("one").with_i16_data(&[1, -2, 300]).with_shape(&[3]);
    for (name, value) in attributes {
        one.set_attr(name, value.clone());
    }
    file.add_group(rig.finish());
    file.finish().unwrap()
}

#[test]
fn scales_and_offsets_of_attributes_are_applied_and_told_or_refused() {
    let number = |name, value| (name, AttrValue::F64(value));
    let all = |table: &Table| table.columns.iter().map(numbers).collect::<Vec<_>>();
    for attributes in [
        [number("scale_factor", 0.5), number("add_offset", 1.0)],
        [number("conversion", 0.5), number("offset", 1.0)],
        [("scale_factor", AttrValue::F32Array(vec![0.5])), ("add_offset", AttrValue::U8(1))],
    ] {
        let bytes = with_attributes(&attributes);
        let table = read(bytes.clone(), Some("rig/data"), Order::Rows).unwrap();
        assert_eq!(all(&table), [[1.5, 2.5, 3.5], [0.0, 3.0, 4.0]]);
        assert_eq!(table.told.len(), 1, "{:?}", table.told);
        let found = read_named(bytes, &["rig/one", "rig/data(2)"]).unwrap();
        assert_eq!(found, [[1.5, 0.0, 151.0], [0.0, 3.0, 4.0]]);
    }
    let plain = [number("scale_factor", 1.0), number("add_offset", 0.0), number("conversion", 1.0)];
    let table = read(with_attributes(&plain), Some("rig/data"), Order::Rows).unwrap();
    assert_eq!((all(&table)[0].clone(), table.told.len()), (vec![1.0, 3.0, 5.0], 0));
    for (attribute, words) in [
        (number("scale_factor", 0.0), "'scale_factor' is 0"),
        (number("scale_factor", f64::NAN), "not one finite number"),
        (("conversion", AttrValue::F64Array(vec![1.0, 2.0])), "not one finite number"),
        (("add_offset", AttrValue::String("1".to_owned())), "not one finite number"),
        (("_FillValue", AttrValue::String("x".to_owned())), "'_FillValue' is not a number"),
    ] {
        let bytes = with_attributes(&[attribute]);
        let error = read(bytes.clone(), Some("rig/data"), Order::Rows).unwrap_err();
        assert!(error.what.contains(words), "{error}");
        let table = take_named(bytes, &["rig/one"]).unwrap();
        let error = place(&table, "rig/one").unwrap_err();
        assert!(error.contains(words) && error.contains("python -c"), "{error}");
    }
}

#[test]
fn numbers_that_stand_for_missing_ones_are_missing_and_signs_that_are_none_are_taken_away() {
    let fill = ("_FillValue", AttrValue::I16(-2));
    let unsigned = ("_Unsigned", AttrValue::String("true".to_owned()));
    let one = |attributes: &[(&str, AttrValue)]| {
        let table = take_named(with_attributes(attributes), &["rig/one"]).unwrap();
        let place = place(&table, "rig/one").unwrap();
        (0..3).map(|row| table.columns[place].cell(row).to_string()).collect::<Vec<_>>()
    };
    assert_eq!(one(&[fill]), ["1", "", "300"]);
    assert_eq!(one(&[unsigned]), ["1", "65534", "300"]);
}

/// As MATLAB writes a structure in version 7.3, and a table.
pub(in super::super) fn matlab_7_3() -> Vec<u8> {
    let mut file = FileBuilder::new();
    file.with_userblock(512).with_userblock_content(b"MATLAB 7.3 MAT-file");
    let class = |class: &str| AttrValue::AsciiString(class.to_owned());
    let mut simout = file.create_group("simout");
    let time = simout.create_dataset("time").with_f64_data(&[0.0, 0.5, 1.0]).with_shape(&[1, 3]);
    time.set_attr("MATLAB_class", class("double"));
    let mut signals = simout.create_group("signals");
    let values = [7.0, 8.0, 9.0, 1.5, -2.0, 4.0];
    let values = signals.create_dataset("values").with_f64_data(&values).with_shape(&[2, 3]);
    values.set_attr("MATLAB_class", class("double"));
    simout.add_group(signals.finish());
    file.add_group(simout.finish());
    let table = file.create_dataset("T").with_u32_data(&[1, 2, 3, 4, 5, 6]).with_shape(&[1, 6]);
    table.set_attr("MATLAB_class", class("table"));
    let mut sparse = file.create_group("sp");
    sparse.set_attr("MATLAB_sparse", AttrValue::U64(3));
    sparse.create_dataset("data").with_f64_data(&[1.0, 2.0]).with_shape(&[2]);
    file.add_group(sparse.finish());
    file.finish().unwrap()
}

#[test]
fn structures_of_matlab_7_3_come_by_their_path_with_points_or_strokes_and_objects_are_named() {
    let take = |names: &[&str], matrix| {
        let table = only(names, |take| {
            super::read(Path::new("a.mat"), matlab_7_3(), matrix, Order::Columns, take).unwrap()
        });
        let all = names.iter().map(|name| place(&table, name).map(|i| numbers(&table.columns[i])));
        all.collect::<Result<Vec<_>, String>>()
    };
    let expect = Ok(vec![vec![0.0, 0.5, 1.0], vec![1.5, -2.0, 4.0]]);
    assert_eq!(take(&["simout.time", "simout.signals.values(2)"], None), expect);
    assert_eq!(take(&["simout/time", "simout/signals/values(2)"], None), expect);
    assert_eq!(take(&["time", "signals.values(2)"], Some("simout")), expect);
    for (name, words) in [
        ("x", "'T' is a MATLAB table; in MATLAB, type s = table2struct(T, 'ToScalar', true)"),
        ("T", "it is a MATLAB table"),
        ("sp/data", "it is a sparse matrix; in MATLAB, type sp = full(sp)"),
    ] {
        let error = take(&[name], None).unwrap_err();
        assert!(error.contains(words) && !error.contains("python"), "{error}");
    }
}

/// A table of h5py: a short, a long and a text in each row.
pub(in super::super) fn compound() -> Vec<u8> {
    let text =
        Datatype::String { size: 2, padding: StringPadding::NullPad, charset: CharacterSet::Ascii };
    let kind = CompoundTypeBuilder::new().f64_field("t").i16_field("n").field("who", text);
    let rows: Vec<u8> = [(0.0_f64, 5_i16), (0.5, -6), (1.0, 300)]
        .into_iter()
        .flat_map(|(t, n)| [&t.to_le_bytes()[..], &n.to_le_bytes(), b"ab"].concat())
        .collect();
    let mut file = FileBuilder::new();
    file.create_dataset("data").with_raw_data(kind.build().unwrap(), rows, 3);
    file.finish().unwrap()
}

/// A table of h5py whose second field has fields itself.
pub(in super::super) fn nested() -> Vec<u8> {
    let within = CompoundTypeBuilder::new().f64_field("angle").f64_field("F").build().unwrap();
    let kind = CompoundTypeBuilder::new().f64_field("t").field("s", within);
    let rows = [0.0_f64, 1.5, 2.5, 0.5, 3.5, 4.5].map(f64::to_le_bytes).concat();
    let mut file = FileBuilder::new();
    file.create_dataset("log").with_raw_data(kind.build().unwrap(), rows, 2);
    file.finish().unwrap()
}

#[test]
fn fields_within_fields_come_by_their_path() {
    let found = read_named(nested(), &["log/t", "log/s/angle", "log.s.F"]).unwrap();
    assert_eq!(found, [[0.0, 0.5], [1.5, 3.5], [2.5, 4.5]]);
    let table = read(nested(), Some("log"), Order::Rows).unwrap();
    assert_eq!(table.names.unwrap(), ["t", "s/angle", "s/F"]);
    let table = take_named(compound(), &["data/who"]).unwrap();
    let why = place(&table, "data/who").unwrap_err();
    assert!(why.contains("a field without numbers") && why.contains("python -c"), "{why}");
}

#[test]
fn factors_of_channels_are_told_beside_the_factor_of_all() {
    let mut file = FileBuilder::new();
    let mut rig = file.create_group("rig");
    let data = rig.create_dataset("data").with_i16_data(&[1, 2, 3, 4]).with_shape(&[2, 2]);
    data.set_attr("conversion", AttrValue::F64(0.25));
    rig.create_dataset("channel_conversion").with_f64_data(&[0.5, 2.0]).with_shape(&[2]);
    file.add_group(rig.finish());
    let table = read(file.finish().unwrap(), Some("rig/data"), Order::Rows).unwrap();
    assert_eq!(numbers(&table.columns[0]), [0.125, 0.375]);
    assert_eq!(numbers(&table.columns[1]), [1.0, 2.0]);
    let told = "those stored × 0.25 × 0.5, 2 channel by channel + 0, as its attributes say (conversion, channel_conversion)";
    assert!(table.told[0].contains(told), "{:?}", table.told);
}

#[test]
fn the_fields_of_a_table_come_by_their_name() {
    let found = read_named(compound(), &["data/t", "data.n"]).unwrap();
    assert_eq!(found, [[0.0, 0.5, 1.0], [5.0, -6.0, 300.0]]);
    let table = read(compound(), Some("data"), Order::Rows).unwrap();
    assert_eq!(table.names.clone().unwrap(), ["t", "n", "who"]);
    assert_eq!(numbers(&table.columns[1]), [5.0, -6.0, 300.0]);
    assert!(place(&table, "who").unwrap_err().contains("without numbers"));
    let table = read(compound(), None, Order::Rows).unwrap();
    let error = place(&table, "data").unwrap_err();
    assert!(error.contains("a table of the fields t, n, who; name one of them"), "{error}");
}

#[test]
fn numbers_of_two_bytes_are_read() {
    let kind = Datatype::FloatingPoint {
        size: 2,
        byte_order: DatatypeByteOrder::LittleEndian,
        layout: FloatingPointLayout {
            bit_offset: 0,
            bit_precision: 16,
            exponent_location: 10,
            exponent_size: 5,
            mantissa_location: 0,
            mantissa_size: 10,
            exponent_bias: 15,
        },
    };
    let stored = [0x3e00_u16, 0xc000, 0x0001, 0x8000, 0x7bff].map(u16::to_le_bytes).concat();
    let mut file = FileBuilder::new();
    file.create_dataset("f").with_raw_data(kind, stored, 5);
    let found = read_named(file.finish().unwrap(), &["f"]).unwrap();
    assert_eq!(found[0], [1.5, -2.0, 2_f64.powi(-24), 0.0, 65504.0]);
}

/// A range of Octave's, a matrix and a text as its `save -hdf5` writes them.
pub(in super::super) fn octave() -> Vec<u8> {
    let mut file = FileBuilder::new();
    let variable = |file: &mut FileBuilder, name: &str, kind: &str| {
        let mut group = file.create_group(name);
        group.set_attr("OCTAVE_NEW_FORMAT", AttrValue::U8(1));
        let text = Datatype::String {
            size: kind.len() as u32,
            padding: StringPadding::NullPad,
            charset: CharacterSet::Ascii,
        };
        group.create_dataset("type").with_raw_data(text, kind.as_bytes().to_vec(), 1);
        group
    };
    let mut range = variable(&mut file, "t", "double_range");
    let fields =
        CompoundTypeBuilder::new().f64_field("base").f64_field("limit").f64_field("increment");
    let parts = [0.0_f64, 1.0, 0.5].map(f64::to_le_bytes).concat();
    let value = range.create_dataset("value").with_raw_data(fields.build().unwrap(), parts, 1);
    value.set_attr("OCTAVE_RANGE_NELEM", AttrValue::I64(3));
    file.add_group(range.finish());
    let mut matrix = variable(&mut file, "f", "matrix");
    let values = [7.0, 8.0, 9.0, 1.5, -2.0, 4.0];
    matrix.create_dataset("value").with_f64_data(&values).with_shape(&[2, 3]);
    file.add_group(matrix.finish());
    let mut text = variable(&mut file, "who", "sq_string");
    text.create_dataset("value").with_i8_data(&[97, 99]).with_shape(&[2]);
    file.add_group(text.finish());
    file.finish().unwrap()
}

#[test]
fn variables_of_octave_are_read_as_it_means_them() {
    let found = read_named(octave(), &["t/value", "f/value(2)"]).unwrap();
    assert_eq!(found, [[0.0, 0.5, 1.0], [1.5, -2.0, 4.0]]);
    let table = read(octave(), Some("f/value"), Order::Rows).unwrap();
    assert_eq!(numbers(&table.columns[0]), [7.0, 8.0, 9.0]);
    let table = take_named(octave(), &["who/value"]).unwrap();
    assert!(place(&table, "who/value").unwrap_err().contains("it is text"));
}
