//! What is found of a trajectory that another program computed for a scene.

use crate::row::rows;
use crate::trade::Proof;
use crate::value::words;
use std::sync::Arc;

words! {
    /// What a trajectory is worth. Of several the first in this order names it.
    TrajectoryVerdict {
        /// The right answer is not proven: nothing can be said against it.
        Unproven = "unproven",
        /// It leaves the right motion exponentially.
        Unstable = "unstable",
        /// It goes beyond a stop, through it or because it gives way.
        BeyondStop = "goes beyond the stop",
        /// Its angle or velocity jumps where that of the scene does not.
        Reset = "state reset",
        /// Something does not happen.
        Missed = "event missed",
        /// Something happens that does not happen in the scene.
        Extra = "event that the scene does not have",
        /// It swings where the scene does not.
        Chatters = "chatters",
        /// It moves on steadily where the lever of the scene is held.
        Creeps = "creeps",
        /// Something happens too late.
        Late = "event late",
        /// Something happens too early.
        Early = "event early",
        /// It gains energy that no force gives.
        EnergyMade = "energy made",
        /// It loses energy that no force takes.
        EnergyLost = "energy lost",
        /// It is further from the right answer than is allowed, for no reason that shows.
        Inaccurate = "inaccurate",
        /// The lever is held all the time, and stands.
        Stands = "stands",
        /// Nothing is wrong with it.
        Right = "right",
    }
    /// What a lever does at an instant.
    LeverEvent {
        /// It reaches a stop.
        StopReached = "stop reached",
        /// It leaves a stop.
        StopLeft = "stop left",
        /// It comes to rest away from the stops.
        CameToRest = "came to rest",
        /// It breaks loose from rest.
        BrokeLoose = "broke loose",
        /// It breaks loose because an actuator lets go.
        ActuatorLetGo = "actuator let go",
        /// It turns round without a rest.
        TurnedRound = "turned round",
    }
}

rows! {
    /// A trajectory of any program beside the right answer of its scene.
    JudgedTrajectory = "judged", "Trajectories judged" {
        /// the scene
        scene: Arc<str>,
        /// the trajectory's file
        trajectory: Arc<str>,
        /// what made it, as was said
        engine: Option<Arc<str>>,
        /// its setting, as was said
        setting: Option<Arc<str>>,
        /// time that it took, as was said
        cost_s: Option<f64> = "s",
        /// what it is worth: the first that holds
        verdict: TrajectoryVerdict,
        /// how many faults there are
        faults: usize,
        /// how far the right answer is proven
        yardstick: Proof,
        /// the solver of the right answer
        by: Arc<str>,
        /// samples that were compared
        samples: usize,
        /// median time between them
        step_s: f64 = "s",
        /// smallest step between the file's angles
        theta_resolution_rad: f64 = "rad",
        /// smallest step between its velocities
        theta_dot_resolution_rad_s: f64 = "rad/s",
        /// whether its velocities were computed from its angles
        velocity_computed: bool,
        /// largest error of the angle
        theta_error_max_rad: f64 = "rad",
        /// root mean square of it
        theta_error_rms_rad: f64 = "rad",
        /// largest error of the velocity
        theta_dot_error_max_rad_s: f64 = "rad/s",
        /// root mean square of it
        theta_dot_error_rms_rad_s: f64 = "rad/s",
        /// largest error of the device's force, by the scene's laws at the trajectory's states
        force_error_max_n: f64 = "N",
        /// root mean square of it
        force_error_rms_n: f64 = "N",
        /// error of its integral over the run
        impulse_error_ns: f64 = "N s",
        /// error of the largest angle
        peak_error_rad: f64 = "rad",
        /// largest error of the user's force in the file, if it has one
        input_error_max_n: Option<f64> = "N",
        /// largest error of the times of events that happen in both
        event_error_s: Option<f64> = "s",
        /// slow force: error over what is felt
        felt_force_share: f64,
        /// slow angle: error over what is felt
        felt_angle_share: f64,
        /// vibration above the right one, over what is felt
        felt_vibration_share: Option<f64>,
        /// whether a person could tell it from the right one
        is_felt: bool,
        /// fastest steady motion where the lever is held, if it is held long enough
        creep_rad_s: Option<f64> = "rad/s",
        /// energy at the end that no force gave
        energy_residual_j: Option<f64> = "J",
        /// how much of it the sampling may make
        energy_bound_j: Option<f64> = "J",
        /// the energy that it is compared with: the largest kinetic one and the user's work
        energy_scale_j: Option<f64> = "J",
    }

    /// A fault of a trajectory. Sizes that it does not have are null.
    TrajectoryFault = "judged_faults", "Faults of trajectories" {
        /// the scene
        scene: Arc<str>,
        /// the trajectory's file
        trajectory: Arc<str>,
        /// what is wrong
        fault: TrajectoryVerdict,
        /// of which event
        event: Option<LeverEvent>,
        /// when it happens in the right answer, or where the fault begins
        t_s: f64 = "s",
        /// how often
        times: usize,
        /// how late the event is; below 0 it is early
        late_s: Option<f64> = "s",
        /// speed of the creep
        creep_rad_s: Option<f64> = "rad/s",
        /// jump of the angle, depth behind a stop, half of a swing, or error
        theta_rad: Option<f64> = "rad",
        /// jump of the velocity
        theta_dot_rad_s: Option<f64> = "rad/s",
        /// whether angle and velocity are 0 after the jump
        to_zero: bool,
        /// frequency of the swings
        frequency_hz: Option<f64> = "Hz",
        /// energy that no force gave
        energy_j: Option<f64> = "J",
        /// rate at which the error grows
        growth_per_s: Option<f64> = "1/s",
    }
}
