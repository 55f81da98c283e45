// The sections after the header: their table, and cutting a file into them. Offsets and lengths have 64 bits and come
// from outside. Above 2^53 they are rounded here, but no file is that long: such a section has another place than it must
// have, or is cut off. Counterpart of `crates/adumbra/src/file/sections.rs`.

import { ShadowFileError } from '../error.js';
import type { Vec3 } from '../grid/vec3.js';
import { HEADER_BYTES, checkChecksum, truncated } from './faults.js';

/** A section as the header's table names it. */
export interface Section {
  /** `top`, `nodes` or `leaf_masks`. */
  readonly name: string;
  /** Where it begins, bytes from the file's first. */
  readonly offset: number;
  /** Its length, bytes. */
  readonly length: number;
  /** CRC-32 of its bytes. */
  readonly checksum: number;
}

/** The sections in file order: top, nodes, leaf masks. */
export type Sections = readonly [Section, Section, Section];

/** Reads the section table. `zero` checks that a reserved word of the header is 0. */
export function readSections(view: DataView, zero: (word: number) => void): Sections {
  const read = (name: string, word: number): Section => {
    zero(word + 5);
    return {
      name,
      offset: Number(view.getBigUint64(4 * word, true)),
      length: Number(view.getBigUint64(4 * word + 8, true)),
      checksum: view.getUint32(4 * word + 16, true),
    };
  };
  return [read('top', 70), read('nodes', 76), read('leaf_masks', 82)];
}

/**
 * Checks that sections are where the specification wants them and have possible lengths. Returns the length of the whole
 * file in bytes.
 */
export function checkSections(sections: Sections, topDims: Vec3): number {
  let end = HEADER_BYTES;
  for (const section of sections) {
    const { name, offset, length } = section;
    const begin = Math.ceil(end / 16) * 16;
    if (offset !== begin) throw bounds(section, 'offset', begin);
    const [multiple, least, most] = lengthsOf(name, topDims);
    if (length % multiple !== 0 || length < least || length > most) {
      throw bounds(section, 'length', least === most ? least : `a multiple of ${multiple} from ${least} to ${most}`);
    }
    end = offset + length;
  }
  return end;
}

/** Returns what a section's length must be a multiple of, and the least and the greatest length. */
function lengthsOf(name: string, [x, y]: Vec3): [multiple: number, least: number, most: number] {
  const WORDS = 2 ** 32;
  if (name === 'nodes') return [4, 0, 2 * (WORDS - 1)];
  if (name === 'leaf_masks') return [8, 0, 8 * WORDS];
  const length = 8 * x * y;
  return [4, length, length];
}

function bounds(section: Section, field: 'offset' | 'length', expected: number | string): ShadowFileError {
  const value = section[field];
  return new ShadowFileError(
    'SectionBounds',
    `the section ${section.name} has ${field} ${value}, but must have ${expected}; bake it again`,
    { section: section.name, field, value: String(value), expected: String(expected) },
  );
}

/**
 * Returns the words of each section, as views of `bytes`, whose first byte must be at a multiple of 4 in its buffer.
 * The lengths and the bytes between sections are checked, and the checksums if `checksums` is true.
 */
export function split(bytes: Uint8Array, sections: Sections, checksums: boolean): Uint32Array[] {
  let end = HEADER_BYTES;
  const parts = sections.map(({ name, offset, length }) => {
    const needed = offset + length;
    if (needed > bytes.length) throw truncated(name, needed, bytes.length);
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
