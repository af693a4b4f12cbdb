use std::ops::Range;

use glam::DVec3;

use crate::{Mesh, Similarity};

/// Meshes of one shape, from fine to coarse, and what distance asks for which.
///
/// Guenter et al. 2012, §6: "As squared distance goes from MinDistSq to MaxDistSq, each object's
/// tessellation ranges from MaxTriCount to MinTriCount. A separate tessellation curve can be specified
/// for each layer." The curve is a straight line in squared distance.
#[derive(Debug, Clone, PartialEq)]
pub struct LevelOfDetail {
    /// Which of the scene's meshes, the finest first.
    pub meshes: Range<usize>,
    /// For each of them: no point of the shape is farther from the mesh, nor, where that is estimated, the
    /// mesh's shading from where the shape has it, object space \[m\].
    pub deviations_m: Vec<f64>,
    /// MinDistSq and MaxDistSq \[m²\], from the eye to the object's origin.
    pub distance_sq_m2: [f64; 2],
    /// MaxTriCount and MinTriCount of the full image and of all layers but the outermost.
    pub triangles: [f64; 2],
    /// MaxTriCount and MinTriCount of the outermost layer.
    pub triangles_outermost: [f64; 2],
}

/// What a pass needs of a shape's detail.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Detail {
    /// How detail follows from distance.
    pub rule: LodRule,
    /// Whether the pass is the outermost of several layers, which have a curve of their own.
    pub outermost: bool,
    /// Width of a sample as a tangent, the smaller one if they differ by axis. The footprint rule alone
    /// reads it.
    pub sample_tan: f64,
    /// By how many such samples the mesh may be off the shape. The footprint rule alone reads it.
    pub error_samples: f64,
}

impl Detail {
    /// Half a sample: about what can be seen of an outline's place.
    pub const ERROR_SAMPLES: f64 = 0.5;
}

/// How detail follows from distance.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum LodRule {
    /// Always the finest mesh.
    Finest,
    /// By squared distance, as Guenter et al. do: the mesh whose triangle count is, as a ratio, nearest
    /// to the curve's.
    Distance,
    /// As [`LodRule::Distance`], and never finer than the samples can show: the coarsest mesh that is
    /// off the shape by less than [`Detail::error_samples`], half a sample by default, as seen from the eye.
    ///
    /// What this changes: outlines by less than that straight ahead. At an angle θ off the axis
    /// samples subtend less and it is at most 1/cos²θ times that (1.24 in the corners of the study's
    /// display). What normals make of light moves by about as much; for it, and for texture coordinates
    /// over larger triangles, no bound is claimed.
    #[default]
    Footprint,
}

impl LevelOfDetail {
    /// Index in `meshes`, which are the scene's, of the mesh to draw of an object placed at `placed`.
    pub(crate) fn mesh(
        &self,
        meshes: &[Mesh],
        placed: &Similarity,
        eye: DVec3,
        detail: Detail,
    ) -> usize {
        let level = match detail.rule {
            LodRule::Finest => 0,
            LodRule::Distance => self.by_distance(meshes, placed, eye, detail.outermost),
            LodRule::Footprint => {
                let by_distance = self.by_distance(meshes, placed, eye, detail.outermost);
                let (centre, radius) = meshes[self.meshes.start].bounds();
                let away = eye.distance(placed.point(centre)) - placed.scale * radius;
                let shown_m = detail.error_samples * detail.sample_tan * away / placed.scale;
                let coarsest = self.deviations_m.iter().rposition(|d| *d < shown_m);
                by_distance.max(coarsest.unwrap_or(0))
            }
        };
        self.meshes.start + level
    }

    /// The level whose triangle count is nearest to the curve's; the finest if the eye is nowhere.
    fn by_distance(
        &self,
        meshes: &[Mesh],
        placed: &Similarity,
        eye: DVec3,
        outermost: bool,
    ) -> usize {
        let wanted = self.wanted(eye.distance_squared(placed.pose.position), outermost);
        let ladder = &meshes[self.meshes.clone()];
        let count = |level: usize| ladder[level].triangles().len() as f64;
        let coarser = ladder.partition_point(|m| m.triangles().len() as f64 > wanted);
        if coarser == 0 {
            0
        } else if coarser == ladder.len() || count(coarser - 1) * count(coarser) < wanted * wanted {
            coarser - 1
        } else {
            coarser
        }
    }

    /// The curve: how many triangles at a squared distance \[m²\].
    pub fn wanted(&self, distance_sq_m2: f64, outermost: bool) -> f64 {
        let [near, far] = self.distance_sq_m2;
        let [most, fewest] = if outermost {
            self.triangles_outermost
        } else {
            self.triangles
        };
        let t = ((distance_sq_m2 - near) / (far - near)).clamp(0.0, 1.0);
        most + t * (fewest - most)
    }

    /// What is wrong with it as a part of a scene with these meshes, if anything.
    pub(crate) fn fault(&self, meshes: &[Mesh]) -> Option<&'static str> {
        let Some(ladder) = meshes
            .get(self.meshes.clone())
            .filter(|ladder| !ladder.is_empty())
        else {
            return Some("must name at least one mesh, all of them in the scene");
        };
        let coarser = |pair: &[Mesh]| pair[0].triangles().len() > pair[1].triangles().len();
        if !ladder.windows(2).all(coarser) {
            return Some("must list its meshes from fine to coarse");
        }
        let distance = |d: &f64| d.is_finite() && *d >= 0.0;
        if self.deviations_m.len() != ladder.len() || !self.deviations_m.iter().all(distance) {
            return Some("must have one deviation of 0 m or more for each mesh");
        }
        let [near, far] = self.distance_sq_m2;
        if !(near >= 0.0 && near < far && far.is_finite()) {
            return Some("must have finite squared distances, the near one below the far one");
        }
        let counts = [self.triangles, self.triangles_outermost];
        let falls = |[most, fewest]: [f64; 2]| fewest >= 1.0 && fewest <= most && most.is_finite();
        if !counts.into_iter().all(falls) {
            return Some("must have triangle counts of 1 or more, the first not below the second");
        }
        None
    }
}
