//! Files with something wrong in them: one clear error or a named warning, for every format.

use std::io;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use foveasim_assets::{
    Format, LoadError, LoadOptions, Loaded, Material, NoSideFiles, SideFiles, load_bytes,
};

fn load(bytes: &[u8], name: &str) -> Result<Loaded, LoadError> {
    load_bytes(bytes, name, &NoSideFiles, &LoadOptions::default())
}

/// Refused in one line that names the file and holds all of `parts`.
fn refused(bytes: impl AsRef<[u8]>, name: &str, parts: &[&str]) {
    let text = load(bytes.as_ref(), name).unwrap_err().to_string();
    assert!(text.starts_with(&format!("{name}: ")), "{text}");
    assert_eq!(text.lines().count(), 1, "{text}");
    for part in parts {
        assert!(text.contains(part), "{part:?} is not in {text:?}");
    }
}

/// Loaded, with a warning that holds all of `parts`.
fn warned(loaded: &Loaded, parts: &[&str]) {
    let has = |w: &String| parts.iter().all(|p| w.contains(p));
    assert!(
        loaded.warnings.iter().any(has),
        "{parts:?}: {:?}",
        loaded.warnings
    );
}

struct Beside(&'static [(&'static str, &'static [u8])]);

impl SideFiles for Beside {
    fn read(&self, name: &str) -> io::Result<Vec<u8>> {
        let found = self.0.iter().find(|(n, _)| *n == name);
        let (_, content) = found.ok_or(io::ErrorKind::NotFound)?;
        Ok(content.to_vec())
    }
}

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

#[test]
fn obj() {
    let with = |rest: &str| format!("{TRIANGLE}{rest}");
    refused(
        with("f 1 2 4"),
        "a.obj",
        &["line 4", "vertex 4", "3 came before"],
    );
    refused(with("f 1 2 0"), "a.obj", &["line 4", "vertex 0"]);
    refused(with("f 1 2 -4"), "a.obj", &["line 4", "-4"]);
    refused(with("f 1 2 3.5"), "a.obj", &["line 4", "whole number"]);
    refused(
        with("f 1/1 2/1 3/1"),
        "a.obj",
        &["line 4", "texture coordinate 1", "0 came"],
    );
    refused(with("f 1//9 2//9 3//9"), "a.obj", &["line 4", "normal 9"]);
    refused(
        with("f 1 2"),
        "a.obj",
        &["line 4", "2 corners", "at least 3"],
    );
    refused(with(""), "a.obj", &["no triangle"]);
    refused(with("f 1 1 2"), "a.obj", &["no triangle"]);
    refused("v 0 nan 0\n", "a.obj", &["line 1", "NaN", "1e6"]);
    refused("v 0 inf 0\n", "a.obj", &["line 1", "inf"]);
    refused("v 0 1e9 0\n", "a.obj", &["line 1", "1000000000", "1e6"]);
    refused("v 0 x 0\n", "a.obj", &["line 1", "\"x\"", "number"]);
    refused("v 0 0\n", "a.obj", &["line 1", "missing"]);
    refused("", "a.obj", &["no triangle"]);
    refused("what is this", "a.txt", &["known format"]);
    refused([0xff, 0, 1, 2], "a", &["known format"]);
}

#[test]
fn obj_with_side_files_that_are_missing_or_broken() {
    let text = format!("mtllib no.mtl\n{TRIANGLE}usemtl wood\nf 1 2 3\n");
    let loaded = load(text.as_bytes(), "a.obj").unwrap();
    assert_eq!(loaded.warnings.len(), 1, "{:?}", loaded.warnings);
    warned(&loaded, &["a.obj", "no.mtl", "not found"]);

    let text =
        format!("mtllib a.mtl\n{TRIANGLE}usemtl wood\nf 1 2 3\nusemtl stone\nf 1 2 3\nzzz\n");
    let files = Beside(&[(
        "a.mtl",
        b"newmtl wood\nKd 1 0.5 0\nmap_Kd -s 1 1 1 gone one.png\nd 0.5\n",
    )]);
    let options = LoadOptions::default();
    let loaded = load_bytes(text.as_bytes(), "a.obj", &files, &options).unwrap();
    warned(&loaded, &["texture", "gone one.png", "not found"]);
    warned(&loaded, &["material \"stone\"", "in no library"]);
    warned(&loaded, &["transparency"]);
    warned(&loaded, &["line 9", "zzz"]);
    assert_eq!(loaded.scene.instances().len(), 2);

    for (library, part) in [
        ("newmtl wood\nKd nan 0 0\n", "a.mtl: line 2"),
        ("newmtl wood\nKd 1 2 3\n", "from 0 to 1"),
    ] {
        struct One(&'static str);
        impl SideFiles for One {
            fn read(&self, _: &str) -> io::Result<Vec<u8>> {
                Ok(self.0.into())
            }
        }
        let error = load_bytes(text.as_bytes(), "a.obj", &One(library), &options).unwrap_err();
        assert!(error.to_string().contains(part), "{error}");
    }
}

#[test]
fn obj_materials_and_polygons_are_understood() {
    let text = "# c\nmtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0.25\n\
                usemtl m\nf -4/1 -3/2 \\\n -2/2 -1/1\n";
    let files = Beside(&[("a.mtl", b"newmtl m\nKd 0.25 0.5 1\nNs 30\nKe 2 0 0\n")]);
    let loaded = load_bytes(text.as_bytes(), "x", &files, &LoadOptions::default()).unwrap();
    assert_eq!((loaded.format, loaded.warnings.len()), (Format::Obj, 0));
    let mesh = &loaded.scene.meshes()[0];
    assert_eq!((mesh.triangles().len(), mesh.vertex_count()), (2, 4));
    // v runs down.
    assert_eq!(mesh.uvs()[1][..2], [1.0, 0.75]);
    // The face is counter-clockwise: its normal is +z.
    assert_eq!(mesh.normals()[2], [1.0; 4]);
    assert!(loaded.scene.instances()[0].two_sided);
    let Material::Textured(m) = &loaded.scene.materials()[loaded.scene.instances()[0].material]
    else {
        panic!("not textured")
    };
    assert_eq!(
        (m.base_colour, m.emissive),
        ([0.25, 0.5, 1.0], [2.0, 0.0, 0.0])
    );
    // α = √(2/32) = 1/4, whose root is 1/2.
    assert_eq!(m.roughness, 0.5);
}

/// A binary STL of `claimed` triangles, of which `given` are there.
fn stl(claimed: u32, given: usize, x: f32) -> Vec<u8> {
    let mut bytes = vec![b' '; 80];
    bytes.extend(claimed.to_le_bytes());
    for _ in 0..given {
        let corners = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, x, 0.0, 0.0, 0.0, 1.0, 0.0f32];
        bytes.extend(corners.iter().flat_map(|v| v.to_le_bytes()));
        bytes.extend([0; 2]);
    }
    bytes
}

#[test]
fn stl_files() {
    assert_eq!(
        load(&stl(1, 1, 1.0), "a.stl")
            .unwrap()
            .scene
            .triangle_count(),
        1
    );
    // "solid" at the start of a binary file does not make it text.
    let mut solid = stl(2, 2, 1.0);
    solid[..11].copy_from_slice(b"solid facet");
    assert_eq!(load(&solid, "a").unwrap().scene.triangle_count(), 2);
    refused(
        stl(42_949_672, 1, 1.0),
        "a.stl",
        &["claims 42949672", "1 are there"],
    );
    refused(
        stl(u32::MAX, 0, 1.0),
        "a.stl",
        &["claims 4294967295", "0 are there"],
    );
    refused(stl(0, 0, 1.0), "a.stl", &["no triangle"]);
    refused(
        stl(1, 1, f32::NAN),
        "a.stl",
        &["triangle 0", "byte 84", "NaN"],
    );
    refused(stl(1, 1, f32::INFINITY), "a.stl", &["triangle 0", "inf"]);
    refused("short", "a.stl", &["5 bytes", "84"]);
    warned(
        &load(&[stl(1, 1, 1.0), vec![0; 9]].concat(), "a.stl").unwrap(),
        &["9 bytes after"],
    );

    let facet = |vertices: &str| {
        format!(
            "solid s\nfacet normal 0 0 1\nouter loop\n{vertices}endloop\nendfacet\nendsolid s\n"
        )
    };
    let good = "vertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n";
    assert_eq!(
        load(facet(good).as_bytes(), "a").unwrap().format,
        Format::Stl
    );
    refused(
        facet("vertex 0 0 0\n"),
        "a",
        &["line 6", "1 vertices", "needs 3"],
    );
    refused(facet("vertex 0 nan 0\n"), "a", &["line 4", "NaN"]);
    refused(facet("vortex\n"), "a", &["line 4", "vortex"]);
    refused(
        "solid s\nfacet\nendsolid s\n",
        "a",
        &["ends within the facet of line 2"],
    );
    refused("solid s\nendsolid s\n", "a", &["no triangle"]);
}

fn ply(format: &str, elements: &str, body: &[u8]) -> Vec<u8> {
    [
        format!("ply\nformat {format} 1.0\n{elements}end_header\n").as_bytes(),
        body,
    ]
    .concat()
}

#[test]
fn ply_files() {
    let elements = |vertices: &str, faces: &str| {
        format!(
            "element vertex {vertices}\nproperty float x\nproperty float y\nproperty float z\n\
             element face {faces}\nproperty list uchar int vertex_indices\n"
        )
    };
    let text = |v: &str, f: &str, body: &str| ply("ascii", &elements(v, f), body.as_bytes());
    let corners = "0 0 0\n1 0 0\n0 1 0\n";
    let body = |faces: &str| format!("{corners}{faces}");
    let loaded = load(&text("3", "1", &body("3 0 1 2\n")), "a").unwrap();
    assert_eq!(
        (loaded.format, loaded.scene.triangle_count()),
        (Format::Ply, 1)
    );
    refused(
        text("3", "1", &body("3 0 1 3\n")),
        "a",
        &["line 13", "vertex 3", "there are 3"],
    );
    refused(text("3", "1", &body("3 0 1 -1\n")), "a", &["vertex -1"]);
    refused(
        text("3", "1", &body("2 0 1\n")),
        "a",
        &["line 13", "2 corners", "at least 3"],
    );
    refused(text("3", "1", &body("9 0 1 2\n")), "a", &["a list of 9"]);
    refused(text("3", "2", &body("3 0 1 2\n")), "a", &["ends before"]);
    refused(
        text("3", "1", "0 0 nan 1 0 0 0 1 0 3 0 1 2"),
        "a",
        &["vertex 0", "NaN"],
    );
    refused(
        text("3", "1", "0 0 x 1 0 0 0 1 0 3 0 1 2"),
        "a",
        &["line 10", "\"x\""],
    );
    refused(text("3", "0", corners), "a", &["no triangle"]);
    refused(
        text("178956970", "1", corners),
        "a",
        &["header", "claims 178956970", "are left"],
    );
    refused(
        text("18446744073709551615", "1", corners),
        "a",
        &["claims 18446744073709551615"],
    );
    refused(
        text("-3", "1", corners),
        "a",
        &["line 3", "-3", "whole number"],
    );
    refused("ply\nformat ascii 2.0\n", "a", &["line 2", "2.0"]);
    refused("ply\nformat ascii 1.0\n", "a", &["no end_header"]);
    refused("ply\nend_header\n", "a", &["no format"]);
    refused(
        "ply\nproperty float x\n",
        "a",
        &["line 2", "before any element"],
    );
    refused(
        "ply\nelement v 1\nproperty quad x\n",
        "a",
        &["line 3", "quad x"],
    );
    refused(
        ply("ascii", "element face 0\n", b""),
        "a",
        &["before element vertex"],
    );
    refused(
        ply("ascii", "element vertex 0\nproperty float x\n", b""),
        "a",
        &["x, y and z"],
    );
    // Elements without properties take no bytes and no time.
    let odd = format!(
        "element nothing 18446744073709551615\n{}",
        elements("3", "1")
    );
    assert!(load(&ply("ascii", &odd, body("3 0 1 2").as_bytes()), "a").is_ok());

    // Binary: each byte order.
    let values = [0.0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    let mut little: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
    little.push(3);
    little.extend([0, 1, 2i32].iter().flat_map(|v| v.to_le_bytes()));
    let mut big: Vec<u8> = values.iter().flat_map(|v| v.to_be_bytes()).collect();
    big.push(3);
    big.extend([0, 1, 2i32].iter().flat_map(|v| v.to_be_bytes()));
    let loaded = load(
        &ply("binary_little_endian", &elements("3", "1"), &little),
        "a",
    )
    .unwrap();
    let other = load(&ply("binary_big_endian", &elements("3", "1"), &big), "a").unwrap();
    assert_eq!(loaded.scene, other.scene);
    let short = &little[..little.len() - 1];
    refused(
        ply("binary_little_endian", &elements("3", "1"), short),
        "a",
        &["before byte", "ends"],
    );
    let claim = elements("178956970", "1");
    refused(
        ply("binary_little_endian", &claim, &little),
        "a",
        &["claims 178956970", "2147483640 bytes"],
    );
}

/// One triangle in a data URI, with `change` made in the JSON.
fn gltf(from: &str, to: &str) -> String {
    let mut data: Vec<u8> = [0.0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]
        .iter()
        .flat_map(|v| v.to_le_bytes())
        .collect();
    data.extend([0, 1, 2, 0u16].iter().flat_map(|v| v.to_le_bytes()));
    let json = format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],
        "nodes":[{{"mesh":0,"name":"n"}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"indices":1}}]}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}},
        {{"bufferView":1,"componentType":5123,"count":3,"type":"SCALAR"}}],
        "bufferViews":[{{"buffer":0,"byteLength":36}},{{"buffer":0,"byteOffset":36,"byteLength":8}}],
        "buffers":[{{"byteLength":44,"uri":"data:application/octet-stream;base64,{}"}}]}}"#,
        STANDARD.encode(data)
    );
    assert!(json.contains(from), "{from}");
    json.replacen(from, to, 1)
}

#[test]
fn gltf_files() {
    let loaded = load(gltf("\"n\"", "\"n\"").as_bytes(), "a").unwrap();
    assert_eq!(
        (loaded.format, loaded.scene.triangle_count()),
        (Format::Gltf, 1)
    );
    assert!(!loaded.scene.instances()[0].two_sided);
    let wrong = |from: &str, to: &str, parts: &[&str]| refused(gltf(from, to), "a", parts);
    wrong("2.0", "1.0", &["asset", "1.0"]);
    wrong(
        "\"asset\"",
        "\"extensionsRequired\":[\"KHR_draco\"],\"asset\"",
        &["KHR_draco"],
    );
    wrong(
        "\"mesh\":0",
        "\"mesh\":7",
        &["nodes[0] \"n\"", "mesh 7", "there are 1"],
    );
    wrong("\"nodes\":[0]", "\"nodes\":[5]", &["node 5"]);
    wrong("\"nodes\":[0]", "\"nodes\":[0,0]", &["reached twice"]);
    wrong(
        "\"mesh\":0",
        "\"mesh\":0,\"children\":[0]",
        &["reached twice"],
    );
    wrong(
        "\"mesh\":0",
        "\"mesh\":0,\"rotation\":[0,0,0,0]",
        &["rotation"],
    );
    wrong(
        "\"mesh\":0",
        "\"mesh\":0,\"scale\":[1e30,1,1]",
        &["scale", "1e6"],
    );
    wrong(
        "\"mesh\":0",
        "\"mesh\":0,\"translation\":[1e300,1,1]",
        &["translation"],
    );
    wrong(
        "\"POSITION\":0",
        "\"POSITION\":9",
        &["meshes[0].primitives[0].POSITION", "accessor 9"],
    );
    wrong("\"POSITION\":0", "\"NORMAL\":0", &["no attribute POSITION"]);
    wrong(
        "\"indices\":1",
        "\"indices\":0",
        &["accessors[0]", "VEC3", "SCALAR"],
    );
    wrong(
        "\"indices\":1",
        "\"indices\":1,\"material\":3",
        &["material 3", "there are 0"],
    );
    wrong("\"indices\":1", "\"indices\":1,\"mode\":9", &["mode 9"]);
    wrong(
        "5126,\"count\":3",
        "5126,\"count\":178956970",
        &["accessors[0]", "claims 178956970"],
    );
    wrong(
        "5126,\"count\":3",
        "5126,\"count\":18446744073709551615",
        &["accessors[0]", "claims"],
    );
    wrong(
        "5126,\"count\":3",
        "5126,\"count\":2",
        &["vertex 2", "there are 2"],
    );
    wrong("5126", "1", &["componentType 1"]);
    wrong(
        "\"byteLength\":36}",
        "\"byteLength\":2147483648}",
        &["bufferViews[0]", "2147483648"],
    );
    wrong(
        "\"byteLength\":44",
        "\"byteLength\":2147483648",
        &["buffers[0]", "44 are there"],
    );
    wrong("base64,", "base64,!", &["buffers[0]", "base64"]);
    wrong(
        "data:application/octet-stream;base64,",
        "x%20y.bin",
        &["x y.bin"],
    );
    wrong(
        "\"count\":3,\"type\":\"SCALAR\"",
        "\"count\":0,\"type\":\"SCALAR\"",
        &["no triangle"],
    );
    wrong("{\"bufferView\":0,", "{", &["no triangle"]);
    refused("{", "a.gltf", &["JSON", "line 1"]);
    refused("{}", "a.gltf", &["JSON", "asset"]);
    // An accessor without a view is all zeros, as many as it claims, but not as many triangles.
    let endless = gltf(",\"indices\":1", "").replace(
        "{\"bufferView\":0,\"componentType\":5126,\"count\":3,",
        "{\"componentType\":5126,\"count\":4000000000,",
    );
    refused(endless, "a", &["claims 4000000000 corners"]);

    let nan = STANDARD.encode([0x00, 0x00, 0xc0, 0x7f]);
    let text = gltf("base64,AAAA", &format!("base64,{}", &nan[..4]));
    assert!(load(text.as_bytes(), "a").is_ok(), "only part of a NaN");
    let whole = [f32::NAN; 9]
        .iter()
        .flat_map(|v| v.to_le_bytes())
        .chain([0, 0, 1, 0, 2, 0, 0, 0]);
    let start = gltf("\"n\"", "\"n\"");
    let head = start.split_once("base64,").unwrap().0;
    let text = format!(
        "{head}base64,{}\"}}]}}",
        STANDARD.encode(whole.collect::<Vec<u8>>())
    );
    refused(text, "a", &["primitives[0]", "vertex 0", "NaN"]);

    let missing = gltf(
        "\"accessors\"",
        "\"materials\":[{\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0}}}],\
         \"textures\":[{\"source\":0}],\"images\":[{\"uri\":\"no.png\"}],\"accessors\"",
    );
    let loaded = load(missing.as_bytes(), "a").unwrap();
    warned(&loaded, &["images[0] \"no.png\"", "not found"]);
}

#[test]
fn glb_containers() {
    let json = gltf("\"n\"", "\"n\"");
    let glb = |version: u32, length: Option<u32>, chunk: u32, kind: &[u8]| {
        let mut bytes = b"glTF".to_vec();
        bytes.extend(version.to_le_bytes());
        bytes.extend(length.unwrap_or(20 + json.len() as u32).to_le_bytes());
        bytes.extend(chunk.to_le_bytes());
        bytes.extend(kind);
        bytes.extend(json.as_bytes());
        bytes
    };
    let size = json.len() as u32;
    assert_eq!(
        load(&glb(2, None, size, b"JSON"), "a").unwrap().format,
        Format::Glb
    );
    refused(
        glb(1, None, size, b"JSON"),
        "a",
        &["version 1", "must be 2"],
    );
    refused(
        glb(2, Some(1 << 31), size, b"JSON"),
        "a",
        &["claims 2147483648"],
    );
    refused(
        glb(2, None, 1 << 31, b"JSON"),
        "a",
        &["byte 12", "claims 2147483648"],
    );
    refused(glb(2, None, size, b"JSOM"), "a", &["no JSON chunk"]);
    refused("glTF", "a", &["12 bytes"]);
}
