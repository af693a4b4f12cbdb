use foveasim_models::math::{cos, sin};
use foveasim_models::{Pose, Role, Stream};
use glam::{DQuat, DVec3};

use crate::{
    AnalyticSky, EnvironmentMap, Instance, Material, Scene, SceneParts, Similarity, Sky, Sun,
    Terrain, TerrainDetail, study_objects, terrain_height, terrain_mesh,
};

/// Frames of the fly-through (Guenter 2012, §6: 5,377).
pub const STUDY_FRAMES: u32 = 5377;

/// Squares along each side of the ground: 20,000 triangles.
const GROUND_CELLS: u32 = 100;
/// Texels along each side of the environment map: one subtends 0.09° on average.
const SKY_TEXELS: u32 = 1536;

/// How much of the study scene there is: the rows of Guenter et al. 2012, Table 1, each with less than
/// the one before it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub enum StudyContent {
    /// "All content as presented in our user study."
    #[default]
    Full,
    /// "Replaces the procedural shading on the terrain with a simpler version."
    CheapTerrain,
    /// "Further removes all objects above the terrain."
    NoObjects,
    /// "Removes the terrain surface entirely."
    NoTerrain,
    /// "Removes the environment map": one colour is left.
    NoSkyBox,
    /// "Eliminates all graphical content and just executes a framebuffer clear": the scene is that of
    /// [`StudyContent::NoSkyBox`]; whoever draws it leaves out drawing, too.
    NoRender,
}

impl StudyContent {
    /// All rows of the table, from top to bottom.
    pub const ALL: [Self; 6] = [
        Self::Full,
        Self::CheapTerrain,
        Self::NoObjects,
        Self::NoTerrain,
        Self::NoSkyBox,
        Self::NoRender,
    ];

    /// The row's name in the table.
    pub fn name(self) -> &'static str {
        match self {
            Self::Full => "Full",
            Self::CheapTerrain => "Cheap Terrain",
            Self::NoObjects => "No Objects",
            Self::NoTerrain => "No Terrain",
            Self::NoSkyBox => "No SkyBox",
            Self::NoRender => "No Render",
        }
    }
}

/// The sun of the study scene: from the right, in front and above.
pub const STUDY_SUN: Sun = Sun {
    direction: DVec3::new(0.45, 0.62, 0.64),
    radiance: [0.95, 0.88, 0.76],
};

/// The sky of the study scene, with the haze of a landscape of some 400 m.
pub fn study_sky(seed: u64) -> AnalyticSky {
    AnalyticSky {
        seed: ground_seed(seed),
        zenith: [0.10, 0.24, 0.60],
        horizon: [0.55, 0.68, 0.86],
        mountains: [0.16, 0.20, 0.26],
        cloud_cover: 0.45,
        visibility_m: 420.0,
    }
}

/// The study scene of Guenter et al. 2012, §5 and §6: procedurally shaded ground of 20,000 triangles,
/// 20 × 20 parametric objects from diffuse to glossy floating above it, 20,000 triangles down to 400
/// each by squared distance, and an environment map of mountains and clouds. The same seed gives the
/// same scene.
pub fn study_scene(seed: u64) -> Scene {
    study_scene_with(seed, StudyContent::Full)
}

/// The study scene, or what a row of the paper's Table 1 leaves of it.
pub fn study_scene_with(seed: u64, content: StudyContent) -> Scene {
    let ground_seed = ground_seed(seed);
    let sky = study_sky(seed);
    let sky = if content < StudyContent::NoSkyBox {
        Sky::Map(EnvironmentMap::of_sky(&sky, &STUDY_SUN, SKY_TEXELS))
    } else {
        Sky::Uniform(sky.horizon)
    };
    let (mut meshes, mut lods) = (Vec::new(), Vec::new());
    let (mut instances, mut materials) = (Vec::new(), Vec::new());
    if content < StudyContent::NoTerrain {
        meshes.push(terrain_mesh(ground_seed, GROUND_CELLS));
        materials.push(Material::Terrain(Terrain {
            seed: ground_seed,
            octaves: 8,
            snow_line_m: 17.0,
            detail: if content == StudyContent::Full {
                TerrainDetail::Procedural
            } else {
                TerrainDetail::Cheap
            },
        }));
        instances.push(Instance {
            mesh: 0,
            lod: None,
            material: 0,
            world_from_object: Similarity::at(DVec3::ZERO),
            two_sided: false,
        });
    }
    if content < StudyContent::NoObjects {
        lods = study_objects::ladders(&mut meshes);
        let first_material = materials.len();
        materials.extend(study_objects::materials(seed));
        instances.extend(study_objects::instances(
            seed,
            &meshes,
            &lods,
            first_material,
        ));
    }
    Scene::build(SceneParts {
        meshes,
        lods,
        instances,
        materials,
        textures: Vec::new(),
        motions: Vec::new(),
        sky,
        sun: STUDY_SUN,
    })
    .expect("generated parts fit together")
}

/// Where the eye is at `t` of the fly-through (0 to 1): along the street in the middle of the grid,
/// looking ahead and swaying. Values beyond are clamped. `seed` is the scene's.
pub fn study_camera(t: f64, seed: u64) -> Pose {
    let t = if t > 0.0 { t.min(1.0) } else { 0.0 };
    let turn = 2.0 * std::f64::consts::PI;
    let z = 84.0 - 160.0 * t;
    let x = 0.8 * sin(turn * 3.0 * t);
    let ground = terrain_height(x, z, ground_seed(seed));
    let position = DVec3::new(x, ground + 6.0 + 0.6 * sin(turn * 5.0 * t), z);
    let yaw = DQuat::from_axis_angle(DVec3::Y, 0.22 * sin(turn * 2.0 * t));
    let pitch = DQuat::from_axis_angle(DVec3::X, -0.05 + 0.05 * cos(turn * 4.0 * t));
    Pose::new(position, (yaw * pitch).normalize())
}

pub(crate) fn ground_seed(seed: u64) -> u32 {
    Stream::new(seed, Role::Scene, 0).next_u64() as u32
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::LazyLock;

    use crate::{Detail, LodRule};

    static SCENE: LazyLock<Scene> = LazyLock::new(|| study_scene(1));

    /// The pixel of a display 1920 pixels and 46.7° wide, as the study's.
    const PIXEL_TAN: f64 = 51.0 / 59.0 / 1920.0;

    fn detail(rule: LodRule, outermost: bool) -> Detail {
        Detail {
            rule,
            outermost,
            sample_tan: PIXEL_TAN,
            error_samples: Detail::ERROR_SAMPLES,
        }
    }

    #[test]
    fn the_same_seed_gives_the_same_scene() {
        assert_eq!(*SCENE, study_scene(1));
        assert_ne!(SCENE.instances(), study_scene(2).instances());
    }

    #[test]
    fn it_is_the_scene_of_the_paper() {
        let scene = &*SCENE;
        assert_eq!(scene.meshes()[0].triangles().len(), 20_000);
        assert_eq!(scene.instances().len(), 1 + 400);
        // 20,000 each, less what whole rows and columns miss of it.
        let triangles = scene.triangle_count();
        assert!((7_940_000..=8_020_000).contains(&triangles), "{triangles}");
        let bytes = |m: &crate::Mesh| 32 * m.vertex_count() + 12 * m.triangles().len();
        let bytes: usize = scene.meshes().iter().map(bytes).sum();
        assert!(bytes < 40 << 20, "{bytes} bytes of meshes");
    }

    #[test]
    fn each_row_of_table_1_has_less_than_the_one_before() {
        let scenes = StudyContent::ALL.map(|content| study_scene_with(1, content));
        let sizes = scenes.each_ref().map(|s| s.instances().len());
        assert_eq!(sizes, [401, 401, 1, 0, 0, 0]);
        let cheap = |s: &Scene| match &s.materials()[0] {
            Material::Terrain(t) => t.detail == TerrainDetail::Cheap,
            _ => false,
        };
        assert!(!cheap(&scenes[0]) && cheap(&scenes[1]) && cheap(&scenes[2]));
        assert_eq!(scenes[0].instances(), scenes[1].instances());
        let maps = scenes.each_ref().map(|s| matches!(s.sky(), Sky::Map(_)));
        assert_eq!(maps, [true, true, true, true, false, false]);
    }

    #[test]
    fn the_camera_stays_above_ground_and_out_of_objects() {
        let scene = &*SCENE;
        for frame in 0..STUDY_FRAMES {
            let eye = study_camera(f64::from(frame) / f64::from(STUDY_FRAMES), 1).position;
            assert!(eye.y > terrain_height(eye.x, eye.z, ground_seed(1)) + 3.0);
            for i in &scene.instances()[1..] {
                let s = i.world_from_object;
                let (_, radius) = scene.meshes()[i.mesh].bounds();
                assert!(
                    eye.distance(s.pose.position) > radius * s.scale + 0.1,
                    "frame {frame}"
                );
            }
        }
    }

    #[test]
    fn the_camera_takes_any_number() {
        assert_eq!(study_camera(f64::NAN, 1), study_camera(0.0, 1));
        assert_eq!(study_camera(7.0, 1), study_camera(1.0, 1));
    }

    /// How many triangles are drawn at a distance against the paper's line: 2^(1/12) at most for steps
    /// of 2^(1/6), and a little for whole rows and columns.
    #[test]
    fn drawn_counts_follow_the_curve() {
        let scene = &*SCENE;
        for outermost in [false, true] {
            let (mut drawn, mut wanted) = (0.0, 0.0);
            for (index, instance) in scene.instances().iter().enumerate().skip(1) {
                let lod = &scene.lods()[instance.lod.unwrap()];
                let origin = instance.world_from_object.pose.position;
                for away in (0..80).map(f64::from) {
                    let eye = origin + DVec3::new(0.6, 0.0, 0.8) * away;
                    let mesh = scene.mesh_for(index, eye, detail(LodRule::Distance, outermost));
                    let count = scene.meshes()[mesh].triangles().len() as f64;
                    let curve = lod.wanted(away * away, outermost);
                    let off = (count / curve).max(curve / count);
                    assert!(off < 1.09, "{count} for {curve} at {away} m");
                    drawn += count;
                    wanted += curve;
                }
            }
            let off: f64 = drawn / wanted - 1.0;
            assert!(off.abs() < 0.02, "{off}");
        }
    }

    #[test]
    fn the_footprint_rule_stays_within_half_a_sample() {
        let scene = &*SCENE;
        let mut coarser = 0;
        for frame in (0..STUDY_FRAMES).step_by(500) {
            let eye = study_camera(f64::from(frame) / f64::from(STUDY_FRAMES), 1).position;
            for (index, instance) in scene.instances().iter().enumerate().skip(1) {
                let lod = &scene.lods()[instance.lod.unwrap()];
                let by_distance = scene.mesh_for(index, eye, detail(LodRule::Distance, false));
                let drawn = scene.mesh_for(index, eye, detail(LodRule::Footprint, false));
                assert!(drawn >= by_distance);
                // Half of four times the samples is twice the samples.
                let strict = Detail {
                    sample_tan: 4.0 * PIXEL_TAN,
                    error_samples: 0.5 * Detail::ERROR_SAMPLES,
                    ..detail(LodRule::Footprint, false)
                };
                let coarse = Detail {
                    sample_tan: 2.0 * PIXEL_TAN,
                    ..detail(LodRule::Footprint, false)
                };
                assert_eq!(
                    scene.mesh_for(index, eye, strict),
                    scene.mesh_for(index, eye, coarse)
                );
                if drawn > by_distance {
                    let placed = instance.world_from_object;
                    let (centre, radius) = scene.meshes()[lod.meshes.start].bounds();
                    let nearest = eye.distance(placed.point(centre)) - radius * placed.scale;
                    let off_m = lod.deviations_m[drawn - lod.meshes.start] * placed.scale;
                    assert!(off_m / nearest < 0.5 * PIXEL_TAN);
                    coarser += 1;
                }
            }
        }
        assert!(coarser > 500, "{coarser}");
        let nowhere = scene.mesh_for(1, DVec3::NAN, detail(LodRule::Footprint, false));
        assert_eq!(
            nowhere,
            scene.mesh_for(1, DVec3::ZERO, detail(LodRule::Finest, false))
        );
    }

    /// Triangles in the view frustum of the study's display: whole objects that are in part, and those
    /// of the ground with a corner in it.
    fn in_view(scene: &Scene, camera: Pose, detail: Detail) -> f64 {
        let (half_x, half_y) = (51.0 / 118.0, 51.0 / 118.0 * 9.0 / 16.0);
        let eye_from_world = camera.inverse();
        let sees = |p: DVec3, radius: f64| {
            let p = eye_from_world.point(p);
            let side = |c: f64, t: f64| c.abs() + p.z * t <= radius * (1.0 + t * t).sqrt();
            p.z < radius && side(p.x, half_x) && side(p.y, half_y)
        };
        let ground = &scene.meshes()[0];
        let seen: Vec<bool> = (0..ground.vertex_count())
            .map(|i| sees(ground.position(i as u32), 0.0))
            .collect();
        let ground = ground
            .triangles()
            .iter()
            .filter(|t| t.iter().any(|&i| seen[i as usize]))
            .count();
        let mut triangles = ground;
        for (index, i) in scene.instances().iter().enumerate().skip(1) {
            let mesh = &scene.meshes()[scene.mesh_for(index, camera.position, detail)];
            let (centre, radius) = mesh.bounds();
            let placed = i.world_from_object;
            if sees(placed.point(centre), radius * placed.scale) {
                triangles += mesh.triangles().len();
            }
        }
        triangles as f64
    }

    /// "Our system renders roughly 250k triangles per frame visible in the view frustum" and "the outer
    /// layer is rendered with roughly half as many" (Guenter 2012, §6).
    #[test]
    fn as_many_triangles_are_in_view_as_the_paper_counts() {
        let scene = &*SCENE;
        let mean = |detail: Detail| {
            let frames = (0..STUDY_FRAMES).step_by(49);
            let count = frames.len() as f64;
            let sum: f64 = frames
                .map(|f| {
                    let camera = study_camera(f64::from(f) / f64::from(STUDY_FRAMES), 1);
                    in_view(scene, camera, detail)
                })
                .sum();
            sum / count
        };
        let inner = mean(detail(LodRule::Distance, false));
        let outer = mean(detail(LodRule::Distance, true));
        let footprint = mean(detail(LodRule::Footprint, false));
        assert!((235_000.0..265_000.0).contains(&inner), "{inner}");
        assert!((0.35..0.6).contains(&(outer / inner)), "{outer}");
        assert!(footprint < 0.75 * inner, "{footprint}");
    }
}
