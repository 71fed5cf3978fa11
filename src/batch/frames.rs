//! Frame lists such as `1-240x2,300`.

use std::collections::HashSet;
use std::fmt;
use std::str::FromStr;

/// Distinct frame numbers, in the order in which they were written: `1-240`, every second one `1-240x2`, or several of
/// either `1,3,7-9`. At least one and at most [`Frames::MOST`].
#[derive(Debug, Clone, PartialEq, Eq, serde::Deserialize)]
#[serde(try_from = "String")]
pub struct Frames(Vec<u32>);

impl TryFrom<String> for Frames {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        text.parse()
    }
}

impl Frames {
    /// Maximum number of frames in a list.
    pub const MOST: usize = 1_000_000;

    /// Returns the frame numbers.
    pub fn numbers(&self) -> &[u32] {
        &self.0
    }
}

/// `first` to `last` in steps of `step`.
#[derive(Clone, Copy)]
struct Range {
    first: u32,
    last: u32,
    step: u32,
}

impl Range {
    fn len(self) -> usize {
        ((self.last - self.first) / self.step) as usize + 1
    }
}

impl FromStr for Range {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let number = |part: &str| {
            let part = part.trim();
            // `parse` would accept a plus sign.
            let digits = part.bytes().all(|b| b.is_ascii_digit());
            let number = part.parse().ok().filter(|_| digits);
            number.ok_or_else(|| format!("'{text}' is no frame and no range of frames: write 7, 1-240 or 1-240x2"))
        };
        let Some((first, rest)) = text.split_once('-') else {
            let first = number(text)?;
            return Ok(Range { first, last: first, step: 1 });
        };
        let (last, step) = rest.split_once('x').unwrap_or((rest, "1"));
        let range = Range { first: number(first)?, last: number(last)?, step: number(step)? };
        match range {
            Range { step: 0, .. } => Err(format!("the frames '{text}' do not go on: the step must be above zero")),
            Range { first, last, .. } if last < first => Err(format!("the frames '{text}' end before they begin")),
            range => Ok(range),
        }
    }
}

impl FromStr for Frames {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let mut numbers = Vec::new();
        let mut known = HashSet::new();
        let mut named = 0;
        for part in text.split(',') {
            let range: Range = part.trim().parse()?;
            named += range.len();
            if named > Frames::MOST {
                return Err(format!("there are more than {} frames", Frames::MOST));
            }
            let new = (range.first..=range.last).step_by(range.step as usize).filter(|&number| known.insert(number));
            numbers.extend(new);
        }
        Ok(Frames(numbers))
    }
}

impl fmt::Display for Frames {
    /// Writes the shortest list of ranges. Parsing it gives the same frames.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut rest = &self.0[..];
        let mut separator = "";
        while let Some(range) = run(rest) {
            match range {
                Range { first, last, .. } if first == last => write!(f, "{separator}{first}")?,
                Range { first, last, step: 1 } => write!(f, "{separator}{first}-{last}")?,
                Range { first, last, step } => write!(f, "{separator}{first}-{last}x{step}")?,
            }
            separator = ",";
            rest = &rest[range.len()..];
        }
        Ok(())
    }
}

/// The longest range at the start of `numbers`. Two numbers do not count as a range.
fn run(numbers: &[u32]) -> Option<Range> {
    let &first = numbers.first()?;
    let alone = Range { first, last: first, step: 1 };
    let Some(step) = numbers.get(1).and_then(|second| second.checked_sub(first)).filter(|&step| step > 0) else {
        return Some(alone);
    };
    let follows = |pair: &&[u32]| pair[0].checked_add(step) == Some(pair[1]);
    let length = 1 + numbers.windows(2).take_while(follows).count();
    Some(if length > 2 { Range { first, last: numbers[length - 1], step } } else { alone })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn numbers(text: &str) -> Vec<u32> {
        text.parse::<Frames>().unwrap().numbers().to_vec()
    }

    #[test]
    fn lists_are_frames_and_ranges_in_their_order() {
        assert_eq!(numbers("7"), [7]);
        assert_eq!(numbers("1-4"), [1, 2, 3, 4]);
        assert_eq!(numbers("1-10x4"), [1, 5, 9]);
        assert_eq!(numbers(" 9, 1 - 3 ,20-24 x 2"), [9, 1, 2, 3, 20, 22, 24]);
        assert_eq!(numbers("0-0"), [0]);
        assert_eq!(numbers("4294967295,0-4294967295x4294967295"), [u32::MAX, 0]);
    }

    #[test]
    fn frames_are_named_once() {
        assert_eq!(numbers("3,1-5,2-6x2"), [3, 1, 2, 4, 5, 6]);
    }

    #[test]
    fn invalid_frame_list_is_one_sentence() {
        for (text, what) in [
            ("", "'' is no frame"),
            ("1,,2", "'' is no frame"),
            ("1-2-3", "'1-2-3' is no frame"),
            ("-1", "'-1' is no frame"),
            ("+1", "'+1' is no frame"),
            ("1x2", "'1x2' is no frame"),
            ("1-9x", "'1-9x' is no frame"),
            ("1.5", "'1.5' is no frame"),
            ("4294967296", "'4294967296' is no frame"),
            ("9-1", "end before they begin"),
            ("1-9x0", "the step must be above zero"),
            ("0-1000000", "more than 1000000 frames"),
            ("1-600000,1-600000", "more than 1000000 frames"),
            ("0-4294967295", "more than 1000000 frames"),
        ] {
            let error = text.parse::<Frames>().unwrap_err();
            assert!(error.contains(what) && !error.contains('\n'), "{text}: {error}");
        }
        assert_eq!(numbers("1-1000000").len(), Frames::MOST);
    }

    #[test]
    fn lists_are_written_as_ranges() {
        let written = |text: &str| text.parse::<Frames>().unwrap().to_string();
        for text in ["7", "1-240", "1-9x2", "1,3,7-9", "5,4,3", "0-4294967294x2147483647", "1,2"] {
            assert_eq!(written(text), text);
        }
        assert_eq!(written("1,2,3,5,7,9-11"), "1-3,5-9x2,10,11");
        assert_eq!(written("1-240x2"), "1-239x2");
    }

    proptest! {
        #[test]
        fn what_is_written_is_read_back(parts in proptest::collection::vec((0u32..50, 0u32..50, 1u32..9), 1..9)) {
            let text: Vec<_> = parts.iter().map(|(first, more, step)| format!("{first}-{}x{step}", first + more)).collect();
            let frames: Frames = text.join(",").parse().unwrap();
            prop_assert_eq!(frames.to_string().parse::<Frames>().unwrap(), frames.clone());
            let distinct: HashSet<&u32> = frames.numbers().iter().collect();
            prop_assert_eq!(distinct.len(), frames.numbers().len());
        }

        #[test]
        fn arbitrary_text_is_a_frame_list_or_one_sentence(text in "[0-9x, -]{0,12}") {
            if let Ok(frames) = text.parse::<Frames>() {
                prop_assert!((1..=Frames::MOST).contains(&frames.numbers().len()));
            }
        }
    }
}
