//! The words for how a run went.

use zwidth_study::worded;

worded! {
    /// How a run went.
    RunVerdict {
        /// Nothing oscillates.
        Smooth = "smooth",
        /// It repeats with the input's period, or with 2 to 4 of them.
        Forced = "forced",
        /// An oscillation that dies out.
        Transient = "transient",
        /// An oscillation that grows, in the model itself.
        Growing = "growing",
        /// An oscillation that nothing drives and nothing damps.
        FreeUndamped = "free, undamped",
        /// An oscillation that the model keeps up by itself.
        LimitCycle = "limit cycle",
        /// Swings that the model does not have: the method's own.
        NumericalChattering = "numerical chattering",
        /// A lever that moves where the model's stands still: the method's own.
        NumericalCreep = "numerical creep",
        /// The step lies outside the method's stability region somewhere on the way.
        UnstableStep = "unstable step",
        /// The model does not say what is commanded at rest, and it matters.
        DependsOnRestRule = "depends on the rule at rest",
        /// The motion is not known well enough.
        CannotTell = "cannot tell",
        /// The run ended in an error.
        Failed = "failed",
    }
}
