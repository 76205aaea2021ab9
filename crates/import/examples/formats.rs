//! The time and the channels of a file of another program, read and added up: seconds, and their sum. `cargo run --release
//! -p zwidth-import --features testing --example formats -- FORMAT FILE [PART]`
#![allow(clippy::print_stdout)] // it is run by hand, or by benches/formats

use std::error::Error;
use std::time::Instant;
use zwidth_import::readers::readers;

fn main() -> Result<(), Box<dyn Error>> {
    let mut given = std::env::args().skip(1);
    let format = given.next().ok_or("which format?")?;
    let file = given.next().ok_or("which file?")?;
    let part = given.next().filter(|part| !part.is_empty());
    let reader = readers().find(|reader| reader.word() == format).ok_or("no such format")?;
    let begun = Instant::now();
    let sum = reader.sum(std::fs::read(file)?, part.as_deref())?;
    println!("{} {sum:e}", begun.elapsed().as_secs_f64());
    Ok(())
}
