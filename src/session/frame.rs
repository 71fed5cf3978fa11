//! The moment of an animation that a picture shows.

use std::fmt;

/// Time and animation of the scene that are rendered.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Moment {
    /// The frame; `None` renders the scene at rest.
    pub frame: Option<FrameNumber>,
    /// The only animation that is played, by name or number; `None` plays all together.
    pub animation: Option<String>,
}

/// A frame of the scene's animations.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct FrameNumber {
    /// Frame number; frame 0 is at time 0.
    pub number: u32,
    /// Frames per second.
    pub fps: f64,
}

impl FrameNumber {
    /// Returns the frame's time in seconds.
    pub fn seconds(self) -> f64 {
        f64::from(self.number) / self.fps
    }

    /// Returns a warning if the animations end before this frame, at `end` in seconds, or if there are none.
    pub(super) fn doubt(self, end: Option<f64>) -> Option<String> {
        let (number, seconds) = (self.number, self.seconds());
        match end {
            None => {
                Some(format!("frame {number} was asked for, and no node is animated: the scene is shown as it stands"))
            }
            // Files store times in f32. The comparison rounds alike, so that the last frame is not past its own key.
            Some(end) if f64::from(seconds as f32) > end => {
                let what =
                    format!("frame {number}, at {seconds:.3} s, is past the end of the animation, at {end:.3} s");
                Some(format!("{what}: the scene is shown as it ends"))
            }
            Some(_) => None,
        }
    }
}

impl fmt::Display for FrameNumber {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} at {} per second", self.number, self.fps)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_past_the_end_or_without_animation_are_warned_of() {
        let frame = |number, fps| FrameNumber { number, fps };
        assert_eq!(frame(36, 24.0).seconds(), 1.5);
        assert_eq!(frame(36, 24.0).doubt(Some(1.5)), None);
        // 1/24 s is rounded up and 5/24 s down.
        assert!((1..100).all(|n| frame(n, 24.0).doubt(Some(f64::from((f64::from(n) / 24.0) as f32))).is_none()));
        assert!(frame(37, 24.0).doubt(Some(1.5)).unwrap().contains("frame 37, at 1.542 s, is past the end"));
        assert!(frame(0, 24.0).doubt(None).unwrap().contains("no node is animated"));
    }
}
