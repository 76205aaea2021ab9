//! Stage: tallies of the answers to Likert questions.
//!
//! [`tally`] counts, for each environment × mode, how often each point of a question's scale was
//! chosen: one row per question, and one per group of questions with its answers pooled. An answer
//! to a reversed question (where agreement is unfavourable) counts from the other end (6 − a on a
//! scale from 1 to 5: lowest + highest − a), so that the last point is always the favourable one.
//! Only answers that were given are counted: an unanswered question is not a 0, and a condition
//! nobody answered for has no row.
//!
//! A scale of up to [`zwidth_study::AnswerScale::MOST_CATEGORIES`] points is ordinal: there is a
//! median and no mean. On a longer one (0 to 100) answers are a quantity, with quartiles and a mean
//! instead of counts; answers on a line, which may have decimals, count with their own numbers.
//! Answers pooled over a group come from the same people, so `n` there is a number of answers, not
//! of independent ones; `participants` says of how many people.
//!
//! [`long`] gives the answers themselves, one row each, as they were given: those that count, and the
//! others with the reason.
//!
//! The question which mode it was is different: its answers are names, and are in no tally.
//! [`blinding`] counts how often they were right.
//!
//! [`scores`] makes one number of several answers after a trial (TLX, SUS, means, sums); it is compared as a
//! metric. [`reliability`] says how far these answers hang together.
//!
//! Pure: answers in memory, rows out. Only answers that count may come into a tally
//! (`StudyData::answers` gives those).

mod blinding;
mod counts;
mod long;
#[cfg(test)]
mod real_data;
mod scores;
mod tally;
#[cfg(test)]
mod tests;

pub use blinding::{Blinding, Guess, blinding, blinding_table};
pub use long::{long, long_table};
pub use scores::{AnsweredTrial, Scoring, reliability, scores};
pub use tally::{LikertError, Scheme, tally, tally_table};

/// Version of the algorithms here: a change of any number they give raises it.
pub const VERSION: u32 = 8;
