//! Pages as a browser sees them: no error on its console, nothing asked of any network.

use std::path::{Path, PathBuf};
use std::process::Command;

use foveasim::study::{AllPublished, Stein2021};

use crate::scratch::Scratch;

/// What a browser had to say of a page.
#[derive(Debug)]
struct Opened {
    /// Lines of its console.
    console: Vec<String>,
    /// Addresses that the page asked for.
    requests: Vec<String>,
    /// Length of the page as the browser understood it.
    length: usize,
}

/// Chromium or its like: `CHROME`, or the first of the usual names on the path.
#[expect(clippy::print_stderr, reason = "a test that checks nothing says so")]
fn browser() -> Option<PathBuf> {
    let given = std::env::var_os("CHROME").map(PathBuf::from);
    let found = given.or_else(|| {
        let names = ["chromium", "chromium-browser", "google-chrome", "chrome"];
        let path = std::env::var_os("PATH")?;
        let folders: Vec<PathBuf> = std::env::split_paths(&path).collect();
        let mut all = names
            .iter()
            .flat_map(|n| folders.iter().map(move |f| f.join(n)));
        all.find(|p| p.is_file())
    });
    if found.is_none() {
        eprintln!("skipped: no Chromium on the path, and CHROME is not set");
    }
    found
}

fn open(browser: &Path, page: &Path, folder: &Path) -> Opened {
    let log = folder.join("net.json");
    let ran = Command::new(browser)
        .args([
            "--headless",
            "--no-sandbox",
            "--disable-gpu",
            "--disable-background-networking",
            "--disable-component-update",
            "--disable-extensions",
            "--no-first-run",
            "--enable-logging=stderr",
            "--v=0",
            "--host-resolver-rules=MAP * ~NOTFOUND",
            "--dump-dom",
        ])
        .arg(format!(
            "--user-data-dir={}",
            folder.join("profile").display()
        ))
        .arg(format!("--log-net-log={}", log.display()))
        .arg(format!("file://{}", page.display()))
        .output()
        .expect("the browser runs");
    let said = String::from_utf8_lossy(&ran.stderr);
    assert!(ran.status.success(), "{said}");
    Opened {
        console: said
            .lines()
            .filter(|l| l.contains(":CONSOLE"))
            .map(str::to_owned)
            .collect(),
        requests: requests(&std::fs::read_to_string(log).expect("a log of the network")),
        length: ran.stdout.len(),
    }
}

/// What pages asked for: the browser's own requests have no origin.
fn requests(log: &str) -> Vec<String> {
    let log: serde_json::Value = serde_json::from_str(log).expect("a log of the network is JSON");
    let kind = &log["constants"]["logSourceType"]["URL_REQUEST"];
    assert!(kind.is_number(), "the log says what a request is");
    let events = log["events"].as_array().expect("events");
    events
        .iter()
        .filter(|e| e["source"]["type"] == *kind)
        .filter(|e| {
            let initiator = e["params"]["initiator"].as_str();
            initiator.is_some_and(|i| i != "not an origin")
        })
        .filter_map(|e| e["params"]["url"].as_str())
        .map(str::to_owned)
        .collect()
}

#[test]
fn pages_need_nothing_and_complain_of_nothing() {
    let Some(browser) = browser() else { return };
    let scratch = Scratch::new();
    // What the test looks for is seen where it is.
    let wrong =
        "<script>console.error('told');nothing();</script><img src='http://x.example/a.png'>";
    let wrong = scratch.write("wrong.html", wrong);
    let words =
        "run --runs 2000 --images 1 --method layers:3,layers:2 --fov 60,100 --ppd-centre 20,40";
    scratch.ok(&words.split(' ').collect::<Vec<_>>());
    let stein = Stein2021::run(2000, 1).expect("embedded presets");
    let all = AllPublished {
        numbers: stein.reproduction().published,
        quick: true,
    };
    let reproduced = scratch.write("all.html", all.page());
    for (name, page) in [
        ("run", scratch.path("out/report.html")),
        ("reproduce", reproduced),
    ] {
        let folder = scratch.path(name);
        std::fs::create_dir(&folder).unwrap();
        let opened = open(&browser, &page, &folder);
        assert_eq!(opened.console, [""; 0], "{name}");
        assert_eq!(opened.requests, [""; 0], "{name}");
        let size = std::fs::metadata(&page).unwrap().len() as usize;
        assert!(opened.length > size / 2, "{name}: all of it is read");
    }
    let folder = scratch.path("wrong");
    std::fs::create_dir(&folder).unwrap();
    let opened = open(&browser, &wrong, &folder);
    assert_eq!(opened.console.len(), 2, "{opened:?}");
    assert_eq!(opened.requests, ["http://x.example/a.png"]);
}
