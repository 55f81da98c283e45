//! Parser of callgrind's profiles whose names and positions are not compressed.
//!
//! Source: *Callgrind Format Specification*, the manual of valgrind 3. `fn=` begins a function, `cfn=` names
//! a function that it calls, `calls=` gives the number of calls, and the line after that has the instructions
//! that they took.

use std::collections::BTreeMap;

/// Returns the instructions of each function including its callees. Calls of a function to itself are not
/// counted again.
pub(super) fn inclusive(profile: &str) -> BTreeMap<&str, u64> {
    let mut sums = BTreeMap::new();
    let (mut caller, mut callee) = ("", "");
    let mut lines = profile.lines();
    while let Some(line) = lines.next() {
        if let Some(name) = line.strip_prefix("fn=") {
            caller = name;
        } else if let Some(name) = line.strip_prefix("cfn=") {
            callee = name;
        } else if line.starts_with("calls=") {
            let cost = lines.next().and_then(|l| l.split_whitespace().nth(1)?.parse::<u64>().ok());
            if callee != caller {
                *sums.entry(callee).or_default() += cost.unwrap_or_default();
            }
        }
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::inclusive;

    #[test]
    fn inclusive_sums_a_function_over_all_callers() {
        let profile = "events: Ir\n\nfn=main\n10 5\ncfn=bake\ncalls=1 20\n11 300\n20 7\ncfn=look up\ncalls=2 30\n21 40\n\n\
                       fn=bake\n20 100\ncfn=bake\ncalls=3 20\n22 90\ncfn=look up\ncalls=1 30\n23 110\n";
        let sums: Vec<_> = inclusive(profile).into_iter().collect();
        assert_eq!(sums, [("bake", 300), ("look up", 150)]);
    }
}
