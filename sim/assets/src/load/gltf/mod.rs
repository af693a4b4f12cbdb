//! glTF 2.0, as JSON or GLB.

mod accessor;
mod animation;
mod container;
mod json;
mod materials;
mod nodes;
mod primitives;

use super::error::Flaw;
use super::files::SideFiles;
use super::{Draft, Warnings};
use container::Document;
use materials::Materials;
use nodes::Placer;

/// Extensions that a file may require: how they change what is read is known.
const KNOWN_EXTENSIONS: [&str; 3] = [
    "KHR_mesh_quantization",
    "KHR_materials_unlit",
    "KHR_materials_emissive_strength",
];

/// The scene that the file names first: its nodes' meshes, their materials and the first animation.
pub(super) fn load(
    bytes: &[u8],
    files: &dyn SideFiles,
    warnings: &mut Warnings,
) -> Result<Draft, Flaw> {
    let document = Document::read(bytes, files)?;
    let root = &document.root;
    if root.asset.version.split('.').next() != Some("2") {
        let version = super::text::shown(&root.asset.version);
        let problem = format!("glTF version {version}: must be 2.0 or another 2");
        return Err(Flaw::new("asset", problem));
    }
    let unknown = |name: &&String| !KNOWN_EXTENSIONS.contains(&name.as_str());
    if let Some(name) = root.extensions_required.iter().find(unknown) {
        let known = KNOWN_EXTENSIONS.join(", ");
        let name = super::text::shown(name);
        let problem = format!("requires extension {name}: those that are read are {known}");
        return Err(Flaw::new("extensionsRequired", problem));
    }
    let mut draft = Draft::default();
    let materials = Materials::read(&document, files, &mut draft, warnings)?;
    let animation = animation::read(&document, warnings)?;
    Placer::new(&document, &materials, animation, &mut draft, warnings).place_all()?;
    Ok(draft)
}

/// `list[index]`, or which name has no such element.
fn get<'a, T>(list: &'a [T], index: usize, what: &str, place: &str) -> Result<&'a T, Flaw> {
    list.get(index).ok_or_else(|| {
        let count = list.len();
        Flaw::new(
            place,
            format_args!("names {what} {index}: there are {count}, counted from 0"),
        )
    })
}
