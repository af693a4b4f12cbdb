//! Moving nodes of glTF files.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use foveasim_assets::{LoadError, LoadOptions, Loaded, NoSideFiles, Scene, load_bytes};
use glam::DVec3;

/// One triangle at x = 0, 1 and y = 0, 1; three times; translations, rotations about y, scales and
/// spline values at those times.
const TIMES: [f32; 3] = [0.0, 1.0, 2.0];

fn buffer() -> Vec<u8> {
    let mut floats = vec![0.0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    floats.extend(TIMES);
    // Translations at 48: 0, then 4 along x, then back.
    floats.extend([0.0, 0.0, 0.0, 4.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    // Rotations at 84: by 0, 90° and 180° about y.
    let half = std::f32::consts::FRAC_1_SQRT_2;
    floats.extend([0.0, 0.0, 0.0, 1.0, 0.0, half, 0.0, half, 0.0, 1.0, 0.0, 0.0]);
    // Scales at 132: 1, 2, 2.
    floats.extend([1.0, 1.0, 1.0, 2.0, 2.0, 2.0, 2.0, 2.0, 2.0]);
    // A spline at 168: tangent, value, tangent for each time. Its value is t³ on the first second.
    for (tangent, value) in [(0.0, 0.0), (3.0, 1.0), (12.0, 8.0f32)] {
        floats.extend([tangent, 0.0, 0.0, value, 0.0, 0.0, tangent, 0.0, 0.0]);
    }
    floats.iter().flat_map(|v| v.to_le_bytes()).collect()
}

fn load(nodes: &str, channels: &str, interpolation: &str) -> Result<Loaded, LoadError> {
    let buffer = buffer();
    let samplers: Vec<String> = [2, 3, 4, 5]
        .iter()
        .map(|output| {
            let own = if *output == 5 {
                "CUBICSPLINE"
            } else {
                interpolation
            };
            format!(r#"{{"input":1,"output":{output},"interpolation":"{own}"}}"#)
        })
        .collect();
    let accessor = |offset: usize, count: usize, shape: &str| {
        format!(
            r#"{{"bufferView":0,"byteOffset":{offset},"componentType":5126,"count":{count},"type":"{shape}"}}"#
        )
    };
    let accessors = [
        accessor(0, 3, "VEC3"),
        accessor(36, 3, "SCALAR"),
        accessor(48, 3, "VEC3"),
        accessor(84, 3, "VEC4"),
        accessor(132, 3, "VEC3"),
        accessor(168, 9, "VEC3"),
    ];
    let json = format!(
        r#"{{"asset":{{"version":"2.0"}},"scenes":[{{"nodes":[0]}}],"nodes":[{nodes}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],
        "animations":[{{"channels":[{channels}],"samplers":[{}]}}],
        "accessors":[{}],"bufferViews":[{{"buffer":0,"byteLength":{}}}],
        "buffers":[{{"byteLength":{},"uri":"data:;base64,{}"}}]}}"#,
        samplers.join(","),
        accessors.join(","),
        buffer.len(),
        buffer.len(),
        STANDARD.encode(&buffer)
    );
    load_bytes(
        json.as_bytes(),
        "a.gltf",
        &NoSideFiles,
        &LoadOptions::default(),
    )
}

fn channel(node: usize, path: &str) -> String {
    let sampler = ["translation", "rotation", "scale", "spline"]
        .iter()
        .position(|p| *p == path);
    let path = if path == "spline" {
        "translation"
    } else {
        path
    };
    format!(
        r#"{{"sampler":{},"target":{{"node":{node},"path":"{path}"}}}}"#,
        sampler.unwrap()
    )
}

/// Where the corner (1, 0, 0) of the first instance is.
fn corner(scene: &Scene, seconds: f64) -> DVec3 {
    let scene = scene.at(seconds);
    let instance = &scene.instances()[0];
    let mesh = &scene.meshes()[instance.mesh];
    instance.world_from_object.point(mesh.position(1))
}

#[track_caller]
fn assert_near(a: DVec3, b: [f64; 3]) {
    assert!(a.distance(b.into()) < 1e-6, "{a} is not {b:?}");
}

#[test]
fn a_node_moves_within_a_turning_one() {
    let nodes = r#"{"children":[1],"translation":[0,5,0]},{"mesh":0,"translation":[2,0,0]}"#;
    let channels = [channel(0, "rotation"), channel(1, "translation")].join(",");
    let scene = load(nodes, &channels, "LINEAR").unwrap().scene;
    assert_eq!(scene.motions().len(), 1);
    assert_near(corner(&scene, 0.0), [1.0, 5.0, 0.0]);
    // Turned by 90° about y, +x is −z; moved by 4 along its own x.
    assert_near(corner(&scene, 1.0), [0.0, 5.0, -5.0]);
    // Turned by 45°, moved by 2: on its circle, not on the chord.
    let h = 3.0 * std::f64::consts::FRAC_1_SQRT_2;
    assert_near(corner(&scene, 0.5), [h, 5.0, -h]);
    // After 2 s it begins again.
    assert_near(corner(&scene, 2.5), [h, 5.0, -h]);
    // A scene at a time is a scene like any other: it can be asked for another time.
    assert_near(corner(&scene.at(1.0), 0.0), [1.0, 5.0, 0.0]);
}

#[test]
fn steps_jump_and_splines_bend() {
    let scene = load(r#"{"mesh":0}"#, &channel(0, "translation"), "STEP")
        .unwrap()
        .scene;
    assert_near(corner(&scene, 0.999), [1.0, 0.0, 0.0]);
    assert_near(corner(&scene, 1.0), [5.0, 0.0, 0.0]);
    let scene = load(r#"{"mesh":0}"#, &channel(0, "spline"), "LINEAR")
        .unwrap()
        .scene;
    for t in [0.0, 0.25, 0.5, 1.0, 1.5] {
        let x = corner(&scene, t).x - 1.0;
        assert!((x - t * t * t).abs() < 1e-6, "{t}: {x}");
    }
    // Between the pieces it is followed by, it is off by at most h²·|x″|/8 = (1/8)²·12/8.
    let x = corner(&scene, 1.97).x - 1.0;
    assert!((x - 1.97f64.powi(3)).abs() < 0.0235, "{x}");
}

#[test]
fn scale_is_even_and_moves_or_uneven_and_stays() {
    let scene = load(r#"{"mesh":0}"#, &channel(0, "scale"), "LINEAR")
        .unwrap()
        .scene;
    assert_near(corner(&scene, 0.5), [1.5, 0.0, 0.0]);
    // Uneven scale of a moving node becomes part of its mesh; of a still one, too.
    let stretched = r#"{"mesh":0,"scale":[3,1,1]}"#;
    let scene = load(stretched, &channel(0, "translation"), "LINEAR")
        .unwrap()
        .scene;
    assert_near(corner(&scene, 0.5), [5.0, 0.0, 0.0]);
    let scene = load(stretched, "", "LINEAR").unwrap().scene;
    assert_near(corner(&scene, 0.5), [3.0, 0.0, 0.0]);
    assert!(scene.motions().is_empty());
    // A mirrored one is wound the other way, so that its front stays its front.
    let scene = load(r#"{"mesh":0,"scale":[-1,1,1]}"#, "", "LINEAR")
        .unwrap()
        .scene;
    let mesh = &scene.meshes()[0];
    let [a, b, c] = mesh.triangles()[0].map(|i| mesh.position(i));
    let front = (b - a).cross(c - a);
    assert!(front.z < 0.0 || mesh.normals()[2][0] > 0.0);
    assert_eq!(front.z.signum(), f64::from(mesh.normals()[2][0]).signum());
}

#[test]
fn movement_that_is_not_rigid_is_refused() {
    let refused = |nodes: &str, channels: &str, part: &str| {
        let text = load(nodes, channels, "LINEAR").unwrap_err().to_string();
        assert!(text.contains(part), "{text}");
    };
    let uneven = r#"{"children":[1],"scale":[1,2,1]},{"mesh":0,"name":"arm"}"#;
    refused(
        uneven,
        &channel(1, "rotation"),
        "nodes[1] \"arm\": moves within",
    );
    refused(r#"{"mesh":0}"#, &channel(7, "rotation"), "node 7");
    refused(
        r#"{"mesh":0}"#,
        &[channel(0, "scale"), channel(0, "scale")].join(","),
        "second time",
    );
    let text = load(r#"{"mesh":0}"#, &channel(0, "scale"), "WOBBLY")
        .unwrap_err()
        .to_string();
    assert!(text.contains("WOBBLY"), "{text}");
    refused(
        r#"{"mesh":0,"matrix":[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1]}"#,
        &channel(0, "scale"),
        "matrix",
    );
}
