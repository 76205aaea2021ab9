//! What the jobs of every stage share: conditions, handles of tables, trials, successes.

pub(crate) mod conditions;
pub(crate) mod handle;
pub(crate) mod making;
pub(crate) mod measured;
pub(crate) mod own_stages;
pub(crate) mod trials;
