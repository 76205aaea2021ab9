//! Stage: which terms of the model a scene needs.
