use super::wide::WIDTH;

/// What shading always needs of one triangle: one cache line.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
pub(crate) struct Attributes(pub(crate) [f32; Attributes::COUNT]);

impl Attributes {
    /// Lattice position of the first corner of the set-up triangle [samples].
    pub(crate) const CORNER: usize = 0;
    /// Normal in the world over w: at CORNER, its change along x, along y.
    pub(crate) const NORMAL: usize = 2;
    /// 1/w at CORNER, its change along x, along y, its least and greatest value.
    pub(crate) const DEPTH: usize = 11;
    pub(crate) const COUNT: usize = 16;
}

/// What else some materials need of a triangle, and fragments whose middle may lie outside of it: each
/// attribute as a start and its change towards the second and the third corner, and the functions that
/// give a sample's place in the triangle.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Details(pub(crate) [f32; Details::COUNT]);

impl Details {
    /// Weight over w of the second and third corner: at CORNER, change along x, along y.
    pub(crate) const WEIGHTS: usize = 0;
    /// Normal in the world: at the first corner, towards the second, towards the third.
    pub(crate) const NORMAL: usize = 6;
    /// Position in the object.
    pub(crate) const OBJECT: usize = 15;
    /// Texture coordinates.
    pub(crate) const UV: usize = 24;
    /// Object units per metre; texture units per metre.
    pub(crate) const PER_METRE: usize = 30;
    pub(crate) const COUNT: usize = 32;
    /// Of a triangle whose details nothing reads.
    pub(crate) const UNREAD: Self = Self([0.0; Self::COUNT]);
}

/// Room for what lies side by side of blocks, but not of fragments.
#[derive(Default)]
pub(super) struct Loose {
    /// Places among the visible triangles.
    pub(super) names: [u32; WIDTH],
    /// Lattice position of each.
    pub(super) x: [f32; WIDTH],
    pub(super) y: [f32; WIDTH],
    /// 1/w at each.
    pub(super) inverse_w: [f32; WIDTH],
    /// When each looks, on rolling displays.
    pub(super) time: [f32; WIDTH],
}

impl Loose {
    /// The depth at these positions, as the depth test has it, to the bit; 1 where there is nothing.
    #[inline(always)]
    pub(super) fn find_depth(&mut self, triangles: &[Attributes]) {
        for lane in 0..WIDTH {
            let Some(Attributes(a)) = triangles.get(self.names[lane] as usize) else {
                self.inverse_w[lane] = 1.0;
                continue;
            };
            let dx = self.x[lane] - a[Attributes::CORNER];
            let dy = self.y[lane] - a[Attributes::CORNER + 1];
            let [at, step_x, step_y, low, high] = std::array::from_fn(|k| a[Attributes::DEPTH + k]);
            let depth = dx * step_x + at + dy * step_y;
            let depth = if depth < high { depth } else { high };
            self.inverse_w[lane] = if depth > low { depth } else { low };
        }
    }
}
