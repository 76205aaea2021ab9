//! What goes into the model, and what comes out.

/// What goes into the model, and what comes out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Causality {
    /// F_ex in, θ out: environment, actuators and their switching are the model's own (Fig. 24).
    ForceDriven,
    /// θ in, F_ex out: the force the recorded motion needs. θ̇ and θ̈ are central differences.
    PositionDriven,
    /// F_ex and the recorded commands of the actuators in, θ out: neither environment nor switching
    /// is modelled, only the plant.
    ClosedLoop,
}

impl Causality {
    /// All three, in the order of the table.
    pub const ALL: [Self; 3] = [Self::ForceDriven, Self::PositionDriven, Self::ClosedLoop];

    /// The word in the table.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::ForceDriven => "force_driven",
            Self::PositionDriven => "position_driven",
            Self::ClosedLoop => "closed_loop",
        }
    }
}
