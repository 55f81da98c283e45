//! [`ShadowFile`] <-> words of the paper's tree and the file's header. The header's checksums are those of the sections,
//! so a file that is made again from words is known to be the same one.

use super::header::Header;
use super::{FormatError, HEADER_BYTES, LightBody, ShadowFile};
use crate::dag::packed::PackError;
use crate::tree::{LightTreeError, TreeError, VoxelTree, dag_of_tree, tree_depth};

/// Why a file has no form as words, or words and header are no file.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum WordsError {
    /// The header, or the file to be written, is not valid.
    #[error(transparent)]
    Format(#[from] FormatError),
    /// The words are not a tree.
    #[error("the words are not a tree: {0}; export it again")]
    Tree(#[from] TreeError),
    /// Graph and tree cannot be made from each other.
    #[error(transparent)]
    Light(#[from] LightTreeError),
    /// The graph has no packed form.
    #[error(transparent)]
    Pack(#[from] PackError),
    /// The graph holds equal nodes apart, which a tree's words cannot say.
    #[error(
        "its graph of {found} words and slabs has another canonical form, of {canonical}; only files that `bake` has written can be exported"
    )]
    NotCanonical {
        /// Words and slabs of the graph.
        found: usize,
        /// Words and slabs of the graph that comes back from the tree.
        canonical: usize,
    },
    /// The words make another file than the header describes.
    #[error(
        "the words make another file than the header beside them describes (byte {byte} of the header differs); export it again"
    )]
    Differs {
        /// The first byte of the header that differs.
        byte: usize,
    },
}

impl ShadowFile {
    /// The tree of the file's graph, and the bytes that [`ShadowFile::with_words`] needs beside its words: the header.
    ///
    /// # Errors
    /// [`WordsError`] where the file is not valid, the tree would be too deep, or the way back would give other bytes.
    pub fn without_words(&self) -> Result<(VoxelTree, Vec<u8>), WordsError> {
        let header = self.header()?.encode();
        // Before the graph is made: of another layout it may be any number of times as large as the file.
        let (size, root_level, _) = self.body.space();
        tree_depth(size, root_level)?;
        let tree = VoxelTree::of_dag(&*self.graph()?)?;
        let again = LightBody::of_dag(dag_of_tree(&tree, size, root_level)?, self.body.layout())?;
        if again != self.body {
            let [found, canonical] = [&self.body, &again]
                .map(|b| b.section_lengths()[1] as usize / 4 + b.section_lengths()[2] as usize / 8);
            return Err(WordsError::NotCanonical { found, canonical });
        }
        Ok((tree, header.to_vec()))
    }

    /// The file of which `rest` is the header and `words` are the tree.
    ///
    /// # Errors
    /// [`WordsError`] where either is not valid or the two do not belong together.
    pub fn with_words(rest: &[u8], words: Vec<u32>) -> Result<Self, WordsError> {
        let header = Header::parse(rest)?;
        if rest.len() > HEADER_BYTES {
            return Err(FormatError::TrailingBytes { end: HEADER_BYTES as u64 }.into());
        }
        let (size, root_level) = (header.grid.size, header.root_level);
        let tree = VoxelTree::from_words(tree_depth(size, root_level)?, words)?;
        let dag = dag_of_tree(&tree, size, root_level)?;
        drop(tree);
        let file = Self::of_dag(header.grid, header.settings, dag, header.layout)?;
        // Both as this version writes them: an earlier one may have written the header.
        let (found, expected) = (file.header()?.encode(), header.encode());
        match (0..HEADER_BYTES).find(|&byte| found[byte] != expected[byte]) {
            Some(byte) => Err(WordsError::Differs { byte }),
            None => Ok(file),
        }
    }
}
