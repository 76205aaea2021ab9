//! What the stage `likert` finds: the answers, their tallies, and who knew the mode. The scales of
//! the study determine the columns of counts and sums, and whether answers are whole numbers.

use crate::row::{of_trial, rows};
use crate::sentence::Sentence;
use std::sync::Arc;
use zwidth_study::{
    AnswerValue, EnvironmentId, MetricId, ModeId, ParticipantId, QuestionId, SessionId,
};

rows! {
    /// An answer as it was given.
    GivenAnswer = "answers", "Answers as given, one row per answer" {
        /// who
        participant: ParticipantId,
        /// in which session
        session: SessionId,
        /// after which trial of the session
        trial: u32,
        /// what was rendered
        environment: EnvironmentId,
        /// how it was rendered; a code while the session is sealed
        mode: ModeId,
        /// the question
        question: QuestionId,
        /// the answer as given
        answer: AnswerValue,
        /// from the question to its answer; null where it was not measured
        answer_time_s or absent: Option<f64> = "s",
        /// whether it enters any tally, mean or test
        counts: bool,
        /// why it does not count; null if it does
        why_not: Option<String>,
    }

    /// A score of several answers after a trial.
    TrialScore = "scores", "Scores by trial" {
        ..of_trial,
        /// which score
        score: MetricId,
        /// questions of it that were answered
        answered: usize,
        /// questions that it has
        questions: usize,
        /// the score; null where answers are missing
        value: Option<f64> = "points",
        /// why there is none
        remark: Option<Sentence>,
    }

    /// How a metric goes together with an answer or a score, within people.
    Relation = "relations", "What was said and what was measured, within participants" {
        /// what was measured
        metric: MetricId,
        /// unit of the metric
        unit: Arc<str>,
        /// what was rendered
        environment: EnvironmentId,
        /// the question, or the score
        said: String,
        /// participants with several pairs
        n: usize,
        /// pairs of means, by session and mode
        pairs: usize,
        /// repeated-measures correlation
        correlation: Option<f64>,
        /// lower end of its interval
        correlation_ci_low: Option<f64>,
        /// upper end of its interval
        correlation_ci_high: Option<f64>,
        /// degrees of freedom
        df: Option<f64>,
        /// p value of no correlation, no claim
        p_value: Option<f64>,
        /// why there is none
        remark: Option<Sentence>,
    }

    /// How far the answers of a score hang together, over people in a condition and session.
    Reliability = "reliability", "Reliability of scores" {
        /// which score
        score: MetricId,
        /// what was rendered
        environment: EnvironmentId,
        /// how it was rendered
        mode: ModeId,
        /// in which session
        session: SessionId,
        /// participants who answered every question
        n: usize,
        /// questions that it has
        questions: usize,
        /// Cronbach's α of participants' mean answers
        alpha: Option<f64>,
        /// lower end of its interval
        alpha_ci_low: Option<f64>,
        /// upper end of its interval
        alpha_ci_high: Option<f64>,
        /// ω of one factor, from 20 participants on
        omega: Option<f64>,
        /// why there is none
        remark: Option<Sentence>,
    }

    /// The answers to a question, or to a group of questions together, after a condition's trials.
    AnswerTally = "likert", "Answers" {
        /// what was rendered
        environment: EnvironmentId,
        /// how it was rendered
        mode: ModeId,
        /// the question; null where a group is pooled
        question: Option<QuestionId>,
        /// the group of questions
        group: Option<String>,
        /// whether the row pools a group
        pooled: bool,
        /// whether agreement speaks against; null where pooled
        reversed: Option<bool>,
        /// people who answered
        participants: usize,
        /// answers
        n: usize,
        /// answers at point 1 as scored
        count_1 or absent: Option<usize>,
        /// answers at point 2 as scored
        count_2 or absent: Option<usize>,
        /// answers at point 3 as scored
        count_3 or absent: Option<usize>,
        /// answers at point 4 as scored
        count_4 or absent: Option<usize>,
        /// answers at point 5 as scored
        count_5 or absent: Option<usize>,
        /// answers at point 6 as scored
        count_6 or absent: Option<usize>,
        /// answers at point 7 as scored
        count_7 or absent: Option<usize>,
        /// answers at point 8 as scored
        count_8 or absent: Option<usize>,
        /// answers at point 9 as scored
        count_9 or absent: Option<usize>,
        /// answers at point 10 as scored
        count_10 or absent: Option<usize>,
        /// answers at point 11 as scored
        count_11 or absent: Option<usize>,
        /// median; for even n the lower of the two middle answers
        median_low: Option<AnswerValue>,
        /// median; for even n the upper of the two middle answers
        median_high: Option<AnswerValue>,
        /// lowest answer as scored, on a scale of many points
        lowest or absent: Option<f64>,
        /// first quartile of these answers
        quartile_1 or absent: Option<f64>,
        /// third quartile of these answers
        quartile_3 or absent: Option<f64>,
        /// highest of these answers
        highest or absent: Option<f64>,
        /// mean of people's means; of one person, of the answers
        mean or absent: Option<f64>,
        /// standard deviation between people's means; of one person, of the answers
        sd or absent: Option<f64>,
    }

    /// How often a participant, or all of them, knew a mode.
    BlindingIndex = "blinding", "Blinding index: which mode participants thought it was" {
        /// who; null over participants
        participant: Option<ParticipantId>,
        /// which mode it was
        mode: ModeId,
        /// people who answered
        participants: usize,
        /// trials after which it was asked
        trials: usize,
        /// answers that named the mode
        right: usize,
        /// answers that named another mode
        wrong: usize,
        /// answers that it is not known
        do_not_know: usize,
        /// blinding index; null without an answer
        index: Option<f64>,
        /// lower end of its t interval over participants
        index_ci_low: Option<f64>,
        /// upper end of its t interval over participants
        index_ci_high: Option<f64>,
    }
}

impl GivenAnswer {
    /// The column of answers.
    pub const ANSWER: &str = "answer";
    /// That of the times that they took.
    pub const TIME: &str = "answer_time_s";
}

impl AnswerTally {
    /// The column that says which questions count the other way round.
    pub const REVERSED: &str = "reversed";
    /// The columns of how often each point was chosen, in their order.
    pub const COUNTS: [&str; 11] = [
        "count_1", "count_2", "count_3", "count_4", "count_5", "count_6", "count_7", "count_8",
        "count_9", "count_10", "count_11",
    ];
    /// The columns of answers.
    pub const MEDIANS: [&str; 2] = ["median_low", "median_high"];
    /// The columns that sum up answers on a scale of many points.
    pub const SUMS: [&str; 6] = ["lowest", "quartile_1", "quartile_3", "highest", "mean", "sd"];
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::row::Row;

    #[test]
    fn columns_that_depend_on_the_scales_are_named_as_they_are_declared() {
        let names: Vec<String> = AnswerTally::fields().iter().map(|f| f.name.to_string()).collect();
        let listed = [&AnswerTally::COUNTS[..], &AnswerTally::MEDIANS, &AnswerTally::SUMS].concat();
        assert_eq!(names[8..], listed);
        assert_eq!(names[5], AnswerTally::REVERSED);
        let names: Vec<String> = GivenAnswer::fields().iter().map(|f| f.name.to_string()).collect();
        assert_eq!(names[6..8], [GivenAnswer::ANSWER, GivenAnswer::TIME]);
    }
}
