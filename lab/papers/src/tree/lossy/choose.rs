//! Chooses which blocks of one height are replaced, and by which. The order is by cost per block saved,
//! lowest first; then targets that stay anyway; then targets that most other blocks resemble, so that many
//! merge into one. A block that has replaced another stays, and a block that has been replaced is no longer a
//! target.

use crate::tree::lossy::candidate::Candidate;
use crate::tree::lossy::facts::Facts;

/// The choices made for the blocks of one height.
pub(crate) struct Chosen {
    /// The target of the words that pointed to each block, counted from the first block of the height.
    pub(crate) target: Vec<u32>,
    /// Number of blocks replaced.
    pub(crate) count: u64,
}

#[derive(Clone, Copy, PartialEq)]
enum Role {
    Open,
    Stays,
    Gone,
}

/// Chooses among the candidates; returns `None` if there are no candidates. The cost is deducted from `left`.
pub(crate) fn choose(
    mut candidates: Vec<Candidate>,
    facts: &[Facts],
    first: usize,
    left: &mut u64,
) -> Option<Chosen> {
    if candidates.is_empty() {
        return None;
    }
    let at = |block: u32| block as usize - first;
    let mut resembled = vec![0_u32; facts.len() - first];
    for c in &candidates {
        resembled[at(c.target)] += 1;
    }
    candidates.sort_unstable_by(|a, b| {
        let cost = |c: &Candidate, other: &Candidate| c.cost * u64::from(facts[other.source as usize].saved);
        let stays = |c: &Candidate| facts[c.target as usize].single;
        let alone = |c: &Candidate| u32::MAX - resembled[at(c.target)];
        (cost(a, b), stays(a), alone(a), a.source, a.target).cmp(&(
            cost(b, a),
            stays(b),
            alone(b),
            b.source,
            b.target,
        ))
    });
    let mut role = vec![Role::Open; facts.len() - first];
    let mut target: Vec<u32> = (first as u32..facts.len() as u32).collect();
    let mut count = 0;
    for c in candidates {
        let (from, to) = (at(c.source), at(c.target));
        if role[from] == Role::Open && role[to] != Role::Gone && c.cost <= *left {
            *left -= c.cost;
            role[from] = Role::Gone;
            role[to] = Role::Stays;
            target[from] = c.target;
            count += 1;
        }
    }
    Some(Chosen { target, count })
}
