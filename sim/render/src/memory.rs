use std::fmt;

use foveasim_models::Image;

/// Memory that frames leave for those drawn after them.
///
/// A magnified frame writes fifty bytes a pixel: of passes, of what reconstruction reads, of the image. Memory that
/// comes fresh from the system is cleared by it page by page as it is written, which takes time.
/// What a frame was drawn in changes nothing of it.
///
/// ```
/// use foveasim_assets::{study_camera, study_scene};
/// use foveasim_models::{Eye, SamplePlan, View, Viewport};
/// use foveasim_render::{FrameMemory, RenderOptions, render_into};
/// use glam::UVec2;
///
/// let scene = study_scene(1);
/// let optics = Viewport::symmetric(UVec2::new(32, 18), 0.43)?;
/// let plan = SamplePlan::full(Eye::Cyclopean, optics.size);
/// let mut memory = FrameMemory::default();
/// for index in 0..3 {
///     let eye = study_camera(index as f64 / 5_377.0, 1);
///     let view = View::still(Eye::Cyclopean, optics, eye);
///     let frame = render_into(&scene, &view, &plan, &RenderOptions::default(), &mut memory)?;
///     assert_eq!(frame.image.size, optics.size);
///     // Shown, and no longer needed.
///     memory.give(frame.image);
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Default)]
pub struct FrameMemory {
    pub(crate) rgb: Pool<[f32; 3]>,
    pub(crate) rgba: Pool<[f32; 4]>,
    pub(crate) reals: Pool<f32>,
    pub(crate) names: Pool<u32>,
}

impl FrameMemory {
    /// Hands in an image that is no longer needed, of whatever size and content.
    pub fn give(&mut self, image: Image) {
        self.rgb.give(image.rgb);
    }
}

/// Memory of one kind of number.
pub(crate) struct Pool<T>(Vec<Vec<T>>);

/// Smaller memory is left to the allocator, which has it at hand \[bytes\].
const LEAST: usize = 1 << 16;
/// The most that are kept: those of a frame of many passes with their histories.
const MOST: usize = 64;

impl<T: Copy> Pool<T> {
    /// Memory for `count` numbers that are all going to be written: `value` or whatever was there.
    pub(crate) fn any(&mut self, count: usize, value: T) -> Vec<T> {
        let Some(mut found) = self.take(count) else {
            return vec![value; count];
        };
        found.truncate(count);
        found.resize(count, value);
        found
    }

    /// Memory for `count` numbers, all of them `value`.
    pub(crate) fn filled(&mut self, count: usize, value: T) -> Vec<T> {
        let Some(mut found) = self.take(count) else {
            return vec![value; count];
        };
        found.clear();
        found.resize(count, value);
        found
    }

    /// Hands in what is no longer needed.
    pub(crate) fn give(&mut self, memory: Vec<T>) {
        if memory.capacity() * size_of::<T>() < LEAST {
            return;
        }
        if self.0.len() == MOST {
            // The oldest is the least likely to be of the present frames' size.
            self.0.remove(0);
        }
        self.0.push(memory);
    }

    /// The least that is large enough. If none is, the largest goes: sizes have grown, and it would not be used again.
    fn take(&mut self, count: usize) -> Option<Vec<T>> {
        if count * size_of::<T>() < LEAST {
            return None;
        }
        let by_capacity = |(_, m): &(usize, &Vec<T>)| m.capacity();
        let places = || self.0.iter().enumerate();
        let fits = places().filter(|(_, m)| m.capacity() >= count);
        let found = fits.min_by_key(by_capacity).map(|(place, _)| place);
        if found.is_none()
            && let Some((largest, _)) = places().max_by_key(by_capacity)
        {
            self.0.swap_remove(largest);
        }
        found.map(|place| self.0.swap_remove(place))
    }
}

impl<T> Default for Pool<T> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<T> fmt::Debug for Pool<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let capacities = self.0.iter().map(Vec::capacity);
        f.debug_list().entries(capacities).finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const K: usize = LEAST / size_of::<f32>();

    #[test]
    fn the_least_that_is_large_enough_is_used_again() {
        let mut pool = Pool::<f32>::default();
        let sizes = [4 * K, 2 * K, 3 * K];
        let mut at = Vec::new();
        for size in sizes {
            let memory = pool.any(size, 1.0);
            at.push(memory.as_ptr());
            at.dedup();
            pool.give(memory);
        }
        // Each of the smaller ones fitted into the first.
        assert_eq!(at.len(), 1);
        pool.give(vec![2.0; K]);
        assert_eq!(pool.any(K, 0.0), vec![2.0; K]);
        let whole = pool.filled(4 * K, 7.0);
        assert_eq!((whole.as_ptr(), whole), (at[0], vec![7.0; 4 * K]));
    }

    #[test]
    fn what_is_too_small_or_too_much_is_let_go() {
        let mut pool = Pool::<f32>::default();
        pool.give(vec![0.0; K / 2]);
        assert!(pool.0.is_empty());
        for _ in 0..2 * MOST {
            pool.give(vec![0.0; K]);
        }
        assert_eq!(pool.0.len(), MOST);
        // Nothing fits: one goes for the one that comes.
        let larger = pool.any(2 * K, 0.0);
        assert_eq!((larger.len(), pool.0.len()), (2 * K, MOST - 1));
    }
}
