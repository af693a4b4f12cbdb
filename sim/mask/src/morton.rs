use glam::DVec2;

use crate::spec::SUBPIXELS;

/// The order of `sites` along Morton's curve: by the bits of both coordinates, interleaved, all of them.
pub(crate) fn morton_order(sites: &[DVec2]) -> Vec<u32> {
    let key = |site: &DVec2| {
        let [x, y] = [site.x, site.y].map(|v| (v * SUBPIXELS) as u32);
        spread(x) | spread(y) << 1
    };
    let mut keyed: Vec<(u64, u32)> = sites.iter().map(key).zip(0..).collect();
    keyed.sort_unstable();
    keyed.into_iter().map(|(_, index)| index).collect()
}

/// The bits of `v`, one place apart.
fn spread(v: u32) -> u64 {
    let mut v = u64::from(v);
    v = (v | v << 16) & 0x0000_ffff_0000_ffff;
    v = (v | v << 8) & 0x00ff_00ff_00ff_00ff;
    v = (v | v << 4) & 0x0f0f_0f0f_0f0f_0f0f;
    v = (v | v << 2) & 0x3333_3333_3333_3333;
    (v | v << 1) & 0x5555_5555_5555_5555
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quadrants_come_one_after_another() {
        let grid = (0..64).map(|k| DVec2::new(f64::from(k % 8) + 0.5, f64::from(k / 8) + 0.5));
        let order = morton_order(&grid.collect::<Vec<_>>());
        assert_eq!(order[..8], [0, 1, 8, 9, 2, 3, 10, 11]);
        assert_eq!(order[63], 63);
        let mut all = order.clone();
        all.sort_unstable();
        assert!(all.into_iter().eq(0..64));
    }

    #[test]
    fn bits_are_spread_to_even_places() {
        for k in 0..32 {
            assert_eq!(spread(1 << k), 1 << (2 * k));
        }
        assert_eq!(spread(u32::MAX), 0x5555_5555_5555_5555);
    }
}
