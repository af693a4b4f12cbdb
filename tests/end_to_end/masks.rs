//! Masks that follow the eye, and foveated volume rendering.

use crate::scratch::{Scratch, number, rows};

/// A mask small enough to wait for.
const BUILD: [&str; 7] = [
    "mask",
    "build",
    "--size",
    "96x80",
    "--fraction",
    "0.1",
    "--format=csv",
];

#[test]
fn masks_are_built_shown_and_kept() {
    let s = Scratch::new();
    let built = s.ok(&[&BUILD[..], &["--cache", "masks", "--out", "m"]].concat());
    for name in [
        "cells-near.png",
        "cells.png",
        "changes.svg",
        "convergence.csv",
        "convergence.svg",
        "distances.csv",
        "order-near.png",
        "order.png",
        "pairs.svg",
        "spacing.csv",
        "spacing.svg",
        "summary.csv",
    ] {
        assert!(s.names("m").iter().any(|n| n == name), "{name}");
    }
    let table = rows(&s.read("m/convergence.csv"));
    let last = table.last().expect("iterations");
    assert_eq!((number(last, "split"), number(last, "merged")), (0.0, 0.0));
    let whole = number(&table[0], "sum_of_shares_rays");
    assert!(
        table
            .iter()
            .all(|r| number(r, "sum_of_shares_rays") == whole)
    );
    // The same from the cache, and after the file was damaged, which is said.
    let again = [&BUILD[..], &["--cache", "masks"]].concat();
    assert_eq!(s.ok(&again), built);
    let [file] = &s.names("masks")[..] else {
        panic!("one mask: {:?}", s.names("masks"));
    };
    s.write(&format!("masks/{file}"), "not a mask");
    let ran = s.run(&again);
    assert_eq!((ran.code, ran.out), (0, built));
    assert!(ran.err.contains("built anew"), "{}", ran.err);
    let one = s.ok(&[&BUILD[..], &["--threads", "1"]].concat());
    assert_eq!(one, s.ok(&[&BUILD[..], &["--threads", "3"]].concat()));
}

#[test]
fn bruder_2019_in_small() {
    let s = Scratch::new();
    s.ok(&["reproduce", "bruder2019", "--quick", "--out", "b"]);
    for name in [
        "errors.csv",
        "errors.svg",
        "gazes.csv",
        "report.html",
        "speedup.svg",
        "table1-printed.csv",
        "table1.csv",
        "volume-1.png",
        "volume-2.png",
    ] {
        assert!(s.names("b").iter().any(|n| n == name), "{name}");
    }
    let gazes = rows(&s.read("b/gazes.csv"));
    assert_eq!(gazes.len(), 8);
    for row in &gazes {
        assert_eq!(number(row, "full_rays"), 96.0 * 96.0);
        assert!(number(row, "foveated_rays") < 0.2 * 96.0 * 96.0);
        assert!(number(row, "foveated_samples") <= number(row, "equal_steps_samples"));
        assert!(number(row, "full_ms") > 0.0 && number(row, "cast_ms") > 0.0);
    }
    assert_eq!(rows(&s.read("b/errors.csv")).len(), 2 * 7 * 4);
    // All but the times is the same again.
    s.ok(&[
        "reproduce",
        "bruder2019",
        "--quick",
        "--out",
        "c",
        "--threads",
        "1",
    ]);
    assert_eq!(s.read("b/errors.csv"), s.read("c/errors.csv"));
}
