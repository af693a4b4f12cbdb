/// Least and greatest values of the 3×3 samples around each sample of a row.
///
/// Plain loops of comparison and selection, whose results IEEE 754 defines; the compiler gives them
/// the vector width of the kernel that calls. NaN stands for a sample that was not drawn: it is left
/// out, and so is whatever lies beyond the lattice.
#[derive(Debug, Default)]
pub(crate) struct Extremes {
    /// Least and greatest of three rows, a sample of NaN before the first and after the last.
    column_least: Vec<f32>,
    column_greatest: Vec<f32>,
    /// Least of the neighbourhood; infinite where none was drawn.
    pub(super) least: Vec<f32>,
    /// Greatest of the neighbourhood; −infinite where none was drawn.
    pub(super) greatest: Vec<f32>,
}

#[inline(always)]
fn least(a: f32, b: f32, c: f32) -> f32 {
    let m = if a < f32::INFINITY { a } else { f32::INFINITY };
    let m = if b < m { b } else { m };
    if c < m { c } else { m }
}

#[inline(always)]
fn greatest(a: f32, b: f32, c: f32) -> f32 {
    let m = if a > f32::NEG_INFINITY {
        a
    } else {
        f32::NEG_INFINITY
    };
    let m = if b > m { b } else { m };
    if c > m { c } else { m }
}

impl Extremes {
    /// Finds them for `row`, whose samples have `N` values each, between the rows above and below
    /// (itself, where there is none).
    #[inline(always)]
    pub(super) fn find<const N: usize>(&mut self, above: &[f32], row: &[f32], below: &[f32]) {
        let n = row.len();
        for column in [&mut self.column_least, &mut self.column_greatest] {
            column.resize(n + 2 * N, f32::NAN);
            column[..N].fill(f32::NAN);
            column[N + n..].fill(f32::NAN);
        }
        let (above, below) = (&above[..n], &below[..n]);
        let low = &mut self.column_least[N..N + n];
        let high = &mut self.column_greatest[N..N + n];
        for i in 0..n {
            low[i] = least(row[i], above[i], below[i]);
            high[i] = greatest(row[i], above[i], below[i]);
        }
        self.least.resize(n, 0.0);
        self.greatest.resize(n, 0.0);
        let (low, high) = (&self.column_least, &self.column_greatest);
        let (out_low, out_high) = (&mut self.least[..n], &mut self.greatest[..n]);
        let (l0, l1, l2) = (&low[..n], &low[N..N + n], &low[2 * N..2 * N + n]);
        let (h0, h1, h2) = (&high[..n], &high[N..N + n], &high[2 * N..2 * N + n]);
        for i in 0..n {
            out_low[i] = least(l1[i], l0[i], l2[i]);
            out_high[i] = greatest(h1[i], h0[i], h2[i]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbourhoods_leave_out_what_was_not_drawn() {
        let nan = f32::NAN;
        let rows = [
            [4.0, nan, 2.0, 7.0, nan, nan],
            [5.0, 1.0, nan, nan, nan, nan],
            [3.0, 8.0, nan, nan, nan, nan],
        ];
        let mut found = Extremes::default();
        found.find::<1>(&rows[0], &rows[1], &rows[2]);
        let none = f32::INFINITY;
        assert_eq!(found.least, [1.0, 1.0, 1.0, 2.0, 7.0, none]);
        assert_eq!(found.greatest, [8.0, 8.0, 8.0, 7.0, 7.0, -none]);

        // Two values per sample do not mix.
        found.find::<2>(&[1.0, 10.0, 2.0, 20.0], &[3.0, 30.0, 4.0, 40.0], &[0.5; 4]);
        assert_eq!(found.least, [0.5, 0.5, 0.5, 0.5]);
        assert_eq!(found.greatest, [4.0, 40.0, 4.0, 40.0]);
    }
}
