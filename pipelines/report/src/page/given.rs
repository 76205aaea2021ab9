//! What a page is made from.

use super::contents::Contents;
use crate::Summary;
use zwidth_study::Setup;

/// What the page shows.
#[derive(Debug, Clone, Copy)]
pub struct Page<'a> {
    /// The summary.
    pub summary: &'a Summary,
    /// What was planned.
    pub planned: &'a Setup,
    /// The study's id.
    pub study: &'a str,
    /// The trials, where there are any.
    pub contents: Option<&'a Contents>,
    /// The page's origin, if it is given.
    pub origin: Option<&'a str>,
    /// The version of the program.
    pub version: &'a str,
}
