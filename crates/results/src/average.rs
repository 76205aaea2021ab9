//! What the stage `average` finds: means of repeats against time, and of force against position.
//! Beside these columns are the mean, SD and band of each signal.

use crate::row::{of_condition, rows};
use crate::value::{named, words};
use zwidth_study::{Alignment, Source};

named!(Alignment);

words! {
    /// A part of a movement there and back, in the order of a movement.
    LoopBranch {
        /// From the onset to the reversal, where the lever goes farther than before.
        In = "in",
        /// From the reversal to the return, or to the last sample if there is none: at one angle,
        /// from the largest force to the smallest.
        Held = "held",
        /// From the return to the end, where the lever goes farther back than before.
        Out = "out",
    }
}

rows! {
    /// The first columns of a mean against time: a point of its grid.
    AveragePoint = "average", "Mean of the repeats against time" {
        ..of_condition,
        /// recorded, twin or imported
        source: Source,
        /// what the repeats were aligned at: onset or landmarks
        alignment: Alignment,
        /// time since movement onset; aligned by landmarks, on the scale of their mean times
        t_s: f64 = "s",
        /// landmarks passed: 0 at the start, 1 at the wall, 2 at the reversal, 3 at the return, 4 at the end, straight between
        phase: Option<f64>,
        /// repeats averaged at this time
        n: usize,
    }

    /// What a figure of a mean against time needs of each of its points.
    AveragedTime = "average", "Mean of the repeats against time" {
        /// time since movement onset; aligned by landmarks, on the scale of their mean times
        t_s: f64 = "s",
        /// repeats averaged at this time
        n: usize,
    }

    /// The first columns of a mean of force against position: an angle of a branch.
    LoopPoint = "loop", "Mean of force against position, by branch" {
        ..of_condition,
        /// recorded, twin or imported
        source: Source,
        /// repeats averaged
        n: usize,
        /// in: onset to reversal, farther along than before;
        /// held: at the turn, from the largest force to the smallest; out: return to end
        branch: LoopBranch,
        /// angle at which the forces are averaged
        theta_rad: f64 = "rad",
    }

    /// The first columns of the same over participants.
    ParticipantsLoopPoint = "participants_loop", "Mean force against position over participants" {
        /// participants averaged
        n: usize,
        /// sessions of theirs
        sessions: usize,
        /// in: onset to reversal, farther along than before;
        /// held: at the turn, from the largest force to the smallest; out: return to end
        branch: LoopBranch,
        /// angle at which the forces are averaged
        theta_rad: f64 = "rad",
    }

    /// What a figure of force against position needs of each angle, of repeats or of participants.
    LoopAngle = "loop", "Mean of force against position, by branch" {
        /// repeats or participants averaged
        n: usize,
        /// in: onset to reversal, farther along than before;
        /// held: at the turn, from the largest force to the smallest; out: return to end
        branch: LoopBranch,
        /// angle at which the forces are averaged
        theta_rad: f64 = "rad",
    }
}
