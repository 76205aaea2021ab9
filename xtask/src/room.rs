//! `cargo xtask room`: checks that the words of every figure have room and are large enough to be
//! read, in one column and in two.

use crate::shell::{program, scratch, words};
use crate::soak::run;
use anyhow::ensure;
use std::path::Path;
use zwidth_draw::style::SMALL_PT;
use zwidth_draw::{Figure, draw};
use zwidth_store::{Layout, StudyData};

/// Widths on paper, mm.
const WIDTHS_MM: [f64; 2] = [85.0, 170.0];
/// Studies besides the one that comes along, with more people and with more sessions, which have
/// figures of their own.
const SIMULATED: [(&str, &str); 2] =
    [("people", "--participants 8 --sessions 1"), ("sessions", "--participants 3 --sessions 2")];

/// Simulates two studies in a folder and looks at their figures, and at those of the study that
/// comes along, which has been run.
pub(crate) fn room() -> anyhow::Result<()> {
    let program = program()?;
    let folder = scratch("room");
    look(Path::new("."), "thesis-twin")?;
    for (study, size) in SIMULATED {
        let twin = format!("--quiet twin {study} {size}");
        // A simulated study may be read with care, which is not what is looked at here.
        run(&program, &folder, &words(&twin), &[0, 3])?;
        run(&program, &folder, &["--quiet", "run", study], &[0, 3])?;
        look(&folder, study)?;
    }
    Ok(())
}

/// Draws every figure of a study that has been run, at each width.
pub(crate) fn look(root: &Path, study: &str) -> anyhow::Result<()> {
    let data = StudyData::load(&Layout::new(root, study.parse()?)).map_err(|findings| {
        anyhow::anyhow!("{study}: {} findings; see `zwidth verify`", findings.len())
    })?;
    let font = zwidth_plan::font(&data).map_err(|error| anyhow::anyhow!("{study}: {error}"))?;
    let mut drawn = 0;
    let mut crowded = Vec::new();
    let mut small = Vec::new();
    for (name, _) in zwidth_plan::captions(&data) {
        let Some(described) = zwidth_plan::describe(&data, &name) else { continue };
        let (figure, _) = described.map_err(|error| anyhow::anyhow!("{name}: {error}"))?;
        for width_mm in WIDTHS_MM {
            let font = font.clone();
            match draw(&Figure { width_mm, height_mm: None, font, ..figure.clone() }) {
                // What has no room is refused, with what to do, and not drawn over itself.
                Err(error) => println!("{study}, {name} at {width_mm} mm is refused: {error}"),
                Ok(drawing) => {
                    drawn += 1;
                    for [a, b] in drawing.overlapping_words()? {
                        crowded.push(format!("{name} at {width_mm} mm: “{a}” and “{b}”"));
                    }
                    for word in drawing.small_words() {
                        small.push(format!("{name} at {width_mm} mm: “{word}”"));
                    }
                }
            }
        }
    }
    println!("{study}: {drawn} figures drawn");
    ensure!(small.is_empty(), "{study}: words below {SMALL_PT} pt\n{}", small.join("\n"));
    ensure!(crowded.is_empty(), "{study}: words lie on each other\n{}", crowded.join("\n"));
    Ok(())
}
