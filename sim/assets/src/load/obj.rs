use std::collections::HashMap;

use glam::DVec3;

use super::error::Flaw;
use super::files::SideFiles;
use super::mtl::Library;
use super::soup::{Corner, NONE, Soup};
use super::text::{Words, lines, shown};
use super::{Draft, Warnings};

/// Statements that carry no triangles: names, smoothing groups (normals follow a crease angle
/// instead), points, lines and free-form geometry.
const SILENT: [&str; 6] = ["o", "g", "s", "vp", "mg", "lod"];
const UNDRAWN: [&str; 9] = [
    "p", "l", "curv", "curv2", "surf", "cstype", "deg", "parm", "end",
];

/// Whether the first statement is one of OBJ.
pub(super) fn is_likely(bytes: &[u8]) -> bool {
    let start = &bytes[..bytes.len().min(1 << 16)];
    let first = lines(start).find_map(|(_, line)| {
        let mut words = line.split_whitespace();
        Some((words.next()?.to_owned(), words.next().is_some()))
    });
    let known = ["v", "vt", "vn", "f", "o", "g", "s", "mtllib", "usemtl"];
    first.is_some_and(|(word, more)| known.contains(&word.as_str()) && more)
}

/// Wavefront OBJ: vertices, faces (fanned from their first corner, as if convex) and materials.
pub(super) fn load(
    bytes: &[u8],
    files: &dyn SideFiles,
    warnings: &mut Warnings,
) -> Result<Draft, Flaw> {
    let mut reader = Reader {
        soup: Soup::default(),
        library: Library::new(),
        material: 0,
        used: HashMap::new(),
    };
    for (line, text) in lines(bytes) {
        let mut words = Words::new(line, &text);
        if let Some(statement) = words.next() {
            reader.statement(statement, words, &text, files, warnings)?;
        }
    }
    let library = reader.library.finish(files, warnings);
    let mut draft = Draft::of_soup(reader.soup, library.materials, warnings)?;
    draft.textures = library.textures;
    Ok(draft)
}

struct Reader {
    soup: Soup,
    library: Library,
    /// Index of the material in use.
    material: u32,
    /// Materials asked for by name; those not in a library are default ones.
    used: HashMap<String, u32>,
}

impl Reader {
    fn statement(
        &mut self,
        statement: &str,
        mut words: Words<'_>,
        text: &str,
        files: &dyn SideFiles,
        warnings: &mut Warnings,
    ) -> Result<(), Flaw> {
        let soup = &mut self.soup;
        match statement {
            "v" => soup
                .positions
                .push(DVec3::from_array(words.coordinates("vertex")?)),
            "vn" => soup
                .normals
                .push(DVec3::from_array(words.coordinates("normal")?)),
            "vt" => {
                let u = words.coordinate("texture coordinate")?;
                // The second one may be left out (a texture of one dimension).
                let v = match words.clone().next() {
                    Some(_) => words.coordinate("texture coordinate")?,
                    None => 0.0,
                };
                // v runs up in OBJ, down in a texture's rows.
                soup.uvs.push([u, 1.0 - v]);
            }
            "f" => self.face(words)?,
            "mtllib" => {
                // Names may hold spaces: the whole rest is tried before its words.
                let rest = after(text, "mtllib");
                self.library.read(rest, files, warnings)?;
            }
            "usemtl" => self.use_material(after(text, "usemtl"), warnings),
            word if SILENT.contains(&word) => {}
            word if UNDRAWN.contains(&word) => {
                warnings.add("points, lines and free-form surfaces are not drawn");
            }
            word => {
                let line = words.line;
                warnings.add(format_args!(
                    "line {line}: unknown statement {} is skipped",
                    shown(word)
                ));
            }
        }
        Ok(())
    }

    fn use_material(&mut self, name: &str, warnings: &mut Warnings) {
        if let Some(&known) = self.used.get(name) {
            self.material = known;
            return;
        }
        self.material = self.library.index_of(name, warnings);
        self.used.insert(name.to_owned(), self.material);
    }

    fn face(&mut self, words: Words<'_>) -> Result<(), Flaw> {
        let line = words.line;
        let (mut first, mut last, mut count) = (None, None, 0usize);
        for word in words {
            let corner = self
                .corner(word)
                .map_err(|problem| Flaw::line(line, problem))?;
            if let (Some(a), Some(b)) = (first, last) {
                self.soup.triangles.push([a, b, corner]);
                self.soup.materials.push(self.material);
            }
            // From the second corner on.
            if first.is_some() {
                last = Some(corner);
            } else {
                first = Some(corner);
            }
            count += 1;
        }
        if count < 3 {
            let problem = format!("a face of {count} corners: needs at least 3");
            return Err(Flaw::line(line, problem));
        }
        Ok(())
    }

    /// `position`, `position/uv`, `position//normal` or `position/uv/normal`, from 1, or from −1 for
    /// the latest.
    fn corner(&self, word: &str) -> Result<Corner, String> {
        let soup = &self.soup;
        let counts = [
            ("vertex", soup.positions.len()),
            ("texture coordinate", soup.uvs.len()),
            ("normal", soup.normals.len()),
        ];
        let mut indices = [NONE; 3];
        for (k, part) in word.split('/').enumerate() {
            let Some((what, count)) = counts.get(k) else {
                return Err(format!(
                    "face corner {}: has more than 3 indices",
                    shown(word)
                ));
            };
            if part.is_empty() && k > 0 {
                continue;
            }
            let given: i64 = part.parse().map_err(|_| {
                format!(
                    "face corner {}: {what} index must be a whole number",
                    shown(word)
                )
            })?;
            let index = match given {
                1.. => given - 1,
                // −1 is the latest; 0 is none at all.
                _ => (*count as i64).saturating_add(given),
            };
            if given == 0 || !(0..*count as i64).contains(&index) {
                return Err(format!(
                    "face corner {}: names {what} {given}, and {count} came before it, counted from 1",
                    shown(word)
                ));
            }
            indices[k] = index as u32;
        }
        let [position, uv, normal] = indices;
        Ok(Corner {
            position,
            uv,
            normal,
        })
    }
}

/// What follows the statement's word.
fn after<'a>(text: &'a str, statement: &str) -> &'a str {
    text.trim_start()[statement.len()..].trim()
}
