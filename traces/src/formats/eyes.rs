use glam::DVec3;

use super::count;

/// Two eyes made one, and how often each was lost.
///
/// Values are in whatever the file has (pixels, angles, directions); where one eye is lost the other
/// counts alone, which may step gaze by half their disagreement.
#[derive(Debug)]
pub(super) struct EyePair {
    /// Whether the file has the left and the right eye at all.
    present: [bool; 2],
    /// What the mean is taken of, for the note.
    of: &'static str,
    lost: [usize; 2],
    alone: usize,
    neither: usize,
}

impl EyePair {
    pub(super) fn new(present: [bool; 2], of: &'static str) -> Self {
        Self {
            present,
            of,
            lost: [0; 2],
            alone: 0,
            neither: 0,
        }
    }

    /// The mean of both eyes, or the one there is.
    pub(super) fn combine(&mut self, eyes: [Option<DVec3>; 2]) -> Option<DVec3> {
        for (lost, eye) in self.lost.iter_mut().zip(eyes) {
            *lost += usize::from(eye.is_none());
        }
        let both = self.present == [true, true];
        match eyes {
            [Some(l), Some(r)] => Some(0.5 * (l + r)),
            [None, None] => {
                self.neither += 1;
                None
            }
            [l, r] => {
                self.alone += usize::from(both);
                l.or(r)
            }
        }
    }

    pub(super) fn notes(&self) -> Vec<String> {
        let mut notes = vec![match self.present {
            [true, true] => format!("gaze is the mean of both eyes{}", self.of),
            [true, false] => "gaze of the left eye alone".into(),
            _ => "gaze of the right eye alone".into(),
        }];
        if self.present == [true, true] && self.alone > 0 {
            notes.push(format!(
                "{} of one eye alone, where the other was lost",
                count(self.alone, "sample")
            ));
            notes.push(format!(
                "left eye lost in {}, right eye in {}, at least one in {}",
                count(self.lost[0], "row"),
                count(self.lost[1], "row"),
                count(self.alone + self.neither, "row")
            ));
        }
        notes
    }
}
