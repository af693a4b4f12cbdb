/// A colour map whose lightness grows steadily, so that order is seen even without colour.
///
/// Polynomials of degree six in each sRGB channel, fitted to matplotlib's maps by Matt Zucker
/// (<https://www.shadertoy.com/view/WlfXRN>, public domain); within 0.02 of the original tables.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ColourMap {
    /// Dark blue over green to yellow: for quantities.
    Viridis,
    /// Black over red to pale yellow: for errors, black where there is none.
    Inferno,
}

const VIRIDIS: [[f64; 3]; 7] = [
    [
        0.277_727_327_223_417_7,
        0.005_407_344_544_966_578,
        0.334_099_805_335_306_1,
    ],
    [
        0.105_093_043_108_577_4,
        1.404_613_529_898_575,
        1.384_590_162_594_685,
    ],
    [
        -0.330_861_828_725_556_3,
        0.214_847_559_468_213,
        0.095_095_163_028_236_59,
    ],
    [
        -4.634_230_498_983_486,
        -5.799_100_973_351_585,
        -19.332_440_956_279_87,
    ],
    [
        6.228_269_936_347_081,
        14.179_933_366_805_09,
        56.690_552_600_681_05,
    ],
    [
        4.776_384_997_670_288,
        -13.745_145_377_746_01,
        -65.353_032_633_372_34,
    ],
    [
        -5.435_455_855_934_631,
        4.645_852_612_178_535,
        26.312_435_249_583_2,
    ],
];

const INFERNO: [[f64; 3]; 7] = [
    [
        0.000_218_940_369_119_226_5,
        0.001_651_004_631_001_012,
        -0.019_480_898_437_091_84,
    ],
    [
        0.106_513_419_485_611_6,
        0.563_956_436_788_409_1,
        3.932_712_388_889_277,
    ],
    [
        11.602_493_082_471_87,
        -3.972_853_965_665_698,
        -15.942_394_106_291_4,
    ],
    [
        -41.703_996_131_394_59,
        17.436_398_882_053_13,
        44.354_145_198_728_13,
    ],
    [
        77.162_935_699_427,
        -33.402_358_942_100_92,
        -81.807_309_257_389_93,
    ],
    [
        -71.319_428_244_992_14,
        32.626_064_263_977_23,
        73.209_519_858_032_02,
    ],
    [
        25.131_126_224_773_41,
        -12.242_668_952_385_67,
        -23.070_325_002_871_72,
    ],
];

impl ColourMap {
    /// The 8-bit sRGB colour at `t`, 0 to 1; clamps, NaN counts as 0.
    pub fn at(self, t: f64) -> [u8; 3] {
        let table = match self {
            Self::Viridis => &VIRIDIS,
            Self::Inferno => &INFERNO,
        };
        let t = if t.is_nan() { 0.0 } else { t.clamp(0.0, 1.0) };
        std::array::from_fn(|c| {
            let v = table
                .iter()
                .rev()
                .fold(0.0, |sum, coefficients| sum * t + coefficients[c]);
            (v.clamp(0.0, 1.0) * 255.0 + 0.5) as u8
        })
    }
}

/// Whether black, rather than white, is legible on a colour: by luma, Rec. 601.
pub(crate) fn is_light([r, g, b]: [u8; 3]) -> bool {
    0.299 * f64::from(r) + 0.587 * f64::from(g) + 0.114 * f64::from(b) > 130.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_are_those_of_the_original_tables() {
        let close = |a: [u8; 3], b: [u8; 3]| a.iter().zip(b).all(|(a, b)| a.abs_diff(b) <= 6);
        assert!(close(ColourMap::Viridis.at(0.0), [0x44, 0x01, 0x54]));
        assert!(close(ColourMap::Viridis.at(0.5), [0x21, 0x91, 0x8c]));
        assert!(close(ColourMap::Viridis.at(1.0), [0xfd, 0xe7, 0x25]));
        assert!(close(ColourMap::Inferno.at(0.0), [0x00, 0x00, 0x04]));
        assert!(close(ColourMap::Inferno.at(0.5), [0xbc, 0x37, 0x54]));
        assert!(close(ColourMap::Inferno.at(1.0), [0xfc, 0xff, 0xa4]));
    }

    #[test]
    fn lightness_grows_all_the_way() {
        for map in [ColourMap::Viridis, ColourMap::Inferno] {
            let luma = |t: f64| {
                let [r, g, b] = map.at(t).map(f64::from);
                0.299 * r + 0.587 * g + 0.114 * b
            };
            for k in 0..50 {
                let (low, high) = (luma(f64::from(k) / 50.0), luma(f64::from(k + 1) / 50.0));
                assert!(high > low, "{map:?} at {k}: {low} then {high}");
            }
        }
    }
}
