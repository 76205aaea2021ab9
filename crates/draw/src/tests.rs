//! Facts about whole figures: every figure of the gallery, and figures of odd numbers.

use std::collections::BTreeMap;
use std::sync::{Arc, LazyLock};

use proptest::prelude::*;
use resvg::usvg::{Node, Options, Tree};
use tiny_skia::{Color, Pixmap, Rect, Transform};

use super::*;
use crate::sheet::{PT_PER_MM, Shape};
use crate::typeface::Style;
use crate::typeface::tests::{file, file_with_letters};

static GALLERY: LazyLock<BTreeMap<&str, Drawing>> = LazyLock::new(|| {
    let figures = gallery::figures().into_iter().chain(crowded());
    figures.map(|(name, figure)| (name, draw(&figure).unwrap())).collect()
});

/// Figures with as little room as they can do with.
fn crowded() -> Vec<(&'static str, Figure)> {
    let row = |i: u32| vec![vec![1, i % 7, 90 - i % 7, 0, 1 + i % 3, 2, 1]];
    let items =
        (0..24).map(|i| format!("{i}. I felt that the virtual shoes moved as my own would"));
    let survey = Likert {
        answers: (1..=7).map(|i| format!("answer {i}")).collect(),
        rows: (0..24).map(row).collect(),
        scale: LikertScale::Percent,
    };
    let share = Axis { ticks: Ticks::Magnitudes, ..Axis::new("answers", "%") };
    let survey =
        Panel::new(Cell::at(0, 0), share, Axis::categories(items), vec![Layer::Likert(survey)]);
    let names = ["administration", "configuration", "closed loop", "none"];
    let whiskers = |direction| {
        let at = (0..4).map(f64::from).collect();
        let ends = [0.0, -2e4, 1e4];
        let ends = ends.map(|off| [-12_345.6, 99_000.0, 1e5, f64::NAN].map(|v| v + off).to_vec());
        Layer::Intervals(Intervals {
            colour: style::mode_colour(3),
            marker: style::Marker::Diamond,
            name: Some("95 %".into()),
            ..Intervals::new(direction, at, ends)
        })
    };
    let wall = |direction, at, label: &str| {
        let line = Reference::new(direction, at, style::reference());
        let label = Some(label.to_owned());
        Layer::Reference(Reference { label, name: Some("limit".into()), ..line })
    };
    let upright = vec![
        whiskers(Direction::Vertical),
        wall(Direction::Horizontal, 0.0, "none"),
        wall(Direction::Horizontal, 500.0, "low"),
    ];
    let across = vec![
        whiskers(Direction::Horizontal),
        wall(Direction::Vertical, 0.0, "none"),
        wall(Direction::Vertical, 500.0, "low"),
    ];
    let value = || Axis::new("stiffness of the wall", "N/m");
    let panels = vec![
        Panel::new(Cell::at(0, 0), Axis::categories(names), value(), upright).titled("**a**  one"),
        Panel::new(Cell::at(0, 1), value(), Axis::categories(names), across)
            .titled("**b**  a heading of two lines"),
    ];
    let narrow = Figure {
        width_mm: ONE_COLUMN_MM,
        mark: Some("SYNTHETIC".into()),
        panels,
        ..Figure::default()
    };
    vec![("survey", Figure { panels: vec![survey], ..Figure::default() }), ("narrow", narrow)]
}

/// The SVG as a library reads it.
fn tree(drawing: &Drawing) -> Tree {
    Tree::from_str(&drawing.svg().unwrap(), &Options::default()).unwrap()
}

/// All shapes of a drawing with their extent on the page, strokes included.
fn shapes(node: &Node, found: &mut Vec<Rect>) {
    match node {
        Node::Group(group) => group.children().iter().for_each(|child| shapes(child, found)),
        leaf => found.push(leaf.abs_stroke_bounding_box()),
    }
}

#[test]
fn nothing_lies_outside_of_the_page() {
    for (name, drawing) in GALLERY.iter() {
        let tree = tree(drawing);
        let mut found = Vec::new();
        tree.root().children().iter().for_each(|node| shapes(node, &mut found));
        assert!(found.len() > 20, "{name}: only {} shapes", found.len());
        let (width, height) = (tree.size().width() + 0.01, tree.size().height() + 0.01);
        for shape in found {
            let inside = shape.left() > -0.01
                && shape.top() > -0.01
                && shape.right() < width
                && shape.bottom() < height;
            assert!(inside, "{name}: {shape:?} on {width} × {height}");
        }
    }
}

#[test]
fn no_line_is_smaller_than_small_print_at_any_width() {
    let crowded = crowded().into_iter().filter(|(name, _)| *name != "survey");
    for (name, figure) in gallery::figures().into_iter().chain(crowded) {
        for width_mm in [ONE_COLUMN_MM, TWO_COLUMNS_MM] {
            let drawing = draw(&Figure { width_mm, ..figure.clone() }).unwrap();
            assert_eq!(drawing.small_words(), [""; 0], "{name} at {width_mm} mm");
            assert_eq!(drawing.overlapping_words().unwrap(), [] as [[String; 2]; 0], "{name}");
        }
    }
}

#[test]
fn no_two_words_overlap() {
    for (name, drawing) in GALLERY.iter() {
        let words = drawing.words(Fonts::bundled().unwrap());
        assert!(words.len() > 5, "{name}: only {} words", words.len());
        assert_eq!(drawing.overlapping_words().unwrap(), [] as [[String; 2]; 0], "{name}");
    }
}

/// Names of points that lie on each other, and of bars beside each other that are wider than they.
#[test]
fn words_of_places_that_are_close_make_room_for_each_other() {
    let text = |x: f64, y: f64, words: &str| {
        Layer::Text(Text { lines: vec![words.to_owned()], place: TextPlace::Over(x, y) })
    };
    let line = Line { x: vec![0.0, 1.0], y: vec![0.0, 1.0], ..Line::default() };
    let layers = vec![
        Layer::Line(line),
        text(0.5, 0.5, "Active 16 V"),
        text(0.5, 0.52, "Passive, Hybrid 8 V"),
        text(0.55, 0.98, "at the edge"),
        text(0.45, 0.98, "at the same edge"),
    ];
    let drawing = draw(&Figure { width_mm: ONE_COLUMN_MM, ..one_panel(layers) }).unwrap();
    assert_eq!(drawing.overlapping_words().unwrap(), [] as [[String; 2]; 0]);
    let words = drawing.words(Fonts::bundled().unwrap());
    for expect in ["Active 16 V", "at the same edge"] {
        assert!(words.iter().any(|(word, _)| word == expect), "{expect} in {words:?}");
    }
}

/// Our pixels beside those that resvg makes of our SVG.
#[test]
fn the_image_is_the_svg_as_another_renderer_draws_it() {
    for (name, drawing) in GALLERY.iter() {
        let image = drawing.png(DEFAULT_DPI).unwrap();
        let mut reader = ::png::Decoder::new(std::io::Cursor::new(image)).read_info().unwrap();
        let mut ours = vec![0; reader.output_buffer_size().unwrap()];
        let frame = reader.next_frame(&mut ours).unwrap();
        let mut theirs = Pixmap::new(frame.width, frame.height).unwrap();
        theirs.fill(Color::WHITE);
        let scale = (DEFAULT_DPI / 96.0) as f32;
        resvg::render(&tree(drawing), Transform::from_scale(scale, scale), &mut theirs.as_mut());
        let theirs = theirs.data().chunks_exact(4).flat_map(|pixel| &pixel[..3]);
        let off: Vec<u8> = ours.iter().zip(theirs).map(|(a, b)| a.abs_diff(*b)).collect();
        let far = off.iter().filter(|off| **off > 64).count() as f64 / off.len() as f64;
        let mean = off.iter().map(|off| f64::from(*off)).sum::<f64>() / off.len() as f64;
        assert!(
            far < 1e-3 && mean < 0.2,
            "{name}: {far} of the pixels are far off, {mean} on average"
        );
    }
}

/// Two boxes without a common area.
fn apart(a: &sheet::Rect, b: &sheet::Rect) -> bool {
    a.right <= b.left || b.right <= a.left || a.bottom <= b.top || b.bottom <= a.top
}

#[test]
fn a_legend_lies_on_no_plot_and_on_no_stamp() {
    let fonts = Fonts::bundled().unwrap();
    let mut seen = 0;
    for (name, figure) in gallery::figures().into_iter().chain(crowded()) {
        let plan = layout::plan(&figure, fonts).unwrap();
        let (legend, (left, top)) = &plan.legend;
        let (right, bottom) = (left + legend.width_pt(), top + legend.height_pt());
        let legend = sheet::Rect { left: *left, top: *top, right, bottom };
        let plots = plan.panels.iter().map(|p| p.plot).chain(plan.mark.map(|(_, frame)| frame));
        for other in plots {
            assert!(apart(&legend, &other), "{name}: the legend {legend:?} meets {other:?}");
        }
        seen += usize::from(legend.height() > 0.0);
    }
    assert!(seen > 3, "only {seen} legends");
}

/// Under a heading the stamp does not narrow the legend: what finds room in a row stands in one.
#[test]
fn a_legend_under_a_heading_is_as_wide_as_the_page() {
    let names = ["external force", "finger tissue", "brake"].map(str::to_owned);
    let line = |name| Line { x: vec![0.0], y: vec![0.0], name: Some(name), ..Line::default() };
    let figure = Figure {
        title: Some("Sine".into()),
        width_mm: ONE_COLUMN_MM,
        mark: Some("SIMULATION: a model run".into()),
        ..one_panel(names.map(line).map(Layer::Line).to_vec())
    };
    let fonts = Fonts::bundled().unwrap();
    let rows = |figure: &Figure| layout::plan(figure, fonts).unwrap().legend.0.height_pt();
    assert!(rows(&figure) < rows(&Figure { title: None, ..figure.clone() }));
}

#[test]
fn the_same_figure_gives_the_same_bytes() {
    for (name, figure) in gallery::figures() {
        let (first, second) = (&GALLERY[name], draw(&figure).unwrap());
        assert_eq!(first, &second, "{name}");
        assert!(first.png(50.0).unwrap() == second.png(50.0).unwrap(), "{name}: PNGs differ");
        assert!(first.pdf().unwrap() == second.pdf().unwrap(), "{name}: PDFs differ");
    }
}

#[test]
fn the_svg_needs_nothing_from_outside() {
    for (name, drawing) in GALLERY.iter() {
        let svg = drawing.svg().unwrap();
        assert!(
            !svg.contains("<text") && !svg.contains("font-family"),
            "{name}: words must be outlines"
        );
        let links = svg.matches("href=\"").count();
        assert_eq!(links, svg.matches("href=\"#").count(), "{name}: links must stay inside");
    }
}

#[test]
fn the_files_carry_title_description_provenance_and_mark() {
    let drawing = &GALLERY["four-panels"];
    assert!(drawing.svg().unwrap().contains("<desc>Angle, force and velocity"));
    assert!(drawing.svg().unwrap().contains("<metadata>zwidth gallery</metadata>"));
    assert!(drawing.svg().unwrap().contains("aria-label=\"SYNTHETIC\""));
    let png = drawing.png(100.0).unwrap();
    assert!(png.windows(14).any(|bytes| bytes == b"zwidth gallery"));
    let pdf = drawing.pdf().unwrap();
    assert!(
        pdf.starts_with(b"%PDF-") && pdf.windows(9).any(|bytes| bytes == b"FontFile2"),
        "font embedded"
    );
}

#[test]
fn a_word_of_the_provenance_is_found_in_the_bytes_of_every_format_whatever_stands_beside_it() {
    let word = b"zwidth:figures:3:0f";
    for beside in ["", "{\"title\": \"Crème – θ\"}", "<&>"] {
        let (_, figure) = gallery::figures().remove(0);
        let provenance = Some(format!("{beside} zwidth:figures:3:0f"));
        let drawing = draw(&Figure { provenance, ..figure }).unwrap();
        let files = [
            drawing.svg().unwrap().into_bytes(),
            drawing.pdf().unwrap(),
            drawing.png(50.0).unwrap(),
        ];
        for (format, bytes) in ["SVG", "PDF", "PNG"].iter().zip(files) {
            assert!(bytes.windows(word.len()).any(|w| w == word), "{format} beside '{beside}'");
        }
    }
}

#[test]
fn marks_above_and_below_one_letter_can_be_drawn_in_every_format() {
    let (_, figure) = gallery::figures().remove(0);
    for title in ["c\u{30c}\u{323}", "mode x\u{301}\u{323}", "\u{10d}\u{323}"] {
        let drawing = draw(&Figure { title: Some(title.to_owned()), ..figure.clone() }).unwrap();
        assert!(
            drawing.svg().is_ok() && drawing.pdf().is_ok() && drawing.png(50.0).is_ok(),
            "{title}"
        );
    }
}

#[test]
fn an_image_has_the_size_on_paper_that_its_figure_asks_for() {
    let drawing = &GALLERY["characteristic"];
    let image =
        ::png::Decoder::new(std::io::Cursor::new(drawing.png(200.0).unwrap())).read_info().unwrap();
    let info = image.info();
    assert_eq!(info.width, (ONE_COLUMN_MM / 25.4 * 200.0).round() as u32);
    assert_eq!(info.pixel_dims.unwrap().xppu, 7874);
    assert!(matches!(drawing.png(0.0), Err(Error::Size { what: "dpi", .. })));
    assert!(matches!(drawing.png(1e9), Err(Error::Size { what: "dpi", .. })));
    assert!(matches!(drawing.png(f64::NAN), Err(Error::Size { what: "dpi", .. })));
}

#[test]
fn a_figure_of_fixed_height_is_that_high() {
    for (_, mut figure) in gallery::figures() {
        figure.height_mm = Some(120.0);
        let (width_pt, height_pt) = draw(&figure).unwrap().size_pt;
        let (width_mm, height_mm) = (width_pt / PT_PER_MM, height_pt / PT_PER_MM);
        assert!((height_mm - 120.0).abs() < 1e-9 && (width_mm - figure.width_mm).abs() < 1e-9);
    }
}

#[test]
fn a_long_recording_makes_a_small_file() {
    let x: Vec<f64> = (0..200_000).map(|i| f64::from(i) / 1000.0).collect();
    let y = x.iter().map(|x| (x / 20.0).sin()).collect();
    let line = Layer::Line(Line { x, y, ..Line::default() });
    let panel = Panel::new(Cell::at(0, 0), Axis::new("t", "s"), Axis::new("x", "m"), vec![line]);
    let figure = Figure { panels: vec![panel], ..Figure::default() };
    let svg = draw(&figure).unwrap().svg().unwrap();
    assert!(svg.len() < 30_000, "{} bytes", svg.len());
}

#[test]
fn words_as_text_take_the_documents_font_and_keep_their_widths() {
    let drawing = GALLERY.values().next().unwrap();
    let own = drawing.svg_with_text(None).unwrap();
    let other = drawing.svg_with_text(Some("Latin Modern \"Roman'")).unwrap();
    assert!(
        other.contains("font-family=\"'Latin Modern &quot;Roman\\'', 'Noto Sans'"),
        "{other:.400}"
    );
    let widths = |svg: &str| -> Vec<String> {
        svg.split("textLength=").skip(1).map(|rest| rest[..8].to_owned()).collect()
    };
    assert!(!widths(&own).is_empty() && widths(&own) == widths(&other));
    assert!(Tree::from_str(&other, &Options::default()).is_ok());
}

#[test]
fn words_as_text_can_be_searched_and_every_reader_shows_them() {
    let figure = Figure { footnotes: vec!["a *note* < 1".into()], ..one_line() };
    let drawing = draw(&figure).unwrap();
    let (text, outlines) = (drawing.svg_with_text(None).unwrap(), drawing.svg().unwrap());
    for words in [
        ">note </text>",
        ">&lt; 1</text>",
        ">time (s)</text>",
        "font-style=\"italic\"",
        "rotate(-90)",
    ] {
        assert!(text.contains(words), "{words} is not in {text}");
    }
    assert!(!text.contains("<use") && !outlines.contains("<text"));
    assert!(Tree::from_str(&text, &Options::default()).is_ok());
}

#[test]
fn a_bare_figure_leaves_heading_and_small_print_to_its_caption_and_keeps_its_stamp() {
    let whole = Figure {
        title: Some("A heading".into()),
        footnotes: vec!["small print".into()],
        mark: Some("SYNTHETIC".into()),
        ..one_line()
    };
    let [whole, bare] =
        [false, true].map(|bare| draw(&Figure { bare, ..whole.clone() }).unwrap().svg().unwrap());
    let is_drawn = |svg: &str, words: &str| svg.contains(&format!("aria-label=\"{words}"));
    assert!(is_drawn(&whole, "A heading") && is_drawn(&whole, "small print"));
    assert!(!is_drawn(&bare, "A heading") && !is_drawn(&bare, "small print"));
    assert!(is_drawn(&bare, "SYNTHETIC") && bare.contains("<title>A heading</title>"));
}

#[test]
fn a_stamp_that_takes_more_than_half_of_a_narrow_figure_stands_above_its_heading() {
    let fonts = Fonts::bundled().unwrap();
    let figure = Figure {
        title: Some("A heading that takes more than half of the figure's width".into()),
        mark: Some("SYNTHETIC: simulated, not measured".into()),
        width_mm: ONE_COLUMN_MM,
        ..one_line()
    };
    let placed = |width_mm: f64| {
        let figure = Figure { width_mm, ..figure.clone() };
        let plan = layout::plan(&figure, fonts).unwrap();
        let (_, stamp) = plan.mark.unwrap();
        assert!(stamp.left > 0.0 && stamp.right < plan.width_pt);
        assert!(stamp.bottom < plan.panels[0].plot.top);
        (stamp, plan.title.1.1)
    };
    let (narrow, wide) = (placed(ONE_COLUMN_MM), placed(2.0 * ONE_COLUMN_MM));
    assert!(narrow.0.bottom < narrow.1 && wide.0.bottom > wide.1);
    let too_narrow = Figure { width_mm: 40.0, ..figure };
    let refused = layout::plan(&too_narrow, fonts).unwrap_err();
    assert!(matches!(refused, Error::TextTooLong { .. }), "{refused}");
}

#[test]
fn a_panel_grows_until_the_names_of_its_rows_have_room() {
    let height_pt = |names: Vec<String>, width_mm: f64| {
        let mut figure = Figure { width_mm, ..one_line() };
        let panel = &mut figure.panels[0];
        panel.height_mm = Some(8.0 * names.len() as f64);
        panel.y = Axis::categories(names);
        let drawing = draw(&figure).unwrap();
        assert_eq!(drawing.overlapping_words().unwrap(), [] as [[String; 2]; 0]);
        drawing.size_pt.1
    };
    for width_mm in [ONE_COLUMN_MM, TWO_COLUMNS_MM] {
        let short = height_pt(vec!["Spring: Hybrid − Active".to_owned(); 2], width_mm);
        let long = height_pt(vec!["<script>alert(1)</script>".repeat(12); 2], width_mm);
        assert!(long > 1.5 * short, "{short} and {long} pt");
    }
}

/// A figure of one line with names on its axes.
fn one_line() -> Figure {
    let line = Line { x: vec![0.0, 1.0], y: vec![0.0, 1.0], ..Line::default() };
    one_panel(vec![Layer::Line(line)])
}

fn one_panel(layers: Vec<Layer>) -> Figure {
    let (x, y) = (Axis::new("time", "s"), Axis::new("force", "N"));
    Figure { panels: vec![Panel::new(Cell::at(0, 0), x, y, layers)], ..Figure::default() }
}

/// Numbers that have broken plots before, among ordinary ones.
fn number() -> impl Strategy<Value = f64> {
    let odd = [
        0.0,
        -0.0,
        1.0,
        1e-321,
        1e-9,
        1e300,
        -1e308,
        f64::MAX,
        f64::NAN,
        f64::INFINITY,
        1e6 + 1e-9,
    ];
    prop_oneof![-10.0..10.0, proptest::sample::select(odd.to_vec())]
}

fn any_axis() -> impl Strategy<Value = Axis> {
    let range = prop_oneof![
        Just(Range::Auto),
        Just(Range::Tight),
        (number(), number()).prop_map(|(low, high)| Range::Holding(low, high)),
        (number(), number()).prop_map(|(low, high)| Range::Fixed(low, high))
    ];
    (range, any::<bool>(), "[a-zθ*_^{}\\\\ ]{0,12}", 0..3).prop_map(
        |(range, linked, label, kind)| {
            let axis = match kind {
                0 => Axis::categories(["a", "b c"]),
                1 => Axis { ticks: Ticks::Powers, ..Axis::new(label, "N") },
                _ => Axis::new(label, "N"),
            };
            let axis = axis.ranged(range);
            if linked { axis.linked("shared") } else { axis }
        },
    )
}

fn any_layer() -> impl Strategy<Value = Layer> {
    let numbers = || proptest::collection::vec(number(), 4);
    (0..6, numbers(), numbers(), numbers(), number()).prop_map(
        |(kind, x, low, high, at)| match kind {
            0 => Layer::Line(Line {
                x,
                y: low,
                dotted: high.iter().map(|v| *v > 0.0).collect(),
                ..Line::default()
            }),
            1 => Layer::Band(Band { x, low, high, ..Band::default() }),
            2 => Layer::Points(Points { x, y: low, ..Points::default() }),
            3 => Layer::Intervals(Intervals {
                marker: style::Marker::Diamond,
                name: Some("interval".into()),
                ..Intervals::new(Direction::Vertical, x, [low.clone(), low, high])
            }),
            4 => Layer::Likert(Likert {
                answers: ["no", "", "yes"].map(String::from).to_vec(),
                rows: [x, low]
                    .map(|row| vec![row[..3].iter().map(|v| *v as u32).collect()])
                    .to_vec(),
                scale: LikertScale::Counts,
            }),
            _ => Layer::Reference(Reference {
                label: Some("here".into()),
                ..Reference::new(Direction::Horizontal, at, style::reference())
            }),
        },
    )
}

proptest! {
    #[test]
    fn any_numbers_give_a_drawing_or_an_error_never_a_panic(
        (x, y) in (any_axis(), any_axis()),
        layers in proptest::collection::vec(any_layer(), 0..4),
        width_mm in prop_oneof![1.0..300.0, number()],
    ) {
        let panel = Panel::new(Cell::at(0, 0), x, y, layers);
        let below = Panel { cell: Cell::at(1, 0), ..panel.clone() };
        if let Ok(drawing) = draw(&Figure { width_mm, panels: vec![panel, below], ..Figure::default() }) {
            let svg = drawing.svg().unwrap();
            prop_assert!(Tree::from_str(&svg, &Options::default()).is_ok());
            prop_assert!(!svg.contains("NaN") && !svg.contains("inf"));
            prop_assert!(drawing.png(20.0).is_ok() && drawing.pdf().is_ok());
        }
    }
}

/// A figure of the gallery in a font of these files.
fn in_font(files: &[FontFile]) -> Drawing {
    let (_, figure) = gallery::figures().remove(0);
    draw(&Figure { font: Some(Font::new(files).unwrap()), ..figure }).unwrap()
}

#[test]
fn a_figure_in_a_font_of_ones_own_is_laid_out_by_its_widths_and_embeds_it() {
    let (_, figure) = gallery::figures().remove(0);
    let usual = draw(&figure).unwrap();
    let same = in_font(&Style::ALL.map(file));
    let bold = in_font(&[file(Style::Bold)]);
    assert_eq!(same.size_pt, usual.size_pt);
    let width = |drawing: &Drawing| -> f64 {
        let advance = |shape: &Shape| match &shape.form {
            sheet::Form::Words { piece, .. } => f64::from(piece.advance) * piece.size_pt,
            _ => 0.0,
        };
        drawing.shapes.iter().map(advance).sum()
    };
    assert_eq!(width(&same), width(&usual), "the bundled font as one of one's own");
    assert!(width(&bold) > 1.02 * width(&usual), "bold letters are wider");
    assert_eq!(bold.overlapping_words().unwrap(), [] as [[String; 2]; 0]);
    let embeds = |drawing: &Drawing, name: &[u8]| {
        drawing.pdf().unwrap().windows(name.len()).any(|bytes| bytes == name)
    };
    assert!(embeds(&bold, b"NotoSans-Bold") && !embeds(&bold, b"NotoSans-Italic"));
    assert!(embeds(&usual, b"NotoSans-Italic"));
    assert!(bold.png(50.0).unwrap() != usual.png(50.0).unwrap());
    assert!(!bold.svg().unwrap().contains("\"#r"), "no glyph of the bundled font");
    assert!(bold.svg_with_text(None).unwrap().contains("font-family=\"'Noto Sans', "));
}

#[test]
fn a_letter_that_a_font_of_ones_own_lacks_is_set_in_the_bundled_one_and_found_in_the_text() {
    let file = file_with_letters(Style::Bold, " adehnstv");
    let (_, figure) = gallery::figures().remove(0);
    let title = Some("the dashed θ̇ stands at 5 ṣ̂".to_owned());
    let font = Some(Font::new(&[file]).unwrap());
    let drawing = draw(&Figure { title, font, ..figure }).unwrap();
    let pieces: Vec<(&str, bool)> = drawing
        .shapes
        .iter()
        .filter_map(|shape| match &shape.form {
            sheet::Form::Words { piece, .. } => Some((piece.text.as_str(), piece.face.is_own)),
            _ => None,
        })
        .collect();
    let title = [("the dashed ", true), ("θ̇", false), (" stands at ", true), ("5", false)];
    assert_eq!(pieces[..4], title, "{pieces:?}");
    assert!(drawing.svg().is_ok() && drawing.pdf().is_ok() && drawing.png(50.0).is_ok());
    let lacking = Figure {
        title: Some("中".into()),
        font: drawing.font.clone(),
        ..gallery::figures().remove(0).1
    };
    assert!(matches!(draw(&lacking), Err(Error::Letter { letter: '中', .. })));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn a_damaged_font_gives_a_drawing_or_an_error_never_a_panic(
        places in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..200),
        cut in prop::option::of(any::<prop::sample::Index>()),
    ) {
        let mut damaged = file(Style::Regular);
        let bytes = Arc::make_mut(&mut damaged.bytes);
        for (place, value) in places {
            // The first bytes say where everything is: half of the damage is done there.
            let reach = if value % 2 == 0 { 1000 } else { bytes.len() };
            let place = place.index(reach);
            bytes[place] = value;
        }
        if let Some(cut) = cut {
            bytes.truncate(cut.index(bytes.len()));
        }
        let (_, figure) = gallery::figures().remove(0);
        // Where letters seem to be wider than they are, the error is that a text has no room.
        let _ = Font::new(&[damaged]).and_then(|font| {
            let drawing = draw(&Figure { font: Some(font), ..figure })?;
            drawing.svg()?;
            drawing.png(30.0)?;
            drawing.pdf()
        });
    }
}
