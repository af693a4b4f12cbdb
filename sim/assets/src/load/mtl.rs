use std::collections::HashMap;

use foveasim_models::math::sqrt;

use super::Warnings;
use super::error::Flaw;
use super::files::SideFiles;
use super::picture::decode;
use super::text::{Words, lines, shown};
use crate::{Encoding, Texture, Textured, Wrap};

/// Options of texture statements and how many words follow each (MTL specification, "Texture map
/// statements"; `-o`, `-s` and `-t` may have fewer than three, which only their numbers tell).
const OPTIONS: [(&str, usize); 12] = [
    ("-blendu", 1),
    ("-blendv", 1),
    ("-bm", 1),
    ("-boost", 1),
    ("-cc", 1),
    ("-clamp", 1),
    ("-imfchan", 1),
    ("-mm", 2),
    ("-o", 3),
    ("-s", 3),
    ("-t", 3),
    ("-texres", 1),
];

/// The materials of an OBJ file: index 0 is the default one.
pub(super) struct Library {
    materials: Vec<Entry>,
    by_name: HashMap<String, u32>,
    /// Whether a library that the file names could not be read: then its materials are not missed
    /// one by one.
    missing: bool,
}

#[derive(Default)]
struct Entry {
    material: Textured,
    base_map: Option<Map>,
    emissive_map: Option<Map>,
}

#[derive(PartialEq, Eq, Hash)]
struct Map {
    file: String,
    wrap: Wrap,
}

/// What the materials became.
pub(super) struct Finished {
    pub(super) materials: Vec<Textured>,
    pub(super) textures: Vec<Texture>,
}

impl Library {
    pub(super) fn new() -> Self {
        Self {
            materials: vec![Entry::default()],
            by_name: HashMap::new(),
            missing: false,
        }
    }

    /// Adds the materials of the library files that `rest` names.
    pub(super) fn read(
        &mut self,
        rest: &str,
        files: &dyn SideFiles,
        warnings: &mut Warnings,
    ) -> Result<(), Flaw> {
        // Names may hold spaces: the whole is tried before its words.
        let whole = files.read(rest);
        if let Ok(bytes) = whole {
            return self.parse(&bytes, rest, warnings);
        }
        for name in rest.split_whitespace() {
            match files.read(name) {
                Ok(bytes) => self.parse(&bytes, name, warnings)?,
                Err(error) => {
                    self.missing = true;
                    warnings.add(format_args!(
                        "material library {}: {error}; its materials are drawn light grey",
                        shown(name)
                    ));
                }
            }
        }
        Ok(())
    }

    /// The material called `name`, or the default one.
    pub(super) fn index_of(&self, name: &str, warnings: &mut Warnings) -> u32 {
        let known = self.by_name.get(name).copied();
        if known.is_none() && !self.missing {
            let name = shown(name);
            warnings.add(format_args!(
                "material {name} is in no library; it is drawn light grey"
            ));
        }
        known.unwrap_or(0)
    }

    fn parse(&mut self, bytes: &[u8], file: &str, warnings: &mut Warnings) -> Result<(), Flaw> {
        let mut current = None;
        for (line, text) in lines(bytes) {
            let mut words = Words::new(line, &text);
            let Some(statement) = words.next() else {
                continue;
            };
            if statement == "newmtl" {
                let name = text.trim_start()["newmtl".len()..].trim();
                self.by_name
                    .insert(name.to_owned(), self.materials.len() as u32);
                current = Some(self.materials.len());
                self.materials.push(Entry::default());
            } else if let Some(i) = current {
                let entry = &mut self.materials[i];
                let read = entry.statement(statement, words, warnings);
                read.map_err(|flaw| flaw.within(file))?;
            }
        }
        Ok(())
    }

    /// Reads the pictures that materials name, each once.
    pub(super) fn finish(self, files: &dyn SideFiles, warnings: &mut Warnings) -> Finished {
        let mut textures = Vec::new();
        let mut known: HashMap<Map, Option<usize>> = HashMap::new();
        let mut load = |map: Option<Map>| {
            let map = map?;
            if let Some(&index) = known.get(&map) {
                return index;
            }
            let read = files.read(&map.file).map_err(|e| e.to_string());
            let texture = read.and_then(|b| decode(&b, Encoding::Srgb, [map.wrap; 2]));
            let index = match texture {
                Ok(texture) => {
                    textures.push(texture);
                    Some(textures.len() - 1)
                }
                Err(problem) => {
                    let name = shown(&map.file);
                    warnings.add(format_args!("texture {name}: {problem}; drawn without it"));
                    None
                }
            };
            known.insert(map, index);
            index
        };
        let finish = |entry: Entry| Textured {
            base_texture: load(entry.base_map),
            emissive_texture: load(entry.emissive_map),
            ..entry.material
        };
        let materials = self.materials.into_iter().map(finish).collect();
        Finished {
            materials,
            textures,
        }
    }
}

impl Entry {
    fn statement(
        &mut self,
        statement: &str,
        mut words: Words<'_>,
        warnings: &mut Warnings,
    ) -> Result<(), Flaw> {
        let m = &mut self.material;
        // A picture's rest is a name, not numbers.
        match statement {
            "map_Kd" => {
                // The factor of an untextured preview is often left black.
                m.base_colour = [1.0; 3];
                self.base_map = map(words);
                return Ok(());
            }
            "map_Ke" => {
                m.emissive = [1.0; 3];
                self.emissive_map = map(words);
                return Ok(());
            }
            "map_Bump" | "map_bump" | "bump" | "norm" | "disp" => {
                warnings.add("normal, bump and displacement maps are not drawn");
                return Ok(());
            }
            "map_d" => {
                warnings.add("transparency is drawn opaque");
                return Ok(());
            }
            _ => {}
        }
        match statement {
            "Kd" if self.base_map.is_none() => m.base_colour = colour(&mut words, "Kd", 1.0)?,
            "Ke" if self.emissive_map.is_none() => m.emissive = colour(&mut words, "Ke", 1e4)?,
            // A Blinn-Phong exponent's lobe is as wide as that of α² = 2/(n + 2) (Walter et al. 2007,
            // §5.2); perceptual roughness is the root of α.
            "Ns" => {
                let exponent = words.coordinate("Ns")?.max(0.0);
                m.roughness = sqrt(sqrt(2.0 / (exponent + 2.0))) as f32;
            }
            "Pr" => m.roughness = share(&mut words, "Pr")?,
            "Pm" => m.metallic = share(&mut words, "Pm")?,
            "d" if share(&mut words, "d")? < 1.0 => warnings.add("transparency is drawn opaque"),
            "Tr" if share(&mut words, "Tr")? > 0.0 => warnings.add("transparency is drawn opaque"),
            _ => {}
        }
        Ok(())
    }
}

/// A colour of three numbers from 0 to `most`, or of one for all three.
fn colour(words: &mut Words<'_>, what: &str, most: f64) -> Result<[f32; 3], Flaw> {
    let line = words.line;
    let red = words.coordinate(what)?;
    let [green, blue] = match words.clone().next() {
        Some(_) => words.coordinates(what)?,
        None => [red; 2],
    };
    let rgb = [red, green, blue];
    if rgb.iter().all(|v| (0.0..=most).contains(v)) {
        return Ok(rgb.map(|v| v as f32));
    }
    let problem = format!("{what} = {rgb:?}: must be three numbers from 0 to {most}");
    Err(Flaw::line(line, problem))
}

fn share(words: &mut Words<'_>, what: &str) -> Result<f32, Flaw> {
    let line = words.line;
    // `d -halo 0.5`: only how far it fades.
    if words.clone().next() == Some("-halo") {
        words.next();
    }
    let value = words.coordinate(what)?;
    if (0.0..=1.0).contains(&value) {
        return Ok(value as f32);
    }
    Err(Flaw::line(
        line,
        format_args!("{what} = {value}: must be from 0 to 1"),
    ))
}

/// Options, then a file name that may hold spaces.
fn map(words: Words<'_>) -> Option<Map> {
    let mut wrap = Wrap::Repeat;
    let mut words = words.peekable();
    while let Some((option, most)) = words
        .peek()
        .and_then(|word| OPTIONS.iter().find(|(name, _)| name == word))
    {
        words.next();
        for k in 0..*most {
            // Of the three numbers of an offset or scale, the last two may be left out.
            let numeric = |word: &&str| word.parse::<f64>().is_ok();
            if k == 0 || words.peek().is_some_and(numeric) {
                let value = words.next();
                if *option == "-clamp" && value == Some("on") {
                    wrap = Wrap::Clamp;
                }
            }
        }
    }
    let file = words.collect::<Vec<_>>().join(" ");
    (!file.is_empty()).then_some(Map { file, wrap })
}
