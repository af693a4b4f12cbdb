use glam::{DQuat, DVec3};
use serde::{Deserialize, Serialize};

use super::{EyePanel, Geometry, LensSpec, pixels};
use crate::error::{above, in_range};
use crate::math::{tan_deg, to_rad};
use crate::{Eye, ModelError, Pose, Viewport};

/// A head-mounted display. Panel and eye buffer are two things: what is rendered has
/// `panel_px × render_scale` pixels, spread evenly over the tangents of the four half-angles.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HmdSpec {
    /// The left eye's half-angles from its axis: outwards (left), inwards (right), up, down
    /// \[deg\]. The right eye's are mirrored.
    pub fov_deg: [f64; 4],
    /// How far each eye's axis is turned outwards \[deg\].
    #[serde(default)]
    pub cant_deg: f64,
    /// Panel pixels per eye, width and height.
    pub panel_px: [u32; 2],
    /// Eye-buffer pixels over panel pixels, width and height.
    #[serde(default = "one_by_one")]
    pub render_scale: [f64; 2],
    /// Fraction of the eye buffer hidden behind the optics and masked out when rendering.
    #[serde(default)]
    pub hidden_area_fraction: f64,
    /// Distance between the eyes \[m\].
    #[serde(default = "mean_ipd")]
    pub ipd_m: f64,
    /// The left eye's lens, if its distortion is to be drawn; the right eye's is mirrored. `fov_deg` is what the
    /// image plane holds.
    #[serde(default)]
    pub lens: Option<LensSpec>,
}

fn one_by_one() -> [f64; 2] {
    [1.0, 1.0]
}

/// Mean interpupillary distance of adults \[m\] (Dodgson 2004, ANSUR).
fn mean_ipd() -> f64 {
    0.0634
}

impl HmdSpec {
    pub(super) fn build(&self) -> Result<(Geometry, Vec<EyePanel>), ModelError> {
        for angle in self.fov_deg {
            above("hmd.fov_deg", angle, 0.0, 85.0)?;
        }
        in_range("hmd.cant_deg", self.cant_deg, -45.0..=45.0)?;
        in_range(
            "hmd.hidden_area_fraction",
            self.hidden_area_fraction,
            0.0..=0.9,
        )?;
        in_range("hmd.ipd_m", self.ipd_m, 0.0..=0.2)?;
        let panel_px = pixels("hmd.panel_px", self.panel_px)?;
        let mut size = [0; 2];
        for axis in 0..2 {
            above("hmd.render_scale", self.render_scale[axis], 0.0, 16.0)?;
            let px = f64::from(panel_px[axis]) * self.render_scale[axis];
            size[axis] = libm::round(px) as u32;
        }
        let size = pixels("hmd eye buffer (panel_px × render_scale)", size)?;
        let [outward, inward, up, down] = self.fov_deg.map(tan_deg);
        let eye = |eye, side: f64| -> Result<EyePanel, ModelError> {
            let (left, right) = if side < 0.0 {
                (outward, inward)
            } else {
                (inward, outward)
            };
            let lens = self.lens.map(|lens| match eye {
                Eye::Right => lens.mirrored(),
                _ => lens,
            });
            if let Some(lens) = lens {
                lens.over(size.into())?;
            }
            let turn = DQuat::from_axis_angle(DVec3::Y, -side * to_rad(self.cant_deg));
            Ok(EyePanel {
                eye,
                viewport: Viewport::new(size.into(), [-left, right, up, -down])?,
                panel_px,
                head_from_eye: Pose::new(DVec3::X * (side * self.ipd_m / 2.0), turn),
                hidden_area_fraction: self.hidden_area_fraction,
                lens,
            })
        };
        Ok((
            Geometry::HeadMounted,
            vec![eye(Eye::Left, -1.0)?, eye(Eye::Right, 1.0)?],
        ))
    }
}
