//! Thresholds over people: the second job of the stage, which takes what the stage `compare` found.

use crate::compare;
use crate::shared::handle::{Derived, write_named};
use crate::thresholds::{STAGE, answered, fits, is_simulated, over_people};
use serde::Serialize;
use zwidth_results::{Mean, ModeDifference, PsychometricFit};
use zwidth_runner::{Inputs, Job, JobError, Made, Making};
use zwidth_store::StudyData;
use zwidth_study::{Contrast, Task};
use zwidth_tables::Table;
use zwidth_thresholds::Means;

/// What thresholds over people depend on besides tables.
#[derive(Serialize)]
struct OverPeople {
    tasks: Vec<Task>,
    contrasts: Vec<Contrast>,
    level: f64,
    simulated: bool,
}

/// Everybody's fits, and what was found of their numbers where modes are compared.
type Found = (Derived<PsychometricFit>, Option<(Derived<Mean>, Derived<ModeDifference>)>);

/// The job over people, which reads what the stage `compare` found.
pub(crate) fn jobs(data: &StudyData) -> Vec<Job> {
    let (Some(fits), Some(results)) = (fits(data), over_people(data)) else { return Vec::new() };
    let parameters = OverPeople {
        tasks: data.study.tasks.clone(),
        contrasts: data.study.compare.contrasts.clone(),
        level: data.study.compare.level,
        simulated: is_simulated(&answered(data)),
    };
    let compared = compare::of_study(data).map(|tables| (tables.table(), tables.table()));
    let inputs: Found = (fits, compared);
    vec![Job::new(STAGE, "thresholds over people", parameters, inputs, results.files(), make_over)]
}

fn make_over(
    parameters: &OverPeople,
    (fits, compared): &Found,
    making: &Making,
) -> Result<Made, JobError> {
    let fits = fits.read()?;
    let (means, contrasts) = match compared {
        Some((means, contrasts)) => (means.read()?, contrasts.read()?),
        None => (Vec::new(), Vec::new()),
    };
    let OverPeople { tasks, contrasts: asked, level, simulated } = parameters;
    let found = Means { asked, means: &means, contrasts: &contrasts };
    let rows = zwidth_thresholds::over_people(tasks, &fits, found, *level);
    let table = Table::of_rows(&rows)?.with_note(
        "Of a JND means are geometric and differences of modes are ratios: it is compared by its natural logarithm. The \
         test is Student's t of everybody's differences. Beside it the two-level model weighs people by the errors of \
         their own fits (Paule–Mandel, Hartung–Knapp); no claim rests on it.",
    );
    write_named(vec![table], making, *simulated)
}
