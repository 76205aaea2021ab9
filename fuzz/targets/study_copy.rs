#![no_main]
libfuzzer_sys::fuzz_target!(|bytes: &[u8]| zwidth_fuzz::in_study("study_copy", bytes));
