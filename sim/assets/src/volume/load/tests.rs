//! Formats of VTK, and real files where they are there.

use std::io::Write;
use std::path::PathBuf;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use glam::{DVec3, UVec3};

use super::*;
use crate::load::NoSideFiles;

const NUMBERS: std::ops::Range<i16> = -12..12;

fn file(attributes: &str, array: &str, text: &[u8], appended: &[u8]) -> Vec<u8> {
    let head = format!(
        "<?xml version=\"1.0\"?>\n<!-- <Piece> -->\n<VTKFile type=\"ImageData\" {attributes}>\n<ImageData \
         WholeExtent=\"1 2 0 2 0 3\" Origin=\"1 2 3\" Spacing=\"2 1 .5\" Direction=\"0 -1 0 1 0 0 0 0 1\">\
         <Piece Extent=\"1 2 0 2 0 3\"><PointData Scalars='b'><DataArray type=\"Float32\" Name=\"a\" \
         format=\"ascii\">1</DataArray><DataArray type=\"Int16\" Name=\"b\" {array}>"
    );
    let tail = b"</DataArray></PointData></Piece></ImageData>";
    [head.as_bytes(), text, tail, appended, b"</VTKFile>"].concat()
}

fn read(bytes: &[u8]) -> Result<Volume, String> {
    let loaded = load_volume_bytes(bytes, "a.vti", 0, &NoSideFiles);
    loaded.map(|l| l.volume).map_err(|e| e.to_string())
}

fn little() -> Vec<u8> {
    NUMBERS.flat_map(i16::to_le_bytes).collect()
}

fn zlib(bytes: &[u8]) -> Vec<u8> {
    let mut z = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::fast());
    z.write_all(bytes).unwrap();
    z.finish().unwrap()
}

/// Two blocks of 32 bytes, the second one half full.
fn blocks() -> (Vec<u8>, Vec<u8>) {
    let all = little();
    let parts = [zlib(&all[..32]), zlib(&all[32..])];
    let counts = [2, 32, 16, parts[0].len() as u32, parts[1].len() as u32];
    let head = counts.iter().flat_map(|n| n.to_le_bytes()).collect();
    (head, parts.concat())
}

#[test]
fn all_codings_of_vtk_give_the_same() {
    let text: Vec<String> = NUMBERS.map(|v| v.to_string()).collect();
    let ascii = read(&file(
        "",
        "format=\"ascii\"",
        text.join(" ").as_bytes(),
        b"",
    ))
    .unwrap();
    assert_eq!(ascii.dims(), UVec3::new(2, 3, 4));
    assert_eq!(ascii.value(UVec3::new(1, 2, 3)), 11.0);
    // The first voxel has index 1 along x, which points along the world's y.
    let first = ascii.world_from_index().transform_point3(DVec3::ZERO);
    assert_eq!(first, DVec3::new(1.0, 4.0, 3.0));
    let next = ascii.world_from_index().transform_vector3(DVec3::Y);
    assert_eq!(next, DVec3::NEG_X);

    let counted = [&48u32.to_le_bytes()[..], &little()].concat();
    let inline = STANDARD.encode(&counted);
    let spaced = format!("\n   {inline}\n");
    let binary = file("", "format=\"binary\"", spaced.as_bytes(), b"");
    assert_eq!(read(&binary).unwrap(), ascii);

    let big: Vec<u8> = NUMBERS.flat_map(i16::to_be_bytes).collect();
    let counted = [&48u64.to_be_bytes()[..], &big].concat();
    let appended = [
        b"<AppendedData encoding=\"raw\">\n  _<<<",
        &counted[..],
        b"</AppendedData>",
    ];
    let attributes = "byte_order=\"BigEndian\" header_type=\"UInt64\"";
    let array = "format=\"appended\" offset=\"3\" /";
    assert_eq!(
        read(&file(attributes, array, b"", &appended.concat())).unwrap(),
        ascii
    );

    let (head, data) = blocks();
    let attributes = "compressor=\"vtkZLibDataCompressor\"";
    let coded = STANDARD.encode(&head) + &STANDARD.encode(&data);
    let inline = file(attributes, "format=\"binary\"", coded.as_bytes(), b"");
    assert_eq!(read(&inline).unwrap(), ascii);
    let appended = format!("<AppendedData encoding=\"base64\">_{coded}</AppendedData>");
    let array = "format=\"appended\" offset=\"0\"";
    assert_eq!(
        read(&file(attributes, array, b"", appended.as_bytes())).unwrap(),
        ascii
    );
    let appended = [b"<AppendedData encoding=\"raw\">_", &head[..], &data].concat();
    assert_eq!(
        read(&file(attributes, array, b"", &appended)).unwrap(),
        ascii
    );
}

#[test]
fn what_is_wrong_in_vtk_files_is_named() {
    let error = |bytes: &[u8]| read(bytes).unwrap_err();
    let ascii = |change: &dyn Fn(String) -> String| {
        let text = String::from_utf8(file("", "format=\"ascii\"", b"1 2 3", b"")).unwrap();
        error(change(text).as_bytes())
    };
    assert!(ascii(&|t| t).contains("cannot hold 24"));
    assert!(ascii(&|t| t.replace("0 3", "0 99999999999")).contains("2 to 4096"));
    assert!(ascii(&|t| t.replace("1 2 0 2", "1 -9223372036854775808 0 2")).contains("extent"));
    assert!(ascii(&|t| t.replace("\"ImageData\"", "\"PolyData\"")).contains("PolyData"));
    assert!(ascii(&|t| t.replace("Int16", "Bit")).contains("\"Bit\""));
    assert!(ascii(&|t| t.replace("PointData", "CellData")).contains("only points"));
    assert!(ascii(&|t| t.replace("<DataArray", "<X")).contains("no <DataArray>"));
    assert!(ascii(&|t| t[..t.len() / 2].to_owned()).contains("a.vti"));
    let (mut head, data) = blocks();
    let compressed = |head: &[u8], data: &[u8]| {
        let coded = STANDARD.encode(head) + &STANDARD.encode(data);
        let attributes = "compressor=\"vtkZLibDataCompressor\"";
        error(&file(
            attributes,
            "format=\"binary\"",
            coded.as_bytes(),
            b"",
        ))
    };
    assert!(compressed(&head, &data[..20]).contains("block"));
    assert!(compressed(&head[..8], &[]).contains("ends within its header"));
    head[3] = 0xff;
    assert!(compressed(&head, &data).contains("more than there is room for"));
    let huge = [&u32::MAX.to_le_bytes()[..], &[0; 8]].concat();
    let text = STANDARD.encode(huge);
    assert!(error(&file("", "format=\"binary\"", text.as_bytes(), b"")).contains("take 48"));
    assert!(error(&file("", "format=\"binary\"", b"!!!!", b"")).contains("base64"));
}

#[test]
fn counts_and_extents_of_vtk_must_be_those_of_the_array() {
    let error = |bytes: &[u8]| read(bytes).unwrap_err();
    let binary = |count: u32| {
        let counted = [&count.to_le_bytes()[..], &little()].concat();
        let text = STANDARD.encode(&counted);
        file("", "format=\"binary\"", text.as_bytes(), b"")
    };
    assert!(read(&binary(48)).is_ok());
    for count in [0, 46, 50, u32::MAX] {
        let text = error(&binary(count));
        assert!(
            text.contains(&format!("states {count} bytes, but its voxels take 48")),
            "{text}"
        );
    }
    let packed = |change: &dyn Fn(&mut Vec<u8>)| {
        let (mut head, data) = blocks();
        change(&mut head);
        let coded = STANDARD.encode(&head) + &STANDARD.encode(&data);
        let attributes = "compressor=\"vtkZLibDataCompressor\"";
        file(attributes, "format=\"binary\"", coded.as_bytes(), b"")
    };
    // The last block is half as long as that.
    let text = error(&packed(&|head| head[8] = 32));
    assert!(text.contains("states 64 bytes"), "{text}");
    // Blocks of 24 are as many bytes in all, but not what is in these.
    let text = error(&packed(&|head| (head[4], head[8]) = (24, 24)));
    assert!(
        text.contains("block 0") && text.contains("24 are stated"),
        "{text}"
    );
    let piece = |extent: &str| {
        let text = String::from_utf8(binary(48)).unwrap();
        let own = format!("<Piece Extent=\"{extent}\">");
        read(
            text.replace("<Piece Extent=\"1 2 0 2 0 3\">", &own)
                .as_bytes(),
        )
    };
    assert!(piece("1  2 0 2 0 3").is_ok());
    let text = piece("1 2 0 2 0 2").unwrap_err();
    assert!(text.contains("must be the WholeExtent"), "{text}");
}

/// What a header does not speak of is said, not drawn as if it were not there.
#[test]
fn more_than_the_header_speaks_of_is_said() {
    let warnings = |name: &str, bytes: &[u8]| {
        let loaded = load_volume_bytes(bytes, name, 0, &NoSideFiles);
        loaded.map(|l| l.warnings).map_err(|e| e.to_string())
    };
    let nrrd = |encoding: &str, data: &[u8]| {
        let head = format!(
            "NRRD0004\ntype: int16\ndimension: 3\nsizes: 2 3 4\nendian: little\nencoding: {encoding}\n\n"
        );
        warnings("a.nrrd", &[head.as_bytes(), data].concat())
    };
    let gzip = |bytes: &[u8]| {
        let mut gz = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
        gz.write_all(bytes).unwrap();
        gz.finish().unwrap()
    };
    let (exact, more) = (little(), [&little()[..], b"more"].concat());
    let text = b"1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23 24";
    assert!(nrrd("raw", &exact).unwrap().is_empty());
    assert!(nrrd("gzip", &gzip(&exact)).unwrap().is_empty());
    assert!(nrrd("ascii", text).unwrap().is_empty());
    for said in [
        nrrd("raw", &more),
        nrrd("gzip", &gzip(&more)),
        nrrd("ascii", &[&text[..], b" 25"].concat()),
    ] {
        let said = said.unwrap();
        assert!(
            said.len() == 1 && said[0].contains("follow the 2 x 3 x 4 voxels"),
            "{said:?}"
        );
    }
}

/// A checksum that does not hold is an error, wherever the damage is.
#[test]
fn damaged_compression_is_refused() {
    let head = "ObjectType = Image\nNDims = 3\nDimSize = 2 3 4\nElementType = MET_SHORT\nBinaryData = True\n\
                CompressedData = True\nElementDataFile = LOCAL\n";
    let load = |packed: &[u8]| {
        let bytes = [head.as_bytes(), packed].concat();
        load_volume_bytes(&bytes, "a.mha", 0, &NoSideFiles).map(|l| l.volume)
    };
    let mut gz = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    gz.write_all(&little()).unwrap();
    for packed in [zlib(&little()), gz.finish().unwrap()] {
        let whole = load(&packed).unwrap();
        assert_eq!(whole.range(), [-12.0, 11.0]);
        for cut in 1..packed.len() {
            assert!(
                load(&packed[..packed.len() - cut]).is_err(),
                "{cut} bytes cut"
            );
        }
        // What a gzip header says beside the numbers is in no checksum.
        for place in 10..packed.len() {
            let mut flipped = packed.clone();
            flipped[place] ^= 1;
            assert!(load(&flipped).map_or(true, |v| v == whole), "byte {place}");
        }
    }
}

#[test]
fn names_of_no_format_are_refused() {
    let error = |bytes: &[u8], name| {
        let loaded = load_volume_bytes(bytes, name, 0, &NoSideFiles);
        loaded.unwrap_err().to_string()
    };
    assert!(error(b"hello", "a.txt").contains("known volume format"));
    for name in ["a.nii", "a.nrrd", "a.mhd", "a.vti", "a.toml", "index.json"] {
        for bytes in [&b""[..], b"\x00", b"{", b"NRRD", b"\x1f\x8b", b"<VTKFile"] {
            assert!(error(bytes, name).contains(name), "{name}");
        }
    }
}

/// Files with a few bytes changed, cut or doubled are volumes or errors: none panics, none takes long.
#[test]
fn damaged_files_do_no_harm() {
    struct Beside;
    impl SideFiles for Beside {
        fn read(&self, _: &str) -> std::io::Result<Vec<u8>> {
            Ok(little())
        }
    }
    let mut nifti = vec![0u8; 352];
    nifti[..4].copy_from_slice(&348i32.to_le_bytes());
    for (k, n) in [3i16, 2, 3, 4].into_iter().enumerate() {
        nifti[40 + 2 * k..42 + 2 * k].copy_from_slice(&n.to_le_bytes());
    }
    nifti[70] = 4;
    nifti[108..112].copy_from_slice(&352f32.to_le_bytes());
    nifti[344..347].copy_from_slice(b"n+1");
    nifti.extend(little());
    let nrrd =
        b"NRRD0004\ntype: short\ndimension: 3\nsizes: 2 3 4\nendian: little\nencoding: raw\n\n";
    let meta = b"NDims = 3\nDimSize = 2 3 4\nElementType = MET_SHORT\nElementDataFile = LOCAL\n";
    let (head, data) = blocks();
    let coded = STANDARD.encode(&head) + &STANDARD.encode(&data);
    let vti = file(
        "compressor=\"vtkZLibDataCompressor\"",
        "format=\"binary\"",
        coded.as_bytes(),
        b"",
    );
    let json =
        br#"{"vtkClass":"vtkImageData","extent":[0,1,0,2,0,3],"pointData":{"arrays":[{"data":
        {"dataType":"Int16Array","ref":{"basepath":"data","id":"x"}}}]}}"#;
    let toml = b"data = \"x\"\ndims = [2, 3, 4]\ntype = \"i16\"\n";
    let files = [
        ("a.nii", nifti),
        ("a.nrrd", [&nrrd[..], &little()].concat()),
        ("a.mha", [&meta[..], &little()].concat()),
        ("a.vti", vti),
        ("index.json", json.to_vec()),
        ("a.toml", toml.to_vec()),
    ];
    let mut rng = foveasim_models::Stream::new(1, foveasim_models::Role::Scene, 0);
    for (name, good) in files {
        let whole = load_volume_bytes(&good, name, 0, &Beside);
        assert_eq!(whole.unwrap().volume.value(UVec3::ZERO), -12.0, "{name}");
        for _ in 0..1500 {
            let mut bytes = good.clone();
            for _ in 0..=rng.below(3) {
                let at = rng.below(bytes.len().max(1) as u64) as usize;
                match rng.below(5) {
                    0 => bytes.truncate(at),
                    1 => bytes.insert(at.min(bytes.len()), b'9'),
                    2 if !bytes.is_empty() => bytes[at] = b"0 -9\n<\xff"[rng.below(7) as usize],
                    3 if !bytes.is_empty() => bytes[at] ^= 1 << rng.below(8),
                    _ => {
                        let part = bytes[at.min(bytes.len())..].to_vec();
                        bytes.extend(part);
                    }
                }
            }
            let _ = load_volume_bytes(&bytes, name, rng.below(2) as usize, &Beside);
        }
    }
}

/// Sides, range and where the middle of the first axis step leads, as the files' own makers say.
#[test]
#[expect(clippy::print_stderr, reason = "a test that is skipped must say so")]
fn real_files_load_as_their_headers_say() {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data/volume");
    if !folder.is_dir() {
        eprintln!("skipped: no real volumes beside the project");
        return;
    }
    let load = |name: &str| load_volume(&folder.join(name), 0).unwrap();
    let check = |name: &str, dims: [u32; 3], range: [f64; 2], step: [f64; 3]| {
        let volume = load(name).volume;
        assert_eq!(volume.dims(), UVec3::from(dims), "{name}");
        for (got, want) in volume.range().into_iter().zip(range) {
            assert!((got - want).abs() < 1e-2, "{name}: {got} {want}");
        }
        let x = volume.world_from_index().matrix3.x_axis;
        assert!((x - DVec3::from(step)).length() < 1e-3, "{name}: {x}");
    };
    check(
        "anatomical.nii",
        [33, 41, 25],
        [-610.0, 30393.0],
        [-2.0, 0.0, 0.0],
    );
    check(
        "image_10426.nii.gz",
        [53, 63, 46],
        [-7.9413, 7.9413],
        [-3.0, 0.0, 0.0],
    );
    let mni = "mni_icbm152_t1_tal_nlin_sym_09a_converted.nii.gz";
    check(mni, [197, 233, 189], [0.0, 255.0], [1.0, 0.0, 0.0]);
    check(
        "frog_tissues.vti",
        [500, 470, 136],
        [0.0, 29.0],
        [1.0, 0.0, 0.0],
    );
    // Thirty degrees about z.
    let turned = [3.2 * 0.866, 3.2 * 0.5, 0.0];
    check("headsq.vti", [64, 64, 93], [0.0, 3926.0], turned);
    check(
        "LIDC2.vti",
        [256, 256, 133],
        [0.0, 255.0],
        [1.40625, 0.0, 0.0],
    );
}
