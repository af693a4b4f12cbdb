use foveasim_models::foveation::{Method, Request};
use foveasim_models::{EyePanel, SamplePlan, Work};
use foveasim_quality::{Rings, compare};
use foveasim_render::{StereoFrame, render_stereo};
use foveasim_reports::{Cell, Table};

use crate::frame::{QUALITY_COLUMNS, work_columns};
use crate::{Drawing, FrameError, FrameOutcome, FrameStudy, Shot, Sight};

/// One moment as both eyes of a headset see it, by one method, beside each eye's reference.
#[derive(Debug)]
pub struct StereoStudy<'a> {
    /// What there is to see; the pose is the head's.
    pub sight: Sight<'a>,
    /// Left and right panel.
    pub panels: [EyePanel; 2],
    /// What the method plans each eye's image for.
    pub requests: [Request; 2],
    /// How it is drawn: each frame by itself.
    pub drawing: Drawing,
}

/// What a [`StereoStudy`] found.
#[derive(Debug, Clone)]
pub struct StereoOutcome {
    /// Both eyes' frames, and what they share.
    pub frame: StereoFrame,
    /// Left and right: the frame beside its reference.
    pub eyes: [FrameOutcome; 2],
}

impl StereoStudy<'_> {
    /// Draws both eyes by `method`, and both references.
    ///
    /// # Errors
    /// If the method cannot be planned for a request, or a plan cannot be drawn.
    pub fn run(&self, method: Method) -> Result<StereoOutcome, FrameError> {
        let plan = |eye: usize| -> Result<SamplePlan, FrameError> {
            let plan = method.plan(&self.requests[eye])?;
            Ok(plan.with_msaa(self.drawing.msaa))
        };
        let plans = [plan(0)?, plan(1)?];
        let head = self.sight.world_from_eye;
        let views = [0, 1].map(|eye| self.panels[eye].view(head));
        // The image planes asked for: a panel's own, or of another size.
        let lens = |eye: usize| -> Result<_, FrameError> {
            let lens = self.drawing.lens.map(|lens| match eye {
                0 => lens,
                _ => lens.mirrored(),
            });
            let size = self.requests[eye].viewport.size;
            Ok(lens.map(|lens| lens.over(size)).transpose()?)
        };
        let lenses = [lens(0)?, lens(1)?];
        let views = [0, 1].map(|eye| foveasim_models::View {
            optics: self.requests[eye].viewport,
            lens: lenses[eye],
            ..views[eye]
        });
        let frame = render_stereo(
            self.sight.scene,
            head,
            [&views[0], &views[1]],
            [&plans[0], &plans[1]],
            &self.drawing.options,
        )?;
        let outcome = |eye: usize| -> Result<FrameOutcome, FrameError> {
            let study = FrameStudy {
                sight: Sight {
                    world_from_eye: views[eye].poses[0],
                    ..self.sight
                },
                before: Vec::new(),
                first_frame: 0,
                gaze: self.requests[eye].gaze,
                request: self.requests[eye].clone(),
                drawing: Drawing {
                    lens: match eye {
                        0 => self.drawing.lens,
                        _ => self.drawing.lens.map(|lens| lens.mirrored()),
                    },
                    ..self.drawing
                },
            };
            let mut outcome = study.run(&[])?;
            let drawn = &frame.eyes[eye];
            let compared = compare(&drawn.image, &outcome.reference.image)?;
            let gaze = study.gaze.vector();
            let rings = compared.rings(&views[eye].optics, gaze, &Rings::default())?;
            outcome.shots.push(Shot {
                method,
                plan: plans[eye].clone(),
                frame: drawn.clone(),
                measures: compared.whole,
                rings,
            });
            Ok(outcome)
        };
        let eyes = [outcome(0)?, outcome(1)?];
        Ok(StereoOutcome { frame, eyes })
    }
}

/// The eyes' names, as rows of tables have them.
const EYES: [&str; 2] = ["left", "right"];

impl StereoOutcome {
    /// As [`FrameOutcome::quality_table`], for each eye.
    pub fn quality_table(&self) -> Table {
        let mut table = Table::new(std::iter::once("eye").chain(QUALITY_COLUMNS));
        for (name, eye) in EYES.iter().zip(&self.eyes) {
            for row in eye.quality_rows() {
                table.push(std::iter::once(Cell::from(*name)).chain(row).collect());
            }
        }
        table
    }

    /// As [`FrameOutcome::work_table`], for each eye, and a row for both together, with what they share.
    pub fn work_table(&self) -> Table {
        let mut table = Table::new(std::iter::once("eye").chain(work_columns()));
        for (name, eye) in EYES.iter().zip(&self.eyes) {
            for row in eye.work_rows() {
                table.push(std::iter::once(Cell::from(*name)).chain(row).collect());
            }
        }
        let method = self.eyes[0].shots.first().map(|s| s.method.to_string());
        let shared = Work {
            vertices: self.frame.shared.vertices,
            ..Work::default()
        };
        for (pass, work) in [("shared", &shared), ("all", &self.frame.work)] {
            let head = [
                "both".into(),
                "frame".into(),
                method.clone().into(),
                pass.into(),
            ];
            let row = head.into_iter().chain(work.rows().map(|(_, n)| n.into()));
            table.push(row.collect());
        }
        table
    }
}
