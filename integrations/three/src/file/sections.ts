// The sections after the header: their table, and cutting a file into them. Offsets and lengths have 64 bits and come
// from outside, so they are compared as BigInt until they are known to be within the file. Counterpart of
// `crates/adumbra/src/file/sections.rs`.

import { ShadowFileError } from '../error.js';
import type { Vec3 } from '../grid/vec3.js';
import type { Layout } from '../settings.js';
import { HEADER_BYTES, checkChecksum, truncated } from './faults.js';

const U64_MAX = 2n ** 64n - 1n;

/** A section as the header's table names it. */
export interface Section {
  /** `top`, `nodes` or `leaf_masks`. */
  readonly name: string;
  /** Where it begins, bytes from the file's first. */
  readonly offset: bigint;
  /** Its length, bytes. */
  readonly length: bigint;
  /** CRC-32 of its bytes. */
  readonly checksum: number;
}

/** The sections in file order: top, nodes, leaf masks. */
export type Sections = readonly [Section, Section, Section];

/** Reads the section table. `zero` checks that a reserved word of the header is 0. */
export function readSections(view: DataView, zero: (name: string, word: number) => void): Sections {
  const read = (name: string, word: number): Section => {
    zero("section table's reserved word", word + 5);
    return {
      name,
      offset: view.getBigUint64(4 * word, true),
      length: view.getBigUint64(4 * word + 8, true),
      checksum: view.getUint32(4 * word + 16, true),
    };
  };
  return [read('top', 70), read('nodes', 76), read('leaf_masks', 82)];
}

/**
 * Checks that sections are where the specification wants them and have possible lengths. Returns the length of the whole
 * file in bytes.
 */
export function checkSections(sections: Sections, layout: Layout, topDims: Vec3): number {
  let end = BigInt(HEADER_BYTES);
  for (const section of sections) {
    const { name, offset, length } = section;
    const begin = alignUp(end);
    if (offset !== begin) throw bounds(section, 'offset', offset, String(begin));
    const [multiple, least, most] = lengthsOf(name, layout, topDims);
    if (length % multiple !== 0n || length < least || length > most) {
      const expected = least === most ? String(least) : `a multiple of ${multiple} from ${least} to ${most}`;
      throw bounds(section, 'length', length, expected);
    }
    end = endOf(section);
  }
  return Number(end);
}

/** Returns what a section's length must be a multiple of, and the least and the greatest length. */
function lengthsOf(name: string, layout: Layout, [x, y, z]: Vec3): [multiple: bigint, least: bigint, most: bigint] {
  const columns = 8n * BigInt(x) * BigInt(y);
  const words = 2n ** 32n;
  if (name === 'nodes') return [4n, 0n, { plain: 4n * (words - 2n), packed: words, depths: 2n * (words - 1n) }[layout]];
  if (name !== 'top') return [8n, 0n, layout === 'packed' ? 2n ** 19n : 8n * words];
  // The number of roots of a packed file is in the section itself.
  if (layout === 'packed') return [4n, columns + 80n, U64_MAX];
  const length = layout === 'plain' ? (columns / 2n) * BigInt(z) : columns;
  return [4n, length, length];
}

function bounds(section: Section, field: string, value: bigint, expected: string): ShadowFileError {
  return new ShadowFileError(
    'SectionBounds',
    `the section ${section.name} has ${field} ${value}, but must have ${expected}; bake it again`,
    { section: section.name, field, value: String(value), expected },
  );
}

/** Returns where a section ends, bytes from the file's first. */
function endOf({ offset, length }: Section): bigint {
  return atMostU64(offset + length);
}

/** Returns the next offset at which a section can begin: a multiple of 16. */
function alignUp(offset: bigint): bigint {
  return atMostU64(((offset + 15n) / 16n) * 16n);
}

function atMostU64(n: bigint): bigint {
  return n > U64_MAX ? U64_MAX : n;
}

/**
 * Returns the words of each section, as views of `bytes`, whose first byte must be at a multiple of 4 in its buffer.
 * The lengths and the bytes between sections are checked, and the checksums if `checksums` is true.
 */
export function split(bytes: Uint8Array, sections: Sections, checksums: boolean): Uint32Array[] {
  let end = HEADER_BYTES;
  const parts = sections.map((section) => {
    // Numbers above 2^53 are not exact, but no file is that long.
    const needed = Number(endOf(section));
    if (needed > bytes.length) throw truncated(section.name, needed, bytes.length);
    const offset = Number(section.offset);
    for (; end < offset; end++) {
      if (bytes[end] !== 0) {
        throw new ShadowFileError(
          'Padding',
          `the padding byte ${end} between two sections is ${bytes[end]}, but must be 0; copy the file again, or bake it again`,
          { offset: end, value: bytes[end] },
        );
      }
    }
    end = needed;
    return bytes.subarray(offset, needed);
  });
  if (end !== bytes.length) {
    throw new ShadowFileError(
      'TrailingBytes',
      `continues past its end at byte ${end}; copy it again, or bake it again`,
      { end },
    );
  }
  return parts.map((part, i) => {
    const { name, checksum } = sections[i as 0 | 1 | 2];
    if (checksums) checkChecksum('SectionChecksum', `section ${name}`, part, checksum, { section: name });
    return new Uint32Array(part.buffer, part.byteOffset, part.length >>> 2);
  });
}
