use foveasim_assets::{Material, Scene, Sky, study_scene};

/// What is drawn in a row of Table 1 (Guenter 2012, §6): each takes something more away.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Content {
    /// Everything.
    Full,
    /// The ground has a simpler shading.
    CheapTerrain,
    /// And there are no objects above it.
    NoObjects,
    /// Nor ground.
    NoTerrain,
    /// Nor sky.
    NoSkyBox,
    /// Nothing is drawn: what is left is clearing and putting together.
    NoRender,
}

/// The rows of Table 1, top to bottom.
pub(super) const CONTENTS: [Content; 6] = [
    Content::Full,
    Content::CheapTerrain,
    Content::NoObjects,
    Content::NoTerrain,
    Content::NoSkyBox,
    Content::NoRender,
];

impl Content {
    /// As printed.
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

    /// The study scene with no more than this in it.
    pub(super) fn scene(self, seed: u64) -> Scene {
        let full = study_scene(seed);
        let mut materials = full.materials().to_vec();
        if self != Self::Full {
            for material in &mut materials {
                if let Material::Terrain(terrain) = material {
                    terrain.octaves = 0;
                }
            }
        }
        let instances = match self {
            Self::Full | Self::CheapTerrain => full.instances(),
            Self::NoObjects => &full.instances()[..1],
            Self::NoTerrain | Self::NoSkyBox | Self::NoRender => &[],
        };
        let sky = match self {
            Self::NoSkyBox | Self::NoRender => Sky::Uniform([0.0; 3]),
            _ => full.sky().clone(),
        };
        let meshes = full.meshes().to_vec();
        Scene::new(meshes, instances.to_vec(), materials, sky, *full.sun())
            .expect("parts of a valid scene")
    }
}
