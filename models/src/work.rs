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
    /// Times that a triangle was left out of a tile because all there is nearer.
    pub triangles_occluded: u64,
    /// Cells of 8 × 8 samples that a triangle was left out of because all there is nearer.
    pub cells_occluded: u64,
    /// Samples that are not drawn because nothing of them is seen: outside the pass's region.
    pub samples_dead: u64,
    /// Samples that are not drawn because inner layers hide them.
    pub samples_hidden: u64,
    /// Positions of visibility tested against triangle edges: all lanes of every block dispatched.
    pub samples_tested: u64,
    /// … of which inside the triangle.
    pub samples_covered: u64,
    /// Quads of 2 × 2 samples in which a triangle passed the depth test, counted for each position of
    /// visibility: what a GPU with early depth test would launch, if triangles came in this order.
    pub quads: u64,
    /// Times that a surface was shaded: once for each sample (or block of coarse shading) and each
    /// triangle visible in it.
    pub samples_shaded: u64,
    /// Times that the sky was shaded.
    pub samples_sky: u64,
    /// Samples put together from several positions because an edge crosses them.
    pub samples_with_edge: u64,
    /// Display pixels reconstructed from passes.
    pub pixels_resolved: u64,
    /// Pass samples read while reconstructing (four per bilinear fetch).
    pub resolve_fetches: u64,
    /// Passes whose last image was shown again, because their cadence left this frame out.
    pub passes_not_due: u64,
    /// Samples blended with the history of their own place: nothing had moved since.
    pub samples_in_place: u64,
    /// Samples whose place in the history was found by their motion.
    pub samples_reprojected: u64,
    /// … of which without any history that shows the same surface.
    pub history_rejected: u64,
    /// … of which with a history pulled into the range of colours around them.
    pub history_clamped: u64,
    /// Triangles offered to maps of shadows.
    pub shadow_triangles: u64,
    /// Texels of maps of shadows.
    pub shadow_texels: u64,
    /// Depths that samples read around them for ambient occlusion.
    pub occlusion_reads: u64,
}

impl Work {
    /// Names and values, in a fixed order, for tables.
    pub fn rows(&self) -> [(&'static str, u64); 26] {
        [
            ("passes", self.passes),
            ("vertices", self.vertices),
            ("triangles", self.triangles),
            ("triangles_back_facing", self.triangles_back_facing),
            ("triangles_outside", self.triangles_outside),
            ("triangles_set_up", self.triangles_set_up),
            ("triangles_occluded", self.triangles_occluded),
            ("cells_occluded", self.cells_occluded),
            ("samples_dead", self.samples_dead),
            ("samples_hidden", self.samples_hidden),
            ("samples_tested", self.samples_tested),
            ("samples_covered", self.samples_covered),
            ("quads", self.quads),
            ("samples_shaded", self.samples_shaded),
            ("samples_sky", self.samples_sky),
            ("samples_with_edge", self.samples_with_edge),
            ("pixels_resolved", self.pixels_resolved),
            ("resolve_fetches", self.resolve_fetches),
            ("passes_not_due", self.passes_not_due),
            ("samples_in_place", self.samples_in_place),
            ("samples_reprojected", self.samples_reprojected),
            ("history_rejected", self.history_rejected),
            ("history_clamped", self.history_clamped),
            ("shadow_triangles", self.shadow_triangles),
            ("shadow_texels", self.shadow_texels),
            ("occlusion_reads", self.occlusion_reads),
        ]
    }

    /// Times that a colour was computed.
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
        self.triangles_occluded += o.triangles_occluded;
        self.cells_occluded += o.cells_occluded;
        self.samples_dead += o.samples_dead;
        self.samples_hidden += o.samples_hidden;
        self.samples_tested += o.samples_tested;
        self.samples_covered += o.samples_covered;
        self.quads += o.quads;
        self.samples_shaded += o.samples_shaded;
        self.samples_sky += o.samples_sky;
        self.samples_with_edge += o.samples_with_edge;
        self.pixels_resolved += o.pixels_resolved;
        self.resolve_fetches += o.resolve_fetches;
        self.passes_not_due += o.passes_not_due;
        self.samples_in_place += o.samples_in_place;
        self.samples_reprojected += o.samples_reprojected;
        self.history_rejected += o.history_rejected;
        self.history_clamped += o.history_clamped;
        self.shadow_triangles += o.shadow_triangles;
        self.shadow_texels += o.shadow_texels;
        self.occlusion_reads += o.occlusion_reads;
    }
}
