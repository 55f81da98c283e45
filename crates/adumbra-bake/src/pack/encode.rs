//! Converts the store to half-words in canonical order, with the most referenced shapes within reach of short pointers.
//!
//! Shapes are in order of last visit, children before parents, roots with x fastest. Before them come the shapes with
//! the most pointers for their length, as many as near pointers can address directly.

use std::collections::HashMap;

use crate::store::shapes::{Entry, INHERITS, NEVER, OWN, ShapeStore, entries};
use adumbra::layout::depths::code::NEAR;
use adumbra::layout::depths::{LEAF_LEVEL, NODE_LEVELS, UNIFORM};

/// A shape: its level as an index among the levels of shapes, 0 = leaves, and its index.
type Shape = (u8, u32);

/// Not yet written.
const NONE: u32 = u32::MAX;

/// Returns top, wide entries and code, from the store and the indices and bases of its roots.
pub(crate) fn encode(
    store: &ShapeStore,
    root_level: u32,
    mut top: Vec<[u32; 2]>,
) -> (Vec<[u32; 2]>, Vec<[u32; 2]>, Vec<u32>) {
    let root = ((root_level - LEAF_LEVEL) / NODE_LEVELS) as u8;
    let frequent = frequent_shapes(store, root, &top);
    let mut encoder = Encoder {
        store,
        halves: Vec::new(),
        places: counts(store, NONE),
        wide: Vec::new(),
        wide_places: HashMap::new(),
    };
    for shape in frequent {
        if encoder.halves.len() >= NEAR as usize {
            break;
        }
        encoder.emit(shape);
    }
    for entry in top.iter_mut().filter(|entry| entry[0] != UNIFORM) {
        entry[0] = encoder.emit((root, entry[0]));
    }
    let code =
        encoder.halves.chunks(2).map(|h| u32::from(h[0]) | h.get(1).map_or(0, |&h| u32::from(h) << 16));
    (top, encoder.wide, code.collect())
}

/// Returns a table with one value for every shape.
fn counts(store: &ShapeStore, value: u32) -> [Vec<u32>; 4] {
    std::array::from_fn(|kind| match kind {
        0 => vec![value; store.leaves.len()],
        _ => vec![value; store.nodes[kind - 1].len()],
    })
}

/// Returns the shapes with two or more pointers, sorted by pointers per half-word, then by first visit.
fn frequent_shapes(store: &ShapeStore, root: u8, top: &[[u32; 2]]) -> Vec<Shape> {
    let mut pointers = counts(store, 0);
    let mut visited: Vec<Shape> = Vec::new();
    let mut open: Vec<Shape> = Vec::new();
    for &[index, _] in top.iter().filter(|entry| entry[0] != UNIFORM) {
        open.push((root, index));
        while let Some((kind, index)) = open.pop() {
            let count = &mut pointers[kind as usize][index as usize];
            *count += 1;
            if *count > 1 {
                continue;
            }
            visited.push((kind, index));
            if kind > 0 {
                let first = open.len();
                store.nodes[kind as usize - 1].with(index, |words| {
                    let children = entries(words).filter(|e| e.index != UNIFORM);
                    open.extend(children.map(|e| (kind - 1, e.index)));
                });
                open[first..].reverse();
            }
        }
    }
    visited.retain(|&(kind, index)| pointers[kind as usize][index as usize] > 1);
    visited.sort_by_cached_key(|&(kind, index)| {
        let length = if kind == 0 {
            store.leaves.with(index, <[u16]>::len)
        } else {
            2 * store.nodes[kind as usize - 1].with(index, <[u32]>::len)
        };
        let saved = u64::from(pointers[kind as usize][index as usize]) << 16;
        std::cmp::Reverse(saved / length as u64)
    });
    visited
}

struct Encoder<'s> {
    store: &'s ShapeStore,
    halves: Vec<u16>,
    places: [Vec<u32>; 4],
    wide: Vec<[u32; 2]>,
    wide_places: HashMap<[u32; 2], u32>,
}

impl Encoder<'_> {
    /// Returns the shape's address. Writes it, and what it points to, if not yet written.
    fn emit(&mut self, (kind, index): Shape) -> u32 {
        let known = self.places[kind as usize][index as usize];
        if known != NONE {
            return known;
        }
        let at = if kind == 0 {
            let at = self.halves.len() as u32;
            self.store.leaves.with(index, |leaf| self.halves.extend_from_slice(leaf));
            at
        } else {
            let mut children = [(Entry { state: INHERITS, delta: 0, index: UNIFORM }, UNIFORM); 16];
            self.store.nodes[kind as usize - 1].with(index, |words| {
                children.iter_mut().zip(entries(words)).for_each(|(child, entry)| child.0 = entry);
            });
            for (entry, at) in children.iter_mut().filter(|(entry, _)| entry.index != UNIFORM) {
                *at = self.emit((kind - 1, entry.index));
            }
            self.node(&children)
        };
        self.places[kind as usize][index as usize] = at;
        at
    }

    /// Writes a node whose children are at these addresses.
    fn node(&mut self, children: &[(Entry, u32); 16]) -> u32 {
        let here = self.halves.len() as u32;
        self.halves.extend([0; 3]);
        let mut bits = [0_u16; 3];
        for (c, &(entry, at)) in children.iter().enumerate() {
            let near = match at {
                UNIFORM => None,
                _ if at < NEAR => Some(at as u16),
                _ if here - at < NEAR => Some((NEAR | (here - at)) as u16),
                _ => None,
            };
            let delta = i16::try_from(entry.delta as i32).ok();
            let mut put = |size: u16, kind: u16, halves: &[u16]| {
                bits[0] |= (size & 1) << c;
                bits[1] |= (size >> 1) << c;
                bits[2] |= kind << c;
                self.halves.extend_from_slice(halves);
            };
            let two = |word: u32| [word as u16, (word >> 16) as u16];
            match (entry.state, delta) {
                (INHERITS, _) => put(0, 0, &[]),
                (NEVER, _) => put(0, 1, &[]),
                (OWN, Some(delta)) => match near {
                    _ if at == UNIFORM => put(1, 1, &[delta as u16]),
                    Some(near) => put(2, 1, &[delta as u16, near]),
                    None => put(3, 0, &[delta as u16, two(at)[0], two(at)[1]]),
                },
                (OWN, None) => {
                    let next = self.wide.len() as u32;
                    let index = *self.wide_places.entry([entry.delta, at]).or_insert(next);
                    if index == next {
                        self.wide.push([entry.delta, at]);
                    }
                    put(3, 1, &[two(index)[0], two(index)[1], 0]);
                }
                _ => match near {
                    Some(near) => put(1, 0, &[near]),
                    None => put(2, 0, &two(at)),
                },
            }
        }
        self.halves[here as usize..][..3].copy_from_slice(&bits);
        here
    }
}
