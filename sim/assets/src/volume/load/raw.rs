//! Raw numbers beside a TOML file that describes them.

use foveasim_models::toml_error;
use glam::DVec3;
use serde::Deserialize;

use super::fields::after;
use super::inflate::plain;
use super::{Draft, Element, affine};
use crate::load::{Flaw, SideFiles, Warnings};
use crate::volume::{Frame, Volume};

/// The file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct RawSpec {
    /// The file of numbers, beside this one; it may be gzipped.
    data: String,
    dims: [u64; 3],
    #[serde(rename = "type")]
    element: ElementSpec,
    #[serde(default)]
    big_endian: bool,
    /// Bytes before the numbers.
    #[serde(default)]
    skip_bytes: u32,
    #[serde(default = "unit")]
    slope: f64,
    #[serde(default)]
    intercept: f64,
    #[serde(default = "ones")]
    spacing: [f64; 3],
    #[serde(default)]
    origin: [f64; 3],
    /// Unit vectors along x, y and z.
    #[serde(default = "axes")]
    axes: [[f64; 3]; 3],
}

#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(rename_all = "lowercase")]
enum ElementSpec {
    U8,
    I8,
    U16,
    I16,
    U32,
    I32,
    U64,
    I64,
    F32,
    F64,
}

fn unit() -> f64 {
    1.0
}

fn ones() -> [f64; 3] {
    [1.0; 3]
}

fn axes() -> [[f64; 3]; 3] {
    [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
}

pub(super) fn load(
    bytes: &[u8],
    name: &str,
    files: &dyn SideFiles,
    warnings: &mut Warnings,
) -> Result<Volume, Flaw> {
    let text = std::str::from_utf8(bytes).map_err(|e| Flaw::new("whole file", e))?;
    let spec: RawSpec = toml::from_str(text).map_err(|e| {
        // The file is named by whoever reads this.
        let line = toml_error(name, text, &e).to_string();
        let line = line.strip_prefix(name).unwrap_or(&line);
        let line = line.trim_start_matches(": ");
        let (place, problem) = line.split_once(": ").unwrap_or(("whole file", line));
        Flaw::new(place, problem)
    })?;
    let steps = [0, 1, 2].map(|k| DVec3::from(spec.axes[k]) * spec.spacing[k]);
    let draft = Draft {
        dims: spec.dims,
        element: match spec.element {
            ElementSpec::U8 => Element::U8,
            ElementSpec::I8 => Element::I8,
            ElementSpec::U16 => Element::U16,
            ElementSpec::I16 => Element::I16,
            ElementSpec::U32 => Element::U32,
            ElementSpec::I32 => Element::I32,
            ElementSpec::U64 => Element::U64,
            ElementSpec::I64 => Element::I64,
            ElementSpec::F32 => Element::F32,
            ElementSpec::F64 => Element::F64,
        },
        big_endian: spec.big_endian,
        slope: spec.slope,
        intercept: spec.intercept,
        world_from_index: affine(steps, DVec3::from(spec.origin)),
        frame: Frame::Plain,
    };
    let skip = spec.skip_bytes as usize;
    let need = draft.bytes()? + skip;
    let data = files
        .read(&spec.data)
        .map_err(|e| Flaw::new("data", format_args!("{:?}: {e}", spec.data)))?;
    let data = plain(&data, need).map_err(|f| f.within(&spec.data))?;
    draft
        .finish(after(&data, skip), warnings)
        .map_err(|f| f.within(&spec.data))
}

#[cfg(test)]
mod tests {
    use glam::UVec3;

    use super::*;
    use crate::volume::load_volume_bytes;

    struct Beside;

    impl SideFiles for Beside {
        fn read(&self, name: &str) -> std::io::Result<Vec<u8>> {
            assert_eq!(name, "v.raw");
            Ok((0..100).collect())
        }
    }

    fn read(text: &str) -> Result<Volume, String> {
        let loaded = load_volume_bytes(text.as_bytes(), "v.toml", 0, &Beside);
        loaded.map(|l| l.volume).map_err(|e| e.to_string())
    }

    #[test]
    fn numbers_lie_beside_it() {
        let good = "data = \"v.raw\"\ndims = [2, 3, 4]\ntype = \"u16\"\nbig_endian = true\nskip_bytes = \
                    4\nspacing = [1, 1, 2.5]\norigin = [-1, 0, 0]\n";
        let v = read(good).unwrap();
        assert_eq!(v.value(UVec3::ZERO), 1029.0);
        assert_eq!(v.bounds()[1], DVec3::new(0.0, 2.0, 7.5));
        let error = |text: &str| read(text).unwrap_err();
        let text = error(&good.replace("spacing", "spaing"));
        assert!(
            text.contains("v.toml: line 6") && text.contains("`spacing`"),
            "{text}"
        );
        assert!(error(&good.replace("4]", "40]")).contains("v.raw"));
        assert!(error(&good.replace("u16", "u17")).contains("line 3"));
        assert!(error(&good.replace("2.5]", "nan]")).contains("axes"));
    }
}
