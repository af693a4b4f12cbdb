use std::collections::VecDeque;

use foveasim_models::Image;

/// The mean of the last frames while what they show stays (Bruder 2019, §4.4): it takes away what flickers as rays move
/// with the gaze.
#[derive(Debug, Clone)]
pub struct TemporalMean {
    frames: usize,
    history: VecDeque<Image>,
}

impl TemporalMean {
    /// The paper's number of frames.
    pub const PUBLISHED_FRAMES: u32 = 8;

    /// Of at most `frames` frames (at least one), the newest among them.
    pub fn new(frames: u32) -> Self {
        Self {
            frames: frames.max(1) as usize,
            history: VecDeque::new(),
        }
    }

    /// Takes the next frame and gives the mean of those held. `changed`: camera, volume or transfer function are not what
    /// they were in the last frame. Then, and when the size changes, what is held is forgotten.
    pub fn push(&mut self, frame: Image, changed: bool) -> Image {
        if changed
            || self
                .history
                .back()
                .is_some_and(|last| last.size != frame.size)
        {
            self.history.clear();
        }
        if self.history.len() == self.frames {
            self.history.pop_front();
        }
        self.history.push_back(frame);
        // Anew every time, oldest first: a running sum would drift.
        let share = 1.0 / self.history.len() as f32;
        let mut mean = self.history[0].clone();
        for frame in self.history.iter().skip(1) {
            for (sum, colour) in mean.rgb.iter_mut().zip(&frame.rgb) {
                for (s, c) in sum.iter_mut().zip(colour) {
                    *s += c;
                }
            }
        }
        if self.history.len() > 1 {
            mean.rgb.iter_mut().flatten().for_each(|v| *v *= share);
        }
        mean
    }
}

#[cfg(test)]
mod tests {
    use glam::UVec2;

    use super::*;

    #[test]
    fn means_are_of_what_has_not_changed() {
        let frame = |v: f32| Image::filled(UVec2::new(3, 2), [v, 2.0 * v, 0.0]);
        let mut mean = TemporalMean::new(3);
        assert_eq!(mean.push(frame(1.0), false), frame(1.0));
        assert_eq!(mean.push(frame(3.0), false), frame(2.0));
        assert_eq!(mean.push(frame(5.0), false), frame(3.0));
        assert_eq!(mean.push(frame(7.0), false), frame(5.0));
        assert_eq!(mean.push(frame(8.0), true), frame(8.0));
        let other = Image::filled(UVec2::new(2, 2), [1.0; 3]);
        assert_eq!(mean.push(other.clone(), false), other);
        let mut one = TemporalMean::new(0);
        one.push(frame(1.0), false);
        assert_eq!(one.push(frame(3.0), false), frame(3.0));
    }
}
