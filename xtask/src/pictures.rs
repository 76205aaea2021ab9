//! `cargo xtask pictures`: the figures in README and docs, as the program makes them.

use crate::shell::{program, scratch, words};
use crate::soak::run;
use anyhow::{Context as _, ensure};
use std::path::{Path, PathBuf};

/// Where they lie.
const FOLDER: &str = "docs/pictures";
/// The study that comes along, of which they are.
const STUDY: &str = "thesis-twin";
/// Which, and at which width on paper, mm.
const PICTURES: [(&str, &str); 6] = [
    ("modes.P01.S01.spring_wall", "175"),
    ("likert", "120"),
    ("compare.wall_past_max_rad", "120"),
    ("characteristic.brake", "120"),
    ("replay.P01.S01.spring", "175"),
    ("scenes.figure_11", "85"),
];
/// Small files for a screen.
const DPI: &str = "110";

/// Makes each picture with the program; writes it where `renew`, else compares it dot by dot.
pub(crate) fn pictures(renew: bool) -> anyhow::Result<()> {
    let program = program()?;
    let folder = scratch("pictures");
    let mut other = Vec::new();
    for (name, width_mm) in PICTURES {
        let made = draw(&program, &folder, name, width_mm)?;
        let kept = Path::new(FOLDER).join(format!("{name}.png"));
        if renew {
            std::fs::create_dir_all(FOLDER)?;
            std::fs::copy(&made, &kept)?;
        } else if !kept.is_file() || dots(&made)? != dots(&kept)? {
            other.push(name);
        }
    }
    let verb = if renew { "written" } else { "compared" };
    println!("{} pictures {verb} in {FOLDER}", PICTURES.len());
    ensure!(
        other.is_empty(),
        "not what the program makes: {}; look at them, then `cargo xtask pictures renew`",
        other.join(", ")
    );
    Ok(())
}

/// The PNG of a figure.
fn draw(program: &Path, folder: &Path, name: &str, width_mm: &str) -> anyhow::Result<PathBuf> {
    let size = format!("--size {width_mm} --dpi {DPI} --format png");
    let to = folder.display().to_string();
    let line = format!("--quiet figure {STUDY} {name} {size} --out");
    run(program, Path::new("."), &[words(&line), vec![to.as_str()]].concat(), &[0])?;
    Ok(folder.join(format!("{name}.png")))
}

/// Size and dots of a PNG; what it says of its making is left out.
fn dots(file: &Path) -> anyhow::Result<(u32, u32, Vec<u8>)> {
    let bytes = std::fs::File::open(file).with_context(|| file.display().to_string())?;
    let mut reader = png::Decoder::new(std::io::BufReader::new(bytes)).read_info()?;
    let size = reader.output_buffer_size().context("a picture of that size")?;
    let mut dots = vec![0; size];
    let frame = reader.next_frame(&mut dots)?;
    dots.truncate(frame.buffer_size());
    Ok((frame.width, frame.height, dots))
}
