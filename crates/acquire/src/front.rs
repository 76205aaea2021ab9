//! What a session needs from its operator: a screen, a script, or nobody.

use crate::{AcquireError, Input, View};
use std::time::Duration;

/// A front end: shows a [`View`] and hands over inputs.
///
/// The screen, lines in and out, and nobody are the three.
pub trait Front {
    /// Shows the view. Called at least at every change of phase, and some twenty times a second
    /// while a trial runs.
    ///
    /// # Errors
    /// A terminal or a pipe that is gone.
    fn show(&mut self, view: &View) -> Result<(), AcquireError>;

    /// The next input by a person, waiting for one at most `wait`; none if there was none. Only the
    /// inputs of people come from here: [`Input::Start`], [`Input::Answer`],
    /// [`Input::AnswerThere`], [`Input::Skip`], [`Input::Hold`], [`Input::Repeat`],
    /// [`Input::Exclude`], [`Input::Note`], [`Input::Of`], [`Input::Tell`], [`Input::Stop`],
    /// [`Input::Quit`].
    ///
    /// # Errors
    /// A terminal or a pipe that is gone.
    fn next(&mut self, wait: Duration) -> Result<Option<Input>, AcquireError>;
}

impl<F: Front + ?Sized> Front for &mut F {
    fn show(&mut self, view: &View) -> Result<(), AcquireError> {
        (**self).show(view)
    }

    fn next(&mut self, wait: Duration) -> Result<Option<Input>, AcquireError> {
        (**self).next(wait)
    }
}
