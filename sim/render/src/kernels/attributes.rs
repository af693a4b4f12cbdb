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
