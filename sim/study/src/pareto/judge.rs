use foveasim_models::foveation::Method;
use foveasim_models::math::mean;
use foveasim_models::{Msaa, SamplePlan};
use foveasim_quality::{Flicker, FollowedFlicker, RingQuality, compare, psnr_db};
use foveasim_render::{Frame, Sequence, render};

use super::row::{Errors, ParetoRing};
use super::{Clip, ClipFrame, Pareto, ShowPair};
use crate::supersample::supersampled_frame;
use crate::{FrameError, Tracks};

/// What is gathered of one method on one clip.
struct Gathered {
    sequence: Sequence,
    flicker: Flicker,
    followed: FollowedFlicker,
    ssim: Vec<f64>,
    mse: Vec<f64>,
    bias: Vec<f64>,
    rings: Vec<Vec<RingQuality>>,
}

impl Pareto<'_> {
    /// Errors of each method on a clip.
    pub(super) fn judge<E: From<FrameError>>(
        &self,
        clip: &Clip<'_>,
        methods: &[Method],
        show: &mut ShowPair<'_, E>,
        done: &mut dyn FnMut(),
    ) -> Result<Vec<Errors>, E> {
        let size = self.request.viewport.size;
        let start = |_: &Method| -> Result<Gathered, FrameError> {
            Ok(Gathered {
                sequence: Sequence::new(self.drawing.temporal),
                flicker: Flicker::new(size)?,
                followed: FollowedFlicker::new(size)?,
                ssim: Vec::new(),
                mse: Vec::new(),
                bias: Vec::new(),
                rings: Vec::new(),
            })
        };
        let gathered: Result<Vec<Gathered>, FrameError> = methods.iter().map(start).collect();
        let mut all = gathered?;
        let judged = self.judged(clip);
        let tracks = match judged.get(judged.len() / 2) {
            Some(middle) if judged.len() > 1 => Some(self.tracks(middle)?),
            _ => None,
        };
        for (number, (k, frame)) in (clip.first_frame..).zip(clip.frames.iter().enumerate()) {
            let view = self.view(&frame.sight)?;
            let scene = frame.sight.scene;
            let counts = k.checked_sub(self.warm_up);
            let reference = match counts {
                Some(_) => Some(self.reference(frame)?),
                None => None,
            };
            let places = match (&tracks, counts) {
                (Some(tracks), Some(_)) => {
                    Some(tracks.places(scene, &view).map_err(FrameError::from)?)
                }
                _ => None,
            };
            for (&method, g) in methods.iter().zip(&mut all) {
                let plan = self.plan(method, frame)?;
                let options = &self.drawing.options;
                let drawn = g.sequence.draw(scene, &view, &plan, number, options);
                let drawn = drawn.map_err(FrameError::from)?;
                if let (Some(reference), Some(judged)) = (&reference, counts) {
                    self.add(g, frame, &drawn, reference, places.as_deref())?;
                    show(clip, method, judged, &drawn, reference)?;
                }
            }
            done();
        }
        let found: Result<Vec<Errors>, FrameError> =
            all.into_iter().map(|g| self.finish(g)).collect();
        Ok(found?)
    }

    fn tracks(&self, frame: &ClipFrame<'_>) -> Result<Tracks, FrameError> {
        let view = self.view(&frame.sight)?;
        Ok(Tracks::new(
            frame.sight.scene,
            &view,
            &self.drawing.options,
        )?)
    }

    fn reference(&self, frame: &ClipFrame<'_>) -> Result<Frame, FrameError> {
        let (scene, view) = (frame.sight.scene, self.view(&frame.sight)?);
        let options = &self.drawing.options;
        Ok(match self.drawing.reference_samples {
            1 => {
                let plan = SamplePlan::full(self.request.eye, self.request.viewport.size);
                render(scene, &view, &plan.with_msaa(Msaa::One), options)?
            }
            n => supersampled_frame(scene, &view, n, options)?,
        })
    }

    fn add(
        &self,
        g: &mut Gathered,
        frame: &ClipFrame<'_>,
        drawn: &Frame,
        reference: &Frame,
        places: Option<&[Option<glam::DVec2>]>,
    ) -> Result<(), FrameError> {
        let comparison = compare(&drawn.image, &reference.image)?;
        let gaze = frame.gaze.vector();
        g.rings
            .push(comparison.rings(&self.request.viewport, gaze, &self.rings)?);
        g.ssim.push(comparison.whole.ssim);
        g.mse.push(comparison.whole.mse_luma);
        g.bias.push(comparison.whole.bias);
        let (image, reference) = (&comparison.image, &comparison.reference);
        g.flicker.push(image, reference)?;
        if let Some(places) = places {
            g.followed.push(image, reference, places)?;
        }
        Ok(())
    }

    fn finish(&self, g: Gathered) -> Result<Errors, FrameError> {
        // One frame by itself does not flicker, nor is known to rest.
        let many = g.ssim.len() > 1;
        let edges = self.rings.edges_deg();
        let ring = |k: usize| {
            let frames = g.rings.iter().map(|rings| &rings[k]);
            let pixels: u64 = frames.clone().map(|r| r.pixels).sum();
            let weighted = |value: &dyn Fn(&RingQuality) -> Option<f64>| {
                let sum = frames.clone().fold(0.0, |sum, r| {
                    sum + value(r).map_or(0.0, |v| v * r.pixels as f64)
                });
                (pixels > 0).then(|| sum / pixels as f64)
            };
            // PSNR is of a mean: of squared errors over all frames.
            let mse = weighted(&|r| r.psnr_db.map(mse_of));
            ParetoRing {
                from_deg: edges[k],
                to_deg: edges.get(k + 1).copied(),
                pixels,
                ssim: weighted(&|r| r.ssim),
                mse,
                bias: weighted(&|r| r.bias),
            }
        };
        let flicker = g.flicker.finish()?;
        Ok(Errors {
            ssim: mean(&g.ssim),
            mse: mean(&g.mse),
            bias: mean(&g.bias),
            flicker: many.then_some(flicker.mean),
            followed: match many {
                true => g.followed.finish()?.mean,
                false => None,
            },
            rings: (0..edges.len()).map(ring).collect(),
        })
    }
}

/// The mean squared error that has this PSNR.
fn mse_of(psnr: f64) -> f64 {
    use foveasim_models::math::pow;
    use foveasim_quality::PEAK;
    debug_assert!(psnr_db(PEAK * PEAK).abs() < 1e-9);
    PEAK * PEAK / pow(10.0, psnr / 10.0)
}
