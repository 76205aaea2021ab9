//! `cargo xtask sheet`: every figure of a study at print size on pages for a reviewer. Beside each
//! figure are its versions in grey and for an eye without green cones; its caption is below.

use anyhow::{Context as _, ensure};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// How a page looks: A3 upright, so that a figure 175 mm wide has room beside it.
const STYLE: &str = "@page { size: A3; margin: 12mm } body { font: 9pt sans-serif; margin: 8mm; color: #222 }
section { display: grid; grid-template-columns: max-content 88mm; gap: 2mm 6mm; break-inside: avoid; margin: 0 0 9mm }
h2, p { grid-column: 1 / 3; margin: 0 } h2 { font-size: 10pt } p { max-width: 175mm; white-space: pre-line }
aside img { width: 88mm; display: block; margin-bottom: 3mm }
.grey { filter: grayscale(1) } .deuteranopia { filter: url(#deuteranopia) }";

/// Deuteranopia on linear sRGB, rows of red, green and blue: Machado, Oliveira & Fernandes 2009,
/// doi:10.1109/TVCG.2009.113, severity 1.
const DEUTERANOPIA: &str = "<svg width=\"0\" height=\"0\" style=\"position:absolute\"><filter id=\"deuteranopia\" \
color-interpolation-filters=\"linearRGB\"><feColorMatrix values=\"0.367322 0.860646 -0.227968 0 0 \
0.280085 0.672501 0.047413 0 0 -0.011820 0.042940 0.968881 0 0 0 0 0 1 0\"/></filter></svg>";

/// Writes the sheet of the figures in `figures` into `folder`.
pub(crate) fn write(figures: &Path, folder: &Path) -> anyhow::Result<()> {
    let pictures = pictures(figures)?;
    std::fs::create_dir_all(folder)?;
    let mut page = format!(
        "<!doctype html>\n<html lang=\"en\"><meta charset=\"utf-8\"><title>Figures at print size</title>\
         <style>{STYLE}</style>\n{DEUTERANOPIA}\n"
    );
    for picture in &pictures {
        let name = picture.file_stem().unwrap_or_default().to_string_lossy();
        std::fs::copy(picture, folder.join(format!("{name}.svg")))?;
        let caption = std::fs::read_to_string(picture.with_extension("txt")).unwrap_or_default();
        let name = escape(&name);
        let caption = escape(caption.trim());
        let image = |class: &str| format!("<img class=\"{class}\" src=\"{name}.svg\" alt=\"\">");
        writeln!(
            page,
            "<section><h2>{name}</h2><div>{}</div><aside>{}{}</aside><p>{caption}</p></section>",
            image("print"),
            image("grey"),
            image("deuteranopia")
        )?;
    }
    let index = folder.join("index.html");
    std::fs::write(&index, page + "</html>\n")?;
    println!("{} figures: {}", pictures.len(), index.display());
    Ok(())
}

/// The SVGs of a folder, in the order of their names.
fn pictures(figures: &Path) -> anyhow::Result<Vec<PathBuf>> {
    let entries = std::fs::read_dir(figures).with_context(|| {
        format!("no figures in {}; make them with `zwidth run`", figures.display())
    })?;
    let paths = entries.map(|entry| Ok(entry?.path())).collect::<std::io::Result<Vec<_>>>()?;
    let is_svg = |path: &PathBuf| path.extension().is_some_and(|extension| extension == "svg");
    let mut pictures: Vec<PathBuf> = paths.into_iter().filter(is_svg).collect();
    pictures.sort();
    ensure!(!pictures.is_empty(), "no figures in {}", figures.display());
    Ok(pictures)
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;")
}
