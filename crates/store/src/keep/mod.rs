//! Whatever changes a study: sessions laid down, trials recorded, several files changed as one, and
//! what a kill left brought in order.

pub(crate) mod accept;
pub mod commit;
pub(crate) mod journal;
pub(crate) mod lay_down;
pub(crate) mod mend_log;
pub(crate) mod open_log;
pub(crate) mod open_session;
pub(crate) mod record;
pub(crate) mod recover;
pub(crate) mod recovered;
pub(crate) mod stream;
pub(crate) mod sweep_log;
