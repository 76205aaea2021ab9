//! The words for how a run went.

/// How a run went.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum RunVerdict {
    /// Nothing oscillates.
    Smooth,
    /// It repeats with the input's period, or with 2 to 4 of them.
    Forced,
    /// An oscillation that dies out.
    Transient,
    /// An oscillation that grows, in the model itself.
    Growing,
    /// An oscillation that nothing drives and nothing damps.
    FreeUndamped,
    /// An oscillation that the model keeps up by itself.
    LimitCycle,
    /// Swings that the model does not have: the method's own.
    NumericalChattering,
    /// A lever that moves where the model's stands still: the method's own.
    NumericalCreep,
    /// The step lies outside the method's stability region somewhere on the way.
    UnstableStep,
    /// The model does not say what is commanded at rest, and it matters.
    DependsOnRestRule,
    /// The motion is not known well enough.
    CannotTell,
    /// The run ended in an error.
    Failed,
}

impl RunVerdict {
    /// Every verdict.
    pub const ALL: [Self; 12] = [
        Self::Smooth,
        Self::Forced,
        Self::Transient,
        Self::Growing,
        Self::FreeUndamped,
        Self::LimitCycle,
        Self::NumericalChattering,
        Self::NumericalCreep,
        Self::UnstableStep,
        Self::DependsOnRestRule,
        Self::CannotTell,
        Self::Failed,
    ];

    /// Its words in tables.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Smooth => "smooth",
            Self::Forced => "forced",
            Self::Transient => "transient",
            Self::Growing => "growing",
            Self::FreeUndamped => "free, undamped",
            Self::LimitCycle => "limit cycle",
            Self::NumericalChattering => "numerical chattering",
            Self::NumericalCreep => "numerical creep",
            Self::UnstableStep => "unstable step",
            Self::DependsOnRestRule => "depends on the rule at rest",
            Self::CannotTell => "cannot tell",
            Self::Failed => "failed",
        }
    }
}
