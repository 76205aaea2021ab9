//! The last few values of a slow function, for callers that ask for the same ones repeatedly.

/// Values that are kept.
const KEPT: usize = 4;

/// The last few values, each with what it was made of.
pub(crate) struct Memo<K, V>(Vec<(K, V)>);

impl<K, V: Clone> Memo<K, V> {
    pub(crate) const fn new() -> Self {
        Self(Vec::new())
    }

    /// The value whose key fulfils `is_it`, if it is kept.
    pub(crate) fn get(&self, is_it: impl Fn(&K) -> bool) -> Option<V> {
        self.0.iter().find(|(key, _)| is_it(key)).map(|(_, value)| value.clone())
    }

    pub(crate) fn keep(&mut self, key: K, value: V) {
        if self.0.len() == KEPT {
            self.0.remove(0);
        }
        self.0.push((key, value));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_few_values_are_known_and_no_others() {
        let mut memo = Memo::new();
        (0..10).for_each(|i| memo.keep(i, 2 * i));
        let known = (0..10).map(|i| memo.get(|of| *of == i));
        assert_eq!(known.flatten().collect::<Vec<_>>(), [12, 14, 16, 18]);
    }
}
