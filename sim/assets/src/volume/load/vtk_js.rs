//! A folder as vtk.js reads it over HTTP: `index.json`, and arrays as gzipped files beside it.

use glam::{DMat3, DVec3};
use serde::Deserialize;

use super::Element;
use super::inflate::plain;
use super::vti::placed;
use crate::load::{Flaw, SideFiles, Warnings};
use crate::volume::Volume;

// Fields that say nothing about a volume are passed over: the format has no closed list.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Index {
    #[serde(default)]
    origin: [f64; 3],
    #[serde(default = "ones")]
    spacing: [f64; 3],
    extent: [i64; 6],
    direction: Option<[f64; 9]>,
    point_data: PointData,
}

#[derive(Deserialize)]
struct PointData {
    arrays: Vec<ArrayEntry>,
}

#[derive(Deserialize)]
struct ArrayEntry {
    data: DataArray,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct DataArray {
    #[serde(default = "one")]
    number_of_components: u32,
    data_type: String,
    #[serde(rename = "ref")]
    place: Place,
}

#[derive(Deserialize)]
struct Place {
    #[serde(default)]
    basepath: String,
    id: String,
    encode: Option<String>,
}

fn ones() -> [f64; 3] {
    [1.0; 3]
}

fn one() -> u32 {
    1
}

pub(super) fn load(
    bytes: &[u8],
    files: &dyn SideFiles,
    warnings: &mut Warnings,
) -> Result<Volume, Flaw> {
    let index: Index = serde_json::from_slice(bytes)
        .map_err(|e| Flaw::new(format_args!("line {}", e.line()), e))?;
    let Some(ArrayEntry { data: array }) = index.point_data.arrays.first() else {
        return Err(Flaw::new("pointData", "has no array"));
    };
    if array.number_of_components != 1 {
        let problem = format_args!("{}: must be 1", array.number_of_components);
        return Err(Flaw::new("numberOfComponents", problem));
    }
    let element = match array.data_type.as_str() {
        "Uint8Array" | "Uint8ClampedArray" => Element::U8,
        "Int8Array" => Element::I8,
        "Uint16Array" => Element::U16,
        "Int16Array" => Element::I16,
        "Uint32Array" => Element::U32,
        "Int32Array" => Element::I32,
        "Float32Array" => Element::F32,
        "Float64Array" => Element::F64,
        other => {
            let problem = format_args!("{other:?}: must be an array type of JavaScript");
            return Err(Flaw::new("dataType", problem));
        }
    };
    // Column by column.
    let direction = index
        .direction
        .map_or(DMat3::IDENTITY, |d| DMat3::from_cols_array(&d));
    let big_endian = array.place.encode.as_deref() == Some("BigEndian");
    let draft = placed(
        index.extent,
        DVec3::from(index.origin),
        DVec3::from(index.spacing),
        direction,
        element,
        big_endian,
    )?;
    let need = draft.bytes()?;
    let stem = match array.place.basepath.as_str() {
        "" => array.place.id.clone(),
        base => format!("{base}/{}", array.place.id),
    };
    let packed = format!("{stem}.gz");
    let (name, data) = match files.read(&packed) {
        Ok(data) => (packed, data),
        Err(first) => match files.read(&stem) {
            Ok(data) => (stem, data),
            Err(_) => return Err(Flaw::new("pointData", format_args!("{packed:?}: {first}"))),
        },
    };
    let data = plain(&data, need).map_err(|f| f.within(&name))?;
    draft.finish(&data, warnings).map_err(|f| f.within(&name))
}
