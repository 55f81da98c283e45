//! The children of nodes, and the ways to refer to a shape.

use crate::layout::depths::page::IN_PAGE;

/// Level and address of a shape.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ShapePlace {
    /// Address in the shape's part.
    pub at: u32,
    /// Level of the shape.
    pub level: u32,
}

/// Where a shape is. Within a common section, both variants mean the same place; its writer takes
/// [`ShapeRef::Here`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ShapeRef {
    /// At an address of the common section.
    Common(u32),
    /// At an address of the part that contains the pointer.
    Here(u32),
}

impl ShapeRef {
    /// Returns the address.
    pub fn at(self) -> u32 {
        match self {
            Self::Common(at) | Self::Here(at) => at,
        }
    }

    /// Returns the root of a page whose root has this shape, see [`Page::root`](super::page::Page::root).
    pub fn root(self) -> u32 {
        match self {
            Self::Common(at) => at,
            Self::Here(at) => IN_PAGE | at,
        }
    }
}

/// A child of a node. A `P` refers to its shape: an index in a list, or a [`ShapeRef`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Child<P> {
    /// No column switches.
    Never,
    /// All columns switch at the base plus this difference, wrapping.
    Uniform(u32),
    /// A shape.
    Shape {
        /// The shape.
        shape: P,
        /// Difference that is added to the base, wrapping.
        delta: u32,
    },
}

/// The children of a node, in the order `y·4 + x`.
pub type Children<P> = [Child<P>; 16];

impl<P> Child<P> {
    /// Replaces the reference to the shape.
    pub fn map<Q>(self, refer: impl FnOnce(P) -> Q) -> Child<Q> {
        match self {
            Self::Never => Child::Never,
            Self::Uniform(delta) => Child::Uniform(delta),
            Self::Shape { shape, delta } => Child::Shape { shape: refer(shape), delta },
        }
    }

    /// Replaces the reference to the shape.
    ///
    /// # Errors
    /// Returns the error of `refer`.
    pub fn try_map<Q, E>(self, refer: impl FnOnce(P) -> Result<Q, E>) -> Result<Child<Q>, E> {
        Ok(match self {
            Self::Never => Child::Never,
            Self::Uniform(delta) => Child::Uniform(delta),
            Self::Shape { shape, delta } => Child::Shape { shape: refer(shape)?, delta },
        })
    }

    /// Adds to the difference.
    pub(crate) fn moved(self, by: u32) -> Self {
        match self {
            Self::Never => Self::Never,
            Self::Uniform(delta) => Self::Uniform(delta.wrapping_add(by)),
            Self::Shape { shape, delta } => Self::Shape { shape, delta: delta.wrapping_add(by) },
        }
    }
}
