use glam::{DMat3, DMat4, DVec3};

use super::super::Warnings;
use super::super::error::Flaw;
use super::super::soup::{Corner, NONE, Soup, coordinate};
use super::accessor::Accessor;
use super::container::Document;
use super::json::Primitive;
use crate::Mesh;

/// Triangles are flat where the file gives no normals (§3.7.2.1).
const FLAT: f64 = 1.0;

/// How triangles may be listed (§3.7.2.1).
#[derive(Clone, Copy)]
enum Mode {
    List,
    Strip,
    Fan,
}

impl Mode {
    /// Numbers of the corners of triangle `i`.
    fn corners(self, i: usize) -> [usize; 3] {
        match self {
            Self::List => [3 * i, 3 * i + 1, 3 * i + 2],
            // Every other triangle of a strip is wound the other way.
            Self::Strip => [i, i + 1 + i % 2, i + 2 - i % 2],
            Self::Fan => [i + 1, i + 2, 0],
        }
    }

    fn count(self, corners: usize) -> usize {
        match self {
            Self::List => corners / 3,
            Self::Strip | Self::Fan => corners.saturating_sub(2),
        }
    }
}

/// Reads primitives, and counts what has been read: accessors may be named any number of times, and
/// what they give must stay in proportion to the file.
pub(super) struct Primitives<'a> {
    document: &'a Document<'a>,
    corners_left: usize,
}

impl<'a> Primitives<'a> {
    pub(super) fn new(document: &'a Document<'a>) -> Self {
        // A corner has at least one byte of index; sixteenfold use is generous.
        let corners_left = document.bytes().saturating_mul(16).max(1 << 16);
        Self {
            document,
            corners_left,
        }
    }

    /// The triangles of a primitive with `object_from_mesh` applied; none if it has none.
    pub(super) fn read(
        &mut self,
        primitive: &Primitive,
        uv_set: u32,
        object_from_mesh: DMat4,
        place: &str,
        warnings: &mut Warnings,
    ) -> Result<Option<Mesh>, Flaw> {
        let mode = match primitive.mode.unwrap_or(4) {
            4 => Mode::List,
            5 => Mode::Strip,
            6 => Mode::Fan,
            0..=3 => {
                warnings.add("points and lines are not drawn");
                return Ok(None);
            }
            mode => {
                let problem = format!("mode {mode}: must be 0 to 6");
                return Err(Flaw::new(place, problem));
            }
        };
        if !primitive.targets.is_empty() {
            warnings.add("morph targets are not applied");
        }
        let named = |name: &str| primitive.attributes.get(name).copied();
        if named("COLOR_0").is_some() {
            warnings.add("colours of vertices are not drawn");
        }
        let accessor = |index: Option<usize>, shape: &str, what: &str| match index {
            Some(i) => {
                let from = format!("{place}.{what}");
                Accessor::new(self.document, i, shape, &from).map(Some)
            }
            None => Ok(None),
        };
        let uv = format!("TEXCOORD_{uv_set}");
        let uvs = accessor(named(&uv), "VEC2", &uv)?;
        let normals = accessor(named("NORMAL"), "VEC3", "NORMAL")?;
        let indices = accessor(primitive.indices, "SCALAR", "indices")?;
        let Some(positions) = accessor(named("POSITION"), "VEC3", "POSITION")? else {
            return Err(Flaw::new(place, "has no attribute POSITION"));
        };
        for (what, other) in [("NORMAL", &normals), (uv.as_str(), &uvs)] {
            if let Some(other) = other.as_ref().filter(|o| o.count < positions.count) {
                let (few, all) = (other.count, positions.count);
                let problem = format!("{few} elements of {what} for {all} of POSITION");
                return Err(Flaw::new(place, problem));
            }
        }
        let corners = indices.as_ref().map_or(positions.count, |i| i.count);
        if corners > self.corners_left {
            let problem = format!(
                "claims {corners} corners: with those before, far more than the file's {} bytes can mean",
                self.document.bytes()
            );
            return Err(Flaw::new(place, problem));
        }
        self.corners_left -= corners;

        let mut reader = Vertices {
            positions: &positions,
            normals: normals.as_ref(),
            uvs: uvs.as_ref(),
            object_from_mesh,
            soup: Soup::default(),
            place,
        };
        // Only vertices that are named are read: several primitives may share a large list.
        let mut names = std::collections::HashMap::new();
        let mut corner = |reader: &mut Vertices<'_>, i: usize| -> Result<Corner, Flaw> {
            let index = match &indices {
                Some(indices) => indices.element::<1>(i)[0],
                None => i as f64,
            };
            if let Some(&known) = names.get(&index.to_bits()) {
                return Ok(known);
            }
            let read = reader.read(index)?;
            names.insert(index.to_bits(), read);
            Ok(read)
        };
        let mirrored = object_from_mesh.determinant() < 0.0;
        for i in 0..mode.count(corners) {
            let [a, b, c] = mode.corners(i);
            let [a, b, c] = [
                corner(&mut reader, a)?,
                corner(&mut reader, b)?,
                corner(&mut reader, c)?,
            ];
            let triangle = if mirrored { [a, c, b] } else { [a, b, c] };
            reader.soup.triangles.push(triangle);
        }
        let meshes = reader.soup.into_meshes(FLAT, warnings)?;
        Ok(meshes.into_iter().next().map(|(_, mesh)| mesh))
    }
}

/// Vertices of a primitive, as they are asked for.
struct Vertices<'a> {
    positions: &'a Accessor<'a>,
    normals: Option<&'a Accessor<'a>>,
    uvs: Option<&'a Accessor<'a>>,
    object_from_mesh: DMat4,
    soup: Soup,
    place: &'a str,
}

impl Vertices<'_> {
    fn read(&mut self, index: f64) -> Result<Corner, Flaw> {
        let count = self.positions.count;
        if !(index >= 0.0 && index < count as f64 && index.fract() == 0.0) {
            let problem = format!("names vertex {index}: there are {count}, counted from 0");
            return Err(Flaw::new(self.place, problem));
        }
        let i = index as usize;
        let vector = |values: [f64; 3], what: &str| {
            let finite = values.map(|v| coordinate(v, what));
            let [x, y, z] = finite;
            let checked = |v: Result<f64, String>| {
                let problem = |p| Flaw::new(self.place, format_args!("vertex {index}: {p}"));
                v.map_err(problem)
            };
            Ok::<_, Flaw>(DVec3::new(checked(x)?, checked(y)?, checked(z)?))
        };
        let position = vector(self.positions.element(i), "position")?;
        let position = self.object_from_mesh.transform_point3(position);
        let position = vector(position.to_array(), "position in the scene")?;
        let new = self.soup.positions.len() as u32;
        let mut corner = Corner {
            position: new,
            uv: NONE,
            normal: NONE,
        };
        if let Some(normals) = self.normals {
            let normal = vector(normals.element(i), "normal")?;
            // Normals are turned by the inverse transpose, here times the determinant, whose sign a
            // mirror image needs, too.
            let m = DMat3::from_mat4(self.object_from_mesh);
            let cofactors = DMat3::from_cols(
                m.y_axis.cross(m.z_axis),
                m.z_axis.cross(m.x_axis),
                m.x_axis.cross(m.y_axis),
            );
            let normal = cofactors * normal * m.determinant().signum();
            self.soup.normals.push(normal);
            corner.normal = new;
        }
        if let Some(uvs) = self.uvs {
            let [u, v] = uvs.element(i);
            let uv = vector([u, v, 0.0], "texture coordinate")?;
            self.soup.uvs.push([uv.x, uv.y]);
            corner.uv = new;
        }
        self.soup.positions.push(position);
        Ok(corner)
    }
}
