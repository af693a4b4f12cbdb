use foveasim_models::{Image, Pose, ScanSkew, Viewport};
use glam::{DMat3, DVec2, DVec3};
use rayon::prelude::*;

use crate::{RenderError, Surfel};

/// Moves a drawn image to where the eye has got to since, by its depths: a grid of one vertex per pixel whose
/// triangles are drawn from the new pose (Mark et al. 1997, as Friston et al. 2019, §5.1, compare with).
///
/// Triangles that join what is near and what is far are stretched as the eye moves; those longer than
/// [`longest_px`](Self::longest_px), and those turned over, are left out. Where nothing is left an image
/// does not know what is there: it is disoccluded. Colours are those of the image: what shading changes with the
/// view it does not know either.
///
/// In the pose it was drawn from, the image is the same to the bit. Vertices are placed on 1/256 of a pixel, colours are
/// linear over triangles; so a pure rotation differs from its homography by less than 1/256 of a pixel, and by what is
/// not linear within one.
#[derive(Debug, Clone, Copy)]
pub struct GridWarp<'a> {
    /// The image plane of both.
    pub optics: &'a Viewport,
    /// From where the image was drawn.
    pub drawn: Pose,
    /// From where it is seen.
    pub seen: Seen<'a>,
    /// The longest side of triangles that are drawn \[px\], 1.5 to 1000; in place they have 1 and √2.
    pub longest_px: f64,
}

/// From where a display is seen as it lights.
#[derive(Debug, Clone, Copy)]
pub enum Seen<'a> {
    /// All at once.
    At(Pose),
    /// From the first pose at time 0 of the scan to the second at time 1; homogeneous positions move linearly
    /// between, as Friston et al. 2019, §3.1.2, take it.
    Rolling([Pose; 2], &'a ScanSkew),
}

/// A warped image.
#[derive(Debug, Clone, PartialEq)]
pub struct Warped {
    /// What is seen; black where that is not known.
    pub image: Image,
    /// For each pixel, whether what is seen is not known.
    pub disoccluded: Vec<bool>,
    /// Triangles of the grid that were drawn.
    pub drawn: u64,
    /// Triangles left out.
    pub culled: u64,
}

/// Sub-pixels.
const SNAP: f64 = 256.0;
/// Vertices farther from the image are not drawn \[px\]: products of their differences fit an integer.
const FARTHEST_PX: f64 = 1e6;
/// Rows of the display that one thread fills at a time.
const BAND: usize = 16;
/// Times of a rolling display are found by asking where a point is at the time its place lights. Each step
/// leaves the share of the error that the image's speed is of the scan's: below a quarter, 1e-5 of the scan after these.
const STEPS: usize = 8;

/// A vertex on the display.
#[derive(Debug, Clone, Copy)]
struct Vertex {
    /// Place \[sub-pixels\].
    x: i64,
    y: i64,
    /// One over the distance along the axis \[1/m\]; NaN if it is not in front of the eye.
    inverse_w: f32,
}

impl Vertex {
    const NONE: Self = Self {
        x: 0,
        y: 0,
        inverse_w: f32::NAN,
    };
}

/// One over the distance of what each sample sees \[1/m\]; 0 for the sky.
pub fn inverse_depths(surfels: &[Option<Surfel>]) -> Vec<f32> {
    let depth = |s: &Option<Surfel>| s.map_or(0.0, |s| 1.0 / s.depth_m);
    surfels.iter().map(depth).collect()
}

impl GridWarp<'_> {
    /// Lengths that leave triangles alone which only turn, on fields of view up to 110°.
    pub const LONGEST_PX: f64 = 4.0;

    /// Warps `image`, in which one over the distance along the axis is `inverse_depth` \[1/m\], 0 for the sky.
    ///
    /// # Errors
    /// If sizes do not fit, a distance is no number, or a pose or the longest side cannot be used.
    pub fn apply(&self, image: &Image, inverse_depth: &[f32]) -> Result<Warped, RenderError> {
        self.check(image, inverse_depth)?;
        let [width, height] = self.optics.size.to_array().map(|n| n as usize);
        // One more all around, so that the outermost pixels have their other halves.
        let across = width + 2;
        let seen_from = self.transforms();
        let mut vertices = vec![Vertex::NONE; across * (height + 2)];
        let rows = vertices.par_chunks_mut(across).enumerate();
        rows.for_each(|(j, row)| {
            let y = j.saturating_sub(1).min(height - 1);
            for (i, vertex) in row.iter_mut().enumerate() {
                let x = i.saturating_sub(1).min(width - 1);
                let px = DVec2::new(i as f64 - 0.5, j as f64 - 0.5);
                *vertex = self.vertex(&seen_from, px, inverse_depth[y * width + x]);
            }
        });
        let reach = |row: &[Vertex]| {
            let there = row.iter().filter(|v| !v.inverse_w.is_nan());
            there.fold([i64::MAX, i64::MIN], |[low, high], v| {
                [low.min(v.y), high.max(v.y)]
            })
        };
        let reaches: Vec<[i64; 2]> = vertices.par_chunks(across).map(reach).collect();
        let grid = Grid {
            image,
            vertices: &vertices,
            reaches: &reaches,
            longest: (self.longest_px * SNAP) as i64,
        };
        let mut out = Image::filled(self.optics.size, [0.0; 3]);
        let mut disoccluded = vec![true; width * height];
        out.rgb
            .par_chunks_mut(BAND * width)
            .zip(disoccluded.par_chunks_mut(BAND * width))
            .enumerate()
            .for_each(|(band, (rgb, hidden))| grid.fill(band * BAND, width, rgb, hidden));
        let drawn: u64 = (0..height + 1)
            .into_par_iter()
            .map(|j| grid.triangles(j).filter(|t| grid.is_drawn(t)).count() as u64)
            .sum();
        let all = 2 * (width as u64 + 1) * (height as u64 + 1);
        Ok(Warped {
            image: out,
            disoccluded,
            drawn,
            culled: all - drawn,
        })
    }

    /// For each end of the scan, what takes a direction of the drawn image, and how much of the way between the
    /// eyes is added by one over the distance.
    fn transforms(&self) -> Vec<(DMat3, DVec3)> {
        let poses = match &self.seen {
            Seen::At(pose) => std::slice::from_ref(pose),
            Seen::Rolling(poses, _) => poses,
        };
        let transform = |seen: &Pose| {
            let back = seen.orientation.conjugate();
            let turn = DMat3::from_quat((back * self.drawn.orientation).normalize());
            (turn, back * (self.drawn.position - seen.position))
        };
        poses.iter().map(transform).collect()
    }

    fn vertex(&self, seen_from: &[(DMat3, DVec3)], px: DVec2, inverse_w: f32) -> Vertex {
        let direction = self.optics.direction(px);
        let at = |k: usize| {
            let (turn, way) = seen_from[k];
            turn * direction + way * f64::from(inverse_w)
        };
        let project = |q: DVec3| {
            let step = self.optics.pixel_tan();
            let [left, _, up, _] = self.optics.tan;
            let tan = DVec2::new(q.x, q.y) / -q.z;
            DVec2::new((tan.x - left) / step.x, (up - tan.y) / step.y)
        };
        let first = at(0);
        let q = match &self.seen {
            Seen::At(_) => first,
            Seen::Rolling(_, scan) => {
                let last = at(1);
                let size = self.optics.size.as_dvec2();
                let mut time = 0.5;
                for _ in 0..STEPS {
                    let q = first.lerp(last, time);
                    // Behind the eye, or off the display, it has the time of the display's edge.
                    let lit = scan.time(project(q).clamp(DVec2::ZERO, size), size);
                    time = if q.z < 0.0 { lit } else { time };
                }
                first.lerp(last, time)
            }
        };
        let place = project(q);
        if !(q.z < -1e-6 && place.abs().max_element() <= FARTHEST_PX) {
            return Vertex::NONE;
        }
        Vertex {
            x: (place.x * SNAP).round() as i64,
            y: (place.y * SNAP).round() as i64,
            inverse_w: (f64::from(inverse_w) / -q.z) as f32,
        }
    }

    fn check(&self, image: &Image, inverse_depth: &[f32]) -> Result<(), RenderError> {
        let refuse = |field, value: String, valid: String| {
            Err(RenderError::OutOfRange {
                field,
                value,
                valid,
            })
        };
        let size = self.optics.size;
        let pixels = size.x as usize * size.y as usize;
        if image.size != size || image.rgb.len() != pixels || pixels == 0 {
            let valid = format!("{} x {}, as the optics have, and above 0", size.x, size.y);
            return refuse("size of a warped image", image.size.to_string(), valid);
        }
        if inverse_depth.len() != pixels {
            let value = inverse_depth.len().to_string();
            return refuse("distances of a warped image", value, pixels.to_string());
        }
        if let Some(k) = inverse_depth.iter().position(|d| !(0.0..=1e6).contains(d)) {
            let value = format!("{} at pixel {k}", inverse_depth[k]);
            let valid = "from 0 to 1e6 1/m".into();
            return refuse("inverse distance of a warped image", value, valid);
        }
        let mut poses = vec![self.drawn];
        match &self.seen {
            Seen::At(pose) => poses.push(*pose),
            Seen::Rolling(two, _) => poses.extend(two),
        }
        let usable = |p: &Pose| {
            let unit = (p.orientation.length() - 1.0).abs() < 1e-6;
            unit && p.position.is_finite() && p.position.abs().max_element() <= 1e6
        };
        if let Some(pose) = poses.iter().find(|p| !usable(p)) {
            let valid = "within ±1e6 m, and a unit quaternion".into();
            return refuse("pose of a warp", format!("{pose:?}"), valid);
        }
        if !(1.5..=1000.0).contains(&self.longest_px) {
            let valid = "from 1.5 to 1000 px".into();
            return refuse("longest side of a warp", self.longest_px.to_string(), valid);
        }
        Ok(())
    }
}

/// The vertices on the display, row by row.
struct Grid<'a> {
    image: &'a Image,
    vertices: &'a [Vertex],
    /// For each row of vertices, the least and greatest place down the display.
    reaches: &'a [[i64; 2]],
    /// Of sides \[sub-pixels\].
    longest: i64,
}

/// A triangle of the grid: places of its vertices in the row of their column, and which of two rows.
type Triangle = [[usize; 2]; 3];

impl Grid<'_> {
    fn across(&self) -> usize {
        self.image.size.x as usize + 2
    }

    /// The triangles between rows `j` and `j + 1` of vertices, from left to right; clockwise on the display.
    fn triangles(&self, j: usize) -> impl Iterator<Item = Triangle> {
        (0..self.across() - 1).flat_map(move |i| {
            let [a, b, c, d] = [[i, j], [i + 1, j], [i + 1, j + 1], [i, j + 1]];
            [[a, b, c], [a, c, d]]
        })
    }

    fn corners(&self, triangle: &Triangle) -> [Vertex; 3] {
        triangle.map(|[i, j]| self.vertices[j * self.across() + i])
    }

    fn is_drawn(&self, triangle: &Triangle) -> bool {
        let [a, b, c] = self.corners(triangle);
        if [a, b, c].iter().any(|v| v.inverse_w.is_nan()) {
            return false;
        }
        let long = |p: Vertex, q: Vertex| {
            let (dx, dy) = ((q.x - p.x).abs(), (q.y - p.y).abs());
            // In this order nothing overflows.
            dx.max(dy) > self.longest || dx * dx + dy * dy > self.longest * self.longest
        };
        !(long(a, b) || long(b, c) || long(c, a)) && edge(a, b, c.x, c.y) > 0
    }

    /// The colour of a vertex.
    fn colour(&self, [i, j]: [usize; 2]) -> [f32; 3] {
        let [width, height] = self.image.size.to_array().map(|n| n as usize);
        let x = i.saturating_sub(1).min(width - 1);
        let y = j.saturating_sub(1).min(height - 1);
        self.image.rgb[y * width + x]
    }

    /// Draws the rows from `first` on: as many as `rgb` holds.
    fn fill(&self, first: usize, width: usize, rgb: &mut [[f32; 3]], hidden: &mut [bool]) {
        let rows = rgb.len() / width;
        let mut depth = vec![f32::NEG_INFINITY; rgb.len()];
        let (low, high) = (
            first as i64 * SNAP as i64,
            (first + rows) as i64 * SNAP as i64,
        );
        for (j, pair) in self.reaches.windows(2).enumerate() {
            let [a, b] = [pair[0], pair[1]];
            if a[0].min(b[0]) > high || a[1].max(b[1]) < low {
                continue;
            }
            for triangle in self.triangles(j).filter(|t| self.is_drawn(t)) {
                let corners = self.corners(&triangle);
                let colours = triangle.map(|v| self.colour(v));
                let area = edge(corners[0], corners[1], corners[2].x, corners[2].y) as f32;
                let [xs, ys] = [corners.map(|v| v.x), corners.map(|v| v.y)];
                let across = pixels(&xs, 0, width);
                for y in pixels(&ys, first, rows) {
                    for x in across.clone() {
                        let Some([b, c]) = inside(&corners, x, y) else {
                            continue;
                        };
                        let (b, c) = (b as f32 / area, c as f32 / area);
                        let between = |v: [f32; 3]| v[0] + (b * (v[1] - v[0]) + c * (v[2] - v[0]));
                        let nearness = between(corners.map(|v| v.inverse_w));
                        let at = (y - first) * width + x;
                        if nearness > depth[at] {
                            depth[at] = nearness;
                            hidden[at] = false;
                            rgb[at] = [0, 1, 2].map(|k| between(colours.map(|rgb| rgb[k])));
                        }
                    }
                }
            }
        }
    }
}

/// Which of `count` pixels from `first` on may have their middles between the least and the greatest of `places`.
fn pixels(places: &[i64; 3], first: usize, count: usize) -> std::ops::Range<usize> {
    let (low, high) = places.iter().fold((i64::MAX, i64::MIN), |(low, high), p| {
        (low.min(*p), high.max(*p))
    });
    let (whole, half) = (SNAP as i64, SNAP as i64 / 2);
    let from = (low - half).div_euclid(whole);
    let end = (high - half).div_euclid(whole) + 1;
    let limit = |p: i64| p.clamp(first as i64, (first + count) as i64) as usize;
    limit(from)..limit(end)
}

/// Twice the area of the triangle of `a`, `b` and a place; above 0 clockwise on the display.
fn edge(a: Vertex, b: Vertex, x: i64, y: i64) -> i64 {
    (b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x)
}

/// Twice the areas opposite the second and third corner if the middle of a pixel is inside; of what lies on an
/// edge, the triangle to its right or below has it.
fn inside([a, b, c]: &[Vertex; 3], x: usize, y: usize) -> Option<[i64; 2]> {
    let (x, y) = (
        x as i64 * SNAP as i64 + SNAP as i64 / 2,
        y as i64 * SNAP as i64 + SNAP as i64 / 2,
    );
    let covers = |p: &Vertex, q: &Vertex| {
        let e = edge(*p, *q, x, y);
        let owns = q.y < p.y || (q.y == p.y && q.x > p.x);
        (e > 0 || (e == 0 && owns)).then_some(e)
    };
    covers(a, b)?;
    let (opposite_a, opposite_b) = (covers(b, c)?, covers(c, a)?);
    let all = edge(*a, *b, c.x, c.y);
    // Opposite c is what is left.
    Some([opposite_b, all - opposite_a - opposite_b])
}

#[cfg(test)]
mod tests {
    use foveasim_models::{Role, Stream};
    use glam::{DQuat, UVec2};

    use super::*;

    fn optics(width: u32, height: u32) -> Viewport {
        Viewport::symmetric(UVec2::new(width, height), 0.8).unwrap()
    }

    fn noise(size: UVec2) -> (Image, Vec<f32>) {
        let random = &mut Stream::new(3, Role::Scene, 0);
        let mut image = Image::filled(size, [0.0; 3]);
        for rgb in &mut image.rgb {
            *rgb = [(); 3].map(|()| random.uniform() as f32);
        }
        let depth = |_: &[f32; 3]| {
            let far = random.below(3) == 0;
            if far {
                0.0
            } else {
                random.range(0.01, 3.0) as f32
            }
        };
        let depths = image.rgb.iter().map(depth).collect();
        (image, depths)
    }

    fn pose(x: f64, yaw_deg: f64) -> Pose {
        let turn = DQuat::from_rotation_y(yaw_deg.to_radians());
        Pose::new(DVec3::new(x, 1.0, -2.0), turn)
    }

    fn warp<'a>(optics: &'a Viewport, drawn: Pose, seen: Seen<'a>) -> GridWarp<'a> {
        GridWarp {
            optics,
            drawn,
            seen,
            longest_px: GridWarp::LONGEST_PX,
        }
    }

    #[test]
    fn in_its_own_pose_an_image_stays_as_it_is() {
        let scan = ScanSkew::new(DVec2::new(0.9, 0.0)).unwrap();
        for (width, height) in [(1, 1), (33, 17), (64, 40)] {
            let optics = optics(width, height);
            let (image, depths) = noise(optics.size);
            let eye = pose(0.4, 37.0);
            for seen in [Seen::At(eye), Seen::Rolling([eye, eye], &scan)] {
                let warped = warp(&optics, eye, seen).apply(&image, &depths).unwrap();
                assert_eq!(warped.image, image);
                assert!(!warped.disoccluded.contains(&true));
                assert_eq!(warped.culled, 0);
            }
        }
    }

    /// Turned, an image of a slope over the display is the slope where the homography takes it from.
    #[test]
    fn a_rotation_is_its_homography() {
        let optics = optics(96, 64);
        let mut image = Image::filled(optics.size, [0.0; 3]);
        for (k, rgb) in image.rgb.iter_mut().enumerate() {
            *rgb = [(k % 96) as f32 + 0.5, (k / 96) as f32 + 0.5, 1.0];
        }
        let (drawn, seen) = (pose(0.0, 0.0), pose(0.0, 3.0));
        let depths = vec![0.5; image.rgb.len()];
        let warped = warp(&optics, drawn, Seen::At(seen))
            .apply(&image, &depths)
            .unwrap();
        let (mut worst, mut known) = (0.0f64, 0);
        for (k, rgb) in warped.image.rgb.iter().enumerate() {
            if warped.disoccluded[k] {
                continue;
            }
            let px = DVec2::new((k % 96) as f64 + 0.5, (k / 96) as f64 + 0.5);
            let direction = seen.orientation * optics.direction(px);
            let from = optics
                .project(drawn.orientation.conjugate() * direction)
                .unwrap();
            // Beyond the outermost middles their colours go on.
            let from = from.clamp(DVec2::splat(0.5), optics.size.as_dvec2() - 0.5);
            let off = DVec2::new(rgb[0].into(), rgb[1].into()) - from;
            worst = worst.max(off.abs().max_element());
            known += 1;
        }
        // Half a sub-pixel along each axis, sheared by the triangle; what a cell bends is far less.
        assert!(worst < 1.0 / 256.0, "{worst} px");
        let turned = 96.0 * (1.0 - 3f64.to_radians().tan() / 1.6);
        assert!(f64::from(known) > 64.0 * (turned - 3.0), "{known}");
        assert!(warped.culled == 0);
    }

    /// A near square before a far wall, seen from farther right: what it hid is known nowhere.
    #[test]
    fn what_was_hidden_is_marked() {
        let optics = optics(80, 80);
        let near = |x: usize, y: usize| (20..60).contains(&x) && (20..60).contains(&y);
        let mut image = Image::filled(optics.size, [0.2; 3]);
        let mut depths = vec![0.1; 80 * 80];
        for y in 0..80 {
            for x in 0..80 {
                if near(x, y) {
                    image.rgb[y * 80 + x] = [0.9; 3];
                    depths[y * 80 + x] = 1.0;
                }
            }
        }
        // Things at 1 m move by 10 px to the left, the wall by 1.
        let step = 10.0 * 1.6 / 80.0;
        let seen = Seen::At(pose(step, 0.0));
        let warped = warp(&optics, pose(0.0, 0.0), seen)
            .apply(&image, &depths)
            .unwrap();
        let hidden = |x: usize, y: usize| warped.disoccluded[y * 80 + x];
        for y in 21..59 {
            let marked: Vec<usize> = (0..79).filter(|x| hidden(*x, y)).collect();
            // From where the square was to where the wall went: nine pixels, less the halves that belong to vertices.
            assert!((8..=10).contains(&marked.len()), "{y}: {marked:?}");
            assert!(marked.iter().all(|x| (49..60).contains(x)), "{marked:?}");
            assert_eq!(warped.image.rgb[y * 80 + 30], [0.9; 3]);
            assert_eq!(warped.image.rgb[y * 80 + 5], [0.2; 3]);
        }
        assert!(!hidden(10, 40) && warped.culled > 0);
    }

    /// Each column of a display that scans to the right is seen as at its own time.
    #[test]
    fn a_rolling_display_is_many_still_ones() {
        let optics = optics(96, 64);
        let mut image = Image::filled(optics.size, [0.0; 3]);
        for (k, rgb) in image.rgb.iter_mut().enumerate() {
            *rgb = [(k % 96) as f32 + 0.5, (k / 96) as f32 + 0.5, 1.0];
        }
        let depths = vec![0.25; image.rgb.len()];
        let scan = ScanSkew::new(DVec2::new(1.0, 0.0)).unwrap();
        let [start, end] = [pose(0.0, 0.0), pose(0.3, 2.0)];
        let rolling = warp(&optics, start, Seen::Rolling([start, end], &scan));
        let rolled = rolling.apply(&image, &depths).unwrap();
        for x in [10usize, 50, 88] {
            let time = (x as f64 + 0.5) / 96.0;
            let eye = start.interpolate(end, time);
            let still = warp(&optics, start, Seen::At(eye))
                .apply(&image, &depths)
                .unwrap();
            for y in 4..60 {
                let k = y * 96 + x;
                assert!(!rolled.disoccluded[k]);
                for c in 0..2 {
                    // Linear in homogeneous places against linear in poses: 2° apart, that is a few 1e-4.
                    let off = (rolled.image.rgb[k][c] - still.image.rgb[k][c]).abs();
                    assert!(off < 0.04, "{x} {y}: {off}");
                }
            }
        }
    }

    #[test]
    fn threads_do_not_matter_and_wrong_input_is_refused() {
        let optics = optics(50, 40);
        let (image, depths) = noise(optics.size);
        let warp = warp(&optics, pose(0.0, 0.0), Seen::At(pose(0.3, 5.0)));
        let on = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            pool.unwrap()
                .install(|| warp.apply(&image, &depths))
                .unwrap()
        };
        assert_eq!(on(1), on(3));
        let refused = |warp: GridWarp<'_>, depths: &[f32]| {
            warp.apply(&image, depths).unwrap_err().to_string()
        };
        assert!(refused(warp, &depths[1..]).contains("must be 2000"));
        let mut broken = depths.clone();
        broken[7] = f32::NAN;
        assert!(refused(warp, &broken).contains("NaN at pixel 7"));
        let short = GridWarp {
            longest_px: 1.0,
            ..warp
        };
        assert!(refused(short, &depths).contains("from 1.5 to 1000"));
        let nowhere = GridWarp {
            drawn: pose(f64::NAN, 0.0),
            ..warp
        };
        assert!(refused(nowhere, &depths).contains("unit quaternion"));
    }
}
