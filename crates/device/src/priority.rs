//! Priority over other threads.

/// Whether a thread comes before others.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Priority {
    /// It runs whenever it wants to.
    RealTime,
    /// It shares the machine as the system sees fit: more jitter, and now and then a missed
    /// deadline.
    Ordinary,
}

/// Priority among real-time threads, 1…99: below the threads that serve interrupts (50 on Linux),
/// whose data it waits for.
#[cfg(unix)]
const REAL_TIME: u8 = 40;

impl Priority {
    /// Asks for real-time scheduling (`SCHED_FIFO`) for the thread that calls. Systems allow it to
    /// an administrator, or to a group named in `/etc/security/limits.conf` (`rtprio`);
    /// elsewhere the thread stays as it is.
    #[cfg(unix)]
    pub fn raise() -> Self {
        use thread_priority::{
            RealtimeThreadSchedulePolicy::Fifo, ThreadPriority, ThreadSchedulePolicy::Realtime,
            set_thread_priority_and_policy, thread_native_id,
        };
        let raised = REAL_TIME.try_into().is_ok_and(|value| {
            let priority = ThreadPriority::Crossplatform(value);
            set_thread_priority_and_policy(thread_native_id(), priority, Realtime(Fifo)).is_ok()
        });
        if raised { Self::RealTime } else { Self::Ordinary }
    }

    /// Asks for the highest priority the system gives a thread.
    #[cfg(not(unix))]
    pub fn raise() -> Self {
        let raised = thread_priority::ThreadPriority::Max.set_for_current().is_ok();
        if raised { Self::RealTime } else { Self::Ordinary }
    }
}
