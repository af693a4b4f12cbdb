use std::collections::HashMap;

use super::super::error::Flaw;
use super::super::files::SideFiles;
use super::super::picture::decode;
use super::super::text::shown;
use super::super::{Draft, Warnings};
use super::container::{Document, resolve};
use super::get;
use super::json::{Material, TextureInfo};
use crate::{Encoding, Textured, Wrap};

/// What primitives need to know of the file's materials.
pub(super) struct Materials {
    /// Of each material of the file, and last of the default one.
    pub(super) infos: Vec<Info>,
}

pub(super) struct Info {
    pub(super) two_sided: bool,
    /// Which set of texture coordinates it uses.
    pub(super) uv_set: u32,
}

struct Reader<'a, 'b> {
    document: &'a Document<'a>,
    files: &'a dyn SideFiles,
    draft: &'b mut Draft,
    warnings: &'b mut Warnings,
    /// Which texture each use of an image became; none if it could not be read.
    known: HashMap<(usize, Encoding, [Wrap; 2]), Option<usize>>,
    /// Embedded images that several names stand for.
    same: HashMap<(&'a [u8], Encoding, [Wrap; 2]), usize>,
}

impl Materials {
    /// Adds all materials and the textures they need to the draft, in the file's order.
    pub(super) fn read(
        document: &Document<'_>,
        files: &dyn SideFiles,
        draft: &mut Draft,
        warnings: &mut Warnings,
    ) -> Result<Self, Flaw> {
        let mut reader = Reader {
            document,
            files,
            draft,
            warnings,
            known: HashMap::new(),
            same: HashMap::new(),
        };
        let mut infos = Vec::new();
        let default = Material::default();
        let given = document.root.materials.iter().enumerate();
        let given = given.map(|(i, m)| (format!("materials[{i}]"), m));
        for (place, m) in given.chain([("default material".into(), &default)]) {
            let material = reader.material(m, &place)?;
            reader
                .draft
                .materials
                .push(crate::Material::Textured(material));
            let info = m.pbr_metallic_roughness.base_color_texture.as_ref();
            infos.push(Info {
                two_sided: m.double_sided,
                uv_set: info.map_or(0, |t| t.tex_coord),
            });
        }
        Ok(Self { infos })
    }

    /// The material of a primitive that names `index`, or none.
    pub(super) fn of(&self, index: Option<usize>, place: &str) -> Result<(usize, &Info), Flaw> {
        let last = self.infos.len() - 1;
        let index = match index {
            None => last,
            Some(i) if i < last => i,
            Some(i) => {
                let problem = format!("names material {i}: there are {last}, counted from 0");
                return Err(Flaw::new(place, problem));
            }
        };
        Ok((index, &self.infos[index]))
    }
}

impl<'a> Reader<'a, '_> {
    fn material(&mut self, m: &'a Material, place: &str) -> Result<Textured, Flaw> {
        let pbr = &m.pbr_metallic_roughness;
        if m.alpha_mode.as_deref().is_some_and(|mode| mode != "OPAQUE") {
            self.warnings
                .add("alpha blending and cut-outs are drawn opaque");
        }
        if m.normal_texture.is_some() {
            self.warnings.add("normal maps are not drawn");
        }
        let [red, green, blue, _] = pbr.base_color_factor.unwrap_or([1.0; 4]);
        let base_colour = [red, green, blue];
        let base_texture = self.texture(pbr.base_color_texture.as_ref(), Encoding::Srgb, place)?;
        if m.extensions.unlit.is_some() {
            // Its colour is all the light it gives.
            return Ok(Textured {
                base_colour: [0.0; 3],
                roughness: 1.0,
                emissive: base_colour,
                emissive_texture: base_texture,
                ..Textured::default()
            });
        }
        let glow = m.extensions.emissive_strength.as_ref();
        let strength = glow.and_then(|g| g.emissive_strength).unwrap_or(1.0);
        let finish = pbr.metallic_roughness_texture.as_ref();
        Ok(Textured {
            base_colour,
            base_texture,
            roughness: pbr.roughness_factor.unwrap_or(1.0),
            metallic: pbr.metallic_factor.unwrap_or(1.0),
            finish_texture: self.texture(finish, Encoding::Linear, place)?,
            emissive: m.emissive_factor.unwrap_or([0.0; 3]).map(|v| v * strength),
            emissive_texture: self.texture(m.emissive_texture.as_ref(), Encoding::Srgb, place)?,
        })
    }

    /// Index in the draft of the texture that `info` names; none if it has none or it is missing.
    fn texture(
        &mut self,
        info: Option<&TextureInfo>,
        encoding: Encoding,
        place: &str,
    ) -> Result<Option<usize>, Flaw> {
        let Some(info) = info else { return Ok(None) };
        if info.extensions.contains_key("KHR_texture_transform") {
            self.warnings
                .add("transforms of texture coordinates are not applied");
        }
        let root = &self.document.root;
        let texture = get(&root.textures, info.index, "texture", place)?;
        let place = format!("textures[{}]", info.index);
        let sampler = match texture.sampler {
            Some(i) => Some(get(&root.samplers, i, "sampler", &place)?),
            None => None,
        };
        let wrap = [
            wrap(sampler.and_then(|s| s.wrap_s), &place)?,
            wrap(sampler.and_then(|s| s.wrap_t), &place)?,
        ];
        let Some(source) = texture.source else {
            let text = "its picture is of a format that is not read; drawn without it";
            self.warnings.add(format_args!("{place}: {text}"));
            return Ok(None);
        };
        if let Some(&index) = self.known.get(&(source, encoding, wrap)) {
            return Ok(index);
        }
        let index = self.image(source, encoding, wrap, &place)?;
        self.known.insert((source, encoding, wrap), index);
        Ok(index)
    }

    fn image(
        &mut self,
        source: usize,
        encoding: Encoding,
        wrap: [Wrap; 2],
        from: &str,
    ) -> Result<Option<usize>, Flaw> {
        let image = get(&self.document.root.images, source, "image", from)?;
        let place = format!("images[{source}]");
        let mut key = None;
        let texture = match (&image.uri, image.buffer_view) {
            (_, Some(view)) => {
                let (bytes, _) = self.document.view(view, &place)?;
                let embedded = (bytes, encoding, wrap);
                if let Some(&index) = self.same.get(&embedded) {
                    return Ok(Some(index));
                }
                key = Some(embedded);
                decode(bytes, encoding, wrap)
            }
            (Some(uri), None) => match resolve(uri, self.files, &place) {
                Ok(bytes) => decode(&bytes, encoding, wrap),
                Err(flaw) => Err(flaw.problem().to_owned()),
            },
            (None, None) => Err("has neither uri nor bufferView".into()),
        };
        match texture {
            Ok(texture) => {
                let index = self.draft.textures.len();
                self.draft.textures.push(texture);
                if let Some(key) = key {
                    self.same.insert(key, index);
                }
                Ok(Some(index))
            }
            Err(problem) => {
                let name = image.uri.as_deref().filter(|u| !u.starts_with("data:"));
                let name = name.map(|n| format!(" {}", shown(n))).unwrap_or_default();
                let text = format!("{place}{name}: {problem}; drawn without it");
                self.warnings.add(text);
                Ok(None)
            }
        }
    }
}

/// OpenGL's codes (§5.26).
fn wrap(code: Option<u32>, place: &str) -> Result<Wrap, Flaw> {
    match code {
        None | Some(10497) => Ok(Wrap::Repeat),
        Some(33648) => Ok(Wrap::Mirror),
        Some(33071) => Ok(Wrap::Clamp),
        Some(code) => {
            let valid = "10497, 33648 or 33071";
            Err(Flaw::new(
                place,
                format_args!("wraps by {code}: must be {valid}"),
            ))
        }
    }
}
