use foveasim_models::math::sum;

/// The x ≥ 0 that make Σ (rows · x − wanted)² least: Lawson and Hanson, *Solving Least Squares Problems* (1974),
/// chapter 23. One coefficient joins at a time, the one whose growth gains most; those that would have to be
/// negative leave again. Deterministic: of equals, the first.
///
/// Columns are scaled to unit length; one that others already say (to 1e-9 of its length) stays 0.
///
/// # Panics
/// If rows are not all of one length, or there are not as many values wanted.
pub fn non_negative_least_squares(rows: &[Vec<f64>], wanted: &[f64]) -> Vec<f64> {
    let columns = rows.first().map_or(0, Vec::len);
    assert!(rows.iter().all(|r| r.len() == columns) && rows.len() == wanted.len());
    let dot = |f: &dyn Fn(usize) -> f64| sum(&(0..rows.len()).map(f).collect::<Vec<_>>());
    let lengths: Vec<f64> = (0..columns)
        .map(|j| dot(&|i| rows[i][j] * rows[i][j]).sqrt())
        .collect();
    let usable = |j: usize| lengths[j] > 0.0 && lengths[j].is_finite();
    let at = |i: usize, j: usize| rows[i][j] / lengths[j];
    let mut x = vec![0.0; columns];
    let mut passive: Vec<usize> = Vec::new();
    let mut refused = vec![false; columns];
    // Each round adds a coefficient for good or refuses one; three times as many rounds as there are is ample.
    for _ in 0..3 * columns + 3 {
        let residual: Vec<f64> = (0..rows.len())
            .map(|i| wanted[i] - passive.iter().map(|&j| at(i, j) * x[j]).sum::<f64>())
            .collect();
        let scale = dot(&|i| wanted[i] * wanted[i])
            .sqrt()
            .max(f64::MIN_POSITIVE);
        let gain = |j: usize| dot(&|i| at(i, j) * residual[i]) / scale;
        let candidates =
            (0..columns).filter(|&j| usable(j) && !refused[j] && !passive.contains(&j));
        let best = candidates
            .map(|j| (j, gain(j)))
            .fold(None, |best, next| match best {
                Some((_, g)) if g >= next.1 => best,
                _ => Some(next),
            });
        let Some((joins, _)) = best.filter(|(_, g)| *g > 1e-12) else {
            break;
        };
        passive.push(joins);
        loop {
            let normal: Vec<Vec<f64>> = passive
                .iter()
                .map(|&a| {
                    let products = passive.iter().map(|&b| dot(&|i| at(i, a) * at(i, b)));
                    products.chain([dot(&|i| at(i, a) * wanted[i])]).collect()
                })
                .collect();
            let Some(s) = solved(normal) else {
                // The columns in use say this one already.
                passive.retain(|&j| j != joins);
                refused[joins] = true;
                break;
            };
            if s.iter().all(|v| *v > 0.0) {
                for (&j, v) in passive.iter().zip(&s) {
                    x[j] = *v;
                }
                break;
            }
            // As far towards the solution as all stay non-negative; those that reach 0 leave.
            let step = passive
                .iter()
                .zip(&s)
                .filter(|(_, v)| **v <= 0.0)
                .map(|(&j, v)| x[j] / (x[j] - v))
                .fold(1.0, f64::min);
            let step = if step.is_finite() { step } else { 0.0 };
            for (&j, v) in passive.iter().zip(&s) {
                x[j] += step * (v - x[j]);
            }
            let leaves: Vec<usize> = passive
                .iter()
                .zip(&s)
                .filter(|(j, v)| **v <= 0.0 && x[**j] <= 1e-14)
                .map(|(j, _)| *j)
                .collect();
            if leaves.contains(&joins) {
                refused[joins] = true;
            }
            if leaves.is_empty() {
                break;
            }
            for j in leaves {
                x[j] = 0.0;
                passive.retain(|&p| p != j);
            }
            if passive.is_empty() {
                break;
            }
        }
    }
    for (v, length) in x.iter_mut().zip(&lengths) {
        *v = if *length > 0.0 { *v / length } else { 0.0 };
    }
    x
}

/// The solution of a symmetric system, its right side in the last column; `None` if rows depend on each other.
fn solved(mut a: Vec<Vec<f64>>) -> Option<Vec<f64>> {
    let n = a.len();
    for k in 0..n {
        let pivot = (k..n).max_by(|i, j| a[*i][k].abs().total_cmp(&a[*j][k].abs()))?;
        a.swap(k, pivot);
        // Diagonals are 1 before elimination: columns have unit length.
        if a[k][k].abs() < 1e-9 {
            return None;
        }
        let row = a[k].clone();
        for below in &mut a[k + 1..] {
            let factor = below[k] / row[k];
            for (v, p) in below.iter_mut().zip(&row).skip(k) {
                *v -= factor * p;
            }
        }
    }
    let mut x = vec![0.0; n];
    for k in (0..n).rev() {
        let known: f64 = (k + 1..n).map(|j| a[k][j] * x[j]).sum();
        x[k] = (a[k][n] - known) / a[k][k];
    }
    Some(x)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn known_solutions() {
        let rows = [vec![1.0, 1.0], vec![1.0, 2.0], vec![1.0, 3.0]];
        let close = |got: Vec<f64>, want: &[f64]| {
            assert!(
                got.iter().zip(want).all(|(a, b)| (a - b).abs() < 1e-9),
                "{got:?} {want:?}"
            );
        };
        close(
            non_negative_least_squares(&rows, &[5.0, 7.0, 9.0]),
            &[3.0, 2.0],
        );
        // The free optimum is 6 − x: the slope may not be negative, and the mean is best.
        close(
            non_negative_least_squares(&rows, &[5.0, 4.0, 3.0]),
            &[4.0, 0.0],
        );
        close(
            non_negative_least_squares(&rows, &[-1.0, -2.0, -3.0]),
            &[0.0, 0.0],
        );
        // A column twice: one of the two.
        let twice = [vec![1.0, 1.0], vec![2.0, 2.0]];
        close(non_negative_least_squares(&twice, &[3.0, 6.0]), &[3.0, 0.0]);
        close(
            non_negative_least_squares(&[vec![0.0], vec![0.0]], &[1.0, 2.0]),
            &[0.0],
        );
    }

    proptest! {
        /// Karush, Kuhn and Tucker: where a coefficient is above 0 the gradient is 0, elsewhere it does not fall.
        #[test]
        fn no_coefficient_could_gain(
            rows in prop::collection::vec(prop::collection::vec(0.0f64..10.0, 4), 6..12),
            wanted in prop::collection::vec(-5.0f64..20.0, 12),
        ) {
            let wanted = &wanted[..rows.len()];
            let x = non_negative_least_squares(&rows, wanted);
            let residual: Vec<f64> = rows.iter().zip(wanted)
                .map(|(r, w)| w - r.iter().zip(&x).map(|(a, b)| a * b).sum::<f64>())
                .collect();
            for (j, v) in x.iter().enumerate() {
                prop_assert!(*v >= 0.0);
                let gain: f64 = rows.iter().zip(&residual).map(|(r, e)| r[j] * e).sum();
                prop_assert!(gain < 1e-6, "{j}: {gain}");
                prop_assert!(*v == 0.0 || gain.abs() < 1e-6, "{j}: {v} {gain}");
            }
        }
    }
}
