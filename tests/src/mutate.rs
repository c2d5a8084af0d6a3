//! Files broken at random, the same ones for the same seed: what importers must survive.

/// A small generator (xorshift) that breaks files.
pub struct Mutator(u64);

/// Numbers that readers trip over.
const ODD: [&str; 12] = [
    "0",
    "-1",
    "1e308",
    "-1e308",
    "1e-320",
    "nan",
    "inf",
    "4294967296",
    "99999999999999999999",
    "2147483647",
    "0.5",
    "",
];

impl Mutator {
    /// A generator of its own sequence.
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1)
    }

    /// Uniform below `end`; 0 where that is 0.
    fn below(&mut self, end: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        ((self.0 >> 11) as usize) % end.max(1)
    }

    /// The file with one to four things wrong with it.
    pub fn mutate(&mut self, file: &[u8]) -> Vec<u8> {
        let mut broken = file.to_vec();
        for _ in 0..=self.below(4) {
            self.break_once(&mut broken);
        }
        broken
    }

    fn break_once(&mut self, file: &mut Vec<u8>) {
        let at = self.below(file.len());
        match self.below(6) {
            0 => {
                if let Some(byte) = file.get_mut(at) {
                    *byte ^= 1 << self.below(8);
                }
            }
            1 => file.truncate(at),
            2 | 3 => {
                let number = number_from(file, at);
                let odd = ODD[self.below(ODD.len())];
                file.splice(number, odd.bytes());
            }
            4 => {
                let line = line_around(file, at);
                let copy = file[line.clone()].to_vec();
                let to = line_around(file, self.below(file.len())).start;
                file.splice(to..to, copy);
            }
            _ => {
                let line = line_around(file, at);
                file.drain(line);
            }
        }
    }
}

/// The first number at or after a place; nothing at the end where there is none.
fn number_from(file: &[u8], at: usize) -> std::ops::Range<usize> {
    let is_part = |byte: &u8| byte.is_ascii_digit() || matches!(byte, b'.' | b'-' | b'+' | b'e');
    let start = file[at..].iter().position(u8::is_ascii_digit);
    let start = start.map_or(file.len(), |offset| at + offset);
    let length = file[start..]
        .iter()
        .take_while(|byte| is_part(byte))
        .count();
    start..start + length
}

/// The line that a place is on, its end included.
fn line_around(file: &[u8], at: usize) -> std::ops::Range<usize> {
    let is_end = |byte: &u8| *byte == b'\n';
    let at = at.min(file.len());
    let start = file[..at].iter().rposition(is_end).map_or(0, |end| end + 1);
    let end = file[at..].iter().position(is_end);
    start..end.map_or(file.len(), |offset| at + offset + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_same_seed_breaks_the_same_way_and_something_breaks() {
        let file = b"one 1\ntwo 2.5e3\nthree 3\n";
        let of = |seed| {
            let mut mutator = Mutator::new(seed);
            (0..50).map(|_| mutator.mutate(file)).collect::<Vec<_>>()
        };
        assert_eq!(of(1), of(1));
        assert_ne!(of(1), of(2));
        let broken = of(3)
            .iter()
            .filter(|broken| broken.as_slice() != file)
            .count();
        assert!(broken > 40, "{broken}");
    }
}
