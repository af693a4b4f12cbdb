use foveasim_assets::study_scene;
use foveasim_models::foveation::{
    KernelSearch, KernelSettings, LensMatchedSettings, Method, Request,
};
use foveasim_models::math::{log10, pow};
use foveasim_models::{Acuity, Affine, Feather, Lattice, Map, ModelError, Resolve, SamplePlan};
use foveasim_quality::{Rings, compare};
use foveasim_render::{RenderOptions, render};
use foveasim_reports::{LineChart, LineSeries, Table};
use glam::UVec2;

use super::pair::Pair;
use crate::reproduce::{ReproduceError, check, stepper};
use crate::supersampled;

/// Compares methods that shade as often as one another with a supersampled reference, ring by ring: the left
/// eye's image on the study scene.
///
/// How often three layers shade at the slope of quality A is what all others are brought to: kernels by σ,
/// lens-matched shading by equal coefficients, and an even grid by its distance. Variable-rate shading has no
/// such number: it shades as its acuity line asks. Full resolution stands beside them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct KernelErrors {
    /// Pixels of the image.
    pub size: UVec2,
    /// Moments of the flight.
    pub moments: u32,
    /// Samples along each side of a pixel of the reference.
    pub reference_samples: u32,
    /// Of the scene.
    pub seed: u64,
}

/// How far one method is off.
#[derive(Debug, Clone, PartialEq)]
pub struct KernelErrorRow {
    /// What it is, as a person would say.
    pub label: String,
    /// The method with its settings at the last moment.
    pub method: String,
    /// Evaluations of shading, mean over the moments.
    pub shadings: f64,
    /// Over the whole image: PSNR of luma \[dB\] (of the mean squared error over the moments), SSIM.
    pub whole: [f64; 2],
    /// The same by ring of eccentricity.
    pub rings: Vec<KernelRing>,
}

/// How far a method is off in a ring.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KernelRing {
    /// Inner edge \[deg\].
    pub from_deg: f64,
    /// Outer edge \[deg\]; `None` for the last, which is open.
    pub to_deg: Option<f64>,
    /// PSNR of luma \[dB\].
    pub psnr_db: f64,
    /// Mean SSIM.
    pub ssim: f64,
}

/// Edges of the rings \[deg\].
const EDGES_DEG: [f64; 7] = [0.0, 2.0, 5.0, 10.0, 20.0, 30.0, 40.0];

/// The ways compared.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Way {
    /// A kernel of an exponent, or of the best one for the acuity line; samples of a pixel averaged or not.
    Kernel {
        alpha: Option<f64>,
        mips: bool,
    },
    Method(&'static str),
    Lens,
    /// A grid as coarse everywhere.
    Even,
}

const WAYS: [(&str, Way); 10] = [
    ("full", Way::Method("full")),
    ("layers", Way::Method("layers:3")),
    ("kernel, α = 4", Way::kernel(4.0, false)),
    ("kernel, α = 4, averaged", Way::kernel(4.0, true)),
    ("kernel, α = 1", Way::kernel(1.0, false)),
    ("kernel, α = ¼", Way::kernel(0.25, false)),
    (
        "kernel, best α",
        Way::Kernel {
            alpha: None,
            mips: false,
        },
    ),
    ("lens-matched", Way::Lens),
    ("variable rate", Way::Method("vrs")),
    ("even grid", Way::Even),
];

impl Way {
    const fn kernel(alpha: f64, mips: bool) -> Self {
        Self::Kernel {
            alpha: Some(alpha),
            mips,
        }
    }

    /// The plan that shades about `wanted` times.
    fn plan(self, request: &Request, wanted: u64) -> Result<SamplePlan, ModelError> {
        match self {
            Self::Method(name) => name.parse::<Method>()?.plan(request),
            Self::Kernel { alpha, mips } => {
                let alpha = match alpha {
                    Some(alpha) => alpha,
                    None => {
                        let found = KernelSearch::new(std::slice::from_ref(request))?.best();
                        found.map_or(1.0, |found| found.settings.alpha())
                    }
                };
                nearest(wanted, [0.5, 30.0], |sigma| {
                    let mut settings = KernelSettings::new(sigma, alpha)?;
                    settings.mips = mips;
                    Method::Kfr(settings).plan(request)
                })
            }
            Self::Lens => nearest(wanted, [0.0, 20.0], |growth| {
                Method::Lms(LensMatchedSettings::new(growth, growth)?).plan(request)
            }),
            Self::Even => nearest(wanted, [1.0, 30.0], |step| Ok(even(request, step))),
        }
    }
}

/// A grid of samples `step` pixels apart.
fn even(request: &Request, step: f64) -> SamplePlan {
    let size = request.viewport.size;
    let fewer = (size.as_dvec2() / step).ceil();
    let mut plan = SamplePlan::full(request.eye, size);
    plan.method = format!("full at 1/{step:.3}");
    plan.passes[0].lattice = Lattice::Grid(fewer.as_uvec2());
    plan.passes[0].map = Map::Affine(Affine {
        scale: size.as_dvec2() / fewer,
        ..Affine::IDENTITY
    });
    plan.resolve = Resolve::Feather(Feather {
        gaze: request.gaze.vector(),
        edges_tan: Vec::new(),
    });
    plan
}

/// The plan of a family that shades nearest to `wanted` times; it shades less as its number grows.
fn nearest(
    wanted: u64,
    [mut low, mut high]: [f64; 2],
    plan: impl Fn(f64) -> Result<SamplePlan, ModelError>,
) -> Result<SamplePlan, ModelError> {
    for _ in 0..30 {
        let middle = (low + high) / 2.0;
        if plan(middle)?.count().shadings() > wanted {
            low = middle;
        } else {
            high = middle;
        }
    }
    // Four decimals are what a person would write.
    plan((high * 1e4).round() / 1e4)
}

/// Sums over moments.
#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    weight: f64,
    squares: f64,
    ssim: f64,
}

impl Sums {
    fn add(&mut self, weight: f64, psnr_db: f64, ssim: f64) {
        self.weight += weight;
        // Infinite where images are equal: no error.
        self.squares += weight * 255.0 * 255.0 * pow(10.0, -psnr_db / 10.0);
        self.ssim += weight * ssim;
    }

    fn psnr_db(self) -> f64 {
        10.0 * log10(255.0 * 255.0 * self.weight / self.squares)
    }

    fn ssim(self) -> f64 {
        self.ssim / self.weight
    }
}

impl KernelErrors {
    /// One moment of a small image: what a test can wait for.
    pub fn quick() -> Self {
        Self {
            size: UVec2::new(160, 180),
            moments: 1,
            reference_samples: 4,
            seed: 1,
        }
    }

    /// Draws and compares. `progress` hears how far it is.
    ///
    /// # Errors
    /// If there are no moments or too many, or an image cannot be drawn or compared.
    pub fn run(&self, progress: &dyn Fn(&str, f64)) -> Result<Vec<KernelErrorRow>, ReproduceError> {
        check("moments", self.moments, 1..=1000, "from 1 to 1000")?;
        let scene = study_scene(self.seed);
        let rings = Rings::new(EDGES_DEG.to_vec())?;
        let options = RenderOptions::default();
        let steps = f64::from(self.moments) * (WAYS.len() + 1) as f64;
        let mut step = stepper(progress, "errors of kernels", [0.0, 1.0], steps);
        let none = (String::new(), 0.0, [Sums::default(); EDGES_DEG.len() + 1]);
        let mut sums = vec![none; WAYS.len()];
        for moment in 0..self.moments {
            let pair = Pair::new(self.size, moment, self.moments, self.seed)?;
            let view = &pair.views[0];
            let request = pair.request(0, Acuity::default());
            let reference = supersampled(&scene, view, self.reference_samples, &options)?;
            step();
            let layers = "layers:3".parse::<Method>()?.plan(&request)?;
            let wanted = layers.count().shadings();
            for ((_, way), (method, shadings, sums)) in WAYS.iter().zip(&mut sums) {
                let plan = way.plan(&request, wanted)?;
                let frame = render(&scene, view, &plan, &options)?;
                let compared = compare(&frame.image, &reference)?;
                let of_rings = compared.rings(&view.optics, request.gaze.vector(), &rings)?;
                method.clone_from(&plan.method);
                *shadings += plan.count().shadings() as f64 / f64::from(self.moments);
                sums[0].add(1.0, compared.whole.psnr_luma_db, compared.whole.ssim);
                for (sum, ring) in sums[1..].iter_mut().zip(&of_rings) {
                    if let (Some(psnr), Some(ssim)) = (ring.psnr_db, ring.ssim) {
                        sum.add(ring.pixels as f64, psnr, ssim);
                    }
                }
                step();
            }
        }
        let rows = WAYS.iter().zip(sums);
        let rows = rows.map(|((label, _), (method, shadings, sums))| {
            let [whole, of_rings @ ..] = sums;
            let ring = |(k, sum): (usize, Sums)| KernelRing {
                from_deg: EDGES_DEG[k],
                to_deg: EDGES_DEG.get(k + 1).copied(),
                psnr_db: sum.psnr_db(),
                ssim: sum.ssim(),
            };
            let of_rings = of_rings.into_iter().enumerate();
            KernelErrorRow {
                label: (*label).into(),
                method,
                shadings,
                whole: [whole.psnr_db(), whole.ssim()],
                // Rings beyond the image have no pixels.
                rings: of_rings.filter(|(_, s)| s.weight > 0.0).map(ring).collect(),
            }
        });
        Ok(rows.collect())
    }

    /// One row for each method and ring, and one for the whole image.
    pub fn table(rows: &[KernelErrorRow]) -> Table {
        let mut table = Table::new([
            "label", "method", "shadings", "from_deg", "to_deg", "psnr_db", "ssim",
        ]);
        for r in rows {
            let mut push = |from: Option<f64>, to: Option<f64>, psnr: f64, ssim: f64| {
                table.push(vec![
                    r.label.clone().into(),
                    r.method.clone().into(),
                    r.shadings.into(),
                    from.into(),
                    to.into(),
                    psnr.into(),
                    ssim.into(),
                ]);
            };
            push(None, None, r.whole[0], r.whole[1]);
            for ring in &r.rings {
                push(Some(ring.from_deg), ring.to_deg, ring.psnr_db, ring.ssim);
            }
        }
        table
    }

    /// PSNR over eccentricity, a line for each method.
    pub fn chart(rows: &[KernelErrorRow]) -> LineChart {
        let middle = |ring: &KernelRing| {
            let outer = ring.to_deg.unwrap_or(ring.from_deg + 10.0);
            (ring.from_deg + outer) / 2.0
        };
        let line = |r: &KernelErrorRow| LineSeries {
            label: r.label.clone(),
            points: r
                .rings
                .iter()
                .map(|ring| [middle(ring), ring.psnr_db])
                .collect(),
        };
        LineChart {
            title: "Error by eccentricity at equal shading".into(),
            x_label: "eccentricity, middle of the ring [deg]".into(),
            y_label: "PSNR of luma [dB]".into(),
            series: rows.iter().map(line).collect(),
            ..LineChart::default()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn methods_are_compared_at_equal_shading() {
        let rows = KernelErrors::quick().run(&|_, _| ()).unwrap();
        let find = |label: &str| rows.iter().find(|r| r.label == label).unwrap();
        let wanted = find("layers").shadings;
        for row in &rows {
            let is_free = ["full", "variable rate"].contains(&row.label.as_str());
            let off = (row.shadings / wanted - 1.0).abs();
            assert!(
                is_free || off < 0.03,
                "{}: {} for {wanted}",
                row.label,
                row.shadings
            );
            assert!(row.whole[0] > 10.0 && row.rings.len() >= 5, "{row:?}");
        }
        // Full resolution is nearest; so are kernels at the gaze to an even grid.
        assert!(
            rows.iter()
                .all(|r| r.whole[0] <= find("full").whole[0] + 1e-9)
        );
        let centre = |label: &str| find(label).rings[0].psnr_db;
        assert!(centre("kernel, α = 1") > centre("even grid"));
        let table = KernelErrors::table(&rows);
        assert_eq!(
            table.rows().len(),
            rows.iter().map(|r| 1 + r.rings.len()).sum::<usize>()
        );
        assert!(KernelErrors::chart(&rows).svg().contains("lens-matched"));
    }
}
