//! A paper's tables and figures beside ours.

use crate::scratch::{Scratch, number, rows};

#[test]
fn all_papers_in_small() {
    let scratch = Scratch::new();
    let out = scratch.ok(&["reproduce", "all", "--quick", "--out", "all"]);
    assert!(out.contains("all/report.html"), "says where it is: {out}");
    let html = scratch.read("all/report.html");
    let numbers = rows(&scratch.read("all/published.csv"));
    for paper in [
        "guenter2012",
        "friston2019",
        "bruder2019",
        "meng2020",
        "stein2021",
    ] {
        let of_paper = numbers.iter().filter(|r| r["paper"] == paper);
        assert!(of_paper.count() >= 4, "{paper}");
        let title = paper.strip_suffix("2012").unwrap_or(&paper[..4]);
        assert!(html.to_lowercase().contains(title), "{paper}");
        let names = scratch.names(&format!("all/{paper}"));
        let page = names.iter().any(|n| n == "report.html");
        assert_eq!(page, paper != "stein2021", "{names:?}");
    }
    for row in &numbers {
        let verdict = row["verdict"].as_str();
        assert!(["agreed", "explained"].contains(&verdict), "{row:?}");
        assert_eq!(verdict == "explained", !row["why"].is_empty(), "{row:?}");
        let measured = row["basis"].starts_with("measured");
        assert!(!measured || verdict == "explained", "{row:?}");
    }
    let agreed = numbers.iter().filter(|r| r["verdict"] == "agreed");
    assert!(agreed.count() >= 80, "pure mathematics agrees");
    std::fs::rename(scratch.path("all/guenter2012"), scratch.path("g")).unwrap();
    guenter_2012(&scratch);
}

/// What is in the folder `g`.
fn guenter_2012(scratch: &Scratch) {
    let names = scratch.names("g");
    for name in [
        "antialiasing-flicker.svg",
        "antialiasing-pixels.svg",
        "antialiasing-ssim.svg",
        "antialiasing.csv",
        "fig10-11.csv",
        "fig10.svg",
        "fig11-pixels.svg",
        "fig11-time.svg",
        "fig12-13.csv",
        "fig12-a.svg",
        "fig12-b.svg",
        "fig13-a.svg",
        "fig13-b.svg",
        "fig5.csv",
        "fig5.svg",
        "report.html",
        "table1.csv",
    ] {
        assert!(names.iter().any(|n| n == name), "{name} in {names:?}");
    }
    let html = scratch.read("g/report.html");
    for part in [
        "Table 1", "Fig. 5", "Fig. 10", "Fig. 11", "Fig. 12", "Fig. 13",
    ] {
        assert!(html.contains(part), "{part}");
    }

    let table = rows(&scratch.read("g/table1.csv"));
    assert_eq!(table.len(), 36);
    for cell in &table {
        let name = format!("{} {}", cell["content"], cell["column"]);
        assert!(number(cell, "median_ms") > 0.0, "{name}");
        assert!(number(cell, "speedup_over_N2") > 0.0, "{name}");
    }
    let cell = |content: &str, column: &str| {
        let mut found = table.iter();
        found
            .find(|r| r["content"] == content && r["column"] == column)
            .expect("every cell")
    };
    assert_eq!(number(cell("Full", "N2"), "speedup_over_N2"), 1.0);
    assert_eq!(number(cell("Full", "Q_A"), "paper_ms"), 4.9);
    assert_eq!(
        number(cell("No SkyBox", "N0"), "samples_per_frame"),
        256.0 * 144.0
    );

    assert_eq!(number(cell("No Render", "Q_A"), "samples_per_frame"), 0.0);

    // The closed forms do not depend on how small the pictures are.
    let predicted = rows(&scratch.read("g/fig12-13.csv"));
    let at_70 = predicted
        .iter()
        .find(|r| r["fov_deg"] == "70" && r["slope"] == "A" && r["curve"] == "n = 4")
        .expect("70 degrees");
    assert!((number(at_70, "speedup") - 103.0).abs() < 0.1);
    let latency = rows(&scratch.read("g/fig5.csv"));
    assert!((number(&latency[4], "worst_ms") - 40.97).abs() < 0.01);
    assert_eq!(rows(&scratch.read("g/fig10-11.csv")).len(), 19);
    // Seven ways, each as a whole and in six rings.
    assert_eq!(rows(&scratch.read("g/antialiasing.csv")).len(), 7 * 7);
}

#[test]
fn what_cannot_be_reproduced_is_said() {
    let scratch = Scratch::new();
    for (words, expect) in [
        (vec!["guenter2013"], "did you mean `guenter2012`?"),
        (vec!["guenter2012", "--frames", "0"], "from 1 to 1000"),
        (vec!["guenter2012", "--frames", "-3"], "--frames"),
        (vec!["guenter2012", "--size", "0x9"], "WIDTHxHEIGHT"),
        (vec!["guenter2012", "--quick", "--frames", "3"], "--quick"),
        (vec!["al"], "did you mean `all`?"),
        (vec!["all", "--frames", "3"], "all takes --quick alone"),
        (vec!["all", "--cameras", "3"], "all takes --quick alone"),
        (vec!["stein2021", "--quick"], "draws nothing"),
        (
            vec!["meng2020", "--antialiasing-frames", "2"],
            "has no antialiasing",
        ),
        (vec!["friston2019", "--gazes", "2"], "has no volumes"),
        (
            vec!["guenter2012", "--antialiasing-frames", "5000"],
            "from 0 to 1000",
        ),
    ] {
        let words: Vec<&str> = ["reproduce"].into_iter().chain(words).collect();
        let ran = scratch.run(&words);
        assert_eq!(ran.code, 2, "{words:?}: {}", ran.out);
        assert!(ran.err.contains(expect), "{words:?}: {}", ran.err);
        assert_eq!(ran.err.lines().count(), 1, "{words:?}: {}", ran.err);
    }
}

#[test]
fn meng_2020() {
    let scratch = Scratch::new();
    let csv = scratch.ok(&[
        "reproduce",
        "meng2020",
        "--quick",
        "--format",
        "csv",
        "--out",
        "m",
    ]);
    let caption = rows(&csv);
    assert!((number(&caption[1], "mean_of_rows") - 1.276_173_763).abs() < 1e-8);
    assert_eq!(caption[1]["caption_possible"], "no");
    assert_eq!(rows(&scratch.read("m/fig7.csv")).len(), 11);
    assert!(
        scratch
            .read("m/report.html")
            .contains("Fig. 7 against its caption")
    );
    let times = rows(&scratch.read("m/times.csv"));
    assert_eq!(times[0]["method"], "full");
    assert!(times.iter().any(|r| r["method"] == "efr:2:3:published"));
    assert!(
        rows(&scratch.read("m/errors.csv"))
            .iter()
            .any(|r| r["label"] == "lens-matched")
    );
    assert!(scratch.read("m/errors.svg").contains("even grid"));
}
