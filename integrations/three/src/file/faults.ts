// Errors that several parts of the reader have in common.

import { ShadowFileError, hex } from '../error.js';
import type { Vec3 } from '../grid/vec3.js';
import { crc32 } from './crc32.js';

/** Size of the header in bytes. */
export const HEADER_BYTES = 256;
/** Size of a directory entry in bytes. */
export const GRID_BYTES = 256;

/** Throws the error for a field with a value that is not allowed, unless `isGood`. */
export function check(isGood: boolean, name: string, value: number | Vec3 | string, expected: number | string): void {
  if (isGood) return;
  throw new ShadowFileError('HeaderField', `the header's ${name} is ${value}, but must be ${expected}; bake it again`, {
    field: name,
    value: String(value),
    expected: String(expected),
  });
}

/**
 * Returns the error for a file with an unknown beginning: it is of another kind, or the server sent something
 * else for a missing file.
 */
export function foreign(kind: string, start: string, magic: string, command: string): ShadowFileError {
  const isPage = /^\s*<(?:!doc|html)/i.test(start);
  const instead = isPage
    ? 'it is a web page, as servers send for a file that they lack; check the address'
    : start === 'version '
      ? 'it is a Git LFS pointer to one; run `git lfs pull`'
      : `it begins with ${JSON.stringify(start)} instead of ${JSON.stringify(magic)}; give a file that \`${command}\` has written, and copy it as binary`;
  return new ShadowFileError('Magic', `not a ${kind}: ${instead}`, { found: start });
}

/** Throws the error for a bundle that fits neither its entry in the table nor the grid, unless `isGood`. */
export function checkBundle(isGood: boolean, section: string, found: string, expected: string): void {
  if (isGood) return;
  throw new ShadowFileError('Bundle', `the ${section} has ${found}, but must have ${expected}; bake it again`, {
    section,
    found,
    expected,
  });
}

/** Returns the error for a coded part that cannot be decoded. */
export function notDecodable(section: string): ShadowFileError {
  return new ShadowFileError('Coded', `the ${section} cannot be decoded; copy it again, or bake it again`, { section });
}

/** Returns the error for a file that ends before a part of it does. */
export function truncated(what: string, needed: number, have: number): ShadowFileError {
  return new ShadowFileError(
    'Truncated',
    `cut off in its ${what}: ${needed} bytes are needed, but the file has ${have}; copy it again, or bake it again`,
    { what, needed, have },
  );
}

/** Returns the error for a file that goes on after its end. */
export function trailing(end: number): ShadowFileError {
  return new ShadowFileError('TrailingBytes', `continues past its end at byte ${end}; copy it again, or bake it again`, { end });
}

/** Checks the checksum of a section, or of the header if none is named. */
export function checkChecksum(bytes: Uint8Array, stored: number, section?: string): void {
  const computed = crc32(bytes);
  if (stored === computed) return;
  const isHeader = section === undefined;
  throw new ShadowFileError(
    isHeader ? 'HeaderChecksum' : 'SectionChecksum',
    `the ${isHeader ? 'header' : `section ${section}`} is damaged: its checksum is ${hex(computed)} instead of ${hex(stored)}; copy it again, or bake it again`,
    { ...(isHeader ? {} : { section }), stored, computed },
  );
}
