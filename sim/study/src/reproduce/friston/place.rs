use foveasim_assets::{GeneratedScene, Scene};
use foveasim_models::foveation::{Method, Request};
use foveasim_models::{Acuity, Eye, Image, ModelError, SamplePlan, View, Viewport};
use foveasim_quality::compare;
use foveasim_render::{RenderOptions, render};
use glam::{DVec2, UVec2};

use super::{FOVEA_PX, Family, Friston2019, ReproduceError};
use crate::kernel::one_colour;
use crate::supersample::{mean, supersampled};

/// A scene as it is looked at, and how its fovea should look.
#[derive(Debug)]
pub(super) struct Place {
    pub(super) scene: GeneratedScene,
    pub(super) world: Scene,
    /// The same with nothing to shade.
    pub(super) bare: Scene,
    pub(super) view: View,
    pub(super) request: Request,
    /// Upper left pixel of the fovea.
    fovea: UVec2,
    /// The fovea at many samples to the pixel.
    reference: Image,
}

/// Samples along a side of the image that a moving view's fovea is cut out of.
const MOST_SIDE: u32 = 4096;
/// Tangent of half the field of view.
const HALF_WIDTH_TAN: f64 = 1.0;
/// How far along its way the camera stands.
const ALONG: f64 = 0.1;

/// Where the eye looks, as shares of the image: at strands, blades, slats and objects.
fn gaze(scene: GeneratedScene) -> DVec2 {
    match scene {
        GeneratedScene::Room { .. } => DVec2::new(0.62, 0.56),
        GeneratedScene::Machine { .. } => DVec2::new(0.58, 0.42),
        _ => DVec2::new(0.5, 0.5),
    }
}

impl Place {
    pub(super) fn new(scene: GeneratedScene, asked: &Friston2019) -> Result<Self, ReproduceError> {
        let size = asked.size;
        let viewport = Viewport::symmetric(size, HALF_WIDTH_TAN)?;
        let centre = (gaze(scene) * size.as_dvec2()).round();
        let direction = viewport.gaze_at(centre);
        let request = Request {
            eye: Eye::Cyclopean,
            viewport,
            acuity: Acuity::default(),
            gaze: direction,
            ahead: viewport.gaze_at(viewport.centre_px()),
            margin_deg: 0.0,
        };
        let eye = scene.camera(ALONG, asked.seed);
        let view = View::still(Eye::Cyclopean, viewport, eye);
        let first = (centre - f64::from(FOVEA_PX) / 2.0).max(DVec2::ZERO);
        let fovea = first.as_uvec2().min(size - FOVEA_PX);
        let world = scene.build(asked.seed);
        let Ok(bare) = one_colour(&world) else {
            unreachable!("the parts of a scene make one")
        };
        let mut place = Self {
            scene,
            world,
            bare,
            view,
            request,
            fovea,
            reference: Image::filled(UVec2::ZERO, [0.0; 3]),
        };
        place.reference = place.foveal(asked.reference_samples)?;
        Ok(place)
    }

    /// The fovea at `n` × `n` samples to the pixel.
    fn foveal(&self, n: u32) -> Result<Image, ReproduceError> {
        let optics = self.view.part(self.fovea, UVec2::splat(FOVEA_PX), 1).optics;
        let part = View {
            optics,
            ..self.view
        };
        let options = RenderOptions::default();
        Ok(supersampled(&self.world, &part, n, &options)?)
    }

    /// The fovea of a view that moves at up to `n` × `n` samples to the pixel: as many as an image of all of it may
    /// have.
    pub(super) fn foveal_rolling(
        &self,
        world: &Scene,
        view: &View,
        n: u32,
    ) -> Result<Image, ReproduceError> {
        let size = view.optics.size;
        let n = n.min(MOST_SIDE / size.max_element()).max(1);
        let fine = View {
            optics: Viewport::new(size * n, view.optics.tan)?,
            ..*view
        };
        let plan = SamplePlan::full(view.eye, size * n);
        let samples = render(world, &fine, &plan, &RenderOptions::default())?.image;
        let mut fovea = Image::filled(UVec2::splat(FOVEA_PX), [0.0; 3]);
        for (k, rgb) in fovea.rgb.iter_mut().enumerate() {
            let px = UVec2::new(k as u32 % FOVEA_PX, k as u32 / FOVEA_PX);
            *rgb = mean(&samples, (self.fovea + px) * n, n);
        }
        Ok(fovea)
    }

    /// SSIM of an image's fovea.
    pub(super) fn likeness(&self, image: &Image) -> Result<f64, ReproduceError> {
        Ok(compare(&self.fovea_of(image), &self.reference)?.whole.ssim)
    }

    /// Where the eye looks \[px\].
    pub(super) fn gaze_px(&self) -> DVec2 {
        (gaze(self.scene) * self.view.optics.size.as_dvec2()).round()
    }

    /// The fovea of an image.
    pub(super) fn fovea_of(&self, image: &Image) -> Image {
        let mut fovea = Image::filled(UVec2::splat(FOVEA_PX), [0.0; 3]);
        for (k, rgb) in fovea.rgb.iter_mut().enumerate() {
            let k = k as u32;
            *rgb = image.at(self.fovea.x + k % FOVEA_PX, self.fovea.y + k / FOVEA_PX);
        }
        fovea
    }

    pub(super) fn plan(&self, method: Method) -> Result<SamplePlan, ModelError> {
        method.plan(&self.request)
    }

    /// The method of a family and strength whose last pass has as many samples as there are pixels.
    pub(super) fn as_many_samples(
        &self,
        family: Family,
        strength: f64,
    ) -> Result<Method, ModelError> {
        let make = |scale: f64| family.method(strength, scale);
        let pixels = u64::from(self.view.optics.size.element_product());
        let [mut low, mut high] = family.scales();
        // Samples grow with the scale. Steps are of a thousandth, so that the method's name stays short.
        while high - low > 1e-3 {
            let middle = (low + high) / 2.0;
            let plan = self.plan(make(middle)?)?;
            let samples = plan.passes.last().map_or(0, |pass| pass.live());
            if samples < pixels {
                low = middle;
            } else {
                high = middle;
            }
        }
        make((low * 1e3).round() / 1e3)
    }
}
