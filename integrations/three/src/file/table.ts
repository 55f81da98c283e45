// The table of a level, with an entry per bundle, and the conversion of stored bytes to words. Counterpart of
// `crates/adumbra/src/file/table.rs` and `common.rs`.

import { PartDecoder } from '../coder/part.js';
import { LARGEST_RATIO } from '../coder/rans.js';
import { hex } from '../error.js';
import { NEVER, UNIFORM } from '../quadtree/leaf.js';
import { BUNDLE_PAGES } from '../quadtree/pages.js';
import type { DepthRange } from '../quadtree/validate.js';
import { check, checkBundle, notDecodable } from './faults.js';
import { Fields } from './fields.js';
import type { Steps } from './steps.js';

/** Size of an entry in bytes. */
export const BUNDLE_ENTRY_BYTES = 24;
/** Number of words of a bundle before those of its pages: root, base and number of words of each. */
export const HEAD_WORDS = 3 * BUNDLE_PAGES;

/** An entry of the table. */
export interface BundleEntry {
  /** Its name in messages. */
  readonly name: string;
  /** Length in the file, bytes. 0 if all columns switch at the range's nearest depth. */
  readonly storedBytes: number;
  /** Number of words of the bundle's pages. */
  readonly pageWords: number;
  /** CRC-32 of the stored bytes. */
  readonly checksum: number;
  /** Depths at which columns switch. */
  readonly range: DepthRange;
}

/** Whether a coded part of `storedBytes` bytes may have shapes of `shapesBytes` raw bytes. */
export function isPlausible(storedBytes: number, shapesBytes: number): boolean {
  return shapesBytes % 4 === 0 && shapesBytes <= LARGEST_RATIO * storedBytes;
}

/** Reads and checks a table. `name` names it, and its bundles are `bundlesBytes` long together. */
export function parseTable(bytes: Uint8Array, level: number, name: string, bundlesBytes: number, isCoded: boolean): BundleEntry[] {
  const entries: BundleEntry[] = [];
  let sum = 0;
  for (let at = 0; at < bytes.length; at += BUNDLE_ENTRY_BYTES) {
    const entry = parseEntry(bytes.subarray(at, at + BUNDLE_ENTRY_BYTES), `bundle ${entries.length} of level ${level}`, isCoded);
    sum += entry.storedBytes;
    entries.push(entry);
  }
  checkBundle(sum === bundlesBytes, name, `bundles of ${sum} bytes in all`, "the directory's length of all bundles");
  return entries;
}

function parseEntry(bytes: Uint8Array, name: string, isCoded: boolean): BundleEntry {
  const fields = new Fields(bytes);
  const [storedBytes, rawBytes, checksum] = fields.u32s(0);
  const [nearest, farthest, flags] = fields.u32s(3);
  check((flags & ~1) === 0, `reserved bits of ${name}`, hex(flags), 'limited to bit 0');
  const range: DepthRange = [nearest, farthest, flags === 1];
  const isLong = rawBytes >= 4 * HEAD_WORDS && rawBytes % 4 === 0;
  const fits =
    storedBytes === 0
      ? rawBytes === 0 && checksum === 0 && farthest === nearest && range[2] === (nearest === NEVER)
      : isLong && (isCoded ? isPlausible(storedBytes, rawBytes - 4 * HEAD_WORDS) : rawBytes === storedBytes);
  checkBundle(
    fits,
    name,
    `${storedBytes} stored and ${rawBytes} raw bytes, checksum ${checksum} and depths ${range}`,
    'no bytes and one depth, or whole words that its bytes hold',
  );
  return { name, storedBytes, pageWords: Math.max(rawBytes / 4 - HEAD_WORDS, 0), checksum, range };
}

/** Turns the stored bytes of a level into words: first those of its common section, then those of its bundles. */
export interface Unpacker {
  /** Returns the words of the common section, which are `rawBytes` long. `name` names it. */
  common(stored: Uint8Array, rawBytes: number, name: string): Steps<Uint32Array>;
  /** Returns the words of a bundle: {@link HEAD_WORDS} of its pages' heads, then those of its pages. */
  bundle(stored: Uint8Array, entry: BundleEntry): Steps<Uint32Array>;
}

/** Returns the unpacker of a level whose parts are stored without coding. */
export function rawUnpacker(): Unpacker {
  return {
    *common(stored, _, name) {
      checkBundle(stored.length % 4 === 0, name, `${stored.length} bytes`, 'whole words');
      return wordsOf(stored);
    },
    *bundle(stored) {
      return wordsOf(stored);
    },
  };
}

/** Returns the unpacker of a level whose parts are coded. */
export function codedUnpacker(): Unpacker {
  const decoder = new PartDecoder();
  const failOf = (name: string) => (): never => {
    throw notDecodable(name);
  };
  return {
    common: (stored, rawBytes, name) => decoder.common(stored, rawBytes / 4, failOf(name)),
    bundle: (stored, { name, pageWords }) => decoder.bundle(stored, HEAD_WORDS + pageWords, failOf(name)),
  };
}

/** Returns the words of a bundle with an entry from its stored bytes. */
export function* unpackBundle(unpacker: Unpacker, stored: Uint8Array, entry: BundleEntry): Steps<Uint32Array> {
  const { name, range, pageWords } = entry;
  if (stored.length === 0) {
    const words = new Uint32Array(HEAD_WORDS);
    for (let head = 0; head < HEAD_WORDS; head += 3) words.set([UNIFORM, range[0]], head);
    return words;
  }
  const words = yield* unpacker.bundle(stored, entry);
  let sum = 0;
  for (let head = 0; head < HEAD_WORDS; head += 3) sum += words[head + 2];
  checkBundle(sum === pageWords, name, `${sum} words of pages`, `${pageWords}`);
  return words;
}

/** Returns bytes as words. They are copied, since they may begin anywhere in their buffer. */
function wordsOf(bytes: Uint8Array): Uint32Array {
  // Copy by the constructor: the method `slice` of Node's Buffer makes no copy.
  return new Uint32Array(new Uint8Array(bytes).buffer);
}
