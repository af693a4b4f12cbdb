use glam::DVec3;

/// Normals of corners from the triangles about them, smooth but for creases.
///
/// The triangles about a position form groups: each joins the group whose normal so far is closest
/// to its own, or begins one if all are further off than the crease angle. A group's normal is the
/// average of its triangles by area. Going through the triangles once in file order, it takes linear
/// time also where all of them share one position.
#[derive(Debug)]
pub(super) struct Normals {
    crease: f64,
    /// First group about each position.
    first: Vec<u32>,
    groups: Vec<Group>,
}

#[derive(Debug)]
struct Group {
    /// Twice the area vectors added up.
    sum: DVec3,
    /// The next group about the same position.
    next: u32,
}

const END: u32 = u32::MAX;
/// Most groups about one position; later triangles join the closest whatever the angle. Directions
/// that are 45° apart from each other cannot be many more than 20.
const MOST_GROUPS: usize = 32;

impl Normals {
    /// For `positions` positions and a crease angle of cosine `crease`; 1 makes every triangle flat.
    pub(super) fn new(positions: usize, crease: f64) -> Self {
        Self {
            crease,
            first: vec![END; positions],
            groups: Vec::new(),
        }
    }

    /// Adds a triangle at `position`, given twice its area vector; the number of its corner's normal.
    pub(super) fn add(&mut self, position: u32, area: DVec3) -> u32 {
        let own = area.normalize_or_zero();
        if self.crease >= 1.0 {
            // Every triangle is flat: nothing to look for.
            return self.begin(position, area);
        }
        let (mut best, mut cosine, mut count) = (END, f64::NEG_INFINITY, 0);
        let mut at = self.first[position as usize];
        while at != END {
            let group = &self.groups[at as usize];
            let c = group.sum.normalize_or_zero().dot(own);
            if c > cosine {
                (best, cosine) = (at, c);
            }
            count += 1;
            at = group.next;
        }
        if best == END || (cosine < self.crease && count < MOST_GROUPS) {
            return self.begin(position, area);
        }
        self.groups[best as usize].sum += area;
        best
    }

    fn begin(&mut self, position: u32, sum: DVec3) -> u32 {
        let new = self.groups.len() as u32;
        let next = std::mem::replace(&mut self.first[position as usize], new);
        self.groups.push(Group { sum, next });
        new
    }

    /// All normals, unit length; by number.
    pub(super) fn finish(self) -> impl Iterator<Item = DVec3> {
        // Triangles that cancel out leave no direction; any will do.
        let unit = |g: Group| g.sum.try_normalize().unwrap_or(DVec3::Y);
        self.groups.into_iter().map(unit)
    }
}

#[cfg(test)]
mod tests {
    use foveasim_models::math::{cos, sin};

    use super::*;

    #[test]
    fn a_cube_keeps_its_edges_and_a_fan_is_smooth() {
        let mut cube = Normals::new(1, 0.7);
        let names = [DVec3::X, DVec3::Y, DVec3::Z, DVec3::X].map(|n| cube.add(0, n));
        assert_eq!(names, [0, 1, 2, 0]);
        assert_eq!(
            cube.finish().collect::<Vec<_>>(),
            [DVec3::X, DVec3::Y, DVec3::Z]
        );

        let mut fan = Normals::new(1, 0.7);
        let tilted = |turn: f64| DVec3::new(0.3 * cos(turn), 0.3 * sin(turn), 1.0);
        for i in 0..100_000 {
            assert_eq!(fan.add(0, tilted(f64::from(i) * 0.0628)), 0);
        }
        let normal = fan.finish().next().unwrap();
        assert!(normal.angle_between(DVec3::Z) < 0.01, "{normal}");
    }

    #[test]
    fn larger_triangles_count_more() {
        let mut normals = Normals::new(1, 0.0);
        normals.add(0, DVec3::Z * 3.0);
        normals.add(0, DVec3::X);
        let normal = normals.finish().next().unwrap();
        assert!(normal.distance(DVec3::new(1.0, 0.0, 3.0).normalize()) < 1e-15);
    }
}
