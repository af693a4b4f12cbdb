use glam::DVec2;

/// What a published bound leaves of a lattice.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Outline {
    /// Nothing: the triangle is behind the eye.
    Nothing,
    /// All: the triangle is partly behind the eye, or its edges have no image.
    Everything,
    /// A convex polygon, its corners turning from x to y.
    Polygon(Vec<DVec2>),
}

impl Outline {
    /// The smallest convex polygon around points (monotone chain, Andrew 1979).
    pub(super) fn hull(mut points: Vec<DVec2>) -> Self {
        points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
        points.dedup();
        if points.len() < 3 {
            return Self::Polygon(points);
        }
        let chain = |points: &mut dyn Iterator<Item = &DVec2>| {
            let mut kept: Vec<DVec2> = Vec::new();
            for &p in points {
                while let [.., a, b] = kept[..] {
                    if (b - a).perp_dot(p - a) > 0.0 {
                        break;
                    }
                    kept.pop();
                }
                kept.push(p);
            }
            kept.pop();
            kept
        };
        let mut hull = chain(&mut points.iter());
        hull.append(&mut chain(&mut points.iter().rev()));
        Self::Polygon(hull)
    }

    /// Whether a lattice position is within it or on its border.
    pub fn contains(&self, p: DVec2) -> bool {
        match self {
            Self::Nothing => false,
            Self::Everything => true,
            Self::Polygon(corners) => {
                let sides =
                    (0..corners.len()).map(|i| [corners[i], corners[(i + 1) % corners.len()]]);
                corners.len() > 2
                    && sides
                        .into_iter()
                        .all(|[a, b]| (b - a).perp_dot(p - a) >= 0.0)
            }
        }
    }

    /// How far a lattice position is outside it \[steps\]; 0 inside. Of a polygon's sides the farthest counts,
    /// so beside a corner it is a little less.
    pub fn excess(&self, p: DVec2) -> f64 {
        match self {
            Self::Nothing => f64::INFINITY,
            Self::Everything => 0.0,
            Self::Polygon(corners) => (0..corners.len())
                .filter_map(|i| {
                    let (a, b) = (corners[i], corners[(i + 1) % corners.len()]);
                    let along = (b - a).try_normalize()?;
                    Some(-along.perp_dot(p - a))
                })
                .fold(0.0, f64::max),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hulls_hold_their_points() {
        let points: Vec<_> = (0..40)
            .map(|i| DVec2::new(f64::from(i * 37 % 41), f64::from(i * i * 11 % 43)))
            .collect();
        let hull = Outline::hull(points.clone());
        assert!(
            points
                .iter()
                .all(|p| hull.contains(*p) && hull.excess(*p) == 0.0)
        );
        assert!(!hull.contains(DVec2::new(-0.01, 20.0)));
        let right = points.iter().fold(0.0, |m: f64, p| m.max(p.x));
        let beyond = DVec2::new(right + 5.0, 20.0);
        let excess = hull.excess(beyond);
        assert!((2.0..=25.0).contains(&excess), "{excess}");
        let line = Outline::hull(vec![DVec2::ZERO, DVec2::ONE, DVec2::splat(2.0)]);
        assert!(!line.contains(DVec2::ONE));
    }
}
