//! What a browser may do for the page, as declared in its head (Content Security Policy, level 3,
//! <https://www.w3.org/TR/CSP3/>): run its own script, use its own style sheet, show its figures. A
//! script or a picture that somebody else brought into the page does nothing, and nothing is sent
//! anywhere.

use super::own::STYLE;
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use sha2::{Digest as _, Sha256};

/// In which form a page is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Form {
    /// With figures and samples beside it, from a disk or from a server.
    Folder,
    /// One file.
    OneFile,
}

/// The policy of a page with this script.
pub(super) fn policy(form: Form, script: &str) -> String {
    let [script, style] =
        [script, STYLE.as_str()].map(|text| STANDARD.encode(Sha256::digest(text)));
    let (loads, images) = match form {
        // `strict-dynamic`: what the page's own script loads is samples; a tag of another script
        // loads nothing. A page from a disk has no origin, so that not every browser takes files
        // beside it for its own (`'self'`). A picture of the page's own making is in its address.
        Form::Folder => (" 'strict-dynamic'", "'self' file: data:"),
        Form::OneFile => ("", "data:"),
    };
    format!(
        "default-src 'none'; script-src 'sha256-{script}'{loads}; style-src 'sha256-{style}'; \
         img-src {images}; base-uri 'none'; form-action 'none'"
    )
}
