//! The transforms of nodes as written in a glTF file (glTF 2.0, 3.5.3).

use serde::Deserialize;

use crate::affine::{Affine, decompose, from_columns};
use crate::movers::Rest;

/// A node's local transform in double precision, as JSON numbers are. The glTF crate stores `f32`, whose
/// steps are half a metre at map coordinates.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(from = "TransformJson")]
pub(super) enum NodeTransform {
    Matrix(Affine),
    Parts(Rest),
}

/// A node's transform as written in the file.
#[derive(Deserialize)]
struct TransformJson {
    matrix: Option<[f64; 16]>,
    translation: Option<[f64; 3]>,
    rotation: Option<[f64; 4]>,
    scale: Option<[f64; 3]>,
}

impl From<TransformJson> for NodeTransform {
    fn from(written: TransformJson) -> Self {
        match written.matrix {
            Some(matrix) => Self::Matrix(from_columns(&matrix)),
            None => Self::Parts(Rest {
                translation: written.translation.unwrap_or_default(),
                rotation: written.rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]),
                scale: written.scale.unwrap_or([1.0; 3]),
            }),
        }
    }
}

impl NodeTransform {
    /// The node's local transform, to its parent's frame.
    pub(super) fn map(&self) -> Affine {
        match self {
            Self::Matrix(map) => *map,
            Self::Parts(rest) => rest.map(),
        }
    }

    /// The node's transform without animation, in the parts that keys replace.
    pub(super) fn rest(&self) -> Rest {
        match self {
            Self::Matrix(map) => {
                let (translation, rotation, scale) = decompose(map);
                Rest { translation, rotation, scale }
            }
            Self::Parts(rest) => *rest,
        }
    }
}
