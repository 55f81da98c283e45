//! The shapes of a page to and from its words.
//!
//! Shapes are in order of last visit: children come before their parents, and the root is last.

use adumbra::layout::depths::ShapePlace;
use adumbra::layout::depths::child::{Child, ShapeRef};
use adumbra::layout::depths::code::Code;
use adumbra::layout::depths::page::PAGE_LEVEL;
use adumbra::layout::depths::shapes::{Shape, ShapeList, ShapeReader};
use adumbra::layout::depths::write::{OutOfReach, Writer};
use xxhash_rust::xxh3::xxh3_128;

/// Writes those shapes of a page that are not in the common section, in order, and sets the places of all.
/// `in_common` returns the address of a shape of the list there.
pub(super) fn write(
    shapes: &ShapeList,
    in_common: impl Fn(usize) -> Option<u32>,
    places: &mut Vec<ShapeRef>,
) -> Result<Vec<u32>, OutOfReach> {
    places.clear();
    let mut writer = Writer::page();
    for index in 0..shapes.len() {
        let place = match (in_common(index as usize), shapes.get(index)) {
            (Some(at), _) => ShapeRef::Common(at),
            (None, Shape::Leaf(halves)) => ShapeRef::Here(writer.leaf(halves)),
            (None, Shape::Node(node)) => {
                let placed = node.all().map(|child| child.map(|shape| places[shape as usize]));
                ShapeRef::Here(writer.node(&placed)?)
            }
        };
        places.push(place);
    }
    Ok(writer.words())
}

/// Returns the words of a page whose root was listed last, and the root's address.
///
/// # Errors
/// Returns [`OutOfReach`] if the page is too large.
pub(crate) fn page(shapes: &ShapeList) -> Result<(Vec<u32>, u32), OutOfReach> {
    let mut places = Vec::new();
    let words = write(shapes, |_| None, &mut places)?;
    match places.last() {
        Some(ShapeRef::Here(at)) => Ok((words, *at)),
        Some(ShapeRef::Common(_)) | None => unreachable!("the root is in the page"),
    }
}

/// Reads the shapes of pages, and hashes them: equal shapes have equal hashes in every page.
#[derive(Debug, Default)]
pub(crate) struct Reader {
    reader: ShapeReader,
    pub(super) list: ShapeList,
    /// The hash of each shape, from its level and all that is below it.
    pub(super) hashes: Vec<u128>,
    hashed: Vec<u8>,
}

impl Reader {
    /// Reads a page without a common section, from its words and the address of its root. A shape that is
    /// stored once is listed once.
    pub(crate) fn read(&mut self, words: &[u32], root: u32) {
        self.list.clear();
        self.reader.begin(words.len());
        let root = ShapePlace { at: root, level: PAGE_LEVEL };
        let root = self.reader.shape(Code { words }, root, None, &mut self.list);
        debug_assert!(root.is_some(), "without a common section, no shape is missing from it");
        self.hashes.clear();
        for index in 0..self.list.len() {
            let hash = self.hash(index);
            self.hashes.push(hash);
        }
    }

    /// Hashes a shape. Those below it have their hashes.
    fn hash(&mut self, index: u32) -> u128 {
        let Self { list, hashes, hashed, .. } = self;
        hashed.clear();
        match list.get(index) {
            Shape::Leaf(halves) => hashed.extend(halves.iter().flat_map(|half| half.to_le_bytes())),
            Shape::Node(node) => {
                for child in node.all() {
                    match child {
                        Child::Never => hashed.push(0),
                        Child::Uniform(delta) => {
                            hashed.push(1);
                            hashed.extend_from_slice(&delta.to_le_bytes());
                        }
                        Child::Shape { shape, delta } => {
                            hashed.push(2);
                            hashed.extend_from_slice(&delta.to_le_bytes());
                            hashed.extend_from_slice(&hashes[shape as usize].to_le_bytes());
                        }
                    }
                }
            }
        }
        hashed.push(list.level(index) as u8);
        xxh3_128(hashed)
    }
}
