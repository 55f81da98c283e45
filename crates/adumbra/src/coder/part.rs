//! A common section, or the pages of a bundle, to and from coded bytes.

use super::rans::{Decoder, Encoder};
use super::shapes::{Coded, Common, Layout, Pool, read_pages};
use super::walk::Walk;
use super::{Fault, least_bytes};
use crate::layout::depths::NEVER;
use crate::layout::depths::child::Child;
use crate::layout::depths::page::{BUNDLE_PAGES, HEAD_WORDS, Page};
use crate::layout::depths::shapes::ShapeList;

/// Codes a common section of `words` words.
///
/// # Errors
/// Returns [`Fault`] if a shape points to a later shape.
pub(crate) fn encode_common(common: &Common, words: usize) -> Result<Vec<u8>, Fault> {
    let none = ShapeList::default();
    let mut walk = Walk::of_section(Encoder::default(), &none, &common.shapes);
    walk.section(common.shapes.len())?;
    Ok(walk.coder.finish(least_bytes(words)))
}

/// Decodes a common section of `words` words. Returns its shapes and its words.
///
/// # Errors
/// Returns [`Fault`] if an encoder would not have written these bytes.
pub(crate) fn decode_common(bytes: &[u8], words: usize) -> Result<(Common, Vec<u32>), Fault> {
    let none = ShapeList::default();
    let source = Pool { common: &none, own: &none };
    let mut walk = Walk::new(Decoder::new(bytes), &none, source, 2 * words);
    walk.section(0)?;
    walk.coder.finish(least_bytes(words))?;
    let Coded::SoFar(mut shapes) = walk.own else { return Err(Fault) };
    shapes.shrink_to_fit();
    let (common, found) = Common::lay_out(shapes, 2 * words)?;
    if found.len() == words { Ok((common, found)) } else { Err(Fault) }
}

/// Codes the pages of a bundle. They must be valid.
///
/// # Errors
/// Returns [`Fault`] if a writer would lay out a page's shapes differently.
pub(crate) fn encode_bundle(pages: &[Page<'_>; BUNDLE_PAGES], common: &Common) -> Result<Vec<u8>, Fault> {
    let (shapes, roots) = read_pages(pages, common)?;
    let mut layout = Layout::of_pages(common, &shapes, usize::MAX);
    for (&root, page) in roots.iter().zip(pages) {
        let (at, words) = layout.page(root)?;
        if at != page.root || words != page.words {
            return Err(Fault);
        }
    }
    let source = Pool { common: &common.shapes, own: &shapes };
    let mut walk = Walk::new(Encoder::default(), &common.shapes, source, usize::MAX);
    walk.pages(roots)?;
    let words = pages.iter().map(|page| page.words.len()).sum::<usize>();
    Ok(walk.coder.finish(least_bytes(words)))
}

/// Decodes a bundle of `words` words. Returns these words: the heads of its pages, then the pages.
///
/// Time and memory are proportional to `words`, whatever the bytes are.
///
/// # Errors
/// Returns [`Fault`] if an encoder would not have written these bytes.
pub(crate) fn decode_bundle(bytes: &[u8], words: usize, common: &Common) -> Result<Vec<u32>, Fault> {
    let none = ShapeList::default();
    let page_words = words.checked_sub(HEAD_WORDS).ok_or(Fault)?;
    let most_halves = 2 * page_words;
    let source = Pool { common: &none, own: &none };
    let mut walk = Walk::new(Decoder::new(bytes), &common.shapes, source, most_halves);
    let roots = walk.pages([Child::Never; BUNDLE_PAGES])?;
    walk.coder.finish(least_bytes(page_words))?;
    let mut layout = Layout::of_pages(common, walk.own.shapes(), most_halves);
    let mut found = vec![0; HEAD_WORDS];
    for (page, root) in roots.into_iter().enumerate() {
        let (at, mut page_words) = layout.page(root)?;
        let base = match root {
            Child::Never => NEVER,
            Child::Uniform(base) | Child::Shape { delta: base, .. } => base,
        };
        found[3 * page..][..3].copy_from_slice(&[at, base, page_words.len() as u32]);
        found.append(&mut page_words);
    }
    found.shrink_to_fit();
    if found.len() == words { Ok(found) } else { Err(Fault) }
}
