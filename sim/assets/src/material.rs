/// How a surface answers light: a closed list, so that a renderer has one kernel for each.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Material {
    /// One colour, whatever the light: for tests and markers. Linear RGB.
    Unlit([f32; 3]),
    /// Rock, grass and snow by height and slope.
    Terrain(Terrain),
    /// A two-coloured surface from diffuse to mirror-like.
    Surface(Surface),
    /// A surface whose colour and finish come from numbers and textures.
    Textured(Textured),
    /// The plainest lit surface, as renderers are compared by.
    Phong(Phong),
}

/// Phong's reflection (1975) with colours that wave through the world, seen alike from both sides:
/// ½ + ½·sin(frequency·p) times (ambient + diffuse·n·l), plus specular·(r·v)^(2^k), in units of the
/// sun's radiance.
#[derive(Debug, Clone, PartialEq)]
pub struct Phong {
    /// Radians of the colours' wave per metre of the world, 0 to 1000.
    pub frequency: f32,
    /// Share of the colour without any light.
    pub ambient: f32,
    /// Share of the colour that faces the light.
    pub diffuse: f32,
    /// Brightness of the highlight.
    pub specular: f32,
    /// Binary logarithm k of the highlight's exponent, 0 to 10.
    pub shininess_log2: u32,
}

/// Procedural ground: bands of grass, rock and snow broken up by noise.
#[derive(Debug, Clone, PartialEq)]
pub struct Terrain {
    /// Seed of the noise.
    pub seed: u32,
    /// Octaves of noise evaluated where the pixel footprint can show them.
    pub octaves: u32,
    /// Height above which snow lies \[m\].
    pub snow_line_m: f32,
    /// How much work each sample is.
    pub detail: TerrainDetail,
}

/// How much work a sample of [`Terrain`] is (Guenter et al. 2012, Table 1: "Cheap Terrain replaces the
/// procedural shading on the terrain with a simpler version").
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum TerrainDetail {
    /// Four fractals (colour at two scales, relief along two axes), `octaves` each: 32 evaluations of
    /// noise with the study's 8, fewer where the footprint cannot show them.
    #[default]
    Procedural,
    /// The same ground from one evaluation of noise, without relief.
    Cheap,
}

/// A lit surface (diffuse plus one microfacet lobe plus the reflected sky).
#[derive(Debug, Clone, PartialEq)]
pub struct Surface {
    /// The two colours of the pattern, linear RGB.
    pub albedo: [[f32; 3]; 2],
    /// Where which colour is.
    pub pattern: Pattern,
    /// Pattern periods per unit of object space or of the texture coordinates.
    pub frequency: f32,
    /// Microfacet roughness α (GGX), 0.02 to 1.
    pub roughness: f32,
    /// Reflectance at normal incidence, 0 to 1.
    pub f0: f32,
    /// Share of the mirrored sky in what is reflected, 0 (none) to 1.
    pub environment: f32,
    /// Seed of the pattern's noise.
    pub seed: u32,
}

/// Where the second colour of a [`Surface`] shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Pattern {
    /// Nowhere.
    Plain,
    /// In every other square of the texture coordinates.
    Checker,
    /// In smooth stripes along the first texture coordinate.
    Stripes,
    /// In veins: noise folded about its middle.
    Marble,
    /// In patches of noise.
    Patches,
}

/// A surface of the metallic-roughness model (glTF 2.0, appendix B, without normal maps): each factor
/// is multiplied by its texture, where it has one.
#[derive(Debug, Clone, PartialEq)]
pub struct Textured {
    /// Base colour, linear RGB, 0 to 1: of diffuse light, or of the mirror image where metallic.
    pub base_colour: [f32; 3],
    /// Index of the texture that multiplies the base colour.
    pub base_texture: Option<usize>,
    /// Perceptual roughness, 0 to 1: the square root of the microfacet α (glTF 2.0, B.2.3).
    pub roughness: f32,
    /// From 0 (reflects 4 % head on, an index of refraction of 1.5) to 1 (reflects its base colour).
    pub metallic: f32,
    /// Index of the texture whose green multiplies the roughness and whose blue the metallic share.
    pub finish_texture: Option<usize>,
    /// Light of its own, linear RGB.
    pub emissive: [f32; 3],
    /// Index of the texture that multiplies the light of its own.
    pub emissive_texture: Option<usize>,
}

impl Default for Textured {
    /// Light grey, rough, neither metallic nor glowing.
    fn default() -> Self {
        Self {
            base_colour: [0.6; 3],
            base_texture: None,
            roughness: 0.7,
            metallic: 0.0,
            finish_texture: None,
            emissive: [0.0; 3],
            emissive_texture: None,
        }
    }
}

impl Textured {
    /// The textures it names.
    pub(crate) fn textures(&self) -> impl Iterator<Item = usize> {
        let all = [
            self.base_texture,
            self.finish_texture,
            self.emissive_texture,
        ];
        all.into_iter().flatten()
    }
}

impl Material {
    /// Whether every number is finite and in its range.
    pub(crate) fn is_valid(&self) -> bool {
        let colour = |c: &[f32; 3]| c.iter().all(|v| v.is_finite() && *v >= 0.0);
        match self {
            Self::Unlit(c) => colour(c),
            Self::Terrain(t) => t.octaves <= 16 && t.snow_line_m.is_finite(),
            Self::Phong(p) => {
                let share = |v: f32| (0.0..=1e3).contains(&v);
                [p.frequency, p.ambient, p.diffuse, p.specular]
                    .into_iter()
                    .all(share)
                    && p.shininess_log2 <= 10
            }
            Self::Textured(t) => {
                colour(&t.base_colour)
                    && t.base_colour.iter().all(|v| *v <= 1.0)
                    && (0.0..=1.0).contains(&t.roughness)
                    && (0.0..=1.0).contains(&t.metallic)
                    && colour(&t.emissive)
            }
            Self::Surface(s) => {
                s.albedo.iter().all(colour)
                    && (0.0..=1e4).contains(&s.frequency)
                    && (0.02..=1.0).contains(&s.roughness)
                    && (0.0..=1.0).contains(&s.f0)
                    && (0.0..=1.0).contains(&s.environment)
            }
        }
    }
}
