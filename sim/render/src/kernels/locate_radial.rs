use fearless_simd::prelude::*;
use foveasim_models::{Falloff, Radial, Reach};
use glam::{DVec2, UVec2};

use super::Kernel;
use super::lanes::Simd;
use super::transcendental::{log2, times_exp2};
use super::wide::{F, WIDTH, max, piece, splat};

/// The inverse of a radial map whose falloff is a power, in single precision.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RadialInverse {
    gaze_px: [f64; 2],
    /// The lattice position of the gaze.
    gaze: [f32; 2],
    /// One over the reach \[1/px\]: of all directions, or to the left, right, upper and lower edge.
    shares: Shares,
    /// Half of 1/k − 1: distances come squared.
    exponent: f32,
    scale: f32,
}

#[derive(Debug, Clone, Copy)]
enum Shares {
    Round(f32),
    Edges([f32; 4]),
}

impl RadialInverse {
    /// `None` for a falloff that is no power.
    pub(crate) fn new(map: &Radial, display: UVec2) -> Option<Self> {
        let Falloff::Power(k) = map.falloff() else {
            return None;
        };
        let (gaze, size) = (map.gaze_px(), display.as_dvec2());
        let shares = match map.reach() {
            Reach::Boundary => {
                // No pixel lies beyond an edge that the gaze is on.
                let share = |room: f64| if room > 0.0 { (1.0 / room) as f32 } else { 0.0 };
                let room = size - gaze;
                Shares::Edges([gaze.x, room.x, gaze.y, room.y].map(share))
            }
            Reach::Px(px) => Shares::Round((1.0 / px) as f32),
            _ => Shares::Round((1.0 / map.reach_px()) as f32),
        };
        let at: DVec2 = map.gaze();
        Some(Self {
            gaze_px: gaze.to_array(),
            gaze: [at.x as f32, at.y as f32],
            shares,
            exponent: (0.5 * (1.0 / k - 1.0)) as f32,
            scale: map.scale() as f32,
        })
    }
}

/// Finds where the pixels of a display row lie in a radial lattice, and how dense it is there.
///
/// Against [`Radial::lattice_from_display`] what a place stands for is off by less than 0.005 pixels, for
/// exponents from 1 to 8 and displays of up to 4000 pixels from gaze to corner.
pub(crate) struct LocateRadialRow<'a> {
    pub(crate) inverse: &'a RadialInverse,
    /// Which row.
    pub(crate) y: u32,
    /// Room for the row, and for as many as fill the last lanes.
    pub(crate) x_out: &'a mut [f32],
    pub(crate) y_out: &'a mut [f32],
    /// Samples in a pixel's length around the gaze: nowhere are there more.
    pub(crate) density: &'a mut [f32],
}

impl Kernel for LocateRadialRow<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let i = self.inverse;
        let dy = splat(simd, (f64::from(self.y) + 0.5 - i.gaze_px[1]) as f32);
        let places = self.x_out.chunks_exact_mut(WIDTH);
        let places = places.zip(self.y_out.chunks_exact_mut(WIDTH));
        for (k, ((x_out, y_out), density)) in
            places.zip(self.density.chunks_exact_mut(WIDTH)).enumerate()
        {
            let first = (k * WIDTH) as f64 + 0.5 - i.gaze_px[0];
            let dx = F::from_slice(simd, &std::array::from_fn::<f32, WIDTH, _>(|k| k as f32))
                + first as f32;
            let square = piece(
                simd,
                #[inline(always)]
                || match i.shares {
                    Shares::Round(share) => (dx * dx + dy * dy) * (share * share),
                    Shares::Edges([left, right, up, down]) => {
                        let across = max(dx * right, dx * -left);
                        let along = max(dy * down, dy * -up);
                        let s = max(across, along);
                        s * s
                    }
                },
            );
            let steps = piece(
                simd,
                #[inline(always)]
                || {
                    // At the gaze itself any finite number will do.
                    let share = max(square, splat(simd, 1e-30));
                    times_exp2(splat(simd, i.scale), log2(share) * i.exponent)
                },
            );
            (dx * steps + i.gaze[0]).store_slice(x_out);
            (dy * steps + i.gaze[1]).store_slice(y_out);
            steps.store_slice(density);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::dispatch;

    #[test]
    fn places_stand_for_their_pixels() {
        let display = UVec2::new(1280, 1440);
        let mut worst = 0.0f64;
        for k in [1.0, 1.3, 2.0, 4.0, 8.0] {
            for (gaze, reach) in [
                (DVec2::new(640.0, 720.0), Reach::Corner),
                (DVec2::new(3.2, 1439.7), Reach::Corner),
                (DVec2::new(0.0, 1440.0), Reach::Boundary),
                (DVec2::new(700.25, 33.0), Reach::Boundary),
                (DVec2::new(700.25, 33.0), Reach::Px(4000.0)),
            ] {
                let falloff = Falloff::power(k).unwrap();
                let map = Radial::new(gaze, display, falloff, reach, 0.8).unwrap();
                let inverse = RadialInverse::new(&map, display).unwrap();
                let room = || vec![0.0f32; 1280];
                let (mut xs, mut ys, mut density) = (room(), room(), room());
                let mut scalar = [room(), room(), room()];
                for y in (0..1440).step_by(53) {
                    let locate = |simd, [xs, ys, density]: [&mut [f32]; 3]| {
                        let kernel = LocateRadialRow {
                            inverse: &inverse,
                            y,
                            x_out: xs,
                            y_out: ys,
                            density,
                        };
                        dispatch(simd, kernel);
                    };
                    locate(crate::Simd::Auto, [&mut xs, &mut ys, &mut density]);
                    locate(crate::Simd::Scalar, scalar.each_mut().map(|v| &mut v[..]));
                    assert_eq!([&xs, &ys, &density], scalar.each_ref());
                    for x in 0..1280 {
                        let px = DVec2::new(x as f64 + 0.5, f64::from(y) + 0.5);
                        let found = DVec2::new(xs[x].into(), ys[x].into());
                        worst = worst.max(map.display_from_lattice(found).distance(px));
                        // What is said of the density is the shortest step around.
                        let exact = map.lattice_from_display(px).distance(map.gaze());
                        let want = exact / px.distance(gaze);
                        assert!((f64::from(density[x]) / want - 1.0).abs() < 1e-4);
                    }
                }
            }
        }
        assert!(worst < 0.005, "{worst} px");
    }
}
