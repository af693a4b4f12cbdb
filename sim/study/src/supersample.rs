use foveasim_assets::Scene;
use foveasim_models::{Image, Lens, SamplePlan, View, Work};
use foveasim_render::{Frame, RenderError, RenderOptions, render, separate_colours};
use glam::UVec2;

/// The most samples along each side of a pixel.
const MOST: u32 = 16;
/// Most samples of one strip.
const STRIP_SAMPLES: u64 = 1 << 23;
/// Most samples along one side of a strip: the renderer's limit.
const STRIP_SIDE: u32 = 16_384;

/// The reference that antialiasing is judged by: a view at `n` × `n` samples to the pixel, each pixel
/// the mean of its samples' linear light (a box filter).
///
/// The samples are those of an image plane `n` times as fine, so procedural detail, texture levels and
/// tessellation that depend on the size of a sample are those of the fine one: an approximation of what
/// is there, and not of what a renderer makes of it at one sample to the pixel. The plane is drawn in
/// strips of at most 2²³ samples, so memory does not grow with `n`; sums are made in a fixed order, so
/// the result does not depend on the number of threads.
///
/// # Errors
/// If `n` is not from 1 to 16, or the renderer refuses the view.
pub fn supersampled(
    scene: &Scene,
    view: &View,
    n: u32,
    options: &RenderOptions,
) -> Result<Image, RenderError> {
    Ok(supersampled_frame(scene, view, n, options)?.image)
}

/// [`supersampled`], with the work of all strips.
pub(crate) fn supersampled_frame(
    scene: &Scene,
    view: &View,
    n: u32,
    options: &RenderOptions,
) -> Result<Frame, RenderError> {
    if !(1..=MOST).contains(&n) {
        return Err(RenderError::OutOfRange {
            field: "samples along each side of a pixel",
            value: n.to_string(),
            valid: format!("from 1 to {MOST}"),
        });
    }
    let size = view.optics.size;
    let options = RenderOptions {
        keep_passes: false,
        ..*options
    };
    if n == 1 {
        let plan = SamplePlan::full(view.eye, size);
        return render(scene, view, &plan, &options);
    }
    let mut image = Image::filled(size, [0.0; 3]);
    let mut work = Work::default();
    let width = (STRIP_SIDE / n).min(size.x).max(1);
    let rows = STRIP_SAMPLES / (u64::from(width) * u64::from(n) * u64::from(n));
    let height = (rows as u32).clamp(1, STRIP_SIDE / n).min(size.y).max(1);
    for y in (0..size.y).step_by(height as usize) {
        for x in (0..size.x).step_by(width as usize) {
            let first = UVec2::new(x, y);
            let part = UVec2::new(width, height).min(size - first);
            let fine = view.part(first, part, n);
            // Moved apart when all is there: a strip's neighbours are other strips.
            let fine = fine.seen_through(fine.lens.map(Lens::without_colours));
            let plan = SamplePlan::full(view.eye, part * n);
            let strip = render(scene, &fine, &plan, &options)?;
            let samples = strip.image;
            work += strip.work;
            for py in 0..part.y {
                for px in 0..part.x {
                    let at = (y + py) as usize * size.x as usize + (x + px) as usize;
                    image.rgb[at] = mean(&samples, UVec2::new(px, py) * n, n);
                }
            }
        }
    }
    let image = match &view.lens {
        Some(lens) => separate_colours(image, lens),
        None => image,
    };
    Ok(Frame {
        image,
        work,
        pass_work: Vec::new(),
        passes: Vec::new(),
    })
}

/// The mean of `n` × `n` samples from `first` on, row by row.
pub(crate) fn mean(samples: &Image, first: UVec2, n: u32) -> [f32; 3] {
    let mut sum = [0.0f64; 3];
    for y in first.y..first.y + n {
        for x in first.x..first.x + n {
            for (sum, light) in sum.iter_mut().zip(samples.at(x, y)) {
                *sum += f64::from(light);
            }
        }
    }
    sum.map(|s| (s / f64::from(n * n)) as f32)
}

#[cfg(test)]
mod tests {
    use foveasim_assets::{Instance, Material, Mesh, Similarity, Sky, Sun, Vertex, study_scene};
    use foveasim_models::{Eye, Pose, Viewport};
    use glam::{DQuat, DVec3};

    use super::*;

    fn view(size: UVec2) -> View {
        let pose = Pose::new(DVec3::ZERO, DQuat::IDENTITY);
        let optics = Viewport::symmetric(size, 0.4).unwrap();
        View::still(Eye::Cyclopean, optics, pose)
    }

    /// White to the right of a slanted edge x = slope · y + shift on a plane one metre ahead.
    fn half_plane(slope: f64, shift: f64) -> Scene {
        let vertex = |x: f64, y: f64| Vertex {
            position: DVec3::new(x, y, -1.0),
            normal: DVec3::Z,
            uv: [0.0; 2],
        };
        let at = |y: f64| slope * y + shift;
        let corners = [
            vertex(at(-9.0), -9.0),
            vertex(90.0, -9.0),
            vertex(90.0, 9.0),
            vertex(at(9.0), 9.0),
        ];
        let mesh = Mesh::new(&corners, vec![[0, 1, 2], [0, 2, 3]]).unwrap();
        let instance = Instance {
            mesh: 0,
            material: 0,
            world_from_object: Similarity::at(DVec3::ZERO),
            two_sided: false,
            lod: None,
        };
        let sun = Sun {
            direction: DVec3::Y,
            radiance: [1.0; 3],
        };
        let white = Material::Unlit([1.0; 3]);
        let black = Sky::Uniform([0.0; 3]);
        Scene::new(vec![mesh], vec![instance], vec![white], black, sun).unwrap()
    }

    #[test]
    fn an_edge_is_as_light_as_the_area_it_covers() {
        let view = view(UVec2::new(40, 30));
        let scene = half_plane(0.37, 0.013);
        let image = supersampled(&scene, &view, 8, &RenderOptions::default()).unwrap();
        let mut between = 0;
        for y in 0..30 {
            for x in 0..40 {
                // Exact cover of the pixel, by rows of the edge: 1000 of them are exact enough.
                let rows = (0..1000).map(|k| {
                    let py = f64::from(y) + (f64::from(k) + 0.5) / 1000.0;
                    let d = view.optics.direction(glam::DVec2::new(0.0, py));
                    let tan = 0.37 * d.y + 0.013;
                    let px = (tan - view.optics.tan[0]) / view.optics.pixel_tan().x;
                    (f64::from(x + 1) - px).clamp(0.0, 1.0)
                });
                let cover = rows.sum::<f64>() / 1000.0;
                let light = f64::from(image.at(x, y)[0]);
                // Each of 8 rows of samples is right to one half of a sample (1/16), and snapping to
                // 1/256 of a sample moves the edge by less than 1/1000 of a pixel.
                assert!(
                    (light - cover).abs() < 1.0 / 16.0 + 1e-3,
                    "{x} {y}: {light} {cover}"
                );
                between += u32::from(cover > 0.1 && cover < 0.9);
            }
        }
        assert!(between > 20, "the edge crosses pixels: {between}");
    }

    #[test]
    fn strips_do_not_show() {
        // 2,100 × 16 samples do not fit one strip, 60 × 16 do: the same pixels either way.
        let scene = study_scene(1);
        let pose = foveasim_assets::study_camera(0.3, 1);
        let wide = View {
            poses: [pose; 2],
            ..view(UVec2::new(2100, 4))
        };
        let left = wide.part(UVec2::ZERO, UVec2::new(60, 4), 1);
        let options = RenderOptions::default();
        let all = supersampled(&scene, &wide, 9, &options).unwrap();
        let some = supersampled(&scene, &left, 9, &options).unwrap();
        let mut largest = 0.0f32;
        for y in 0..4 {
            for x in 0..60 {
                for (a, b) in all.at(x, y).into_iter().zip(some.at(x, y)) {
                    largest = largest.max((a - b).abs());
                }
            }
        }
        // Snapping to 1/256 of a sample may move an edge across one sample of 81.
        assert!(largest < 3.0 / 81.0, "{largest}");
    }

    #[test]
    fn one_sample_is_a_plain_frame_and_none_is_an_error() {
        let (scene, view) = (half_plane(0.2, 0.0), view(UVec2::new(24, 18)));
        let options = RenderOptions::default();
        let plan = SamplePlan::full(view.eye, view.optics.size);
        let plain = render(&scene, &view, &plan, &options).unwrap().image;
        assert_eq!(supersampled(&scene, &view, 1, &options).unwrap(), plain);
        for n in [0, 17] {
            let error = supersampled(&scene, &view, n, &options).unwrap_err();
            assert!(error.to_string().contains("from 1 to 16"), "{error}");
        }
    }
}
