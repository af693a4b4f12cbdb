//! The meshes that lie in `../shared/data/mesh` where it is there: all load, and none does harm when
//! broken.
#![allow(clippy::print_stderr, reason = "says what was skipped")]
#![allow(
    unsafe_code,
    reason = "counting what is allocated needs an allocator of our own"
)]

use std::alloc::{GlobalAlloc, Layout, System};
use std::path::PathBuf;
use std::sync::atomic::{AtomicUsize, Ordering};

use foveasim_assets::{LoadOptions, Material, NoSideFiles, load_bytes, load_scene};
use foveasim_models::{Role, Stream};

/// Counts bytes in use and their peak, over all threads.
struct Counting;

static IN_USE: AtomicUsize = AtomicUsize::new(0);
static PEAK: AtomicUsize = AtomicUsize::new(0);

// SAFETY: passes everything on to the system's allocator and only counts.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let now = IN_USE.fetch_add(layout.size(), Ordering::Relaxed) + layout.size();
        PEAK.fetch_max(now, Ordering::Relaxed);
        // SAFETY: as the caller promised.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        IN_USE.fetch_sub(layout.size(), Ordering::Relaxed);
        // SAFETY: as the caller promised.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// What `f` gives, and the most bytes it had allocated at once.
fn peak<T>(f: impl FnOnce() -> T) -> (T, usize) {
    let before = IN_USE.load(Ordering::Relaxed);
    PEAK.store(before, Ordering::Relaxed);
    let value = f();
    (value, PEAK.load(Ordering::Relaxed) - before)
}

fn path(name: &str) -> PathBuf {
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR"));
    let folders = ["../../../shared", "../../../../shared"];
    let found = folders.map(|f| root.join(f).join("data/mesh").join(name));
    let [near, far] = found;
    if near.exists() { near } else { far }
}

/// Name; triangles as its SOURCES.md counts them; how many warnings, and what they speak of.
const MESHES: [(&str, u64, &[&str]); 10] = [
    ("airplane.ply", 2452, &[]),
    ("boat.obj", 32_416, &[]),
    ("building.obj", 1152, &["building.mtl"]),
    ("mountain.obj", 50_562, &[]),
    ("oculus-touch-left.glb", 12_491, &[]),
    ("skull.obj", 100_002, &[]),
    ("spot.obj", 23_062, &[]),
    ("suzanne.stl", 4012, &[]),
    ("sword.obj", 44_582, &[]),
    ("tree_pine.obj", 248, &["tree_b.mtl"]),
];

// One test, since another one beside it would be counted, too.
#[test]
fn all_load_and_none_does_harm_when_broken() {
    for (name, triangles, words) in MESHES {
        let path = path(name);
        let Ok(bytes) = std::fs::read(&path) else {
            eprintln!("skipped: no {}", path.display());
            continue;
        };
        let (loaded, whole) = peak(|| load_scene(&path, &LoadOptions::default()).unwrap());
        eprintln!(
            "{name}: {:.1} bytes a byte at most",
            whole as f64 / bytes.len() as f64
        );
        assert_eq!(loaded.scene.triangle_count(), triangles, "{name}");
        assert_eq!(
            loaded.warnings.len(),
            words.len(),
            "{name}: {:?}",
            loaded.warnings
        );
        for (warning, word) in loaded.warnings.iter().zip(words) {
            assert!(warning.contains(word), "{warning}");
        }
        if name.ends_with(".glb") {
            // Four images, two of which are the same again.
            assert_eq!(loaded.scene.textures().len(), 2);
            let textured =
                |m: &Material| matches!(m, Material::Textured(t) if t.base_texture.is_some());
            assert_eq!(
                loaded
                    .scene
                    .materials()
                    .iter()
                    .filter(|m| textured(m))
                    .count(),
                2
            );
        }
        drop(loaded);
        // What takes long is broken less often; FOVEASIM_THOROUGH breaks all alike.
        let thorough = std::env::var_os("FOVEASIM_THOROUGH").is_some_and(|v| !v.is_empty());
        let [cuts, flips] = match bytes.len() {
            _ if thorough => [50, 200],
            0..200_000 => [50, 200],
            200_000..1_000_000 => [10, 40],
            _ => [3, 8],
        };
        let most = whole.max(10 * bytes.len()) * 3 / 2 + (1 << 20);
        let try_load = |bytes: &[u8], what: &str| {
            let load = || {
                drop(load_bytes(
                    bytes,
                    name,
                    &NoSideFiles,
                    &LoadOptions::default(),
                ))
            };
            let ((), peak) = peak(load);
            assert!(
                peak <= most,
                "{name} {what}: {peak} bytes at once, {most} are allowed"
            );
        };
        for k in 0..cuts {
            try_load(
                &bytes[..bytes.len() * k / cuts],
                &format!("cut at {k}/{cuts}"),
            );
        }
        let random = &mut Stream::new(7, Role::Scene, 0);
        let mut broken = bytes.clone();
        for k in 0..flips {
            // Every other one near the start, where headers are.
            let reach = if k % 2 == 0 {
                bytes.len()
            } else {
                bytes.len().min(4096)
            };
            let at = random.below(reach as u64) as usize;
            broken[at] ^= 1 << random.below(8);
            try_load(&broken, &format!("flip {k} at {at}"));
            broken[at] = bytes[at];
        }
    }
}
