use super::Target;
use crate::raster::EyeVertex;

/// What shading reads of a moving triangle: where a sample lies in it, at the sample's own time, and its normals.
#[derive(Debug, Clone, Copy)]
pub(crate) struct MovingAttributes {
    /// Edges by power of t and component: of equal sign within, and in proportion to the weights of the corners.
    pub(crate) edges: [[[f32; 3]; 3]; 3],
    /// Normals of the corners in the world at the start, of the side that faces out.
    pub(crate) normals: [[f32; 3]; 3],
    /// How they change until the end.
    pub(crate) turns: [[f32; 3]; 3],
}

impl MovingAttributes {
    /// Of a triangle whose vertices are `start` and `end`.
    pub(crate) fn new(target: &Target, start: &[EyeVertex; 3], end: &[EyeVertex; 3]) -> Self {
        let turn = |i: usize| [0, 1, 2].map(|k| end[i].normal[k] - start[i].normal[k]);
        Self {
            edges: target.edges,
            normals: start.map(|v| v.normal),
            turns: [0, 1, 2].map(turn),
        }
    }
}
