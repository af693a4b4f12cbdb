//! What can be drawn, and what is refused.

use foveasim_assets::Scene;
use foveasim_models::{
    Affine, Interpolation, Lattice, Map, Msaa, Pass, Pose, Region, Resolve, SamplePlan, Shading,
    View, Viewport, Visibility,
};
use glam::UVec2;

use crate::moving::Warp;
use crate::{RenderError, RenderOptions, live, mosaic};

/// Most samples along one side of a pass.
pub const LARGEST_SIDE: u32 = 16_384;
/// Most samples and pixels of a frame, all passes and the image together (12 bytes each).
const MOST_SAMPLES: u64 = 1 << 26;
/// Greatest tangent of the image's edges: 89.94° off the axis.
const LARGEST_TAN: f64 = 1e3;
/// Least size of a pixel, as a tangent: a fiftieth of an arc second.
const SMALLEST_PIXEL_TAN: f64 = 1e-7;
/// Greatest distance of the image's edges from the axis \[px\]: single precision still resolves 1/128
/// of a pixel there.
const LARGEST_FROM_AXIS_PX: f64 = 65_536.0;
/// Greatest distance of a pass's first sample from display pixel (0, 0), in pixels and in samples:
/// in sub-samples it is at most 2²⁴, so sums with positions on the lattice stay below 2³¹.
const LARGEST_ORIGIN: f64 = 65_536.0;

/// Refuses what cannot be drawn.
pub(crate) fn check(
    scene: &Scene,
    view: &View,
    plan: &SamplePlan,
    options: &RenderOptions,
) -> Result<(), RenderError> {
    check_plan(
        view,
        plan,
        options,
        Warp::of(scene, view, options).is_some(),
    )
}

/// The same whatever the scene; `warped` if what it shows moves, or is seen through a lens.
pub(crate) fn check_plan(
    view: &View,
    plan: &SamplePlan,
    options: &RenderOptions,
    warped: bool,
) -> Result<(), RenderError> {
    options.check()?;
    check_view(view)?;
    let size = view.optics.size;
    if plan.display_px != size {
        return Err(RenderError::OtherSize {
            method: plan.method.clone(),
            plan: format!("{} x {}", plan.display_px.x, plan.display_px.y),
            view: format!("{} x {}", size.x, size.y),
        });
    }
    let mut samples = u64::from(size.x) * u64::from(size.y);
    for (index, p) in plan.passes.iter().enumerate() {
        let refuse = |why| RenderError::Pass {
            method: plan.method.clone(),
            pass: index,
            why,
        };
        check_pass(p, view).map_err(refuse)?;
        check_sharing(plan, index).map_err(refuse)?;
        if warped {
            check_warped(p).map_err(refuse)?;
        }
        samples += p.lattice.samples();
    }
    if samples > MOST_SAMPLES {
        return Err(RenderError::OutOfRange {
            field: "samples of all passes and pixels of the image",
            value: samples.to_string(),
            valid: format!("at most {MOST_SAMPLES}"),
        });
    }
    let resolve = |why| RenderError::Resolve {
        method: plan.method.clone(),
        why,
    };
    if view.lens.is_some() && matches!(plan.resolve, Resolve::Feather(_)) {
        let why = "layers blend by eccentricity on the display, which a lens changes";
        return Err(resolve(why.into()));
    }
    check_resolve(plan).map_err(resolve)
}

/// What is drawn of moving triangles: one position of visibility and one evaluation of shading per sample.
fn check_warped(pass: &Pass) -> Result<(), String> {
    const HERE: &str = "on a rolling display, through a lens or with a bound asked for";
    match pass.visibility {
        Visibility::Own(Msaa::One) => {}
        Visibility::Own(_) => {
            return Err(format!("samples have one position of visibility {HERE}"));
        }
        _ => return Err(format!("passes cannot share visibility {HERE}")),
    }
    match pass.shading {
        Shading::PerSample => Ok(()),
        Shading::Nowhere => Err(format!("passes cannot share visibility {HERE}")),
        _ => Err(format!("each sample must be shaded by itself {HERE}")),
    }
}

fn check_view(view: &View) -> Result<(), RenderError> {
    if !view.is_still() && view.scan.is_none() {
        return Err(RenderError::MovingView);
    }
    let range = |field, value: String, valid: &str| {
        Err(RenderError::OutOfRange {
            field,
            value,
            valid: valid.into(),
        })
    };
    for pose in view.poses {
        check_pose(pose)?;
    }
    let size = view.optics.size;
    if size.min_element() == 0 || size.max_element() > LARGEST_SIDE {
        return range(
            "image size",
            format!("{} x {}", size.x, size.y),
            "1 to 16384 pixels a side",
        );
    }
    check_optics(&view.optics)
}

fn check_pose(pose: Pose) -> Result<(), RenderError> {
    let range = |field, value: String, valid: &str| {
        Err(RenderError::OutOfRange {
            field,
            value,
            valid: valid.into(),
        })
    };
    if !(pose.position.is_finite() && pose.position.abs().max_element() <= 1e6) {
        return range("eye position", pose.position.to_string(), "within ±1e6 m");
    }
    if !is_unit(pose.orientation.length()) {
        return range(
            "eye orientation",
            pose.orientation.to_string(),
            "a unit quaternion",
        );
    }
    Ok(())
}

/// A view's optics can be built without the checks of their constructor.
fn check_optics(optics: &Viewport) -> Result<(), RenderError> {
    let range = |field, value: String, valid: String| {
        Err(RenderError::OutOfRange {
            field,
            value,
            valid,
        })
    };
    let [left, right, up, down] = optics.tan;
    if !optics.tan.iter().all(|t| t.abs() <= LARGEST_TAN) {
        let valid =
            format!("left, right, upper and lower edge as tangents within ±{LARGEST_TAN} (89.9°)");
        return range("image edges", format!("{:?}", optics.tan), valid);
    }
    let pixel = optics.pixel_tan();
    if !(pixel.x >= SMALLEST_PIXEL_TAN && pixel.y >= SMALLEST_PIXEL_TAN) {
        let value = format!("{:e} x {:e}", pixel.x, pixel.y);
        let valid = format!(
            "at least {SMALLEST_PIXEL_TAN:e} as a tangent: use a wider field of view or fewer pixels"
        );
        return range("pixel size", value, valid);
    }
    let far = (left.abs().max(right.abs()) / pixel.x).max(up.abs().max(down.abs()) / pixel.y);
    if far > LARGEST_FROM_AXIS_PX {
        let valid = format!("at most {LARGEST_FROM_AXIS_PX} pixels");
        return range(
            "distance of the image from the view axis",
            format!("{far} pixels"),
            valid,
        );
    }
    Ok(())
}

/// Whether a length is 1 up to rounding; NaN is not.
fn is_unit(length: f64) -> bool {
    (length - 1.0).abs() < 1e-6
}

fn check_pass(pass: &Pass, view: &View) -> Result<(), String> {
    if pass.eye != view.eye {
        let (pass, view) = (pass.eye.name(), view.eye.name());
        return Err(format!(
            "it is for the {pass} eye, the view is the {view} eye's"
        ));
    }
    match pass.lattice {
        Lattice::Grid(grid) if grid.max_element() > LARGEST_SIDE => {
            return Err(format!(
                "{} x {} samples; at most {LARGEST_SIDE} a side",
                grid.x, grid.y
            ));
        }
        Lattice::Grid(_) => {}
        other => return Err(format!("cannot draw a lattice of kind {other:?}")),
    }
    match pass.map {
        Map::Affine(map) => {
            let scale = map.scale.min_element() >= 1e-3 && map.scale.max_element() <= 1e4;
            let far = map.origin.abs().max((map.origin / map.scale).abs());
            let origin = far.max_element() <= LARGEST_ORIGIN;
            if !(scale && origin && map.scale.is_finite() && map.origin.is_finite()) {
                return Err(format!(
                    "origin {} px and scale {} px: scale must be from 0.001 to 10000, origin within ±{LARGEST_ORIGIN} pixels and samples (origin / scale)",
                    map.origin, map.scale
                ));
            }
        }
        Map::LogPolar(map) if map.gaze_px().abs().max_element() > LARGEST_FROM_AXIS_PX => {
            let gaze = map.gaze_px();
            return Err(format!(
                "its gaze is at {gaze}: within ±{LARGEST_FROM_AXIS_PX} pixels, or single precision cannot look pixels up"
            ));
        }
        Map::LogPolar(_) | Map::LensMatched(_) | Map::Radial(_) => {}
        other => return Err(format!("cannot draw a map of kind {other:?}")),
    }
    let grid = live::grid(pass);
    match &pass.shading {
        Shading::Nowhere | Shading::PerSample => {}
        Shading::Coarse(_) if !matches!(pass.map, Map::Affine(_)) => {
            return Err("its samples do not lie evenly: each must be shaded by itself".into());
        }
        Shading::Coarse(rates) if rates.lattice() == grid => {}
        Shading::Coarse(rates) => {
            let other = rates.lattice();
            return Err(format!(
                "its shading rates are for {other} samples, not for {grid}"
            ));
        }
        other => return Err(format!("cannot shade by {other:?}")),
    }
    match &pass.region {
        Region::All => {}
        Region::Cells(mask) if mask.lattice() == grid => {}
        Region::Cells(mask) => {
            let other = mask.lattice();
            return Err(format!("its region is for {other} samples, not for {grid}"));
        }
        Region::Spans(spans) if spans.lattice() == grid => {}
        Region::Spans(spans) => {
            let other = spans.lattice();
            return Err(format!("its region is for {other} samples, not for {grid}"));
        }
        other => return Err(format!("cannot draw a region of kind {other:?}")),
    }
    if !(pass.offset.is_finite() && pass.offset.abs().max_element() <= 0.5) {
        let offset = pass.offset;
        return Err(format!(
            "its samples are shifted by {offset} of a step: at most half a step"
        ));
    }
    Ok(())
}

/// Passes that share visibility: with one that finds it for each pixel, in the same frames, while they are
/// not affine themselves; and passes that are not shaded but for others.
fn check_sharing(plan: &SamplePlan, index: usize) -> Result<(), String> {
    let pass = &plan.passes[index];
    match pass.visibility {
        Visibility::Own(_) => {}
        Visibility::Shared(other) if other >= index => {
            return Err(format!(
                "it shares the visibility of pass {other}: only an earlier one has it"
            ));
        }
        Visibility::Shared(other) => {
            let found = &plan.passes[other];
            let fits = matches!(found.visibility, Visibility::Own(_))
                && found.shading == Shading::Nowhere
                && found.region == Region::All
                && found.cadence == pass.cadence
                && live::grid(found) == plan.display_px
                && found.map == Map::Affine(Affine::IDENTITY);
            if !fits || matches!(pass.map, Map::Affine(_)) {
                return Err(format!(
                    "to share the visibility of pass {other}, that one must find it for each display pixel, in the same frames and without shading, and this one must not lie evenly"
                ));
            }
        }
        other => return Err(format!("cannot find visibility by {other:?}")),
    }
    let shared = |p: &Pass| p.visibility == Visibility::Shared(index);
    if pass.shading == Shading::Nowhere && !plan.passes.iter().any(shared) {
        return Err("it is not shaded, and no other pass shares its visibility".into());
    }
    Ok(())
}

fn check_resolve(plan: &SamplePlan) -> Result<(), String> {
    let passes = plan.passes.len();
    let evenly =
        |p: &Pass| matches!((&p.map, &p.shading), (Map::Affine(_), s) if *s != Shading::Nowhere);
    if !matches!(plan.resolve, Resolve::Inverse(_)) && !plan.passes.iter().all(evenly) {
        return Err(
            "passes that do not lie evenly, or are not shaded, need the inverse of a map".into(),
        );
    }
    match &plan.resolve {
        Resolve::Direct => {
            let whole = |p: &Pass| {
                p.lattice == Lattice::Grid(plan.display_px)
                    && p.map == Map::Affine(Affine::IDENTITY)
            };
            match plan.passes.as_slice() {
                [only] if whole(only) => Ok(()),
                _ => Err("it needs exactly one pass that samples each pixel once".into()),
            }
        }
        Resolve::Feather(f) => {
            if f.edges_tan.len() + 1 != passes {
                let n = f.edges_tan.len();
                return Err(format!(
                    "{passes} passes need {} edges, not {n}",
                    passes.max(1) - 1
                ));
            }
            if !is_unit(f.gaze.length()) {
                return Err(format!("gaze {} is not a unit vector", f.gaze));
            }
            // Infinite edges (90° and more) are fine; NaN or reversed ones are not.
            if let Some(e) = f.edges_tan.iter().find(|[a, b]| !(0.0 <= *a && a <= b)) {
                return Err(format!("edge {e:?} must be two tangents, 0 ≤ start ≤ end"));
            }
            match plan.passes.last().map(|p| p.lattice) {
                Some(Lattice::Grid(UVec2 { x: 1.., y: 1.. })) => Ok(()),
                _ => Err("the outermost pass has no samples".into()),
            }
        }
        // Pixels that no pass has would be black.
        Resolve::Mosaic => match mosaic::uncovered(plan) {
            None => Ok(()),
            Some(px) => Err(format!("no pass has a live sample at pixel {px}")),
        },
        Resolve::Inverse(filter)
            if filter.interpolation == Interpolation::Gather
                && (filter.mips || filter.smooth_from.is_some()) =>
        {
            Err("gathering reads samples as they are: neither mips nor smoothed ones".into())
        }
        Resolve::Inverse(_) => match plan.passes.last() {
            Some(last) if last.shading == Shading::Nowhere => {
                Err("its last pass is not shaded".into())
            }
            Some(last) if last.live() > 0 => Ok(()),
            _ => Err("its last pass has no samples".into()),
        },
        other => Err(format!("cannot resolve by {other:?}")),
    }
}
