use foveasim_models::{CostProfile, FrameWork, ModelError, Rate, presets};

/// What time, memory and link cost: the same for every row of a sweep.
#[derive(Debug, Clone, PartialEq)]
pub struct Terms {
    /// From work to frame time.
    pub cost: CostProfile,
    /// What images take in memory.
    pub buffers: Buffers,
    /// What carries the image to the display.
    pub link: Link,
}

/// Bytes of framebuffers, of which each pass has one and the displayed image another if it is put together from
/// several or from other samples than its own.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Buffers {
    /// Of each sample: colour and depth, of all positions of multisampling.
    pub sample_bytes: f64,
    /// Of each pixel of the displayed image: colour.
    pub pixel_bytes: f64,
}

/// A link that carries samples as they are rendered, each pass as often as it is drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Link {
    /// Of a sample.
    pub bits_per_pixel: f64,
    /// The part of the time in which samples are on the link; the rest is blanking.
    pub active_fraction: f64,
    /// How many times compression makes them fewer; 1: it does not.
    pub compression: f64,
}

impl Default for Terms {
    /// The profile of Guenter 2012's graphics card; 4 bytes of colour and 4 of depth; 24 bits a pixel, neither
    /// blanking nor compression.
    fn default() -> Self {
        Self {
            cost: presets::cost("guenter2012").expect("it is shipped, and a test reads it"),
            buffers: Buffers {
                sample_bytes: 8.0,
                pixel_bytes: 4.0,
            },
            link: Link {
                bits_per_pixel: 24.0,
                active_fraction: 1.0,
                compression: 1.0,
            },
        }
    }
}

impl Terms {
    /// Checks that every number is in range.
    ///
    /// # Errors
    /// Names the number that is not, and what would be valid.
    pub fn check(&self) -> Result<(), ModelError> {
        let Self { buffers, link, .. } = self;
        let within = |name: &str, value: f64, from: f64, to: f64| match (from..=to).contains(&value)
        {
            true => Ok(()),
            false => Err(ModelError::range(
                name,
                value,
                format!("from {from} to {to}"),
            )),
        };
        within("bytes per sample", buffers.sample_bytes, 0.0, 4096.0)?;
        within("bytes per pixel", buffers.pixel_bytes, 0.0, 4096.0)?;
        within("bits per pixel", link.bits_per_pixel, 1.0, 1024.0)?;
        within("active fraction", link.active_fraction, 0.01, 1.0)?;
        within("compression", link.compression, 1.0, 1000.0)
    }
}

impl Buffers {
    /// Megabytes (10⁶) of a frame whose passes have so many samples, drawn or not, and that puts together so many
    /// pixels.
    pub fn megabytes(&self, samples: f64, pixels_resolved: f64) -> f64 {
        (samples * self.sample_bytes + pixels_resolved * self.pixel_bytes) / 1e6
    }
}

impl Link {
    /// Gigabits (10⁹) of so many samples, as compressed.
    pub fn frame_gigabits(&self, samples: f64) -> f64 {
        samples * self.bits_per_pixel / self.compression / 1e9
    }

    /// Gigabits (10⁹) a second while the link is active, of so many samples in each refresh.
    pub fn gigabits(&self, samples: f64, refresh: Rate) -> f64 {
        samples * self.bits_per_pixel * refresh.hz()
            / (self.active_fraction * self.compression)
            / 1e9
    }
}

/// Whether frames of a predicted time are finished within a refresh.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fits {
    /// Also those in which every pass is drawn.
    Always,
    /// On average, each pass at its own cadence; those in which every pass is drawn are not.
    OnAverage,
    /// They are not.
    No,
}

impl Fits {
    /// Of frames that take so long on average and when every pass is drawn \[ms\].
    pub fn of(mean_ms: f64, all_ms: f64, refresh: Rate) -> Self {
        let period_ms = 1000.0 / refresh.hz();
        match (all_ms <= period_ms, mean_ms <= period_ms) {
            (true, _) => Self::Always,
            (false, true) => Self::OnAverage,
            (false, false) => Self::No,
        }
    }

    /// As in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Always => "yes",
            Self::OnAverage => "on average",
            Self::No => "no",
        }
    }
}

/// What a row needs, by the sweep's [`Terms`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Needs {
    /// Predicted time of a frame, each pass at its own cadence \[ms\].
    pub frame_ms: f64,
    /// The same when every pass is drawn \[ms\].
    pub frame_all_ms: f64,
    /// Of a frame with a sample for each pixel \[ms\].
    pub full_ms: f64,
    /// Whether the work is beyond what the cost profile rests on: the first part that is.
    pub beyond_fit: Option<&'static str>,
    /// Framebuffers \[10⁶ bytes\].
    pub framebuffer_mb: f64,
    /// Rate of the link, if samples are what is transmitted \[10⁹ bit/s\]; `None` without a refresh rate.
    pub link_gbps: Option<f64>,
    /// The same of a frame with a sample for each pixel.
    pub full_link_gbps: Option<f64>,
    /// What a frame takes of energy, each pass at its own cadence, and its samples on the link \[mJ\]; `None` where the
    /// cost profile does not say.
    pub energy_mj: Option<f64>,
    /// The same of a frame with a sample for each pixel.
    pub full_energy_mj: Option<f64>,
    /// That of a frame at each refresh \[W\]; `None` without a refresh rate.
    pub power_w: Option<f64>,
    /// The same of frames with a sample for each pixel.
    pub full_power_w: Option<f64>,
}

impl Needs {
    /// Times faster than a frame with a sample for each pixel.
    pub fn speedup(&self) -> f64 {
        self.full_ms / self.frame_ms
    }
}

/// A frame with a sample for each of so many pixels, of so many eyes.
pub(super) fn full_work(pixels: f64, eyes: usize) -> FrameWork {
    FrameWork {
        samples_shaded: pixels,
        samples: pixels,
        pixels_resolved: 0.0,
        passes: eyes as f64,
    }
}
