use foveasim_models::math;

/// Three significant digits, or all digits of a whole number.
pub(crate) fn short(v: f64) -> String {
    if !v.is_finite() {
        return "–".into();
    }
    if v.abs() < 1e15 && (v - v.round()).abs() < 1e-9 {
        return grouped(v);
    }
    let magnitude = math::log10(v.abs()).floor();
    if !(-4.0..9.0).contains(&magnitude) {
        return format!("{v:.1e}");
    }
    if magnitude >= 4.0 {
        return grouped(v);
    }
    format!("{v:.*}", (2.0 - magnitude).clamp(0.0, 6.0) as usize)
}

/// A whole number; from 10,000 on with commas between thousands.
fn grouped(v: f64) -> String {
    let digits = format!("{:.0}", v.abs());
    let sign = if v < 0.0 && digits != "0" { "-" } else { "" };
    if digits.len() < 5 {
        return format!("{sign}{digits}");
    }
    let mut out = String::from(sign);
    for (k, digit) in digits.chars().enumerate() {
        if k > 0 && (digits.len() - k) % 3 == 0 {
            out.push(',');
        }
        out.push(digit);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn short_numbers() {
        let texts = [
            13.29,
            103.04,
            1920.0,
            0.0275,
            1.0,
            12_345.6,
            2_073_600.0,
            -0.0,
            f64::NAN,
        ]
        .map(short);
        assert_eq!(
            texts,
            [
                "13.3",
                "103",
                "1920",
                "0.0275",
                "1",
                "12,346",
                "2,073,600",
                "0",
                "–"
            ]
        );
    }
}
