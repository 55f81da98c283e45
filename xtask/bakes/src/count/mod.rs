//! Instructions of the hot steps, counted by valgrind's callgrind and compared with `docs/counts.json`. The
//! counts do not depend on the load of the machine.
//!
//! Counts also change with the compiler; the table names the compiler that it was made with. Hash tables have
//! the same seed in every run, so the counts of one program differ between runs by far less than the
//! tolerance.

mod profile;
mod steps;

use std::error::Error;
use std::path::Path;
use std::process::Command;
use std::{env, fs};

use serde_json::{Map, Value, json};

use steps::STEPS;

const TABLE: &str = "docs/counts.json";
/// Tolerance: a step may take at most this many times the instructions in the table.
const MOST: f64 = 1.03;
/// Option that `cargo xtask count` gets under valgrind.
const INSIDE: &str = "--inside";

pub(crate) fn run(root: &Path, options: &[&str]) -> Result<(), Box<dyn Error>> {
    let bless = match options {
        [INSIDE] => return steps::run(),
        [] => false,
        ["--bless"] => true,
        _ => return Err(format!("unknown options {options:?}; the only option is --bless").into()),
    };
    if !Command::new("valgrind").arg("--version").output().is_ok_and(|o| o.status.success()) {
        eprintln!(
            "SKIPPED: valgrind is not installed; it is needed to count instructions (apt-get install valgrind)"
        );
        return Ok(());
    }
    let counted = count()?;
    let path = root.join(TABLE);
    if bless {
        let steps: Map<String, Value> =
            counted.iter().map(|&(name, n)| (name.to_owned(), n.into())).collect();
        let table = json!({"target": target(), "rustc": compiler()?, "instructions": steps});
        fs::write(&path, format!("{table:#}\n"))?;
        eprintln!("wrote {}", path.display());
        return Ok(());
    }
    let table: Value = serde_json::from_slice(&fs::read(&path)?)?;
    if table["target"] != target() {
        eprintln!("SKIPPED: {TABLE} is for {}, this machine is {}", table["target"], target());
        return Ok(());
    }
    if table["rustc"] != compiler()? {
        eprintln!("note: {TABLE} was made with {}, this is {}", table["rustc"], compiler()?);
    }
    compare(&table["instructions"], &counted)
}

/// Prints the table, and returns an error if a count grew beyond the tolerance.
fn compare(table: &Value, counted: &[(&str, u64)]) -> Result<(), Box<dyn Error>> {
    let mut grown = Vec::new();
    for &(name, now) in counted {
        let before =
            table[name].as_u64().ok_or_else(|| format!("{TABLE} lacks {name:?}; write it with --bless"))?;
        let ratio = now as f64 / before as f64;
        println!("{name:32} {before:14} {now:14} {:+8.2} %", 100.0 * (ratio - 1.0));
        if ratio > MOST {
            grown.push(name);
        }
    }
    if grown.is_empty() {
        return Ok(());
    }
    Err(format!(
        "more than {:.0} % more instructions: {}; reduce them or, if they are worth it, write the table with \
         cargo xtask count --bless and say why",
        100.0 * (MOST - 1.0),
        grown.join(", ")
    )
    .into())
}

/// Runs the steps under callgrind and returns the instructions of each.
fn count() -> Result<Vec<(&'static str, u64)>, Box<dyn Error>> {
    let folder = env::temp_dir().join(format!("adumbra-count-{}", std::process::id()));
    fs::create_dir_all(&folder)?;
    let counted = count_in(&folder);
    fs::remove_dir_all(&folder)?;
    counted
}

fn count_in(folder: &Path) -> Result<Vec<(&'static str, u64)>, Box<dyn Error>> {
    let profile = folder.join("callgrind.out");
    let output = Command::new("valgrind")
        .args(["--tool=callgrind", "--compress-strings=no", "--compress-pos=no"])
        .arg(format!("--callgrind-out-file={}", profile.display()))
        .arg(env::current_exe()?)
        .args(["count", INSIDE])
        .output()?;
    if !output.status.success() {
        return Err(format!("the steps failed: {}", String::from_utf8_lossy(&output.stderr)).into());
    }
    let text = fs::read_to_string(&profile)?;
    let inclusive = profile::inclusive(&text);
    let count_of = |symbol: &[&str; 2]| -> u64 {
        let is_it = |name: &str| name.contains(symbol[0]) && name.ends_with(symbol[1]);
        inclusive.iter().filter(|(name, _)| is_it(name)).map(|(_, n)| n).sum()
    };
    STEPS
        .iter()
        .map(|step| match count_of(&step.symbol) {
            0 => Err(format!("no function {:?} was found: was it inlined?", step.symbol).into()),
            n => Ok((step.name, n)),
        })
        .collect()
}

fn target() -> String {
    format!("{}-{}", env::consts::ARCH, env::consts::OS)
}

fn compiler() -> Result<String, Box<dyn Error>> {
    let output = Command::new("rustc").arg("--version").output()?;
    Ok(String::from_utf8(output.stdout)?.trim().to_owned())
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::compare;

    #[test]
    fn compare_rejects_grown_and_new_steps() {
        let table = json!({"descent": 1_000_000, "join": 1_000});
        assert!(compare(&table, &[("descent", 1_030_000), ("join", 500)]).is_ok());
        let grown = compare(&table, &[("descent", 1_000_000), ("join", 1_031)]).unwrap_err().to_string();
        assert!(grown.contains("join") && !grown.contains("descent"), "{grown}");
        let new = compare(&table, &[("leaf", 1)]).unwrap_err().to_string();
        assert!(new.contains("leaf") && new.contains("--bless"), "{new}");
    }
}
