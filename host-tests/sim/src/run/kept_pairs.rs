//! Pairs of a run of any length that are kept in memory for computations after the run.

use rigs::data::Match;

/// Largest number of matches and pairs held, added up. A single pair may have more.
const MOST: usize = 1 << 18;

/// Keeps all pairs while there are few, then every 2nd, then every 4th, and so on, from the first pair on.
#[derive(Debug, Clone)]
pub struct KeptPairs {
    pairs: Vec<Vec<Match>>,
    /// Number of matches in `pairs`, plus one for each pair.
    held: usize,
    most: usize,
    offered: usize,
    every: usize,
}

impl Default for KeptPairs {
    fn default() -> Self {
        Self { pairs: Vec::new(), held: 0, most: MOST, offered: 0, every: 1 }
    }
}

impl KeptPairs {
    /// Offers the next pair, which may be kept.
    pub fn offer(&mut self, pair: &[Match]) {
        if self.offered.is_multiple_of(self.every) {
            self.held += pair.len() + 1;
            self.pairs.push(pair.to_vec());
        }
        self.offered += 1;
        while self.held > self.most && self.pairs.len() > 1 {
            self.every *= 2;
            let mut even = [true, false].into_iter().cycle();
            self.pairs.retain(|_| even.next() == Some(true));
            self.held = self.pairs.iter().map(|pair| pair.len() + 1).sum();
        }
    }

    /// The kept pairs, in their order.
    pub fn into_pairs(self) -> Vec<Vec<Match>> {
        self.pairs
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_pairs_are_all_kept_and_many_are_thinned_evenly() {
        let at = |ul| Match { ul, vl: 0.0, ur: 0.0, vr: 0.0, score: 1.0, step: 0.0 };
        let kept = |count: u32| {
            let mut kept = KeptPairs { most: 100, ..KeptPairs::default() };
            for i in 0..count {
                kept.offer(&[at(f64::from(i)); 9]);
                assert!(kept.held <= 100);
            }
            kept.into_pairs().iter().map(|pair| pair[0].ul).collect::<Vec<_>>()
        };
        assert_eq!(kept(10), [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0]);
        assert_eq!(kept(11), [0.0, 2.0, 4.0, 6.0, 8.0, 10.0]);
        assert_eq!(kept(80), [0.0, 8.0, 16.0, 24.0, 32.0, 40.0, 48.0, 56.0, 64.0, 72.0]);
        // A single pair is kept, however many matches it has.
        let mut one = KeptPairs { most: 10, ..KeptPairs::default() };
        one.offer(&[at(0.0); 99]);
        assert_eq!(one.into_pairs().len(), 1);
    }
}
