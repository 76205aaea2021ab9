//! Random numbers of orders: those of the ChaCha8 cipher keyed with a seed, the same on any machine.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// What random numbers are for: each use has a key of its own.
#[derive(Clone, Copy)]
pub(crate) enum Stream {
    Study,
    Session,
    Person,
    Groups,
    Pairs,
    Tasks,
}

/// Number of bytes of the cipher's key.
const KEY_BYTES: usize = 32;

pub(crate) fn stream(seed: u64, purpose: Stream, number: u64) -> ChaCha8Rng {
    let mut key = [0; KEY_BYTES];
    key[..8].copy_from_slice(&seed.to_le_bytes());
    // By their order in the list: another order of it would draw other sessions.
    key[8] = purpose as u8;
    let mut rng = ChaCha8Rng::from_seed(key);
    rng.set_stream(number);
    rng
}

/// A whole number below `n`, from the high half of a 64 × 64 bit product (Lemire 2019); 0 for `n` =
/// 0. Its bias is below n / 2⁶⁴.
pub(crate) fn below(rng: &mut ChaCha8Rng, n: usize) -> usize {
    ((u128::from(rng.next_u64()) * n as u128) >> u64::BITS) as usize
}

/// Fisher and Yates: each permutation equally likely.
pub(crate) fn shuffle<T>(rng: &mut ChaCha8Rng, values: &mut [T]) {
    for i in (1..values.len()).rev() {
        values.swap(i, below(rng, i + 1));
    }
}
