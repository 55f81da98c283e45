//! Checks that the guide to what apps may do names an existing test for each situation.

use std::fs;
use std::path::{Path, PathBuf};

const GUIDE: &str = "docs/guides/what-your-app-may-do.md";

/// Returns the possible paths of a test file, below the folder of the integrations.
fn files(name: &str) -> Vec<PathBuf> {
    let three = ["unit/", ""].map(|folder| format!("three/tests/{folder}{name}.test.ts"));
    let bevy = ["tests/", ""].map(|folder| format!("bevy_adumbra/{folder}{name}.rs"));
    [three, bevy].into_iter().flatten().map(PathBuf::from).collect()
}

/// Returns the parts of a cell of tests: a file and a part of a test's name. A file may have several.
fn tests(cell: &str) -> Vec<(String, &str)> {
    let mut file = String::new();
    let named = cell.split('*').collect::<Vec<_>>();
    let pairs = named.as_chunks().0.iter().map(|[before, name]| {
        let new = before.trim_matches([' ', ',', ':']);
        if !new.is_empty() {
            file = new.to_owned();
        }
        (file.clone(), *name)
    });
    pairs.collect()
}

/// Whether a text has all parts of a name in one line; `…` stands for anything.
fn has_test(text: &str, name: &str) -> bool {
    text.lines().any(|line| {
        let mut rest = Some(line);
        for part in name.split('…') {
            rest = rest.and_then(|rest| Some(rest.split_once(part.trim())?.1));
        }
        rest.is_some()
    })
}

#[test]
fn every_situation_has_a_test() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let guide = fs::read_to_string(root.join(GUIDE)).unwrap();
    let (mut rows, mut faults) = (0, Vec::new());
    for line in
        guide.lines().filter(|line| line.starts_with("| ") && !line.starts_with("| what the app does"))
    {
        rows += 1;
        let cell = line.trim_matches(['|', ' ']).rsplit(" | ").next().unwrap();
        let tests = tests(cell);
        if tests.is_empty() {
            faults.push(format!("no test: {line}"));
        }
        for (file, name) in tests {
            let known = files(&file)
                .into_iter()
                .find_map(|path| fs::read_to_string(root.join("integrations").join(path)).ok());
            if !known.is_some_and(|text| has_test(&text, name)) {
                faults.push(format!("no test {file}: {name}"));
            }
        }
    }
    assert!(rows > 50, "{rows} rows in {GUIDE}");
    assert!(faults.is_empty(), "{GUIDE}:\n{}", faults.join("\n"));
}
