use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use crate::math;

/// What a random stream is for. Streams of different roles are independent for the same seed, so
/// switching one source of randomness off leaves the others as they were.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
#[repr(u64)]
pub enum Role {
    /// Phases between clocks.
    Phase = 1,
    /// Tracker processing time.
    Tracker = 2,
    /// Gaze measurement noise.
    GazeNoise = 3,
    /// Synthetic gaze.
    SynthGaze = 4,
    /// Synthetic head motion.
    SynthHead = 5,
    /// Generated scenes.
    Scene = 6,
    /// Sample jitter.
    Jitter = 7,
    /// Monte Carlo draws of viewers, errors and fits.
    Population = 8,
    /// When gaze steps.
    GazeStep = 9,
    /// Rendering times.
    RenderTime = 10,
    /// Slippage of a headset on the face.
    Slippage = 11,
    /// When a tracker loses the eye.
    Dropout = 12,
    /// When the viewer blinks.
    Blink = 13,
    /// Transport of tracker samples.
    Transport = 14,
    /// Where sampling masks begin.
    Mask = 15,
    /// Extreme inputs of closed forms and kernels.
    Stress = 16,
}

/// Random numbers of one (seed, role, index): the same on any machine and any number of threads.
#[derive(Debug, Clone)]
pub struct Stream {
    rng: Xoshiro256PlusPlus,
    spare_normal: Option<f64>,
}

impl Stream {
    /// The stream of `seed`, `role` and `index` (a run, tile, object … number).
    pub fn new(seed: u64, role: Role, index: u64) -> Self {
        let key = mix(mix(mix(seed) ^ role as u64) ^ index);
        Self {
            rng: Xoshiro256PlusPlus::seed_from_u64(key),
            spare_normal: None,
        }
    }

    /// 64 random bits.
    pub fn next_u64(&mut self) -> u64 {
        self.rng.next_u64()
    }

    /// Uniform in [0, 1), a multiple of 2⁻⁵³.
    pub fn uniform(&mut self) -> f64 {
        (self.next_u64() >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
    }

    /// Uniform in [low, high).
    pub fn range(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.uniform()
    }

    /// A uniform whole number in `0..n`; 0 for n = 0. The bias is below n / 2⁶⁴.
    pub fn below(&mut self, n: u64) -> u64 {
        ((u128::from(self.next_u64()) * u128::from(n)) >> 64) as u64
    }

    /// Normal with mean 0 and standard deviation 1 (Box and Muller 1958).
    pub fn normal(&mut self) -> f64 {
        if let Some(value) = self.spare_normal.take() {
            return value;
        }
        let radius = math::sqrt(-2.0 * math::log(1.0 - self.uniform()));
        let angle = 2.0 * std::f64::consts::PI * self.uniform();
        self.spare_normal = Some(radius * math::sin(angle));
        radius * math::cos(angle)
    }
}

/// The finalizer of SplitMix64 (Steele, Lea, Flood 2014): every output bit depends on every input bit.
fn mix(x: u64) -> u64 {
    let x = x.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn streams_are_reproducible_and_distinct() {
        let draw = |seed, role, index| Stream::new(seed, role, index).next_u64();
        assert_eq!(draw(1, Role::Phase, 0), draw(1, Role::Phase, 0));
        assert_ne!(draw(1, Role::Phase, 0), draw(1, Role::Tracker, 0));
        assert_ne!(draw(1, Role::Phase, 0), draw(1, Role::Phase, 1));
        assert_ne!(draw(1, Role::Phase, 0), draw(2, Role::Phase, 0));
    }

    #[test]
    fn moments_of_uniform_and_normal() {
        let n = 200_000;
        let mut stream = Stream::new(7, Role::Scene, 0);
        let uniform: Vec<f64> = (0..n).map(|_| stream.uniform()).collect();
        let normal: Vec<f64> = (0..n).map(|_| stream.normal()).collect();
        let variance = |v: &[f64]| {
            let m = math::mean(v);
            math::mean(&v.iter().map(|x| (x - m) * (x - m)).collect::<Vec<_>>())
        };
        // Five standard errors of each estimate.
        assert!((math::mean(&uniform) - 0.5).abs() < 5.0 * 0.289 / (n as f64).sqrt());
        assert!((math::mean(&normal)).abs() < 5.0 / (n as f64).sqrt());
        assert!((variance(&normal) - 1.0).abs() < 5.0 * (2.0 / n as f64).sqrt());
    }
}
