//! Everything that changes a study: setting up sessions, recording trials, changing several files
//! as one, and repairs after a kill.

pub(crate) mod accept;
pub(crate) mod beside_log;
pub mod commit;
pub(crate) mod journal;
pub(crate) mod lay_down;
pub(crate) mod mend_log;
pub(crate) mod new_folder;
pub(crate) mod open_log;
pub(crate) mod open_session;
pub(crate) mod outside_log;
pub(crate) mod record;
pub(crate) mod recover;
pub(crate) mod recovered;
pub(crate) mod stream;
pub(crate) mod sweep_log;
