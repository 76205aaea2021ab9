//! Workspace tests: architecture, whole runs, bad input, real recordings.
