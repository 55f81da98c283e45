//! Converts between a [`DagFile`] and the words of the paper's tree plus the header of the file. The
//! checksums in the header are those of the sections, so they show that a file rebuilt from words is the same
//! file.

use adumbra::FormatError;

use crate::dag::build::convert::{body_in, graph_of};
use crate::dag::{DAG_HEADER_BYTES, DagFile, Header};

use crate::tree::error::WordsError;
use crate::tree::graph::VoxelTree;
use crate::tree::light::{dag_of_tree, tree_depth};

/// Returns the tree of the graph of a file, and the bytes that [`file_of_words`] needs besides its words: the
/// header.
///
/// # Errors
/// Returns [`WordsError`] if the file is not valid, the tree would be too deep, or the reverse conversion
/// would give other bytes.
pub fn words_of(file: &DagFile) -> Result<(VoxelTree, Vec<u8>), WordsError> {
    let header = file.header()?.encode();
    // Checked before the graph is made: the graph of a file in another layout can be arbitrarily larger than
    // the file.
    let (size, root_level, _) = file.body.space();
    tree_depth(size, root_level)?;
    let tree = VoxelTree::from_dag(&*graph_of(&file.body)?)?;
    let again = body_in(file.body.layout(), dag_of_tree(&tree, size, root_level)?)?;
    if again != file.body {
        let [found, canonical] = [&file.body, &again]
            .map(|b| b.section_lengths()[1] as usize / 4 + b.section_lengths()[2] as usize / 8);
        return Err(WordsError::NotCanonical { found, canonical });
    }
    Ok((tree, header.to_vec()))
}

/// Rebuilds the file with `rest` as its header and `words` as its tree.
///
/// # Errors
/// Returns [`WordsError`] if either is not valid or if they do not belong together.
pub fn file_of_words(rest: &[u8], words: Vec<u32>) -> Result<DagFile, WordsError> {
    let header = Header::parse(rest)?;
    if rest.len() > DAG_HEADER_BYTES {
        return Err(FormatError::TrailingBytes { end: DAG_HEADER_BYTES as u64 }.into());
    }
    let (size, root_level) = (header.grid.size, header.root_level);
    let tree = VoxelTree::from_words(tree_depth(size, root_level)?, words)?;
    let dag = dag_of_tree(&tree, size, root_level)?;
    drop(tree);
    let body = body_in(header.layout, dag)?;
    let file = DagFile { grid: header.grid, settings: header.settings, body };
    let (found, expected) = (file.header()?.encode(), header.encode());
    match (0..DAG_HEADER_BYTES).find(|&byte| found[byte] != expected[byte]) {
        Some(byte) => Err(WordsError::Differs { byte }),
        None => Ok(file),
    }
}
