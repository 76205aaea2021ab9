//! The participant's own screen, beside a session.
//!
//! ```text
//! session: View → Sight → Reception ═ Door ═══ a line to this machine ═══ Guest → screen or lines
//!          Input ←──────── Beside                                         answer
//! ```
//!
//! What the participant may see is a [`Sight`](sight::Sight), which has no place for a mode, a
//! voltage or a message; nothing else leaves the session. Both ends prove that they know a secret
//! before they send anything else. The door has threads of its own, so that neither the control
//! loop nor the session ever waits for a screen.

mod beside;
mod big;
mod door;
mod draw;
mod guest;
#[cfg(any(test, feature = "testing"))]
pub mod hostile;
mod keys;
mod lines;
mod proof;
mod reception;
mod sight;
mod terminal;
mod wire;

pub use beside::Beside;
pub use door::Door;
pub use guest::Guest;
pub use lines::show_lines;
pub use proof::{Knock, Nonce, Secret};
pub use reception::{Reception, SentAway, Teller, Visit};
pub use terminal::show_screen;
pub use wire::place_of;
