use super::super::csv::Dialect;
use super::super::limits::tests::everything;
use super::super::table::Cell;
use super::super::text::Encoding;
use super::*;
use flate2::write::DeflateEncoder;
use flate2::{Compression, Crc};
use std::io::Write as _;

/// A ZIP archive of parts, stored or deflated.
pub(in super::super) fn packed(parts: &[(&str, Vec<u8>)], deflated: bool) -> Vec<u8> {
    let (mut bytes, mut directory) = (Vec::new(), Vec::new());
    for (name, content) in parts {
        let packed = match deflated {
            false => content.clone(),
            true => {
                let mut encoder = DeflateEncoder::new(Vec::new(), Compression::default());
                encoder.write_all(content).unwrap();
                encoder.finish().unwrap()
            }
        };
        let mut crc = Crc::new();
        crc.update(content);
        let number = |n: usize| u32::try_from(n).unwrap().to_le_bytes();
        let short = |n: usize| u16::try_from(n).unwrap().to_le_bytes();
        let method = short(if deflated { 8 } else { 0 });
        let sums = [crc.sum().to_le_bytes(), number(packed.len()), number(content.len())].concat();
        let about = [&[0; 2][..], &method, &[0; 4], &sums, &short(name.len())].concat();
        let at = number(bytes.len());
        bytes.extend(
            [b"PK\x03\x04", &[20, 0][..], &about, &short(0), name.as_bytes(), &packed].concat(),
        );
        let rest = [&short(0)[..], &[0; 8], &at, name.as_bytes()].concat();
        directory.extend([b"PK\x01\x02", &[20, 0, 20, 0][..], &about, &short(0), &rest].concat());
    }
    let [n, length, at] = [parts.len(), directory.len(), bytes.len()];
    let counts = u16::try_from(n).unwrap().to_le_bytes().repeat(2);
    let places = [length, at].map(|n| u32::try_from(n).unwrap().to_le_bytes()).concat();
    [bytes, directory, b"PK\x05\x06\0\0\0\0".to_vec(), counts, places, vec![0, 0]].concat()
}

/// A ZIP archive of stored texts.
pub(in super::super) fn archive(parts: &[(&str, &str)]) -> Vec<u8> {
    let parts: Vec<_> =
        parts.iter().map(|(name, text)| (*name, text.as_bytes().to_vec())).collect();
    packed(&parts, false)
}

/// A workbook of these sheets: name and rows.
pub(in super::super) fn xlsx(sheets: &[(&str, &str)]) -> Vec<u8> {
    let list: String = (1..)
        .zip(sheets)
        .map(|(i, (name, _))| format!("<sheet name=\"{name}\" sheetId=\"{i}\" r:id=\"rId{i}\"/>"))
        .collect();
    let links: String = (1..=sheets.len())
        .map(|i| format!("<Relationship Id=\"rId{i}\" Target=\"worksheets/sheet{i}.xml\"/>"))
        .collect();
    let book = format!("<workbook><sheets>{list}</sheets></workbook>");
    let links = format!("<Relationships>{links}</Relationships>");
    let texts = "<sst count=\"4000000000\" uniqueCount=\"4000000000\"><si><t>t</t></si><si><r><t>F &amp; </t></r><r><t>x</t></r>\
                 <rPh><t>no</t></rPh></si></sst>";
    let styles = "<styleSheet><numFmts><numFmt numFmtId=\"164\" formatCode=\"yyyy\\-mm\\-dd\"/></numFmts>\
                  <cellStyleXfs><xf numFmtId=\"14\"/></cellStyleXfs><cellXfs><xf numFmtId=\"0\"/><xf numFmtId=\"164\"/></cellXfs></styleSheet>";
    let names: Vec<String> =
        (1..=sheets.len()).map(|i| format!("xl/worksheets/sheet{i}.xml")).collect();
    let contents: Vec<String> = sheets
        .iter()
        .map(|(_, rows)| {
            format!("<worksheet><dimension ref=\"A1:XFD1048576\"/><sheetData>{rows}</sheetData></worksheet>")
        })
        .collect();
    let mut parts = vec![
        ("xl/workbook.xml", book.as_str()),
        ("xl/_rels/workbook.xml.rels", &links),
        ("xl/sharedStrings.xml", texts),
        ("xl/styles.xml", styles),
    ];
    parts.extend(names.iter().map(String::as_str).zip(contents.iter().map(String::as_str)));
    archive(&parts)
}

fn ods(tables: &str) -> Vec<u8> {
    archive(&[
        ("mimetype", "application/vnd.oasis.opendocument.spreadsheet"),
        ("content.xml", &format!("<office:document-content>{tables}</office:document-content>")),
    ])
}

const ROWS: &str = "<row r=\"1\"><c r=\"A1\" t=\"s\"><v>0</v></c><c r=\"B1\" t=\"s\"><v>1</v></c><c r=\"C1\" t=\"inlineStr\"><is><t>when</t></is></c></row>\
    <row r=\"3\"><c r=\"A3\"><v>0.5</v></c><c r=\"B3\"><v>1E-3</v></c><c r=\"C3\" s=\"1\"><v>45351</v></c></row>\
    <row r=\"4\"><c r=\"A4\"><v>1</v></c><c r=\"C4\" t=\"e\"><v>#DIV/0!</v></c><c r=\"D4\"><f>A4*2</f></c></row>";

fn with(bytes: &[u8], is_ods: bool, part: Option<&str>, skip: usize) -> Result<Table, StoreError> {
    let dialect = Dialect {
        delimiter: b',',
        header: true,
        comment: None,
        skip,
        encoding: Encoding::Utf8,
        bad_lines: 0,
        before: 0,
    };
    everything(|take| read(Path::new("a"), bytes, is_ods, dialect, part, take))
}

fn try_xlsx(bytes: &[u8]) -> Result<Table, StoreError> {
    with(bytes, false, None, 0)
}

fn cells(table: &Table, row: usize) -> Vec<Cell<'_>> {
    table.columns.iter().map(|column| column.cell(row)).collect()
}

#[test]
fn numbers_texts_dates_errors_and_formulas_of_a_sheet_are_what_they_are() {
    let table = try_xlsx(&xlsx(&[("data", ROWS)])).unwrap();
    assert_eq!(table.names.as_ref().unwrap()[..], ["t", "F & x", "when", ""]);
    assert_eq!(table.lines, [3, 4]);
    let (number, text) = (Cell::Number, Cell::Text);
    assert_eq!(cells(&table, 0), [number(0.5), number(1e-3), text("2024-02-29"), Cell::Empty]);
    assert_eq!(cells(&table, 1), [number(1.0), Cell::Empty, text("#DIV/0!"), text("=A4*2")]);
}

#[test]
fn an_error_of_a_newer_program_is_a_text_and_the_rest_of_its_sheet_is_read() {
    let rows = ROWS.replace("#DIV/0!", "#SPILL!");
    let table = try_xlsx(&xlsx(&[("data", &rows)])).unwrap();
    assert_eq!(cells(&table, 1)[2], Cell::Text("#SPILL!"));
    assert_eq!(cells(&table, 0)[0], Cell::Number(0.5));
}

#[test]
fn a_sheet_of_an_ods_reads_alike_and_what_is_repeated_counts() {
    let row = "<table:table-row><table:table-cell office:value-type=\"string\"><text:p>t</text:p></table:table-cell>\
        <table:table-cell office:value-type=\"string\"><office:annotation><text:p>no</text:p></office:annotation><text:p>F</text:p></table:table-cell></table:table-row>\
        <table:table-row table:number-rows-repeated=\"2\"><table:table-cell table:number-columns-repeated=\"2\" office:value-type=\"float\" office:value=\"1.5\"><text:p>1,5</text:p></table:table-cell>\
        <table:table-cell table:number-columns-repeated=\"16382\"/></table:table-row>\
        <table:table-row table:number-rows-repeated=\"1048573\"><table:table-cell table:number-columns-repeated=\"16384\"/></table:table-row>";
    let tables =
        format!("<table:table table:name=\"a\"/><table:table table:name=\"b\">{row}</table:table>");
    let table = with(&ods(&tables), true, None, 0).unwrap();
    assert_eq!(table.names.as_ref().unwrap()[..], ["t", "F"]);
    assert_eq!(
        (cells(&table, 0), cells(&table, 1)),
        (vec![Cell::Number(1.5); 2], vec![Cell::Number(1.5); 2])
    );
    assert_eq!(table.lines, [2, 3]);
    let bomb = "<table:table table:name=\"a\"><table:table-row table:number-rows-repeated=\"1048576\"><table:table-cell \
        table:number-columns-repeated=\"16384\" office:value-type=\"float\" office:value=\"1\"/></table:table-row></table:table>";
    let twice = format!("{bomb}{bomb}").replacen("1048576", "1", 1);
    assert!(with(&ods(&twice), true, None, 0).unwrap_err().what.contains("2 sheets have values"));
    let rows = bomb.replace("<table:table table:name=\"a\">", "<table:table table:name=\"a\"><table:table-row><table:table-cell office:value-type=\"string\"><text:p>h</text:p></table:table-cell></table:table-row>");
    let refused = with(&ods(&rows), true, None, 0).unwrap_err();
    assert!(refused.what.contains("more than is read at once"), "{refused}");
}

#[test]
fn which_sheet_is_meant_must_be_plain() {
    let two = xlsx(&[("first", ROWS), ("notes", ""), ("second", ROWS)]);
    let check = |result: Result<Table, StoreError>, words: &str| {
        let error = result.unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    };
    check(
        try_xlsx(&two),
        "2 sheets have values; the file has first, notes, second; set sheet in [file]",
    );
    check(
        with(&two, false, Some("third"), 0),
        "there is no sheet 'third'; the file has first, notes, second",
    );
    check(with(&two, false, Some("notes"), 0), "the sheet has no values");
    assert_eq!(with(&two, false, Some("second"), 0).unwrap().lines, [3, 4]);
    assert_eq!(try_xlsx(&xlsx(&[("notes", ""), ("data", ROWS)])).unwrap().lines, [3, 4]);
    check(
        try_xlsx(b"t,f\n0,1\n"),
        "not a workbook: it does not begin as an .xlsx or .ods does; if it is a text, set format",
    );
    check(
        try_xlsx(b"\xd0\xcf\x11\xe0rest"),
        "an old one (.xls), or one that a password locks; save it as .xlsx",
    );
    check(try_xlsx(b""), "the file is empty");
    check(try_xlsx(&ods("")), "it is an .ods; set format = \"ods\"");
}

#[test]
fn lines_before_the_header_are_passed_by_by_their_number_in_the_sheet() {
    let rows = format!(
        "<row r=\"1\"><c r=\"A1\" t=\"inlineStr\"><is><t>Rig 2</t></is></c></row>{}",
        ROWS.replace("r=\"1\"", "r=\"2\"")
    );
    let table = with(&xlsx(&[("data", &rows)]), false, None, 1).unwrap();
    assert_eq!(table.names.unwrap()[1], "F & x");
}

#[test]
fn a_file_cut_or_damaged_anywhere_is_an_error_and_never_ends_the_program() {
    let bytes = xlsx(&[("data", ROWS)]);
    for at in 0..bytes.len() {
        if at % 7 == 0 {
            assert!(try_xlsx(&bytes[..at]).is_err());
        }
        let mut bad = bytes.clone();
        bad[at] ^= 1 << (at % 8);
        let _ = try_xlsx(&bad);
    }
    // What its checks do not notice: the parts damaged before they are packed.
    for at in 0..ROWS.len() {
        let mut rows = ROWS.as_bytes().to_vec();
        rows[at] ^= 1 << (at % 7);
        let _ = String::from_utf8(rows).map(|rows| try_xlsx(&xlsx(&[("data", &rows)])));
    }
}
