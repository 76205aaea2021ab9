//! A session of trials: its flow, the runner that binds it to a device and the store, and the screen.
