//! Simulated NOR flash that loses power at a chosen operation, and may have wrong bits.
//!
//! It panics if the code under test breaks the rules of NOR flash: if it writes a word twice, or uses ranges that are
//! not whole words or blocks. An interrupted operation leaves undefined words, as the driver's contract allows.

use core::cell::Cell;
use std::rc::Rc;

use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash,
};
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Why an access failed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fault {
    /// Power is off.
    NoPower,
    /// The bus does not work ([`Flash::is_deaf`]).
    Deaf,
    /// The word accepts no write: it was torn and reads as erased, or it is not erased and the flash has
    /// [`Blank::Unreadable`].
    Torn,
    /// The ECC of a word does not fit: the word was torn, or is erased and erased words cannot be read.
    Ecc,
    /// The block is worn out.
    Worn,
}

impl NorFlashError for Fault {
    fn kind(&self) -> NorFlashErrorKind {
        NorFlashErrorKind::Other
    }
}

/// Effect of a loss of power on a write. A block whose erasure is interrupted always gets torn words.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Tear {
    /// The words before the loss are written; the next one is written with some, none or all of its bits.
    Word,
    /// Every word of the call is written with some, none or all of its bits.
    Call,
    /// The words before the loss are written; the next one reads as erased although it is not.
    Hidden,
    /// As [`Tear::Word`], but torn words cannot be read.
    Ecc,
}

/// All effects.
pub const TEARS: [Tear; 4] = [Tear::Word, Tear::Call, Tear::Hidden, Tear::Ecc];

/// Content of erased words.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Blank {
    /// Ones.
    Ones,
    /// Zeros. The simulation stores the inverted content.
    Zeros,
    /// Erased words cannot be read. A write to a word that is not erased fails.
    Unreadable,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Word {
    Erased,
    Written,
    Torn,
}

/// A simulated flash. `W` is the number of bytes of a word, `E` of an erase block.
#[derive(Debug, Clone)]
pub struct Flash<const W: usize, const E: usize> {
    /// Content; inverted for [`Blank::Zeros`].
    pub bytes: Vec<u8>,
    words: Vec<Word>,
    /// Number of words and blocks until power is lost, during the last of them; `None` if power lasts.
    pub power_for: Option<u32>,
    /// Number of writes of a word and erasures of a block that were begun.
    pub operations: u32,
    /// Number of completed erasures of each block.
    pub erased: Vec<u32>,
    /// Block that accepts no further word, and whether a write to it reports an error.
    pub worn: Option<(usize, bool)>,
    /// Whether reads fail.
    pub is_deaf: Rc<Cell<bool>>,
    /// On average, one read in this number returns a wrong bit.
    pub flaky: Option<u32>,
    /// Number of reads at the last of which a byte changes, position of the byte, and its bits that change. With this
    /// setting, a write to an erased word that does not read as erased does not panic, because the code under test need
    /// not have read the change.
    pub rot: Option<(u32, usize, u8)>,
    /// Effect of a loss of power.
    pub tear: Tear,
    /// Content of erased words.
    pub blank: Blank,
    /// Random numbers for the torn words.
    pub random: ChaCha8Rng,
}

impl<const W: usize, const E: usize> Flash<W, E> {
    /// A flash with random content, as if it was never erased.
    #[must_use]
    pub fn new(blocks: usize, seed: u64) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut bytes = vec![0; blocks * E];
        random.fill_bytes(&mut bytes);
        Self::of(bytes, seed)
    }

    /// A flash with this content: words of all ones count as erased.
    #[must_use]
    pub fn of(bytes: Vec<u8>, seed: u64) -> Self {
        let erased = |word: &[u8]| word.iter().all(|byte| *byte == 0xff);
        let state = |word| if erased(word) { Word::Erased } else { Word::Written };
        Self {
            words: bytes.chunks(W).map(state).collect(),
            erased: vec![0; bytes.len() / E],
            bytes,
            power_for: None,
            operations: 0,
            worn: None,
            is_deaf: Rc::default(),
            flaky: None,
            rot: None,
            tear: Tear::Word,
            blank: Blank::Ones,
            random: ChaCha8Rng::seed_from_u64(seed),
        }
    }

    /// Restores the power.
    pub fn power_on(&mut self) {
        self.power_for = None;
    }

    /// Counts an operation; returns whether power lasts to its end.
    fn operate(&mut self) -> bool {
        self.operations += 1;
        match &mut self.power_for {
            None => true,
            Some(0) => false,
            Some(left) => {
                *left -= 1;
                *left > 0
            }
        }
    }

    fn has_power(&self) -> Result<(), Fault> {
        if self.power_for == Some(0) { Err(Fault::NoPower) } else { Ok(()) }
    }

    /// Writes some, none or all of the bits of a word.
    fn tear_word(&mut self, word: usize, content: &[u8]) {
        self.words[word] = Word::Torn;
        let hidden = self.tear == Tear::Hidden;
        let much: u8 = self.random.random_range(0..4);
        for (i, byte) in content.iter().enumerate() {
            let left: u8 = match much {
                _ if hidden => 0xff,
                0 => 0,
                1 => 0xff,
                _ => self.random.random(),
            };
            self.bytes[word * W + i] &= byte | left;
        }
    }

    /// Erases some, none or all of a block, or some of its bytes and makes others random. All its words are torn then.
    fn tear_block(&mut self, block: usize) {
        let many = match self.random.random_range(0..4_u8) {
            0 => 0,
            1 => E,
            _ => self.random.random_range(0..E),
        };
        let mixed: bool = self.random.random();
        for i in 0..E {
            let byte = &mut self.bytes[block * E + i];
            match self.random.random_range(0..3_u8) {
                _ if !mixed && i < many => *byte = 0xff,
                0 if mixed => *byte = 0xff,
                1 if mixed => *byte = self.random.random(),
                _ => (),
            }
        }
        self.words[block * E / W..(block + 1) * E / W].fill(Word::Torn);
    }
}

impl<const W: usize, const E: usize> ErrorType for Flash<W, E> {
    type Error = Fault;
}

impl<const W: usize, const E: usize> ReadNorFlash for Flash<W, E> {
    const READ_SIZE: usize = if W < 4 { W } else { 4 };

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Fault> {
        self.has_power()?;
        if self.is_deaf.get() {
            return Err(Fault::Deaf);
        }
        let start = offset as usize;
        assert!(start.is_multiple_of(Self::READ_SIZE), "a read not aligned");
        assert!(bytes.len().is_multiple_of(Self::READ_SIZE), "a read not of whole words");
        let end = start + bytes.len();
        let words = &self.words[start / W..end.div_ceil(W)];
        if self.tear == Tear::Ecc && words.contains(&Word::Torn)
            || self.blank == Blank::Unreadable && words.contains(&Word::Erased)
        {
            return Err(Fault::Ecc);
        }
        if let Some((reads, at, bits)) = &mut self.rot
            && let Some(left) = reads.checked_sub(1)
        {
            *reads = left;
            self.bytes[*at] ^= if left == 0 { *bits } else { 0 };
        }
        bytes.copy_from_slice(&self.bytes[start..end]);
        if self.blank == Blank::Zeros {
            for byte in &mut *bytes {
                *byte = !*byte;
            }
        }
        if let Some(one_in) = self.flaky
            && self.random.random_ratio(1, one_in)
        {
            let at = self.random.random_range(0..bytes.len());
            bytes[at] ^= 1 << self.random.random_range(0..8);
        }
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.bytes.len()
    }
}

impl<const W: usize, const E: usize> NorFlash for Flash<W, E> {
    const WRITE_SIZE: usize = W;
    const ERASE_SIZE: usize = E;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), Fault> {
        assert!(from < to && (from as usize).is_multiple_of(E) && (to as usize).is_multiple_of(E));
        for block in from as usize / E..to as usize / E {
            self.has_power()?;
            if !self.operate() {
                self.tear_block(block);
                return Err(Fault::NoPower);
            }
            self.bytes[block * E..(block + 1) * E].fill(0xff);
            self.words[block * E / W..(block + 1) * E / W].fill(Word::Erased);
            self.erased[block] += 1;
        }
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Fault> {
        let first = offset as usize / W;
        assert!((offset as usize).is_multiple_of(W) && bytes.len().is_multiple_of(W));
        let inverted: Vec<u8> = bytes.iter().map(|byte| !byte).collect();
        let bytes = if self.blank == Blank::Zeros { &inverted } else { bytes };
        for (i, content) in bytes.chunks(W).enumerate() {
            self.has_power()?;
            let word = first + i;
            let reads_erased = self.bytes[word * W..(word + 1) * W].iter().all(|b| *b == 0xff);
            match self.words[word] {
                Word::Torn if reads_erased => return Err(Fault::Torn),
                Word::Erased if reads_erased || self.rot.is_some() => (),
                _ if self.blank == Blank::Unreadable => return Err(Fault::Torn),
                state => panic!("word {word} is written in state {state:?}"),
            }
            match self.worn {
                Some((block, true)) if block == word * W / E => return Err(Fault::Worn),
                Some((block, false)) if block == word * W / E => continue,
                _ => (),
            }
            if self.operate() {
                self.words[word] = Word::Written;
                let cells = &mut self.bytes[word * W..(word + 1) * W];
                cells.iter_mut().zip(content).for_each(|(cell, bits)| *cell &= bits);
                continue;
            }
            if self.tear == Tear::Call {
                self.bytes[first * W..][..bytes.len()].fill(0xff);
                let words = bytes.chunks(W).enumerate();
                words.for_each(|(j, content)| self.tear_word(first + j, content));
            } else {
                self.tear_word(word, content);
            }
            return Err(Fault::NoPower);
        }
        Ok(())
    }
}
