//! Figures of what is compared: metrics by mode, participant, session and repeat; answers.

pub(crate) mod answers;
pub(crate) mod compared;
pub(crate) mod likert;
pub(crate) mod ratings;

pub use answers::{ANSWERS_COMPARED, AnswersPage, answers_compared, answers_pages};
pub use compared::{
    MODES_COMPARED, MetricResults, PARTICIPANTS_COMPARED, REPEATS_COMPARED, SESSIONS_COMPARED,
    modes_compared, participants_compared, repeats_compared, sessions_compared,
};
pub use likert::{LIKERT, LIKERT_ITEMS, LikertPage, likert, likert_items, likert_overview};
pub use ratings::{RATINGS, RatingsPage, ratings, ratings_pages};
