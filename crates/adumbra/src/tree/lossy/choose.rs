//! Which blocks of one height give way, and to which: the cheapest for what they save first; then to blocks that stay
//! anyway, then to those that most others resemble, so that many gather around one. A block that another gave way to
//! stays, and one that gave way is nobody's target.

use super::round::Facts;

/// One block might give way to another.
#[derive(Clone, Copy)]
pub(super) struct Candidate {
    pub(super) source: u32,
    pub(super) target: u32,
    /// Voxels that change.
    pub(super) cost: u64,
}

/// What became of a height's blocks.
pub(super) struct Chosen {
    /// Where the words that pointed to a block, counted from the height's first, now point.
    pub(super) target: Vec<u32>,
    /// Blocks that gave way.
    pub(super) count: u64,
}

#[derive(Clone, Copy, PartialEq)]
enum Role {
    Open,
    Stays,
    Gone,
}

/// Chooses among the candidates; none where there are none. What it costs is taken from `left`.
pub(super) fn choose(
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
