//! Rays through volumes of 256³ at 1024², half-voxel steps, lit, the camera moving a little from frame to
//! frame: each volume as it is drawn, and with each of what it leaves out put back. `blobs` is the volume, camera and
//! transfer function that VTK's ray caster is compared on (benches/peers/vtk_volume.sh): 36 Gaussians, 74 % below
//! what is shown.
//!
//! `cargo bench --bench volume -- --frames 5 [--only blobs] [--ways drawn] [--size 1024] [--voxels 256] [--cpu-time]
//! [--png FILE]`
//!
//! `--cpu-time` (Linux) takes the processor time of all threads instead of the time that passes.

#![expect(
    clippy::print_stdout,
    reason = "a program whose results are what it prints"
)]

mod common;

use common::Args;
use foveasim::assets::{
    Frame, GeneratedVolume, TransferFunction, TransferPoint, Volume, VolumeParts, Voxels, look_at,
};
use foveasim::models::{Eye, Image, View, Viewport, linear_from_srgb};
use foveasim::volume::{CastOptions, Caster, Instructions, Storage, VolumeFrame, orbit};
use glam::{DAffine3, DQuat, DVec3, UVec2, UVec3};

/// The generator of numpy's `RandomState` (Matsumoto and Nishimura 1998), so that the peer's volume is ours.
struct Mt19937 {
    state: [u32; 624],
    next: usize,
}

impl Mt19937 {
    fn new(seed: u32) -> Self {
        let mut state = [seed; 624];
        for k in 1..624 {
            let before = state[k - 1] ^ (state[k - 1] >> 30);
            state[k] = before.wrapping_mul(1_812_433_253).wrapping_add(k as u32);
        }
        Self { state, next: 624 }
    }

    fn bits(&mut self) -> u32 {
        if self.next == 624 {
            for k in 0..624 {
                let y = self.state[k] & 0x8000_0000 | self.state[(k + 1) % 624] & 0x7fff_ffff;
                let odd = if y & 1 == 1 { 0x9908_b0df } else { 0 };
                self.state[k] = self.state[(k + 397) % 624] ^ (y >> 1) ^ odd;
            }
            self.next = 0;
        }
        let mut y = self.state[self.next];
        self.next += 1;
        y ^= y >> 11;
        y ^= y << 7 & 0x9d2c_5680;
        y ^= y << 15 & 0xefc6_0000;
        y ^ y >> 18
    }

    fn uniform(&mut self, low: f64, high: f64) -> f64 {
        let (a, b) = (self.bits() >> 5, self.bits() >> 6);
        let unit = (f64::from(a) * 67_108_864.0 + f64::from(b)) / 9_007_199_254_740_992.0;
        low + (high - low) * unit
    }
}

/// The peer's volume: 36 Gaussians, 16 bits.
fn blobs(n: u32) -> Volume {
    let mut rng = Mt19937::new(7);
    let count = n as usize;
    let place = |k: usize| (2.0 * k as f64 / (count - 1) as f64 - 1.0) as f32;
    let mut sum = vec![0.0f32; count * count * count];
    for _ in 0..36 {
        let c: [f64; 3] = std::array::from_fn(|_| rng.uniform(-0.75, 0.75));
        let (s, a) = (rng.uniform(0.07, 0.17), rng.uniform(0.5, 1.0));
        let axis = |c: f64| -> Vec<f32> {
            let bell = |k: usize| {
                let d = f64::from(place(k)) - c;
                (-d * d / (2.0 * s * s)).exp() as f32
            };
            (0..count).map(bell).collect()
        };
        let e = c.map(axis);
        for (z, slice) in sum.chunks_mut(count * count).enumerate() {
            let depth = a as f32 * e[2][z];
            for (y, row) in slice.chunks_mut(count).enumerate() {
                let height = depth * e[1][y];
                for (value, width) in row.iter_mut().zip(&e[0]) {
                    *value += height * width;
                }
            }
        }
    }
    let words = sum.iter().map(|v| (v.min(1.0) * 65_535.0) as u16).collect();
    Volume::build(VolumeParts {
        dims: UVec3::splat(n),
        voxels: Voxels::U16(words),
        slope: 1.0 / 65_535.0,
        intercept: 0.0,
        world_from_index: DAffine3::from_scale_rotation_translation(
            DVec3::splat(2.0 / f64::from(n - 1)),
            DQuat::IDENTITY,
            DVec3::NEG_ONE,
        ),
        frame: Frame::Plain,
    })
    .expect("finite values")
}

/// The peer's transfer function: opacity and colour have points of their own.
fn blobs_transfer() -> TransferFunction {
    let opacity = [(0.0, 0.0), (0.1, 0.0), (0.3, 0.08), (0.6, 0.5), (1.0, 0.9)];
    let colour = [
        (0.0, [0.0, 0.0, 0.0]),
        (0.2, [0.2, 0.3, 0.9]),
        (0.5, [0.9, 0.7, 0.2]),
        (1.0, [1.0, 0.3, 0.2]),
    ];
    let at = |points: &[(f64, f64)], v: f64| {
        let k = points[1..points.len() - 1]
            .iter()
            .filter(|p| p.0 <= v)
            .count();
        let ((a, from), (b, to)) = (points[k], points[k + 1]);
        from + (v - a) / (b - a) * (to - from)
    };
    let values = [0.0, 0.1, 0.2, 0.3, 0.5, 0.6, 1.0];
    let point = |value: f64| TransferPoint {
        value,
        colour: std::array::from_fn(|c| {
            let channel: Vec<(f64, f64)> = colour.iter().map(|(v, rgb)| (*v, rgb[c])).collect();
            linear_from_srgb(at(&channel, value))
        }),
        opacity: at(&opacity, value),
    };
    TransferFunction::new(values.map(point).to_vec()).expect("rising values")
}

fn main() {
    let args = Args::new();
    let number = |flag: &str| args.value::<u32>(flag);
    // `cargo test --benches` runs this with other arguments: something small will do.
    let frames = number("--frames");
    let (size, voxels) = match frames {
        Some(_) => (
            number("--size").unwrap_or(1024),
            number("--voxels").unwrap_or(256),
        ),
        None => (64, 32),
    };
    let frames = frames.unwrap_or(1).max(1);
    let clock = args.clock();
    let clock = || clock.now().as_secs_f64();
    println!(
        "volume,way,threads,frames,prepare_ms,kept_mib,frame_ms_median,frame_ms_least,rays,steps,steps_seen,\
         steps_skipped,rays_ended_early"
    );
    let own = CastOptions::default();
    let ways = [
        ("drawn", own),
        (
            "nothing-skipped",
            CastOptions {
                skip_empty: false,
                ..own
            },
        ),
        (
            "never-ended",
            CastOptions {
                terminate: 0.0,
                ..own
            },
        ),
        // VTK ends a ray when less than 255 of 32,767 shines through; 1.2 is the brightest that is shown.
        (
            "ended-as-vtk",
            CastOptions {
                terminate: 1.2 * 255.0 / 32_767.0,
                ..own
            },
        ),
        (
            "gradients-at-samples",
            CastOptions {
                storage: Storage::Values,
                ..own
            },
        ),
        (
            "one-lane",
            CastOptions {
                instructions: Instructions::Scalar,
                ..own
            },
        ),
    ];
    let kinds = GeneratedVolume::ALL.map(|k| (k.name(), Some(k)));
    for (name, kind) in std::iter::once(("blobs", None)).chain(kinds) {
        if args.text("--only").is_some_and(|only| only != name) {
            continue;
        }
        let volume = match kind {
            None => blobs(voxels),
            Some(kind) => kind.build(voxels, 1).expect("a size that can be built"),
        };
        let transfer = match kind {
            None => blobs_transfer(),
            Some(_) => TransferFunction::of_volume(&volume),
        };
        for (way, options) in &ways {
            if args.text("--ways").is_some_and(|only| only != *way) {
                continue;
            }
            let start = clock();
            let caster =
                Caster::new(&volume, &transfer, options).expect("options that can be used");
            let prepare = clock() - start;
            let mut times = Vec::new();
            let mut last = None;
            for frame in 0..=frames {
                let view = view(&volume, kind.is_none(), size, frame);
                let start = clock();
                let drawn = caster.full(&view).expect("a view that can be drawn");
                // The first one touches memory for the first time.
                if frame > 0 {
                    times.push(clock() - start);
                }
                last = Some(drawn);
            }
            times.sort_by(f64::total_cmp);
            let VolumeFrame { image, work } = last.expect("at least one frame");
            let kept = caster.prepared();
            println!(
                "{name},{way},{},{frames},{:.1},{:.1},{:.1},{:.1},{},{},{},{},{}",
                rayon::current_num_threads(),
                1e3 * prepare,
                (kept.voxel_bytes + kept.other_bytes) as f64 / f64::from(1 << 20),
                1e3 * times[times.len() / 2],
                1e3 * times[0],
                work.rays,
                work.steps,
                work.steps_seen,
                work.steps_skipped,
                work.rays_ended_early,
            );
            if let (Some(file), "drawn") = (args.text("--png"), *way) {
                save(&image, &format!("{file}-{name}.png"));
            }
        }
    }
}

/// From where the peer looks, or, for volumes that it has not, from a little above; frames are 10⁻⁴ radians
/// apart.
fn view(volume: &Volume, peer: bool, size: u32, frame: u32) -> View {
    let moved = 1e-4 * f64::from(frame);
    let (optics, pose) = if peer {
        let around = 0.3 + moved;
        let optics = Viewport::symmetric(UVec2::splat(size), 15f64.to_radians().tan());
        let eye = 4.4 * DVec3::new(0.95 * around.sin(), 0.3, 0.95 * around.cos());
        (optics.expect("30 degrees"), look_at(eye, DVec3::ZERO))
    } else {
        let optics = Viewport::symmetric(UVec2::splat(size), 15f64.to_radians().tan());
        let optics = optics.expect("30 degrees");
        let pose = orbit(
            volume.bounds(),
            &optics,
            35.0 + moved.to_degrees(),
            20.0,
            0.8,
        );
        (optics, pose)
    };
    View::still(Eye::Cyclopean, optics, pose.expect("an eye off the middle"))
}

fn save(image: &Image, file: &str) {
    let bytes = foveasim::reports::png(image).expect("an image that fits a PNG");
    std::fs::write(file, bytes).expect("a writable file");
}
