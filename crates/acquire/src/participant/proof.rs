//! How both ends of the line prove that they know the session's secret, which itself never goes
//! over the line.
//!
//! ```text
//! screen    FORM and the screen's nonce
//! session   the session's nonce, and its proof
//! screen    its proof
//! ```
//!
//! A proof is a BLAKE3 hash, keyed with the secret, of who gives it and of both nonces. So a proof
//! of one end is not valid for the other, and an overheard proof is not valid on another line. A
//! program that took over the port of an earlier session learns nothing from a screen, and the
//! screen shows nothing that this program sends.

use blake3::{Hash, Hasher};
use std::fmt;

/// The form of the lines. A screen of another form is not let in.
const FORM: &str = "zwidth-participant-2";

/// A number that nobody uses twice.
pub type Nonce = [u8; 32];

/// What a session and the screens of its user know, and nobody else.
#[derive(Clone, PartialEq, Eq)]
pub struct Secret([u8; 32]);

impl fmt::Debug for Secret {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Secret")
    }
}

impl Secret {
    /// From bytes that nobody can guess.
    pub fn new(bytes: [u8; 32]) -> Self {
        Self(bytes)
    }

    /// From its digits.
    pub(super) fn from_hex(digits: &str) -> Option<Self> {
        Some(Self(read(digits)?.into()))
    }

    /// Its digits, for the file that only this user can read.
    pub(super) fn hex(&self) -> String {
        Hash::from(self.0).to_hex().to_string()
    }
}

/// Who gives a proof.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum By {
    Session,
    Screen,
}

/// The numbers of one line.
#[derive(Debug, Clone, Copy)]
pub(super) struct Nonces {
    screen: Nonce,
    session: Nonce,
}

impl Nonces {
    /// Those of a screen's first line and of this session; none if the line is no such line.
    pub(super) fn of_hello(line: &str, session: Nonce) -> Option<Self> {
        let screen = line.strip_prefix(FORM)?.strip_prefix(' ')?;
        Some(Self { screen: read(screen)?.into(), session })
    }

    /// The session's line.
    pub(super) fn session_line(&self, secret: &Secret) -> String {
        let nonce = Hash::from(self.session).to_hex();
        format!("{nonce} {}", self.proof(secret, By::Session).to_hex())
    }

    /// Whether a line proves that a screen knows the secret.
    pub(super) fn is_proven_by(&self, secret: &Secret, line: &str) -> bool {
        // Hashes are compared in the same time wherever they differ.
        read(line).is_some_and(|proof| proof == self.proof(secret, By::Screen))
    }

    fn proof(&self, secret: &Secret, by: By) -> Hash {
        let by: &[u8] = match by {
            By::Session => b" by the session ",
            By::Screen => b" by the screen ",
        };
        let mut hasher = Hasher::new_keyed(&secret.0);
        for part in [FORM.as_bytes(), by, &self.screen, &self.session] {
            hasher.update(part);
        }
        hasher.finalize()
    }
}

/// A screen that asks to be let in.
#[derive(Debug, Clone)]
pub struct Knock {
    secret: Secret,
    nonce: Nonce,
}

impl Knock {
    /// With the secret, and a number that was never used before.
    pub fn new(secret: Secret, nonce: Nonce) -> Self {
        Self { secret, nonce }
    }

    /// The first line.
    pub fn hello(&self) -> String {
        format!("{FORM} {}", Hash::from(self.nonce).to_hex())
    }

    /// The screen's proof, if the session's line proves that it knows the secret.
    pub fn proof(&self, line: &str) -> Option<String> {
        let (session, proof) = line.split_once(' ')?;
        let nonces = Nonces { screen: self.nonce, session: read(session)?.into() };
        let is_session = read(proof)? == nonces.proof(&self.secret, By::Session);
        is_session.then(|| nonces.proof(&self.secret, By::Screen).to_hex().to_string())
    }
}

/// 32 bytes by their digits.
fn read(digits: &str) -> Option<Hash> {
    Hash::from_hex(digits).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn secret(byte: u8) -> Secret {
        Secret::new([byte; 32])
    }

    fn nonces(knock: &Knock, session: u8) -> Nonces {
        Nonces::of_hello(&knock.hello(), [session; 32]).unwrap()
    }

    #[test]
    fn two_ends_that_know_the_secret_believe_each_other_and_never_send_it() {
        let knock = Knock::new(secret(1), [2; 32]);
        let nonces = nonces(&knock, 3);
        let session = nonces.session_line(&secret(1));
        let proof = knock.proof(&session).unwrap();
        assert!(nonces.is_proven_by(&secret(1), &proof));
        for line in [knock.hello(), session, proof] {
            assert!(!line.contains(&secret(1).hex()), "{line}");
        }
    }

    #[test]
    fn another_secret_another_line_and_the_other_ends_proof_prove_nothing() {
        let knock = Knock::new(secret(1), [2; 32]);
        let first = nonces(&knock, 3);
        let session = first.session_line(&secret(1));
        let proof = knock.proof(&session).unwrap();
        assert!(!nonces(&knock, 4).is_proven_by(&secret(1), &proof), "a replayed proof");
        assert!(!first.is_proven_by(&secret(9), &proof));
        let (_, of_session) = session.split_once(' ').unwrap();
        assert!(!first.is_proven_by(&secret(1), of_session), "the session's proof sent back");
        assert_eq!(knock.proof(&first.session_line(&secret(9))), None);
        assert_eq!(Knock::new(secret(1), [7; 32]).proof(&session), None, "a replayed session");
        for line in ["", " ", "x y", &proof, "\u{1b}[2J"] {
            assert_eq!(knock.proof(line), None, "{line:?}");
            assert!(line == proof || !first.is_proven_by(&secret(1), line), "{line:?}");
        }
    }

    #[test]
    fn another_form_is_no_hello() {
        let line = Knock::new(secret(1), [2; 32]).hello();
        for other in [line.replace("-2 ", "-1 "), line.replace(' ', ""), line[..40].into()] {
            assert!(Nonces::of_hello(&other, [3; 32]).is_none(), "{other}");
        }
    }
}
