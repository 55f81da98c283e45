//! Shapes as half-words, each after what it points to, with the shortest pointers that reach.

use adumbra::layout::depths::code::{self, Code, FAR, LeafHead, NEAR, NO_SHAPE};
use adumbra::layout::depths::{LEAF_LEVEL, NODE_LEVELS};

use super::shapes::{Child, Children, Shape, Shapes};

/// Where a shape is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Place {
    /// At an address of the common section, seen from a page.
    Common(u32),
    /// At an address of the part that is being written.
    Here(u32),
}

/// A child whose shape has a place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PlacedChild {
    Uniform(u32),
    Never,
    Shape { delta: u32, place: Place },
}

/// A pointer as a node stores it.
enum Pointer {
    Near(u16),
    Far(u32),
}

/// Writes the shapes of a page or of the common section.
#[derive(Debug)]
pub(super) struct Layout<'c> {
    /// The common section, unless that is what is written.
    common: Option<&'c [u32]>,
    pub(super) halves: Vec<u16>,
}

impl<'c> Layout<'c> {
    /// Begins a page that may refer to the words of a common section.
    pub(super) fn page(common: &'c [u32]) -> Self {
        Self { common: Some(common), halves: Vec::new() }
    }

    /// Begins a common section.
    pub(super) fn common() -> Self {
        Self { common: None, halves: Vec::new() }
    }

    /// Writes those shapes that are not in the common section, in order, and sets the places of all.
    /// `in_common` returns the address of a shape of the list there.
    pub(super) fn shapes(
        &mut self,
        shapes: &Shapes,
        in_common: impl Fn(usize) -> Option<u32>,
        places: &mut Vec<Place>,
    ) {
        places.clear();
        for (index, shape) in shapes.list.iter().enumerate() {
            let place = in_common(index).map_or_else(
                || {
                    Place::Here(match *shape {
                        Shape::Leaf { first, length } => self.leaf(shapes.leaf(first, length)),
                        Shape::Node { children, .. } => {
                            self.node(placed(shapes.children(children), places), shape.level())
                        }
                    })
                },
                Place::Common,
            );
            places.push(place);
        }
    }

    /// Writes a leaf and returns its address.
    pub(super) fn leaf(&mut self, halves: &[u16]) -> u32 {
        let at = self.halves.len() as u32;
        self.halves.extend_from_slice(halves);
        at
    }

    /// Writes a node of this level and returns its address.
    ///
    /// A child with a wide difference has room for a near pointer alone. If its shape is too far away, it is copied.
    pub(super) fn node(&mut self, mut children: [PlacedChild; 16], level: u32) -> u32 {
        while let Some(far) = children.iter().position(|&child| self.lacks_room(child)) {
            if let PlacedChild::Shape { delta, place } = children[far] {
                let place = Place::Here(self.copy(place, level - NODE_LEVELS));
                children[far] = PlacedChild::Shape { delta, place };
            }
        }
        let from = self.halves.len() as u32;
        let mut bits = [0_u16; 3];
        self.halves.extend(bits);
        for (c, child) in children.into_iter().enumerate() {
            let two = |word: u32| [word as u16, (word >> 16) as u16];
            let mut put = |size: u16, kind: u16, halves: &[u16]| {
                bits[0] |= (size & 1) << c;
                bits[1] |= (size >> 1) << c;
                bits[2] |= kind << c;
                self.halves.extend_from_slice(halves);
            };
            match child {
                PlacedChild::Never => put(0, 1, &[]),
                PlacedChild::Uniform(0) => put(0, 0, &[]),
                PlacedChild::Uniform(delta) => match narrow(delta) {
                    Some(delta) => put(1, 1, &[delta]),
                    None => put(3, 1, &[two(delta)[0], two(delta)[1], NO_SHAPE as u16]),
                },
                PlacedChild::Shape { delta, place } => {
                    match (delta, narrow(delta), pointer(self.common.is_none(), from, place)) {
                        (0, _, Pointer::Near(near)) => put(1, 0, &[near]),
                        (0, _, Pointer::Far(far)) => put(2, 0, &two(far)),
                        (_, Some(delta), Pointer::Near(near)) => put(2, 1, &[delta, near]),
                        (_, Some(delta), Pointer::Far(far)) => put(3, 0, &[delta, two(far)[0], two(far)[1]]),
                        (_, None, Pointer::Near(near)) => put(3, 1, &[two(delta)[0], two(delta)[1], near]),
                        (_, None, Pointer::Far(_)) => unreachable!("its shape has been copied"),
                    }
                }
            }
        }
        self.halves[from as usize..][..3].copy_from_slice(&bits);
        from
    }

    /// Whether a child of a node that is written next has a wide difference, and a shape out of reach of a near pointer.
    fn lacks_room(&self, child: PlacedChild) -> bool {
        let from = self.halves.len() as u32;
        let is_far = |place| matches!(pointer(self.common.is_none(), from, place), Pointer::Far(_));
        matches!(child, PlacedChild::Shape { delta, place } if narrow(delta).is_none() && is_far(place))
    }

    /// Writes a shape of this level once more.
    fn copy(&mut self, place: Place, level: u32) -> u32 {
        let (words, at) = match (place, self.common) {
            (Place::Common(at), Some(common)) => (common.to_vec(), at),
            (Place::Common(at) | Place::Here(at), _) => (self.words(), at),
        };
        let code = Code { words: &words };
        if level == LEAF_LEVEL {
            let length = LeafHead::new(code.half(at)).length();
            let halves: Vec<u16> = (at..at + length).map(|at| code.half(at) as u16).collect();
            return self.leaf(&halves);
        }
        let is_common = self.common.is_some() && matches!(place, Place::Common(_));
        let children = std::array::from_fn(|child| match code.child(at, child as u32) {
            code::Child::Never => PlacedChild::Never,
            code::Child::Uniform(delta) => PlacedChild::Uniform(delta),
            code::Child::Shape { at, delta, is_relative } => {
                let is_here = self.common.is_none() || is_relative && !is_common;
                let place = if is_here { Place::Here(at) } else { Place::Common(at) };
                PlacedChild::Shape { delta, place }
            }
        });
        self.node(children, level)
    }

    /// Returns what has been written, as words.
    pub(super) fn words(&self) -> Vec<u32> {
        let word = |two: &[u16]| u32::from(two[0]) | two.get(1).map_or(0, |&high| u32::from(high) << 16);
        self.halves.chunks(2).map(word).collect()
    }
}

/// Returns children with the places of their shapes.
fn placed(children: &Children, places: &[Place]) -> [PlacedChild; 16] {
    children.map(|child| match child {
        Child::Never => PlacedChild::Never,
        Child::Uniform(delta) => PlacedChild::Uniform(delta),
        Child::Shape { delta, index } => PlacedChild::Shape { delta, place: places[index as usize] },
    })
}

/// Returns a difference as 16 bits, if it fits.
fn narrow(delta: u32) -> Option<u16> {
    i16::try_from(delta as i32).ok().map(|delta| delta as u16)
}

/// Returns the shortest pointer from a node at `from`.
fn pointer(in_common: bool, from: u32, place: Place) -> Pointer {
    let (address, back) = match place {
        Place::Common(at) => (Some(at), None),
        Place::Here(at) if in_common => (Some(at), Some(from - at)),
        Place::Here(at) => (None, Some(from - at)),
    };
    match (address, back) {
        (Some(at), _) if at < NEAR => Pointer::Near(at as u16),
        (_, Some(back)) if back < NEAR => Pointer::Near((NEAR | back) as u16),
        (Some(at), _) => Pointer::Far(at),
        (None, Some(back)) => Pointer::Far(FAR | back),
        (None, None) => unreachable!("every shape has a place"),
    }
}
