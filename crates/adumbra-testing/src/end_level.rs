//! The level at which a look-up in a quadtree ends.

use adumbra::layout::depths::DepthTree;
use adumbra::layout::depths::code::ColumnNode;
use adumbra::query::FixedReceiver;

/// Returns the level of the block in which the look-up of a filter's middle texel ends. The block switches at
/// one depth and spans 2^level columns along each side; level 0 is a single column. `None` outside the grid's
/// texels and before the grid, where nothing is looked up. A shader returns the same level.
pub fn end_level(tree: &DepthTree, r: &FixedReceiver) -> Option<u32> {
    let [nx, ny, _] = tree.size().map(i64::from);
    let [x, y] = r.texel();
    let is_inside = (0..nx).contains(&x) && (0..ny).contains(&y) && r.layer([x, y]) >= 0;
    is_inside.then(|| match tree.place(x as u32, y as u32) {
        (ColumnNode::Uniform(_), level) => level,
        (ColumnNode::Leaf { .. }, _) => 0,
    })
}
