// The beginning of a path file: header and tables. `spec/sun-path.md` describes the bytes. Counterpart of
// `crates/adumbra/src/path/format.rs`.

import { ShadowFileError, hex } from '../error.js';
import { HEADER_BYTES as KEY_HEADER_BYTES, checkChecksum, foreign, truncated } from '../file/faults.js';
import { Fields } from '../file/fields.js';

/** Size of the header in bytes. */
export const HEADER_BYTES = 128;
/** The version of the format that is read. */
const VERSION = 1;
/** Size of a step, and of an entry of a key, in bytes. */
const ENTRY_BYTES = 32;
/** Numbers of a step: seconds, and the vector towards the sun. */
export const STEP_NUMBERS = 4;
const MAGIC = 'ADUMDAY\n';
/** The first bytes of other files of the project. */
const OTHER_KINDS: Readonly<Record<string, string>> = { 'ADUMBRA\n': 'the shadow file of one sun', ADUMTREE: 'a tree file' };

/** Where the file of a key is. */
export interface KeyPlace {
  readonly seconds: number;
  readonly offset: number;
  readonly bytes: number;
  /** Number of words of its finest level, decoded. */
  readonly words: number;
}

/** The header of a path file. */
export interface PathHeader {
  /** Latitude and longitude in degrees, north and east positive; `null` if the path has no place. */
  readonly placeDegrees: readonly [latitude: number, longitude: number] | null;
  /** How far the local clock is ahead of UTC, seconds. */
  readonly utcOffsetSeconds: number;
  /** Length of the file, bytes. */
  readonly fileBytes: number;
  /** Number of steps. */
  readonly stepCount: number;
  /** Bytes before the first key. */
  readonly frontBytes: number;
  /** CRC-32 of steps and keys. */
  readonly tablesChecksum: number;
}

/** The part of the file before the keys. */
export interface PathFront extends PathHeader {
  /** For each step: its seconds, which ascend, and the unit vector towards the sun. */
  readonly steps: Float64Array;
  /** The keys, in the order of time. */
  readonly keys: readonly KeyPlace[];
}

/**
 * Reads and checks the header at the start of `bytes`. More bytes may follow.
 *
 * @throws ShadowFileError of the kind `Magic`, `OtherKind`, `FutureVersion`, `Truncated`, `HeaderChecksum` or
 * `HeaderField`.
 */
export function parsePathHeader(bytes: Uint8Array): PathHeader {
  const [MAX_STEPS, MAX_KEYS, MAX_OFFSET] = [527_040, 65_536, 86_400];
  const HAS_PLACE = 1;
  const fields = new Fields(bytes, " of the path's header");
  identify(bytes, fields);
  fields.reserved(15, 31);
  const [flags, steps, keys] = fields.u32s(4);
  check((flags & ~HAS_PLACE) === 0, 'flags', hex(flags), '0 or 1');
  const hasPlace = flags === HAS_PLACE;
  const [latitude, longitude] = [fields.f64(8), fields.f64(10)];
  check(hasPlace || fields.isZero(8, 12), 'place', `${latitude}, ${longitude}`, 'zeros, because flag bit 0 is not set');
  check(steps > 0 && steps <= MAX_STEPS, 'steps', steps, `from 1 to ${MAX_STEPS}`);
  check(keys > 0 && keys <= MAX_KEYS, 'keys', keys, `from 1 to ${MAX_KEYS}`);
  const isOnEarth = Math.abs(latitude) <= 90 && Math.abs(longitude) <= 180;
  check(isOnEarth, 'place', `${latitude}, ${longitude}`, 'a latitude from -90 to 90 and a longitude from -180 to 180 degrees');
  const utcOffsetSeconds = fields.u32(7) | 0;
  check(Math.abs(utcOffsetSeconds) <= MAX_OFFSET, 'utc_offset_seconds', utcOffsetSeconds, `from -${MAX_OFFSET} to ${MAX_OFFSET}`);
  return {
    placeDegrees: hasPlace ? [latitude, longitude] : null,
    utcOffsetSeconds,
    fileBytes: fields.u64(12),
    stepCount: steps,
    frontBytes: HEADER_BYTES + ENTRY_BYTES * (steps + keys),
    tablesChecksum: fields.u32(14),
  };
}

/**
 * Reads and checks the tables after a header. `bytes` are the bytes of the file up to its first key.
 *
 * @throws ShadowFileError of the kind `Truncated`, `SectionChecksum` or `HeaderField`.
 */
export function parsePathTables(bytes: Uint8Array, header: PathHeader): PathFront {
  const { frontBytes, stepCount, tablesChecksum, fileBytes } = header;
  const what = 'tables of the path';
  if (bytes.length < frontBytes) throw truncated(what, frontBytes, bytes.length);
  const tables = bytes.subarray(HEADER_BYTES, frontBytes);
  checkChecksum(tables, tablesChecksum, what);
  const keysAt = ENTRY_BYTES * stepCount;
  // A copy, since numbers of 64 bits must begin at a multiple of 8.
  const steps = new Float64Array(new Uint8Array(tables.subarray(0, keysAt)).buffer);
  checkSteps(steps);
  const keys: KeyPlace[] = [];
  for (let at = keysAt; at < tables.length; at += ENTRY_BYTES) {
    const fields = new Fields(tables.subarray(at, at + ENTRY_BYTES), ' of a key');
    keys.push({ seconds: fields.f64(0), offset: fields.u64(2), bytes: fields.u64(4), words: fields.u64(6) });
  }
  const end = checkKeys(keys, frontBytes);
  check(fileBytes === end, 'file_bytes', fileBytes, end);
  return { ...header, steps, keys };
}

function checkSteps(steps: Float64Array): void {
  /** How far the square of a direction's length may be from 1. */
  const TOLERANCE = 1e-9;
  for (let at = 0; at < steps.length; at += STEP_NUMBERS) {
    const [seconds, x, y, z] = steps.subarray(at, at + STEP_NUMBERS) as unknown as [number, number, number, number];
    const name = `step ${at / STEP_NUMBERS}`;
    check(isFinite(seconds), name, seconds, 'at a finite time');
    check(Math.abs(x * x + y * y + z * z - 1) <= TOLERANCE, name, `${x}, ${y}, ${z}`, 'a unit vector towards the sun');
    check(at === 0 || seconds > steps[at - STEP_NUMBERS]!, name, seconds, 'later than the step before it');
  }
}

/** Checks keys, the first of which follows the tables. Returns where the last key ends. */
function checkKeys(keys: readonly KeyPlace[], frontBytes: number): number {
  /** Keys begin at multiples of this many bytes. */
  const ALIGNMENT = 8;
  let end = frontBytes;
  for (const [i, { seconds, offset, bytes }] of keys.entries()) {
    const place = Math.ceil(end / ALIGNMENT) * ALIGNMENT;
    check(isFinite(seconds), `key ${i}`, seconds, 'at a finite time');
    check(i === 0 || seconds > keys[i - 1]!.seconds, `key ${i}`, seconds, 'later than the key before it');
    check(offset === place && bytes >= KEY_HEADER_BYTES, `key ${i}`, `${bytes} bytes from byte ${offset} on`, `a file at byte ${place}`);
    end = offset + bytes;
  }
  return end;
}

/** Checks that `bytes` begin with a header: magic, version, length, and the checksum in its last word. */
function identify(bytes: Uint8Array, fields: Fields): void {
  const start = String.fromCharCode(...bytes.subarray(0, MAGIC.length));
  const other = OTHER_KINDS[start];
  if (other !== undefined) throw new ShadowFileError('OtherKind', `this is ${other}, not a sun path; bake one with --sun-path`);
  if (!MAGIC.startsWith(start)) throw foreign('sun path', start, MAGIC, 'adumbra bake --sun-path');
  // Another version may have a shorter header, so the version is checked before the length.
  if (bytes.length >= 16) {
    const [version, length] = [fields.u32(2), fields.u32(3)];
    if (version > VERSION) {
      const message = `version ${version} of sun paths, but this reader knows versions up to ${VERSION}; update adumbra-three, or bake the path again`;
      throw new ShadowFileError('FutureVersion', message, { version, supported: VERSION });
    }
    check(version === VERSION, 'version', version, VERSION);
    check(length === HEADER_BYTES, 'header_bytes', length, HEADER_BYTES);
  }
  if (bytes.length < HEADER_BYTES) throw truncated('header', HEADER_BYTES, bytes.length);
  checkChecksum(bytes.subarray(0, HEADER_BYTES - 4), fields.u32(31));
}

/** Throws the error for a field with a value that is not allowed, unless `isGood`. */
function check(isGood: boolean, field: string, value: number | string, expected: number | string): void {
  if (isGood) return;
  throw new ShadowFileError('HeaderField', `the path's ${field} is ${value}, but must be ${expected}; bake it again`, {
    field,
    value: String(value),
    expected: String(expected),
  });
}
