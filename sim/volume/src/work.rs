use std::ops::AddAssign;

/// What casting rays took, counted exactly; counters do not depend on threads or vector width.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct CastWork {
    /// Rays asked for that lie on the display.
    pub rays: u64,
    /// … of which pass the volume by.
    pub rays_missed: u64,
    /// … of which ended before they left the volume: what lies behind could not be seen.
    pub rays_ended_early: u64,
    /// Rays asked for that lie off the display: not cast.
    pub rays_off_screen: u64,
    /// Samples of the volume up to where rays end. (Steps are taken in pairs: of a ray that ends at the first of
    /// two, the second is read, too, and not counted.)
    pub steps: u64,
    /// … of which the transfer function shows something.
    pub steps_seen: u64,
    /// Places of samples that were not taken because the transfer function shows nothing there.
    pub steps_skipped: u64,
    /// Times that a ray left an empty part of the volume out.
    pub bricks_skipped: u64,
    /// Voxels read: eight for each sample.
    pub voxels_fetched: u64,
}

impl CastWork {
    /// Names and values, in a fixed order, for tables.
    pub fn rows(&self) -> [(&'static str, u64); 9] {
        [
            ("rays", self.rays),
            ("rays_missed", self.rays_missed),
            ("rays_ended_early", self.rays_ended_early),
            ("rays_off_screen", self.rays_off_screen),
            ("steps", self.steps),
            ("steps_seen", self.steps_seen),
            ("steps_skipped", self.steps_skipped),
            ("bricks_skipped", self.bricks_skipped),
            ("voxels_fetched", self.voxels_fetched),
        ]
    }
}

impl AddAssign for CastWork {
    fn add_assign(&mut self, o: Self) {
        self.rays += o.rays;
        self.rays_missed += o.rays_missed;
        self.rays_ended_early += o.rays_ended_early;
        self.rays_off_screen += o.rays_off_screen;
        self.steps += o.steps;
        self.steps_seen += o.steps_seen;
        self.steps_skipped += o.steps_skipped;
        self.bricks_skipped += o.bricks_skipped;
        self.voxels_fetched += o.voxels_fetched;
    }
}
