// Validates the top of a packed graph: its length, its pools, and its columns of root cubes.

import type { BakedShadowFile } from '../file/shadow-file.js';
import { packedFault } from './packed-fault.js';
import { LEAF_NODE_LEVEL, POOL_WORDS, rootsWord } from './packed-node.js';

/**
 * Checks the section `top` of a file of the packed layout.
 *
 * @throws ShadowFileError of the kind `Packed`.
 */
export function validatePackedTop({ top, nodes, topDims, rootLevel }: BakedShadowFile): void {
  const rootsAt = rootsWord(topDims);
  const length = rootsAt + top[rootsAt - 1];
  if (top.length !== length) {
    packedFault('TopLength', `top of ${top.length} words, but its columns and roots require ${length}`);
  }
  const units = 2 * nodes.length;
  const bad = (word: number): never =>
    packedFault('Pools', `top word ${word}: a pool begins at unit ${top[word]}, out of order or beyond unit ${units}`);
  let last = 0;
  for (let word = 0; word < POOL_WORDS; word++) {
    const unit = top[word];
    // The first pool begins at 0. Pools above the root level are empty.
    const isEmpty = word > rootLevel - LEAF_NODE_LEVEL + 1;
    if (unit < last || (word === 0 && unit !== 0) || (isEmpty && unit !== last)) bad(word);
    last = unit;
  }
  if (last + (last % 2) !== units) bad(POOL_WORDS - 1);
  if (last % 2 === 1 && nodes[nodes.length - 1] >>> 16 !== 0) {
    const value = nodes[nodes.length - 1] >>> 16;
    packedFault('Filler', `unit ${last} is padding and has the value ${value}, but must be 0`);
  }
  const depth = topDims[2];
  let roots = 0;
  let most = 0;
  for (let word = POOL_WORDS; word < rootsAt; word++) {
    const value = top[word];
    const isLitRoots = (word - POOL_WORDS) % 2 === 1;
    const isGood = isLitRoots ? value <= depth : roots <= value && value - roots <= most;
    if (!isGood) {
      packedFault('Column', `top word ${word} is ${value}, impossible in a column of ${depth} root cubes`);
    }
    if (isLitRoots) most = depth - value;
    else roots = value;
  }
}
