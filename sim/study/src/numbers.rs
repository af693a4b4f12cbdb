use foveasim_models::ModelError;

/// The most numbers one list may have.
const MOST: usize = 1_000_000;

/// Reads numbers and inclusive ranges `from..to:step`, separated by commas: `70`, `10..130:5`,
/// `40,60..100:20`.
///
/// # Errors
/// Says which part is not a finite number or not a range, or that there are more than a million.
pub fn parse_numbers(text: &str) -> Result<Vec<f64>, ModelError> {
    parse(text).map_err(ModelError::Syntax)
}

fn parse(text: &str) -> Result<Vec<f64>, String> {
    let mut values = Vec::new();
    for part in text.split(',').map(str::trim) {
        match part.split_once("..") {
            None => values.push(number(part)?),
            Some((from, rest)) => range(part, from, rest, &mut values)?,
        }
        if values.len() > MOST {
            return Err(too_many(text));
        }
    }
    Ok(values)
}

fn range(part: &str, from: &str, rest: &str, values: &mut Vec<f64>) -> Result<(), String> {
    let (to, step) = rest
        .split_once(':')
        .ok_or_else(|| format!("`{part}` has no step: write it as in 10..130:5"))?;
    let (from, to, step) = (number(from)?, number(to)?, number(step)?);
    if from > to {
        return Err(format!(
            "`{part}` runs backwards: write {to}..{from}:{step}"
        ));
    }
    if step <= 0.0 {
        return Err(format!("`{part}` has step {step}: must be above 0"));
    }
    // The end belongs to the range even where the step has no exact binary form.
    let last = ((to - from) / step + 1e-9).floor();
    if last.is_nan() || last >= MOST as f64 {
        return Err(too_many(part));
    }
    // From the integer k, never by adding up; nine decimals hide the step's own binary form.
    let nine = |v: f64| {
        if v.abs() < 1e6 {
            (v * 1e9).round() / 1e9
        } else {
            v
        }
    };
    values.extend((0..=last as u32).map(|k| nine(from + f64::from(k) * step)));
    Ok(())
}

fn number(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err(format!(
            "`{text}` is not a finite number; want 70, 10..130:5, or a list of them"
        )),
    }
}

fn too_many(text: &str) -> String {
    format!("`{text}` is more than {MOST} numbers")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_and_ranges() {
        assert_eq!(parse("70").unwrap(), [70.0]);
        assert_eq!(parse("0.1..0.5:0.2, 7").unwrap(), [0.1, 0.3, 0.5, 7.0]);
        let wide = parse("10..130:5").unwrap();
        assert_eq!((wide.len(), wide[0], wide[24]), (25, 10.0, 130.0));
        assert_eq!(parse("5..5:1").unwrap(), [5.0]);
        assert_eq!(parse("0..1:0.3").unwrap(), [0.0, 0.3, 0.6, 0.9]);
    }

    #[test]
    fn bad_lists_say_why() {
        for (text, expect) in [
            ("", "not a finite number"),
            ("nan", "not a finite number"),
            ("1e999", "not a finite number"),
            ("10,,20", "not a finite number"),
            ("10..20", "has no step"),
            ("20..10:1", "runs backwards: write 10..20:1"),
            ("10..20:0", "must be above 0"),
            ("10..20:-1", "must be above 0"),
            ("10..20:nan", "not a finite number"),
            ("0..1:1e-9", "more than 1000000 numbers"),
            ("-1e308..1e308:1e-300", "more than 1000000 numbers"),
        ] {
            let error = parse(text).unwrap_err();
            assert!(error.contains(expect), "{text}: {error}");
        }
    }
}
