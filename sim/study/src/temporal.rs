use std::ops::Range;

use foveasim_models::math::mean;
use foveasim_models::{Image, Viewport};
use foveasim_quality::{
    Flicker, FlickerMap, FollowedFlicker, FollowedMap, Measures, QualityError, RingFlicker,
    RingQuality, Rings, compare,
};
use foveasim_reports::{Cell, LineChart, LineSeries, Table};
use glam::{DVec2, DVec3};

/// A source of consecutive frames: asked for one frame after the other, in order.
pub type FrameSource<'a, E> = Box<dyn FnMut(u64) -> Result<Image, E> + 'a>;

/// Tells where in a frame the points are seen that are followed, as [`Tracks`](crate::Tracks) does: one
/// for each pixel of the frame in the middle of those that are judged \[px\], `None` where it is not seen.
pub type PlaceSource<'a, E> = dyn FnMut(u64) -> Result<Vec<Option<DVec2>>, E> + 'a;

/// Consecutive frames of one view, by any number of ways to draw them, judged against a reference
/// sequence: how like it each frame is, and how much of the difference flickers.
#[derive(Debug, Clone)]
pub struct TemporalStudy {
    /// The image plane of every frame.
    pub viewport: Viewport,
    /// Where the eye looks, eye frame: what rings are centred on in all frames.
    pub gaze: DVec3,
    /// Rings of eccentricity.
    pub rings: Rings,
    /// Frames that are judged.
    pub frames: Range<u64>,
    /// Frames drawn before those without being judged, so that there is a history.
    pub warm_up: u64,
}

/// One way to draw the frames.
#[derive(Debug, Clone, PartialEq)]
pub struct TemporalQuality {
    /// Its name.
    pub name: String,
    /// Mean SSIM of the frames.
    pub ssim: f64,
    /// Mean over the frames of their mean squared error of luma, as PSNR \[dB\].
    pub psnr_db: f64,
    /// Flicker of every pixel.
    pub flicker: FlickerMap,
    /// Flicker of what the pixels of the middle frame show, followed along its motion.
    pub followed: FollowedMap,
    /// By ring.
    pub rings: Vec<TemporalRing>,
}

/// One ring of one way to draw the frames.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TemporalRing {
    /// Its flicker.
    pub flicker: RingFlicker,
    /// Mean flicker of what is followed \[grey levels\]; `None` if nothing is.
    pub followed: Option<f64>,
    /// Mean SSIM of the frames there; `None` if no pixel lies in it.
    pub ssim: Option<f64>,
}

/// What is gathered of one source.
struct Gathered {
    flicker: Flicker,
    followed: FollowedFlicker,
    measures: Vec<Measures>,
    rings: Vec<Vec<RingQuality>>,
}

impl TemporalStudy {
    /// Judges every source. The reference and the places are asked for each judged frame once; a source
    /// is asked for `warm_up` frames more before them. `done` hears of each judged frame.
    ///
    /// # Errors
    /// Those of the sources; also if an image does not have the viewport's pixels, or there are no
    /// frames.
    pub fn run<E: From<QualityError>>(
        &self,
        reference: &mut dyn FnMut(u64) -> Result<Image, E>,
        places: &mut PlaceSource<'_, E>,
        sources: &mut [(String, FrameSource<'_, E>)],
        done: &mut dyn FnMut(),
    ) -> Result<Vec<TemporalQuality>, E> {
        for (_, source) in sources.iter_mut() {
            for frame in self.frames.start.saturating_sub(self.warm_up)..self.frames.start {
                source(frame)?;
            }
        }
        let start = |_: &(String, _)| {
            Ok(Gathered {
                flicker: Flicker::new(self.viewport.size)?,
                followed: FollowedFlicker::new(self.viewport.size)?,
                measures: Vec::new(),
                rings: Vec::new(),
            })
        };
        let mut all: Vec<Gathered> = sources.iter().map(start).collect::<Result<_, E>>()?;
        for frame in self.frames.clone() {
            let truth = reference(frame)?;
            let places = places(frame)?;
            for ((_, source), gathered) in sources.iter_mut().zip(&mut all) {
                let comparison = compare(&source(frame)?, &truth)?;
                let rings = comparison.rings(&self.viewport, self.gaze, &self.rings)?;
                gathered.rings.push(rings);
                gathered
                    .flicker
                    .push(&comparison.image, &comparison.reference)?;
                gathered
                    .followed
                    .push(&comparison.image, &comparison.reference, &places)?;
                gathered.measures.push(comparison.whole);
            }
            done();
        }
        let names = sources.iter().map(|(name, _)| name.clone());
        let found = names.zip(all).map(|(name, g)| Ok(self.judge(name, g)?));
        found.collect()
    }

    fn judge(&self, name: String, gathered: Gathered) -> Result<TemporalQuality, QualityError> {
        let flicker = gathered.flicker.finish()?;
        let rings = flicker.rings(&self.viewport, self.gaze, &self.rings)?;
        let followed = gathered.followed.finish()?;
        let followed_rings = followed.rings(&self.viewport, self.gaze, &self.rings)?;
        let ring = |(k, flicker): (usize, RingFlicker)| {
            let frames = gathered.rings.iter().filter_map(|rings| rings[k].ssim);
            let ssim: Vec<f64> = frames.collect();
            let ssim = (!ssim.is_empty()).then(|| mean(&ssim));
            TemporalRing {
                flicker,
                followed: followed_rings[k],
                ssim,
            }
        };
        let of = |f: fn(&Measures) -> f64| {
            let values: Vec<f64> = gathered.measures.iter().map(f).collect();
            mean(&values)
        };
        Ok(TemporalQuality {
            name,
            ssim: of(|m| m.ssim),
            psnr_db: foveasim_quality::psnr_db(of(|m| m.mse_luma)),
            rings: rings.into_iter().enumerate().map(ring).collect(),
            flicker,
            followed,
        })
    }
}

impl TemporalQuality {
    /// For each way one row for the whole image, then one per ring of eccentricity.
    pub fn table(all: &[Self]) -> Table {
        let mut table = Table::new([
            "antialiasing",
            "from_deg",
            "to_deg",
            "pixels",
            "followed_flicker_grey_levels",
            "flicker_grey_levels",
            "flicker_p99_grey_levels",
            "excess_change_grey_levels",
            "ssim",
            "psnr_luma_db",
        ]);
        for q in all {
            table.push(vec![
                q.name.as_str().into(),
                Cell::Empty,
                Cell::Empty,
                q.flicker.flicker.values().len().into(),
                q.followed.mean.into(),
                q.flicker.mean.into(),
                q.flicker.p99.into(),
                q.flicker.mean_excess_change.into(),
                q.ssim.into(),
                q.psnr_db.into(),
            ]);
            for ring in &q.rings {
                let f = &ring.flicker;
                table.push(vec![
                    q.name.as_str().into(),
                    f.from_deg.into(),
                    f.to_deg.into(),
                    f.pixels.into(),
                    ring.followed.into(),
                    f.mean.into(),
                    f.p99.into(),
                    f.excess_change.into(),
                    ring.ssim.into(),
                    Cell::Empty,
                ]);
            }
        }
        table
    }

    /// Flicker along the motion, at each pixel, and SSIM, over eccentricity: one point for each ring that has pixels, at its middle
    /// (the open one's at its inner edge).
    pub fn charts(all: &[Self]) -> [LineChart; 3] {
        let chart = |title: &str, y_label: &str, value: fn(&TemporalRing) -> Option<f64>| {
            let series = all.iter().map(|q| LineSeries {
                label: q.name.clone(),
                points: q
                    .rings
                    .iter()
                    .filter_map(|r| Some([middle(&r.flicker), value(r)?]))
                    .collect(),
            });
            LineChart {
                title: title.into(),
                x_label: "eccentricity [deg]".into(),
                y_label: y_label.into(),
                series: series.collect(),
                ..LineChart::default()
            }
        };
        [
            chart(
                "Flicker along the motion, by eccentricity",
                "grey levels of 255",
                |r| r.followed,
            ),
            chart(
                "Change of each pixel's error, by eccentricity",
                "grey levels of 255",
                |r| r.flicker.mean,
            ),
            chart("Likeness by eccentricity", "SSIM", |r| r.ssim),
        ]
    }
}

fn middle(ring: &RingFlicker) -> f64 {
    ring.to_deg
        .map_or(ring.from_deg, |to| (ring.from_deg + to) / 2.0)
}

#[cfg(test)]
mod tests {
    use foveasim_models::linear_from_srgb;
    use glam::UVec2;

    use super::*;

    const SIZE: UVec2 = UVec2::new(48, 32);

    /// A picture of grey levels by pixel and frame.
    fn picture(level: impl Fn(u32, u32) -> f64) -> Image {
        let mut image = Image::filled(SIZE, [0.0; 3]);
        for y in 0..SIZE.y {
            for x in 0..SIZE.x {
                let light = linear_from_srgb(level(x, y) / 255.0) as f32;
                image.rgb[(y * SIZE.x + x) as usize] = [light; 3];
            }
        }
        image
    }

    fn study() -> TemporalStudy {
        TemporalStudy {
            viewport: Viewport::symmetric(SIZE, 0.4).unwrap(),
            gaze: DVec3::NEG_Z,
            rings: Rings::new(vec![0.0, 8.0, 16.0]).unwrap(),
            frames: 10..18,
            warm_up: 3,
        }
    }

    /// Nothing moves.
    fn in_place(_: u64) -> Result<Vec<Option<DVec2>>, QualityError> {
        let px = |i: u32| DVec2::new(f64::from(i % SIZE.x) + 0.5, f64::from(i / SIZE.x) + 0.5);
        Ok((0..SIZE.x * SIZE.y).map(|i| Some(px(i))).collect())
    }

    type Source<'a> = (String, FrameSource<'a, QualityError>);

    #[test]
    fn flicker_is_found_where_it_is() {
        let stripes = |x: u32, frame: u64| 100.0 + 20.0 * f64::from((x + frame as u32) % 3);
        let mut asked = Vec::new();
        let same: Source<'_> = (
            "same".into(),
            Box::new(|k| {
                asked.push(k);
                Ok(picture(|x, _| stripes(x, k)))
            }),
        );
        // From 16° on to the sides, ±6 levels in turn.
        let edge = |x: u32| (f64::from(x) + 0.5 - 24.0).abs() > 20.0;
        let flickers: Source<'_> = (
            "flickers".into(),
            Box::new(move |k| {
                let sign = if k % 2 == 0 { 6.0 } else { -6.0 };
                Ok(picture(|x, _| {
                    stripes(x, k) + if edge(x) { sign } else { 0.0 }
                }))
            }),
        );
        let mut judged = 0;
        let mut sources = [same, flickers];
        let mut reference = |k| Ok(picture(|x, _| stripes(x, k)));
        let found = study()
            .run(&mut reference, &mut in_place, &mut sources, &mut || {
                judged += 1
            })
            .unwrap();
        drop(sources);
        assert_eq!(asked, (7..18).collect::<Vec<u64>>());
        assert_eq!(judged, 8);
        let [same, flickers] = found.as_slice() else {
            panic!("two sources")
        };
        assert_eq!((same.flicker.mean, same.ssim), (0.0, 1.0));
        assert_eq!(same.followed.mean, Some(0.0));
        let ring = |k: usize| flickers.rings[k].flicker.mean.unwrap();
        let followed = |k: usize| flickers.rings[k].followed.unwrap();
        assert!(
            followed(0) == 0.0 && followed(2) > 2.0,
            "{:?}",
            flickers.rings
        );
        assert!(ring(0) == 0.0 && ring(2) > 2.0, "{:?}", flickers.rings);
        assert!((flickers.flicker.p99 - 6.0).abs() < 1e-9);
        assert!(flickers.ssim < 1.0 && flickers.rings[0].ssim > flickers.rings[2].ssim);
        let table = TemporalQuality::table(&found);
        assert_eq!(table.rows().len(), 2 * (1 + 3));
        assert!(TemporalQuality::charts(&found)[0].svg().contains("Flicker"));
    }

    #[test]
    fn errors_are_passed_on() {
        let mut none: [Source<'_>; 0] = [];
        let mut reference = |_| Err(QualityError::NoFrames);
        let failed = study().run(&mut reference, &mut in_place, &mut none, &mut || ());
        assert_eq!(failed, Err(QualityError::NoFrames));
        let small: Source<'_> = (
            "small".into(),
            Box::new(|_| Ok(Image::filled(UVec2::new(20, 20), [0.5; 3]))),
        );
        let mut reference = |_| Ok(picture(|_, _| 9.0));
        assert!(
            study()
                .run(&mut reference, &mut in_place, &mut [small], &mut || ())
                .is_err()
        );
    }
}
