// The order in which shapes are decoded, and the contents of leaves. Counterpart of `walk.rs` and `leaf.rs`
// in `crates/adumbra/src/coder/`.
//
// Pages come in order, each from its root down. A shape is decoded at its first use; later uses are
// references. A common section is decoded shape by shape, in the order in which they are stored.

import { BUNDLE_SIDE, PAGE_LEVEL } from '../quadtree/pages.js';
import { LEAF_LEVEL, NODE_LEVELS } from '../quadtree/quadtree.js';
import { Leaf, readColumns } from './columns.js';
import { Edges, classOfFacing, kindOfFacing, risen, slantOfFacing } from './edges.js';
import {
  COUNT,
  DIFFERENCE,
  GRADIENT,
  HEAD,
  HIT,
  INDEX,
  IS_SLANTED,
  LAST,
  LAST_IS_NEVER,
  LEAF_DEPTH,
  LEVEL,
  ModelReader,
  NEVER,
  NODE_DEPTH,
  REFERENCE,
  SLANT,
  STATE,
  UNIFORM_DEPTH,
} from './model.js';
import { MIXED, NEVER_CLASS, classOf, readOutline } from './outline.js';
import { LEVELS, NEVER_CHILD, NODE, Shapes, UNIFORM_CHILD, rankOf } from './shapes.js';

/** Number of shapes of a level, and of gradients, that are remembered in order of their last use. */
const RECENT = 10;
const RECENT_SLANTS = 13;

/** Symbols of a child's state. Any other is that of a known shape. */
const UNIFORM_STATE = 0;
const NEVER_STATE = 1;
const NEW = 2;
const ABOVE = 3;
const LEFT = 4;

/** Symbols of a reference to a shape that is not a recent one. */
const IN_COMMON = 14;

/** Symbols of a leaf's head for last ranks from 4 and from 8 on. */
const FROM_4 = 13;
/** Symbol of a gradient that is coded by its change. */
const OTHER_SLANT = 15;

/** Decodes shapes, part after part. */
export class Walk {
  /** Shapes of the common section. */
  common = new Shapes();
  /** Shapes of the part. */
  own = new Shapes();
  /** The reader of the part. */
  readonly reader = new ModelReader();
  readonly #edges = new Edges();
  readonly #leaf = new Leaf();
  readonly #recent = new Int32Array(LEVELS * RECENT);
  readonly #recentSlants = new Int32Array(RECENT_SLANTS);
  /** Children of the nodes that are being decoded, by rank; the last entry is a root. */
  readonly #children = new Int32Array(LEVELS * NODE + 2);
  #lists: readonly [common: Shapes, own: Shapes] = [this.common, this.own];
  #halvesLeft = 0;
  #fail: () => never = () => {
    throw new Error();
  };

  /** Begins a part. `fail` is called if it cannot be decoded, or has shapes of more than `mostHalves` half-words. */
  begin(halves: Uint16Array<ArrayBuffer>, mostHalves: number, fail: () => never): void {
    this.own.clear();
    this.reader.begin(halves);
    this.#edges.clear();
    this.#recent.fill(UNIFORM_CHILD);
    this.#recentSlants.fill(0);
    this.#lists = [this.common, this.own];
    this.#halvesLeft = mostHalves;
    this.#fail = fail;
  }

  /** Makes the shapes of the part those of the common section. */
  keepCommon(): void {
    this.common = this.own;
    this.own = new Shapes();
  }

  /** Decodes the number of shapes of a common section. */
  count(): number {
    return this.reader.number(COUNT) >>> 0;
  }

  /** Decodes a shape of a common section. */
  shape(): void {
    const rank = this.reader.symbol(LEVEL) & 3;
    const level = LEAF_LEVEL + NODE_LEVELS * rank;
    this.#edges.forget(level);
    if (rank === 0) this.#newLeaf(0, 0, 0);
    else this.#node(level, 0, 0, 0);
  }

  /** Decodes a page. Returns its root: a shape, and the difference of its base from `base`. */
  page(index: number, base: number): readonly [shape: number, delta: number] {
    const at = LEVELS * NODE;
    const x = index % BUNDLE_SIDE;
    const y = (index - x) / BUNDLE_SIDE;
    this.#child(PAGE_LEVEL, x << PAGE_LEVEL, y << PAGE_LEVEL, base, at);
    return [this.#children[at], this.#children[at + 1]];
  }

  /** Decodes a child of a shape with a base, and puts it at a place of {@link Walk.#children}. */
  #child(level: number, x: number, y: number, base: number, place: number): void {
    const edges = this.#edges;
    const rank = rankOf(level);
    const blockX = x >> LEAF_LEVEL;
    const blockY = y >> LEAF_LEVEL;
    const above = level === LEAF_LEVEL ? edges.above[blockX] : summary(edges.above, blockX, level);
    const left = level === LEAF_LEVEL ? edges.left[blockY] : summary(edges.left, blockY, level);
    const leaves = (kindOfFacing(above) !== 0 ? 1 : 0) + 2 * (kindOfFacing(left) !== 0 ? 1 : 0);
    const state = this.reader.symbol(STATE + 25 * (4 * rank + leaves) + 5 * classOfFacing(above) + classOfFacing(left));
    let shape = NEVER_CHILD;
    let depth = base;
    if (state === NEVER_STATE) edges.uniform(x, y, level, NEVER);
    else if (state === UNIFORM_STATE) {
      shape = UNIFORM_CHILD;
      depth = this.#plainDepth(UNIFORM_DEPTH, level, x, y, base);
      edges.uniform(x, y, level, depth);
    } else {
      if (state === NEW && level === LEAF_LEVEL) {
        depth = this.#newLeaf(x, y, base);
        shape = this.common.length + this.own.length - 1;
      } else if (state === NEW) {
        depth = this.#plainDepth(NODE_DEPTH, level, x, y, base);
        shape = this.#node(level, x, y, depth);
      } else {
        // Only leaves have a shape above and to the left.
        if (state === ABOVE && level === LEAF_LEVEL) shape = edges.shapeAbove[blockX];
        else if (state === LEFT && level === LEAF_LEVEL) shape = edges.shapeLeft[blockY];
        if (shape < 0) shape = this.#reference(rank);
        depth = this.#seen(level, x, y, base, shape);
      }
      toFront(this.#recent, RECENT * rank, RECENT, shape);
    }
    this.#children[place] = shape;
    this.#children[place + 1] = depth - base;
  }

  /** Counts half-words that were decoded. */
  #spend(halves: number): void {
    this.#halvesLeft -= halves;
    if (this.#halvesLeft < 0 || this.reader.isPastEnd) this.#fail();
  }

  /** Decodes a reference to a shape by its last use, or by its number among those of its level. */
  #reference(rank: number): number {
    const way = this.reader.symbol(REFERENCE + rank);
    if (way < IN_COMMON) {
      const shape = way < RECENT ? this.#recent[RECENT * rank + way] : UNIFORM_CHILD;
      return shape === UNIFORM_CHILD ? this.#fail() : shape;
    }
    const list = way === IN_COMMON ? this.common : this.own;
    const number = this.reader.number(INDEX + 2 * rank + way - IN_COMMON) >>> 0;
    return number < list.counts[rank] ? list.levels[rank][number] : this.#fail();
  }

  /** Decodes the base of a known shape. */
  #seen(level: number, x: number, y: number, base: number, shape: number): number {
    let depth;
    if (level === LEAF_LEVEL) {
      const before = this.common.length;
      const list = shape < before ? this.common : this.own;
      const facing = list.entries[3 * (shape < before ? shape : shape - before) + 2];
      depth = this.#leafDepth(x, y, base, facing >>> 9, (facing >>> 6) & 7);
    } else depth = this.#plainDepth(NODE_DEPTH, level, x, y, base);
    this.#edges.shape(x, y, depth, shape, this.#lists);
    return depth;
  }

  /** Decodes a new node with a base. Returns its index. */
  #node(level: number, x: number, y: number, base: number): number {
    this.#spend(3);
    const below = level - NODE_LEVELS;
    const place = NODE * rankOf(level);
    const children = this.#children;
    for (let c = 0, at = place; c < 16; c++, at += 2) {
      this.#child(below, x + ((c & 3) << below), y + ((c >> 2) << below), base, at);
      // A child that is listed has at least one half-word.
      if (children[at] >= 0 || children[at + 1] !== 0) this.#spend(1);
    }
    return this.own.pushNode(level, children, place, this.common.length);
  }

  /** Decodes a new leaf, where `base` is its parent's. Returns its own base. */
  #newLeaf(x: number, y: number, base: number): number {
    const leaf = this.#leaf;
    this.#head(x, y);
    const { last, never, slant } = leaf;
    const kind = last === 0 ? 1 : last === 1 ? (never ? 2 : 3) : last < 4 ? 4 : 5;
    const depth = this.#leafDepth(x, y, base, slant, kind);
    this.#edges.faceLeaf(x, y, slant);
    this.#differences(depth);
    readColumns(this.reader, this.#edges, x, y, depth, leaf);
    const { own } = this;
    own.reserveLeaf();
    const begin = own.halvesLength;
    const end = writeLeaf(leaf, own.halves, begin);
    this.#spend(end - begin);
    const { outline } = this.#edges;
    readOutline(own.halves, begin, outline);
    const facing = classOf(outline, 0) | (classOf(outline, 8) << 3) | (kind << 6) | (slant << 9);
    const shape = own.pushLeaf(end, facing, this.common.length);
    this.#edges.leaf(x, y, depth, shape, facing);
    return depth;
  }

  /** Decodes the depth of a uniform child, or the base of a node. */
  #plainDepth(model: number, level: number, x: number, y: number, base: number): number {
    const last = (1 << level) - 1;
    const { bottom, right } = this.#edges;
    const { known } = this.reader;
    known[0] = right[y];
    known[1] = bottom[x];
    known[2] = right[y + last];
    known[3] = bottom[x + last];
    known[4] = NEVER;
    known[5] = base;
    return this.reader.depth(model + rankOf(level));
  }

  /** Decodes the base of a leaf. */
  #leafDepth(x: number, y: number, base: number, slant: number, kind: number): number {
    const { bottom, right } = this.#edges;
    const { known } = this.reader;
    known[1] = risen(right[y], slant, -1, 0);
    known[2] = risen(bottom[x], slant, 0, -1);
    known[3] = risen(right[y + 7], slant, -1, 7);
    known[4] = risen(bottom[x + 7], slant, 7, -1);
    known[0] = Math.min(known[1] >>> 0, known[2] >>> 0, known[3] >>> 0, known[4] >>> 0);
    known[5] = base;
    return this.reader.depth(LEAF_DEPTH + (slant !== 0 ? 1 : 0) + 2 * (kind > 3 ? 1 : 0));
  }

  /** Decodes the number of depths, whether the last is never, and the gradient. */
  #head(x: number, y: number): void {
    const { reader } = this;
    const leaf = this.#leaf;
    const above = this.#edges.above[x >> LEAF_LEVEL];
    const left = this.#edges.left[y >> LEAF_LEVEL];
    const head = reader.symbol(HEAD + 6 * look(above) + look(left));
    let last = 0;
    let flags = 2;
    if (head > 0 && head < FROM_4) {
      last = (head + 3) >> 2;
      flags = (head - 1) & 3;
    } else if (head > 0) {
      const many = (head > FROM_4 ? 1 : 0);
      const more = reader.symbol(LAST + many);
      last = Math.min((many === 0 ? 4 : 8) + more + (more === 15 ? reader.plain(6) : 0), 63);
      const never = reader.bit(LAST_IS_NEVER + many);
      flags = never + 2 * reader.bit(IS_SLANTED + 2 * many + never);
    }
    leaf.last = last;
    leaf.never = (flags & 1) === 1;
    leaf.slant = flags >= 2 ? this.#slant(slantOfFacing(above), slantOfFacing(left)) : 0;
    // A leaf with a single depth must have a gradient.
    if (last === 0 && leaf.slant === 0) this.#fail();
  }

  /** Decodes a gradient. `above` and `left` are the gradients of the neighbours, or 0. */
  #slant(above: number, left: number): number {
    const { reader } = this;
    const recent = this.#recentSlants;
    const way = reader.symbol(SLANT + (above !== left ? 2 : (above !== 0 ? 1 : 0)));
    let slant;
    if (way === 0) slant = above;
    else if (way === 1) slant = left;
    else if (way < OTHER_SLANT) slant = recent[way - 2];
    else {
      const guess = above || left || recent[0];
      slant = (guess + reader.signed(GRADIENT)) & 0xff;
      slant |= (((guess >> 8) + reader.signed(GRADIENT + 1)) & 0xff) << 8;
    }
    toFront(recent, 0, RECENT_SLANTS, slant);
    return slant;
  }

  /** Decodes the differences of the depths of the leaf with a base. */
  #differences(base: number): void {
    const { reader } = this;
    const { last, stored, slant, differences } = this.#leaf;
    const { cells } = this.#edges;
    const kind = 2 * Math.min(last - 1, 3) + (slant !== 0 ? 1 : 0);
    let depth = base;
    for (let i = 0; i < stored; i++) {
      // Distance to the next facing depth, minus 1.
      let next = 0xffffffff;
      for (let cell = 0; cell < 16; cell++) {
        const distance = (cells[cell] - depth - 1) >>> 0;
        if (distance < next) next = distance;
      }
      const context = 8 * Math.min(i, 2) + kind;
      let difference = next + 1;
      if (next >= 1 << 15 || reader.bit(HIT + 8 * context + Math.min(32 - Math.clz32(difference), 7)) === 0) {
        difference = reader.number(DIFFERENCE + context);
        if (difference !== -1) difference++;
      }
      differences[i] = difference;
      depth = (depth + difference) | 0;
    }
  }
}

/** Returns the facing that summarises the blocks along a square of a level. */
function summary(facings: Int32Array, first: number, level: number): number {
  let all = facings[first];
  for (let i = first + (1 << (level - LEAF_LEVEL)) - 1; i > first; i--) {
    const facing = facings[i];
    const isSame = ((facing ^ all) & 7) === 0;
    all = ((all | facing) & ~7) | (isSame ? all & 7 : MIXED);
  }
  return all;
}

/** Returns the part of a facing that a leaf's head depends on. */
function look(facing: number): number {
  const kind = kindOfFacing(facing);
  if (kind === 0) return (classOfFacing(facing) === NEVER_CLASS ? 1 : 0);
  return (kind < 4 ? 2 : 4) + (slantOfFacing(facing) !== 0 ? 1 : 0);
}

/** Puts a value first among the `count` values from `first` on. The others keep their order; without it, the last is dropped. */
function toFront(recent: Int32Array, first: number, count: number, value: number): void {
  let place = first;
  while (place < first + count - 1 && recent[place] !== value) place++;
  for (; place > first; place--) recent[place] = recent[place - 1];
  recent[first] = value;
}

/** Writes the half-words of a leaf in their shortest form. Returns where they end. */
function writeLeaf(leaf: Leaf, halves: Uint16Array, from: number): number {
  const { last, never, slant, stored, differences, rows } = leaf;
  let at = from + 1;
  if (slant !== 0) halves[at++] = slant;
  let bits = 0;
  for (let i = 0; i < stored; i++) bits |= differences[i];
  const width = bits >>> 8 === 0 ? 0 : bits >>> 16 === 0 ? 1 : 2;
  halves[from] = last | ((never ? 1 : 0) << 6) | (width << 7) | ((slant !== 0 ? 1 : 0) << 9);
  for (let i = 0; i < stored; i++) {
    const difference = differences[i];
    if (width > 0) halves[at++] = difference;
    else if (i % 2 === 0) halves[at] = difference;
    else halves[at++] |= difference << 8;
    if (width > 1) halves[at++] = difference >>> 16;
  }
  if (width === 0 && stored % 2 === 1) at++;
  for (let plane = 0; plane < 32 - Math.clz32(last); plane++) {
    for (let word = 2; word < 18; word += 4) {
      halves[at++] =
        bitsOf(rows[word], plane) | (bitsOf(rows[word + 1], plane) << 4) | (bitsOf(rows[word + 2], plane) << 8) | (bitsOf(rows[word + 3], plane) << 12);
    }
  }
  return at;
}

/** Returns a bit of each of four bytes. */
function bitsOf(bytes: number, bit: number): number {
  return (Math.imul((bytes >>> bit) & 0x01010101, 0x01020408) >>> 24) & 15;
}
