use glam::DVec3;

use super::{MovingTriangle, Real};

/// A moving triangle as functions of where (u, v) and when (t) a sample looks, d = (u, v, 1):
///
/// * eᵢ = d·Nᵢ(t) for its three edges, Nᵢ(t) = Pⱼ(t) × Pₖ(t) = N₀ + N₁·t + N₂·t², with P the corners in
///   homogeneous pixels;
/// * D(t) = P₀·(P₁ × P₂), of third degree.
///
/// A ray d·λ meets the plane of the triangle at Σ eᵢ·Pᵢ/D, so where all eᵢ have the sign of D it meets the
/// triangle, in front of the eye: λ = D/Σ eᵢ > 0. Nothing is clipped or divided, and corners may lie behind
/// the eye.
///
/// All are divided by powers of two so that the largest coefficient is between ½ and 1: that changes no sign and is
/// exact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Forms<T> {
    /// By edge, power of t, and component.
    pub(super) edges: [[[T; 3]; 3]; 3],
    /// By power of t.
    pub(super) volume: [T; 4],
    /// Σ Nᵢ in the scale of the volume, by power of t and component: 1/λ = d·plane(t)/D(t).
    plane: [[T; 3]; 3],
    facing: Facing,
}

/// Which side of a triangle can be seen. The front is where its corners turn counterclockwise as the
/// viewer sees them: display y runs down, so there D < 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Facing {
    /// Both.
    #[default]
    Both,
    /// The front alone.
    Front,
}

impl<T: Real> Forms<T> {
    /// Of a triangle; `None` if it has no extent at any time, is not finite, or surely shows at no time a side that can
    /// be seen.
    ///
    /// The coefficients are rounded once, and what they are rounded to is what is drawn, so bounds need not
    /// allow for it. An edge that two triangles share has the same coefficients in both, but for the sign
    /// and a power of two.
    #[inline]
    pub fn new(triangle: &MovingTriangle, facing: Facing) -> Option<Self> {
        let corners = triangle.0.map(|p| [p.start, p.end - p.start]);
        let [p, p_dot] = corners[0];
        let first = edge(corners[1], corners[2]);
        let [n0, n1, n2] = first;
        let volume = [
            p.dot(n0),
            p.dot(n1) + p_dot.dot(n0),
            p.dot(n2) + p_dot.dot(n1),
            p_dot.dot(n2),
        ];
        // Most of what is dropped is dropped here.
        if facing == Facing::Front && is_never_negative(&volume) {
            return None;
        }
        let edges = [
            first,
            edge(corners[2], corners[0]),
            edge(corners[0], corners[1]),
        ];
        // Plain loops: of millions of triangles a frame sets up, calls would show.
        let mut numbers = [[[0.0; 3]; 3]; 3];
        for (numbers, edge) in numbers.iter_mut().zip(&edges) {
            for (numbers, n) in numbers.iter_mut().zip(edge) {
                *numbers = n.to_array();
            }
        }
        let edge_scale = scale(numbers.as_flattened().as_flattened())?;
        let volume_scale = scale(&volume)?;
        let mut forms = Self {
            edges: [[[T::zero(); 3]; 3]; 3],
            volume: [T::zero(); 4],
            plane: [[T::zero(); 3]; 3],
            facing,
        };
        let all = forms.edges.as_flattened_mut().as_flattened_mut();
        for (out, x) in all.iter_mut().zip(numbers.as_flattened().as_flattened()) {
            *out = T::nearest(*x * edge_scale);
        }
        for (p, plane) in forms.plane.iter_mut().enumerate() {
            for (c, out) in plane.iter_mut().enumerate() {
                let sum = numbers[0][p][c] + numbers[1][p][c] + numbers[2][p][c];
                *out = T::nearest(sum * volume_scale);
            }
        }
        for (out, d) in forms.volume.iter_mut().zip(volume) {
            *out = T::nearest(d * volume_scale);
        }
        Some(forms)
    }

    /// Which sides can be seen.
    pub fn facing(&self) -> Facing {
        self.facing
    }

    /// The coefficients of the edges Nᵢ: by edge, power of t, and component.
    pub fn edges(&self) -> &[[[T; 3]; 3]; 3] {
        &self.edges
    }

    /// The coefficients of D, by power of t.
    pub fn volume_coefficients(&self) -> &[T; 4] {
        &self.volume
    }

    /// The coefficients of Σ Nᵢ by power of t and component, in the scale of D: the 1/λ of what a sample
    /// (u, v, t) sees is d·Σ Nᵢ(t)/D(t).
    pub fn plane(&self) -> &[[T; 3]; 3] {
        &self.plane
    }

    /// e of edge `i` (opposite corner `i`) at a sample.
    ///
    /// # Panics
    /// If there is no such edge.
    pub fn edge(&self, i: usize, [u, v, t]: [T; 3]) -> T {
        let n = self.edges[i];
        let at = |c: usize| (n[2][c] * t + n[1][c]) * t + n[0][c];
        u * at(0) + v * at(1) + at(2)
    }

    /// D at a time.
    pub fn volume(&self, t: T) -> T {
        let [d0, d1, d2, d3] = self.volume;
        ((d3 * t + d2) * t + d1) * t + d0
    }

    /// Whether the triangle covers a sample (u, v, t). A sample on an edge is covered by both sides.
    pub fn covers(&self, sample: [T; 3]) -> bool {
        let e = [0, 1, 2].map(|i| self.edge(i, sample));
        let (volume, zero) = (self.volume(sample[2]), T::zero());
        let front = volume < zero && e.iter().all(|e| *e <= zero);
        let back = volume > zero && e.iter().all(|e| *e >= zero);
        front || (back && self.facing == Facing::Both)
    }
}

/// The cross product of two moving points, by power of t. Which of the two comes first changes nothing but
/// the sign, and that exactly: products commute, and rounding is symmetric.
fn edge([a, a_dot]: [DVec3; 2], [b, b_dot]: [DVec3; 2]) -> [DVec3; 3] {
    [
        a.cross(b),
        a.cross(b_dot) + a_dot.cross(b),
        a_dot.cross(b_dot),
    ]
}

/// Whether a polynomial of third degree is surely nowhere negative from 0 to 1, by its Bézier points; coefficients may be
/// rounded to single precision afterwards.
fn is_never_negative([a, b, c, d]: &[f64; 4]) -> bool {
    let points = [
        *a,
        a + b * (1.0 / 3.0),
        a + b * (2.0 / 3.0) + c * (1.0 / 3.0),
        a + b + c + d,
    ];
    // Far above what that and these sums can round.
    let slack = 1e-5 * (a.abs() + b.abs() + c.abs() + d.abs());
    points.iter().all(|p| *p >= slack)
}

/// The power of two that brings the largest size between ½ and 1.
fn scale(values: &[f64]) -> Option<f64> {
    let mut largest = 0u64;
    for value in values {
        // Sizes are ordered as their bits are; what is not finite comes last.
        let size = value.to_bits() & (u64::MAX >> 1);
        largest = if size > largest { size } else { largest };
    }
    // largest = m·2ᵉ with m from ½ to 1.
    let exponent = (largest >> 52) as i64 - 1022;
    // Farther off than this, the scale itself would not be a normal number; nor are 0 and what is not finite.
    (exponent.abs() <= 1000).then(|| f64::from_bits(((1023 - exponent) as u64) << 52))
}

#[cfg(test)]
mod tests {
    use super::super::MovingPoint;
    use super::*;

    fn triangle(points: [[f64; 3]; 3]) -> MovingTriangle {
        let at = points.map(DVec3::from);
        MovingTriangle::new(at, at)
    }

    #[test]
    fn covers_what_is_within_and_in_front() {
        let front = triangle([[0.0, 0.0, 1.0], [0.0, 20.0, 2.0], [10.0, 0.0, 1.0]]);
        let mut turned = front;
        turned.0.swap(1, 2);
        for (triangle, seen) in [(front, true), (turned, false)] {
            let both = Forms::<f64>::new(&triangle, Facing::Both).unwrap();
            let one = Forms::<f64>::new(&triangle, Facing::Front);
            assert_eq!(one.is_some(), seen);
            for (u, v, inside) in [(2.0, 2.0, true), (9.0, 9.0, false), (-1.0, 2.0, false)] {
                assert_eq!(both.covers([u, v, 0.0]), inside);
                assert_eq!(
                    one.is_some_and(|one| one.covers([u, v, 0.0])),
                    inside && seen
                );
            }
        }
        let behind = MovingTriangle(front.0.map(|p| MovingPoint {
            start: -p.start,
            end: -p.end,
        }));
        assert!(
            !Forms::<f64>::new(&behind, Facing::Both)
                .unwrap()
                .covers([2.0, 2.0, 0.0])
        );
    }

    /// Two triangles with an edge in common leave no sample out and share none but those on the edge.
    #[test]
    fn shared_edges_agree_to_the_bit() {
        let p = [
            [3.1, 4.7, 1.3],
            [90.3, 11.9, 1.7],
            [55.5, 80.1, 0.9],
            [-7.0, 66.0, 2.1],
        ];
        let q = p.map(|[x, y, w]| DVec3::new(x + 3.3 * w, y - 7.7, w * 1.07));
        let p = p.map(DVec3::from);
        let make = |i: [usize; 3]| MovingTriangle::new(i.map(|i| p[i]), i.map(|i| q[i]));
        let a = edge_of(&make([0, 1, 2]), 1);
        let b = edge_of(&make([0, 2, 3]), 2);
        assert_eq!(a, b.map(|n| -n));
        fn edge_of(t: &MovingTriangle, i: usize) -> [DVec3; 3] {
            let c = t.0.map(|p| [p.start, p.end - p.start]);
            edge(c[(i + 1) % 3], c[(i + 2) % 3])
        }
    }

    #[test]
    fn nothing_and_not_finite() {
        let point = triangle([[1.0, 2.0, 1.0]; 3]);
        assert_eq!(Forms::<f32>::new(&point, Facing::Both), None);
        for bad in [f64::NAN, f64::INFINITY, f64::MAX] {
            let t = triangle([[bad, 0.0, 1.0], [0.0, 9.0, 1.0], [9.0, 0.0, 1.0]]);
            assert_eq!(Forms::<f32>::new(&t, Facing::Both), None, "{bad}");
        }
    }
}
