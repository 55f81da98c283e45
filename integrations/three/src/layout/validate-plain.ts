// Validates a graph of the plain layout: every pointer leads to a node or leaf mask, every path ends, and the words are
// the only ones in which this graph can be written. Counterpart of `crates/adumbra/src/layout/plain/validate.rs`.
//
// Nodes are numbered in order of first visit, so one walk proves it: the first pointer to a node must be the next free
// word, every later one must name a header that was visited at the same level. A node without leaf masks below it means
// the same at every level that its height fits.

import type { ShadowFileFault } from '../error.js';
import { hex, voxelFault } from '../file/faults.js';
import type { BakedShadowFile } from '../file/shadow-file.js';
import { lowestBit, popCount } from './bits.js';
import { LEAF_NODE_LEVEL } from './packed-node.js';


function fail(fault: ShadowFileFault, message: string): never {
  voxelFault('Graph', fault, message);
}

/**
 * Checks the words of a file of the plain layout. Cost: one pass over them, and one byte of memory per node word.
 *
 * @throws ShadowFileError of the kind `Graph`.
 */
export function validatePlain({ top, nodes, leafMasks, rootLevel }: BakedShadowFile): void {
  const LIT = 0xffffffff;
  const SHADOWED = 0xfffffffe;
  /** Added to the height of a node without leaf masks below it, in `kinds`. */
  const LEAF_MASK_FREE = 128;
  const leafMaskCount = leafMasks.length >>> 1;
  /** For the word of a header, the node's level, or `LEAF_MASK_FREE` plus its height; else 0. */
  const kinds = new Uint8Array(nodes.length);
  let nodesSeen = 0;
  let leafMasksSeen = 0;

  /** Throws the error for the first pointer to a node word or leaf mask, if it is not the next one. */
  const checkFirst = (where: string, index: number, what: string, pointer: number, next: number, count: number): void => {
    if (pointer === next && pointer < count) return;
    const pair = `${where} ${index} refers to ${what} ${pointer}, but `;
    if (pointer >= count) fail('PointerRange', `${pair}there are only ${count}`);
    fail('Order', `${pair}the next in order of first visit is ${next}`);
  };

  /** Checks a node to which word or entry `index` points. Returns its kind, see `kinds`. */
  const visit = (pointer: number, level: number, where: string, index: number): number => {
    if (pointer < nodesSeen) {
      const kind = kinds[pointer];
      const isFree = kind >= LEAF_MASK_FREE;
      const lowest = isFree ? LEAF_NODE_LEVEL + kind - LEAF_MASK_FREE : kind;
      if (isFree ? level < lowest : level !== lowest) {
        const pair = `${where} ${index} refers to node word ${pointer}`;
        if (lowest === 0) fail('NotAHeader', `${pair}, which is a pointer and not a header`);
        fail('TwoLevels', `${pair} as a node of level ${level}, but it is one of level ${lowest}`);
      }
      return kind;
    }
    checkFirst(where, index, 'node word', pointer, nodesSeen, nodes.length);
    const end = pointer + 1 + checkHeader(nodes[pointer], pointer);
    if (end > nodes.length) {
      fail('NodeEnd', `node word ${pointer} is a header with ${end - pointer - 1} pointers, but there are only ${nodes.length} words`);
    }
    kinds[pointer] = level;
    nodesSeen = end;
    let kind = LEAF_MASK_FREE;
    for (let word = pointer + 1; word < end; word++) {
      if (level === LEAF_NODE_LEVEL) {
        visitLeafMask(nodes[word], word);
        kind = level;
      } else {
        const child = visit(nodes[word], level - 1, 'node word', word);
        kind = child >= LEAF_MASK_FREE && kind >= LEAF_MASK_FREE ? Math.max(kind, child + 1) : level;
      }
    }
    kinds[pointer] = kind;
    return kind;
  };

  const visitLeafMask = (pointer: number, word: number): void => {
    if (pointer < leafMasksSeen) return;
    checkFirst('node word', word, 'leaf mask', pointer, leafMasksSeen++, leafMaskCount);
    const low = leafMasks[2 * pointer];
    if (low === leafMasks[2 * pointer + 1] && (low === 0 || low === LIT)) {
      uniform(`leaf mask ${pointer}`, low !== 0);
    }
  };

  for (let index = 0; index < top.length; index++) {
    if (top[index] < SHADOWED) visit(top[index], rootLevel, 'top grid entry', index);
  }
  checkAllSeen('node word', nodesSeen, nodes.length);
  checkAllSeen('leaf mask', leafMasksSeen, leafMaskCount);
}

function checkAllSeen(what: string, seen: number, count: number): void {
  if (seen === count) return;
  fail('Unreachable', `${what} ${seen} is not reachable from any root`);
}

/** Checks a header on its own. Returns the number of pointers that follow it. */
function checkHeader(header: number, word: number): number {
  const threes = header & (header >>> 1) & 0x5555;
  if (header >>> 16 !== 0) {
    fail('HeaderBits', `node word ${word} is the header ${hex(header)}, whose upper bits are not zero`);
  }
  if (threes !== 0) {
    const child = lowestBit(threes) >>> 1;
    fail('ChildState', `node word ${word} is the header ${hex(header)}, whose child ${child} has the state 3`);
  }
  if (header === 0 || header === 0x5555) uniform(`node word ${word}`, header !== 0);
  return popCount(header & 0xaaaa);
}

function uniform(place: string, lit: boolean): never {
  const state = lit ? 'lit' : 'shadowed';
  fail('Uniform', `${place} is all ${state}, so the word that refers to it must say so`);
}
