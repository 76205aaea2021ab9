//! Loads a study and makes every finding: the files are compared with each other, with the logs,
//! with the plan and with what is plausible.

pub(crate) mod alike;
pub(crate) mod beside;
pub(crate) mod calibrated;
pub(crate) mod fit;
pub(crate) mod laid;
pub(crate) mod lately;
pub(crate) mod logged_sweeps;
pub(crate) mod one_form;
pub(crate) mod open;
pub(crate) mod outside;
pub(crate) mod people;
pub(crate) mod plausible;
pub(crate) mod samples;
pub(crate) mod sealed;
pub(crate) mod sessions;
pub(crate) mod sources;
pub(crate) mod study;
pub(crate) mod tasks;
pub(crate) mod thin;
pub(crate) mod verify;
pub(crate) mod whole;
