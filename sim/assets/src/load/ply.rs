use glam::DVec3;

use super::error::Flaw;
use super::soup::{Corner, NONE, Soup, coordinate};
use super::text::shown;
use super::{Draft, Warnings};
use crate::Textured;

mod header;
mod values;

use header::{Element, Header, Property};
use values::Values;

/// Stanford PLY, text or binary: elements `vertex` and `face` (polygons fanned from their first
/// corner, as if convex); others are read over.
pub(super) fn load(bytes: &[u8], warnings: &mut Warnings) -> Result<Draft, Flaw> {
    let header = Header::read(bytes)?;
    let mut values = Values::new(bytes, &header);
    let mut soup = Soup::default();
    let mut seen_vertices = false;
    for element in &header.elements {
        // Each takes at least so many bytes: what cannot be there is not begun.
        let there = values.remaining();
        let needed = element
            .count
            .saturating_mul(element.least_bytes(header.encoding));
        if needed > there as u64 {
            let (count, name) = (element.count, shown(&element.name));
            let problem =
                format!("claims {count} of {name}, at least {needed} bytes; {there} are left");
            return Err(Flaw::new("header", problem));
        }
        match element.name.as_str() {
            "vertex" if !seen_vertices => {
                vertices(element, &mut values, &mut soup, warnings)?;
                seen_vertices = true;
            }
            "face" => {
                if !seen_vertices {
                    let problem = "element face comes before element vertex: must come after it";
                    return Err(Flaw::new("header", problem));
                }
                faces(element, &mut values, &mut soup)?;
            }
            name => {
                if name == "tristrips" {
                    warnings.add("triangle strips are not read");
                }
                skip(element, &mut values)?;
            }
        }
    }
    Draft::of_soup(soup, vec![Textured::default()], warnings)
}

/// Places of the properties that go by any of `names`; `None` if one has none.
fn find<const N: usize>(element: &Element, names: [&[&str]; N]) -> Option<[usize; N]> {
    let mut places = [0; N];
    for (place, names) in places.iter_mut().zip(names) {
        let named = |p: &Property| p.list.is_none() && names.contains(&p.name.as_str());
        *place = element.properties.iter().position(named)?;
    }
    Some(places)
}

fn vertices(
    element: &Element,
    values: &mut Values<'_>,
    soup: &mut Soup,
    warnings: &mut Warnings,
) -> Result<(), Flaw> {
    let Some(position) = find(element, [&["x"], &["y"], &["z"]]) else {
        let problem = "element vertex has no properties x, y and z";
        return Err(Flaw::new("header", problem));
    };
    let normal = find(element, [&["nx"], &["ny"], &["nz"]]);
    let uv = find(
        element,
        [
            &["s", "u", "texture_u", "texture_s"],
            &["t", "v", "texture_v", "texture_t"],
        ],
    );
    if find(element, [&["red", "r", "diffuse_red"]]).is_some() {
        warnings.add("colours of vertices are not drawn");
    }
    let mut row = vec![0.0; element.properties.len()];
    for index in 0..element.count {
        for (value, property) in row.iter_mut().zip(&element.properties) {
            *value = match property.list {
                None => values.next(property.kind)?,
                Some(_) => {
                    values.list(property, |_, _| Ok(()))?;
                    0.0
                }
            };
        }
        let pick = |places: [usize; 3], what: &str| {
            let mut v = [0.0; 3];
            for (value, place) in v.iter_mut().zip(places) {
                *value =
                    coordinate(row[place], what).map_err(|p| values.flaw("vertex", index, p))?;
            }
            Ok(DVec3::from_array(v))
        };
        soup.positions.push(pick(position, "position")?);
        if let Some(normal) = normal {
            soup.normals.push(pick(normal, "normal")?);
        }
        if let Some([u, v]) = uv {
            let uv = pick([u, v, v], "texture coordinate")?;
            // As in OBJ, v runs up; PLY itself says nothing.
            soup.uvs.push([uv.x, 1.0 - uv.y]);
        }
    }
    Ok(())
}

fn faces(element: &Element, values: &mut Values<'_>, soup: &mut Soup) -> Result<(), Flaw> {
    let is_corners = |p: &Property| {
        p.list.is_some() && ["vertex_indices", "vertex_index"].contains(&p.name.as_str())
    };
    if !element.properties.iter().any(is_corners) {
        let problem = "element face has no list property vertex_indices (or vertex_index)";
        return Err(Flaw::new("header", problem));
    }
    let count = soup.positions.len();
    let (has_uv, has_normal) = (!soup.uvs.is_empty(), !soup.normals.is_empty());
    for index in 0..element.count {
        for property in &element.properties {
            if property.list.is_none() {
                values.next(property.kind)?;
                continue;
            }
            if !is_corners(property) {
                values.list(property, |_, _| Ok(()))?;
                continue;
            }
            let (mut first, mut last) = (None, None);
            let triangles = &mut soup.triangles;
            let corners = values.list(property, |_, value| {
                if !(value >= 0.0 && value < count as f64 && value.fract() == 0.0) {
                    return Err(format!(
                        "face {index} names vertex {value}: there are {count}, counted from 0"
                    ));
                }
                let i = value as u32;
                let corner = Corner {
                    position: i,
                    uv: if has_uv { i } else { NONE },
                    normal: if has_normal { i } else { NONE },
                };
                if let (Some(a), Some(b)) = (first, last) {
                    triangles.push([a, b, corner]);
                }
                if first.is_some() {
                    last = Some(corner);
                } else {
                    first = Some(corner);
                }
                Ok(())
            })?;
            if corners < 3 {
                let problem = format!("has {corners} corners: needs at least 3");
                return Err(values.flaw("face", index, problem));
            }
        }
    }
    Ok(())
}

fn skip(element: &Element, values: &mut Values<'_>) -> Result<(), Flaw> {
    // Elements without properties take no bytes, however many are claimed.
    if element.properties.is_empty() {
        return Ok(());
    }
    for _ in 0..element.count {
        for property in &element.properties {
            match property.list {
                None => {
                    values.next(property.kind)?;
                }
                Some(_) => {
                    values.list(property, |_, _| Ok(()))?;
                }
            }
        }
    }
    Ok(())
}
