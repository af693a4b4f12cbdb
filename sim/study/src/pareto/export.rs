use std::collections::BTreeSet;
use std::fmt::Write;

use foveasim_models::foveation::Method;
use foveasim_models::math::{atan_deg, hypot};
use foveasim_models::{Image, Rate, Viewport};
use foveasim_render::Frame;
use foveasim_reports::{ReportError, Table, png};

use super::{Clip, Pareto};

/// Frames, gaze and display in files that FovVideoVDP (Mantiuk et al., ACM TOG 40(4), 2021) reads, and a script that has
/// it judge them: `python3 score.py` in the folder that they are written to.
///
/// Frames are PNG in sRGB. Its model of displays is of flat screens seen from in front of their middle, with square pixels;
/// luminance is its standard monitor's unless told.
#[derive(Debug, Clone, PartialEq)]
pub struct Export {
    viewport: Viewport,
    rate: Rate,
    /// Luminance of white \[cd/m²\].
    pub max_luminance: f64,
    /// White over black.
    pub contrast: f64,
    /// Ambient light \[lux\].
    pub ambient_lux: f64,
    /// Clips and methods whose frames were written: clip, method, and their folders.
    written: Vec<[String; 4]>,
    /// Frames of clips whose reference was written.
    references: BTreeSet<(String, usize)>,
}

impl Export {
    /// For frames of this image, shown at this rate.
    pub fn new(viewport: Viewport, rate: Rate) -> Self {
        Self {
            viewport,
            rate,
            max_luminance: 200.0,
            contrast: 1000.0,
            ambient_lux: 250.0,
            written: Vec::new(),
            references: BTreeSet::new(),
        }
    }

    /// The files of a frame, by name: it, and its reference if no method before had that.
    ///
    /// # Errors
    /// If an image cannot be written as PNG.
    pub fn frame(
        &mut self,
        clip: &Clip<'_>,
        method: Method,
        number: usize,
        frame: &Frame,
        reference: &Frame,
    ) -> Result<Vec<(String, Vec<u8>)>, ReportError> {
        let home = folder(&clip.name);
        let own = format!("{home}/{}", folder(&method.to_string()));
        let truth = format!("{home}/reference");
        let entry = [
            clip.name.clone(),
            method.to_string(),
            own.clone(),
            truth.clone(),
        ];
        if !self.written.contains(&entry) {
            self.written.push(entry);
        }
        let mut files = vec![file(&own, number, &frame.image)?];
        if self.references.insert((clip.name.clone(), number)) {
            files.push(file(&truth, number, &reference.image)?);
        }
        Ok(files)
    }

    /// Gaze, display, what was written, and the script, by name.
    pub fn finish(&self, asked: &Pareto<'_>) -> Vec<(String, String)> {
        let mut files: Vec<(String, String)> = asked
            .clips
            .iter()
            .map(|clip| {
                (
                    format!("{}/gaze.csv", folder(&clip.name)),
                    self.gaze(asked, clip),
                )
            })
            .collect();
        let mut index = Table::new(["clip", "method", "test", "reference", "gaze"]);
        for [clip, method, test, reference] in &self.written {
            let gaze = format!("{}/gaze.csv", folder(clip));
            index.push(vec![
                clip.as_str().into(),
                method.as_str().into(),
                test.as_str().into(),
                reference.as_str().into(),
                gaze.into(),
            ]);
        }
        files.push(("index.csv".into(), index.csv()));
        files.push(("display_models.json".into(), self.display()));
        files.push(("score.py".into(), score_script(self.rate)));
        files
    }

    /// Where the eye looks in each frame \[px from the upper left, of the middles of pixels\].
    fn gaze(&self, asked: &Pareto<'_>, clip: &Clip<'_>) -> String {
        let mut table = Table::new(["frame", "x_px", "y_px"]);
        let size = self.viewport.size.as_dvec2();
        for (k, frame) in asked.judged(clip).iter().enumerate() {
            // Its fixation is an index of a pixel; beyond the image it has none.
            let place = self
                .viewport
                .project(frame.gaze.vector())
                .unwrap_or(size / 2.0);
            let place = (place - 0.5).clamp(glam::DVec2::ZERO, size - 1.0);
            table.push(vec![k.into(), place.x.into(), place.y.into()]);
        }
        table.csv()
    }

    fn display(&self) -> String {
        let size = self.viewport.size;
        let [left, right, up, down] = self.viewport.tan;
        let half = hypot(right - left, up - down) / 2.0;
        let mut text = String::from("{\n  \"foveasim\": {\n");
        let mut line = |name: &str, value: String| {
            let _ = writeln!(text, "    \"{name}\": {value},");
        };
        line(
            "name",
            "\"foveasim: the display that was simulated\"".into(),
        );
        line("resolution", format!("[{}, {}]", size.x, size.y));
        line("fov_diagonal", format!("{:.6}", 2.0 * atan_deg(half)));
        line("viewing_distance_meters", "3".into());
        line("max_luminance", self.max_luminance.to_string());
        line("contrast", self.contrast.to_string());
        line("E_ambient", self.ambient_lux.to_string());
        text.push_str("    \"source\": \"foveasim pareto --export\"\n  }\n}\n");
        text
    }
}

/// A file of a folder's picture.
fn file(folder: &str, number: usize, image: &Image) -> Result<(String, Vec<u8>), ReportError> {
    Ok((format!("{folder}/{number:04}.png"), png(image)?))
}

/// A name that every file system takes.
fn folder(name: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
    let text: String = name
        .chars()
        .map(|c| if plain(c) { c } else { '-' })
        .collect();
    let text = text.trim_start_matches('.');
    if text.is_empty() {
        "clip".into()
    } else {
        text.into()
    }
}

/// The script that judges what [`Export`] wrote, and writes scores.csv for `foveasim pareto --import`.
fn score_script(rate: Rate) -> String {
    SCRIPT.replace("@RATE@", &rate.hz().to_string())
}

const SCRIPT: &str = r#"#!/usr/bin/env python3
"""Judges the frames in this folder with FovVideoVDP, and writes scores.csv.

Needs: pip install pyfvvdp numpy imageio torch
Then:  python3 score.py
       foveasim pareto ... --import scores.csv
"""
import csv
import glob
import os

import imageio.v2 as imageio
import numpy as np
import pyfvvdp

FRAMES_PER_SECOND = @RATE@
HERE = os.path.dirname(os.path.abspath(__file__))


def video(folder):
    names = sorted(glob.glob(os.path.join(HERE, folder, "*.png")))
    return np.stack([imageio.imread(name)[..., :3] for name in names], axis=-1)  # H, W, C, frames


def gaze(name):
    with open(os.path.join(HERE, name), newline="") as file:
        rows = list(csv.DictReader(file))
    return np.array([[float(r["x_px"]), float(r["y_px"])] for r in rows], dtype=np.float32)


def main():
    metric = pyfvvdp.fvvdp(
        display_name="foveasim",
        display_models=os.path.join(HERE, "display_models.json"),
        foveated=True,
        heatmap=None,
    )
    with open(os.path.join(HERE, "index.csv"), newline="") as file:
        index = list(csv.DictReader(file))
    scores = []
    for row in index:
        test, reference = video(row["test"]), video(row["reference"])
        fixation = gaze(row["gaze"])
        frames = test.shape[-1]
        jod, _ = metric.predict(
            test,
            reference,
            dim_order="HWCF",
            frames_per_second=FRAMES_PER_SECOND if frames > 1 else 0,
            fixation_point=fixation if frames > 1 else fixation[0],
        )
        print(row["clip"], row["method"], float(jod))
        scores.append([row["clip"], row["method"], f"{float(jod):.4f}"])
    with open(os.path.join(HERE, "scores.csv"), "w", newline="") as file:
        out = csv.writer(file, lineterminator="\n")
        out.writerow(["clip", "method", "jod"])
        out.writerows(scores)


if __name__ == "__main__":
    main()
"#;
