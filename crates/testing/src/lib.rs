//! What the tests of several crates begin with. Only dev-dependencies lead here.
#![expect(clippy::unwrap_used, reason = "a fixture that cannot be made is a failed test")]

use zwidth_study::{Kind, Source, Status, Study, TrialMeta, template};

/// The study of the template, called `demo`: a spring and a spring with a wall, each rendered by
/// motor, by brake and by both.
#[expect(clippy::missing_panics_doc, reason = "the template is a study")]
pub fn study() -> Study {
    Study::from_toml(&template(&"demo".parse().unwrap())).unwrap()
}

/// The metadata of the trial with that number: a repeat of `spring` in a mode, whole, simulated.
#[expect(clippy::missing_panics_doc, reason = "a mode's name that is none is a failed test")]
pub fn meta(trial: u32, mode: &str) -> TrialMeta {
    TrialMeta {
        participant: "P01".parse().unwrap(),
        session: "S01".parse().unwrap(),
        trial,
        repeat: trial,
        kind: Kind::Trial,
        status: Status::Complete,
        environment: "spring".parse().unwrap(),
        mode: mode.parse().unwrap(),
        likert: None,
        source: Source::Twin,
        presented: None,
    }
}
