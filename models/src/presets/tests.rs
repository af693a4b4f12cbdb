use super::*;

/// Every number in the file has an entry in `sources`, and every entry says something.
fn check_sources(text: &str, sources: &BTreeMap<String, Source>) {
    fn leaves(prefix: &str, value: &toml::Value, out: &mut Vec<String>) {
        match value {
            toml::Value::Table(t) => {
                for (key, v) in t {
                    let path = if prefix.is_empty() {
                        key.clone()
                    } else {
                        format!("{prefix}.{key}")
                    };
                    if path != "sources" {
                        leaves(&path, v, out);
                    }
                }
            }
            toml::Value::String(_) => {}
            _ => out.push(prefix.to_owned()),
        }
    }
    let mut paths = Vec::new();
    leaves(
        "",
        &toml::from_str::<toml::Value>(text).unwrap(),
        &mut paths,
    );
    for path in &paths {
        let source = sources
            .get(path)
            .unwrap_or_else(|| panic!("{path} has no source"));
        assert!(!source.source.is_empty() || source.unverified, "{path}");
    }
}

#[test]
fn every_preset_is_valid_and_sourced() {
    for (name, text) in DISPLAYS {
        let spec = display_spec(name).unwrap();
        assert_eq!(spec.name, *name);
        check_sources(text, &spec.sources);
        let display = display(name).unwrap();
        assert!(
            display.fov_h_deg() > 20.0 && display.fov_h_deg() < 130.0,
            "{name}"
        );
    }
    for (name, text) in COSTS {
        let profile = cost(name).unwrap();
        assert_eq!(profile.name, *name);
        check_sources(text, &profile.sources);
    }
    for (name, text) in TRACKERS {
        let spec = tracker_spec(name).unwrap();
        assert_eq!(spec.name, *name);
        check_sources(text, &spec.sources);
        tracker(name).unwrap();
    }
}

#[test]
fn a_source_for_no_field_is_refused() {
    let text = tracker_text("tx300")
        .unwrap()
        .replace("rate_hz = {", "rate_hs = {");
    let error = parse_tracker(&text, "mine.toml").unwrap_err().to_string();
    assert!(
        error.contains("mine.toml") && error.contains("did you mean `rate_hz`"),
        "{error}"
    );
}

#[test]
fn an_unknown_key_is_refused_with_its_line() {
    let text = "name = 'x'\nrate_hz = 1\nexposure_ms = 1\nprocessing_ms = [1, 2]\nbais_deg = 1";
    let error = parse_tracker(text, "file.toml").unwrap_err().to_string();
    assert!(
        error.contains("bais_deg") && error.contains("line 5"),
        "{error}"
    );
}
