use super::*;
use crate::Role;

fn drawn(law: &Durations) -> Vec<Nanos> {
    let mut stream = Stream::new(1, Role::RenderTime, 0);
    (0..20_000).map(|_| law.draw(&mut stream)).collect()
}

#[test]
fn draws_stay_in_their_support_and_reach_it() {
    for text in ["8", "uniform:1.3..3.3", "normal:8,0.5", "normal:1,1"] {
        let law: Durations = text.parse().unwrap();
        let drawn = drawn(&law);
        let (min, max) = (drawn.iter().min().unwrap(), drawn.iter().max().unwrap());
        assert!(law.min() <= *min && *max <= law.max(), "{text}");
        let mean = drawn.iter().map(|t| t.0 as f64).sum::<f64>() / drawn.len() as f64;
        if text != "normal:1,1" {
            // Five standard errors of at most 0.58 ms over √20,000.
            assert!(
                (mean - law.mean_ns()).abs() < 5.0 * 580_000.0 / 141.0,
                "{text}"
            );
        }
    }
    assert_eq!(
        "normal:1,1".parse::<Durations>().unwrap().min(),
        Nanos::ZERO
    );
}

#[test]
fn csv_with_and_without_a_header() {
    let of = |text| Durations::from_csv(text, "t.csv", None);
    let law = of("frame,gpu_ms,cpu_ms\n0,8.5,1\n# stalled\n1,9.25,1\n\n2,7,1\n").unwrap();
    assert_eq!((law.min(), law.max()), (Nanos(7_000_000), Nanos(9_250_000)));
    assert_eq!(law.in_order().unwrap().len(), 3);
    assert!(
        drawn(&law)
            .iter()
            .all(|t| law.in_order().unwrap().contains(t))
    );
    assert_eq!(of("1.5\n2.5\n").unwrap().max(), Nanos(2_500_000));
    for (text, part) in [
        ("", "0 values"),
        ("gpu_ms\n", "0 values"),
        ("a,b\n1,2\n", "line 1"),
        ("1,2\n", "line 1"),
        ("x_ms\n8\n\nfast\n", "line 4 = `fast`"),
        ("x_ms\n-1\n", "line 2 = -1"),
        ("x_ms\nNaN\n", "line 2 = NaN"),
        ("i,x_ms\n3\n", "line 2 = 1 fields"),
    ] {
        let error = of(text).unwrap_err().to_string();
        assert!(
            error.contains("t.csv") && error.contains(part),
            "{text:?}: {error}"
        );
    }
}

#[test]
fn csv_columns_by_name() {
    let text = "Application,MsBetweenPresents,MsGPUActive\ngame.exe,11.1,7.5\ngame.exe,11.2,8\n";
    let of = |column| Durations::from_csv(text, "t.csv", Some(column)).map_err(|e| e.to_string());
    let law = of("MsGPUActive").unwrap();
    assert_eq!((law.min(), law.max()), (Nanos(7_500_000), Nanos(8_000_000)));
    assert!(
        of("Application")
            .unwrap_err()
            .contains("line 2 = `game.exe`")
    );
    // As it is written, and in a header only.
    for column in ["msgpuactive", "", "7.5"] {
        let error = of(column).unwrap_err();
        assert!(
            error.contains(&format!("a header with a column `{column}`")),
            "{error}"
        );
    }
    assert!(Durations::from_csv("1\n2\n", "t.csv", Some("1")).is_err());
}

#[test]
fn what_is_no_duration() {
    for text in [
        "",
        "x",
        "-1",
        "nan",
        "uniform:2..1",
        "uniform:2",
        "normal:1",
        "gamma:1,2",
        "1e9",
    ] {
        assert!(text.parse::<Durations>().is_err(), "{text}");
    }
}

#[test]
fn a_shift_never_goes_below_nothing() {
    let law: Durations = "uniform:1..3".parse().unwrap();
    let less = law.shifted(Nanos(-2_000_000));
    assert_eq!((less.min(), less.max()), (Nanos::ZERO, Nanos(1_000_000)));
}
