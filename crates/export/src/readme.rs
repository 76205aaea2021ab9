//! `README.md`: what somebody who gets the folder reads first.

use crate::contents::Contents;
use crate::data_package::Resource;
use crate::{Asked, Format, samples};
use zwidth_study::counted;

/// The text.
pub(crate) fn readme(contents: &Contents, asked: &Asked, resources: &[Resource]) -> String {
    let Contents { title, study, source, trials, .. } = contents;
    let mark = if contents.is_simulated {
        "\n**SYNTHETIC: simulated, not measured.** The column `source` says which rows: `twin` and `simulated` were not measured.\n"
    } else {
        ""
    };
    let licence = match &asked.licence {
        Some(licence) => format!("{licence}, see LICENCE."),
        None => "TODO: no licence was chosen yet, and so nobody may use the data. See LICENCE."
            .to_owned(),
    };
    let mut text = format!(
        "# {title}\n{mark}\nThe trials of the force-feedback study `{study}` that count: {}, with {}. Source of the numbers: {source}. \
         Exported on {} by {}. Licence: {licence}\n\n",
        counted(rows(contents, "trials"), "trials"),
        if trials.is_empty() {
            "answers alone".to_owned()
        } else {
            format!("samples of {}", trials.len())
        },
        asked.date,
        asked.software,
    );
    text += "## Files\n\n| file | what it holds |\n|---|---|\n";
    for Resource { title, path, .. } in resources {
        text += &format!("| `{path}` | {title} |\n");
    }
    text += "| `tables/*.parquet` | the same tables as Parquet |\n| `dictionary.csv` | type, unit and definition of each column |\n";
    if asked.formats.contains(&Format::Bids) {
        text += "| `bids/` | samples as a BIDS dataset (motion); forces are `MISC` there |\n";
    }
    if asked.formats.contains(&Format::Mcap) {
        text += "| `mcap/` | samples as MCAP, JSON messages, a file for each trial |\n";
    }
    if asked.formats.contains(&Format::Mat) {
        text += "| `mat/` | samples and tables as MAT files; a missing number is NaN there, and texts are ASCII |\n";
    }
    if asked.formats.contains(&Format::Xlsx) {
        text += "| `tables.xlsx` | the tables as a workbook |\n";
    }
    text += "| `study.toml` | what was planned: environments, modes, questions, analysis |\n\
             | `datapackage.json`, `ro-crate-metadata.json` | all this for programs (Data Package 2.0, RO-Crate 1.2) |\n\
             | `CITATION.cff`, `LICENCE` | how to cite, and what may be done with the data |\n\
             | `SHA256SUMS` | checksums: `sha256sum -c SHA256SUMS` |\n\n";
    text += "All quantities are in SI units, angles in radians, times in seconds since the trial began. An empty cell is a missing \
             value; nothing is written as 0 that was not measured. Rows of `trials` have the key participant, session, trial, which \
             the other tables share.\n\n";
    text += "```python\nimport pandas as pd\ntrials = pd.read_csv(\"tables/trials.csv\")\n";
    if !trials.is_empty() {
        text += &format!("samples = pd.read_parquet(\"{}\")\n", samples::PARQUET);
    }
    text += "```\n\n```r\ntrials <- read.csv(\"tables/trials.csv\")\n```\n\n";
    text += &read_back(contents);
    text += "## What was left out\n\n";
    for line in &contents.left_out {
        text += &format!("* {line}\n");
    }
    if contents.is_renamed {
        text += "\nParticipants have random codes, and rows are in the order of these. Hashes and origins of files are left out. **What \
                 this cannot hide:** the order of the modes in a session follows the participant's number in the study, so whoever knows \
                 the plan and its seed may find the number; and whoever knows how a person moved may know them by it.\n";
    }
    text
}

/// How the samples come back into zwidth.
fn read_back(contents: &Contents) -> String {
    let study = &contents.study;
    if contents.trials.is_empty() || contents.tasks {
        let why = if contents.tasks {
            "Samples of tasks cannot be imported again with their levels"
        } else {
            "There are no samples"
        };
        return format!(
            "## Into zwidth again\n\n{why}; answers can: `zwidth answer STUDY --from tables/answers.csv`.\n\n"
        );
    }
    let people = match contents.people {
        Some(_) => format!("cp import/participants.csv raw/{study}/\n"),
        None => String::new(),
    };
    format!(
        "## Into zwidth again\n\n```sh\nmkdir -p raw/{study} && cp study.toml raw/{study}/\n{people}\
         zwidth import {study} --map import/samples.toml samples.parquet\n\
         zwidth answer {study} --from tables/answers.csv    # if there are answers\n```\n\n\
         The samples come back to the last bit. Their source is `imported` then, or `simulated`.\n\n"
    )
}

fn rows(contents: &Contents, table: &str) -> usize {
    let own = contents.tables.iter().find(|own| own.table.name() == table);
    own.map_or(0, |own| own.table.height())
}
