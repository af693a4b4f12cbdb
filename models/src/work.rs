use std::ops::AddAssign;

/// What a frame did, counted exactly. Counters do not depend on threads or vector width unless their
/// doc says so.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Work {
    /// Passes drawn.
    pub passes: u64,
    /// Vertices transformed, once per vertex and pass.
    pub vertices: u64,
    /// Triangles offered to a pass.
    pub triangles: u64,
    /// … of which facing away.
    pub triangles_back_facing: u64,
    /// … of which outside the view or between sample positions.
    pub triangles_outside: u64,
    /// … of which set up for rasterization (near-plane clipping may make two of one).
    pub triangles_set_up: u64,
    /// Samples tested against triangle edges: all lanes of every block dispatched.
    pub samples_tested: u64,
    /// … of which inside the triangle.
    pub samples_covered: u64,
    /// Samples shaded as surface: exactly the visible ones.
    pub samples_shaded: u64,
    /// Samples shaded as sky.
    pub samples_sky: u64,
    /// Display pixels reconstructed from passes.
    pub pixels_resolved: u64,
    /// Pass samples read while reconstructing (four per bilinear fetch).
    pub resolve_fetches: u64,
}

impl Work {
    /// Names and values, in a fixed order, for tables.
    pub fn rows(&self) -> [(&'static str, u64); 12] {
        [
            ("passes", self.passes),
            ("vertices", self.vertices),
            ("triangles", self.triangles),
            ("triangles_back_facing", self.triangles_back_facing),
            ("triangles_outside", self.triangles_outside),
            ("triangles_set_up", self.triangles_set_up),
            ("samples_tested", self.samples_tested),
            ("samples_covered", self.samples_covered),
            ("samples_shaded", self.samples_shaded),
            ("samples_sky", self.samples_sky),
            ("pixels_resolved", self.pixels_resolved),
            ("resolve_fetches", self.resolve_fetches),
        ]
    }

    /// All samples whose colour was computed.
    pub fn samples(&self) -> u64 {
        self.samples_shaded + self.samples_sky
    }
}

impl AddAssign for Work {
    fn add_assign(&mut self, o: Self) {
        self.passes += o.passes;
        self.vertices += o.vertices;
        self.triangles += o.triangles;
        self.triangles_back_facing += o.triangles_back_facing;
        self.triangles_outside += o.triangles_outside;
        self.triangles_set_up += o.triangles_set_up;
        self.samples_tested += o.samples_tested;
        self.samples_covered += o.samples_covered;
        self.samples_shaded += o.samples_shaded;
        self.samples_sky += o.samples_sky;
        self.pixels_resolved += o.pixels_resolved;
        self.resolve_fetches += o.resolve_fetches;
    }
}
