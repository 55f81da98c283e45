// The first 256 bytes of a file: the fields for all of its levels. `spec/adumbra-file.md`, "Header",
// describes the words; the checks are in its order, so that every reader names the same fault. Counterpart of
// `crates/adumbra/src/file/header.rs` and `fields.rs`.

import { ShadowFileError, hex } from '../error.js';
import type { Bounds } from '../grid/light-grid.js';
import type { FileSettings } from '../settings.js';
import { GRID_BYTES, HEADER_BYTES, check, checkChecksum, foreign, truncated } from './faults.js';
import { Fields } from './fields.js';

/** The version of the format that is read. */
export const LATEST_VERSION = 4;

const MAGIC = 'ADUMBRA\n';

/** The header of a file. Every field has been checked. */
export interface ShadowFileHeader {
  /** Version of the format. */
  readonly version: number;
  /** Settings of the bake. */
  readonly settings: FileSettings;
  /** Whether common sections and bundles are coded, or stored as they are. */
  readonly isCoded: boolean;
  /** Number of levels of detail, 1 to 8. */
  readonly levelCount: number;
  /** CRC-32 of the directory of levels, which follows the header. */
  readonly directoryChecksum: number;
  /** Length of the whole file, bytes. */
  readonly fileBytes: number;
}

/**
 * Reads and checks the header at the start of `bytes`. More bytes may follow. The first 256 bytes of a file
 * are enough.
 *
 * @throws ShadowFileError of the kind `Magic`, `OtherKind`, `FutureVersion`, `Truncated`, `HeaderChecksum` or
 * `HeaderField`.
 */
export function parseHeader(bytes: Uint8Array): ShadowFileHeader {
  const ASSUME_GROUND = 1;
  const CLOSED_REGIONS = 2;
  const IGNORE_ALPHA = 4;
  const STATIC_RECEIVERS = 8;
  const HAS_BOUNDS = 16;
  const SCENE_IS_Z_UP = 32;
  const MAX_LEVELS = 8;
  const fields = new Fields(bytes);

  identify(bytes, fields);
  fields.reserved(40, 63);
  const flags = fields.u32(4);
  check(flags <= 63, 'flags', hex(flags), 'limited to bits 0 to 5');
  const has = (flag: number): boolean => (flags & flag) !== 0;
  const encoding = fields.u32(7);
  check(encoding <= 1, 'encoding', encoding, '0 (raw) or 1 (coded)');
  const region = regionOf(fields);
  const box: Bounds = { min: fields.f64s(16), max: fields.f64s(22) };
  const isGiven = has(HAS_BOUNDS);
  check(isGiven || fields.isZero(16, 28), 'bounds', `${box.min}, ${box.max}`, 'zero, because flag bit 4 is not set');

  const levelCount = fields.u32(6);
  const [constantTexels, slopeTexels, normalOffsetTexels] = fields.f64s(10);
  const settings: FileSettings = {
    resolution: fields.u32(5),
    thicknessWorld: fields.f64(8),
    assumeGround: has(ASSUME_GROUND),
    closedRegions: has(CLOSED_REGIONS),
    ignoreAlpha: has(IGNORE_ALPHA),
    sceneIsZUp: has(SCENE_IS_Z_UP),
    receivers: has(STATIC_RECEIVERS) ? 'static' : 'all',
    switchWithinVoxels: fields.u32(32),
    darkAfterVoxels: fields.u32(39),
    bounds: isGiven ? box : null,
    region,
    bias: { constantTexels, slopeTexels, normalOffsetTexels },
    triangles: fields.u64(28),
    instances: fields.u64(30),
  };
  const { resolution, thicknessWorld } = settings;
  check(resolution > 0, 'resolution', resolution, 'at least 1');
  check(levelCount > 0 && levelCount <= MAX_LEVELS, 'grids', levelCount, `from 1 to ${MAX_LEVELS}`);
  check(isFinite(thicknessWorld) && thicknessWorld >= 0, 'thickness', thicknessWorld, 'a finite number, zero or more');
  const bias = fields.f64s(10);
  check(bias.every(isFinite), 'bias', bias, 'finite numbers');
  const { min, max } = box;
  const isBox = [...min, ...max].every(isFinite) && min.every((c, a) => c <= max[a as 0 | 1 | 2]);
  check(isBox, 'bounds', `${min}, ${max}`, 'finite, with no minimum above its maximum');
  const fileBytes = fields.u64(34);
  const directoryEnd = directoryEndOf(levelCount);
  check(fileBytes >= directoryEnd, 'file_bytes', fileBytes, `at least ${directoryEnd}`);
  return { version: LATEST_VERSION, settings, isCoded: encoding === 1, levelCount, directoryChecksum: fields.u32(33), fileBytes };
}

/** Returns the region that the file covers, or `null` if it covers a whole world. */
function regionOf(fields: Fields): FileSettings['region'] {
  const [texels, x, y] = fields.u32s(36);
  if (fields.isZero(36, 39)) return null;
  const isSide = texels > 15 && texels <= 131072 && (texels & (texels - 1)) === 0;
  check(isSide, 'region', texels, 'a power of two, 16 to 131072');
  return { x: x | 0, y: y | 0, texels };
}

/** Returns the offset at which the directory of `levelCount` levels ends. */
export function directoryEndOf(levelCount: number): number {
  return HEADER_BYTES + GRID_BYTES * levelCount;
}

/** Checks that `bytes` begin with a header: magic, version, length, and the checksum in its last word. */
function identify(bytes: Uint8Array, fields: Fields): void {
  /** The first bytes of a file with a world-aligned tree, see `spec/adumbra-tree.md`. */
  const TREE_MAGIC = 'ADUMTREE';
  const start = String.fromCharCode(...bytes.subarray(0, MAGIC.length));
  if (start === TREE_MAGIC) {
    throw new ShadowFileError(
      'OtherKind',
      'this is a tree file, not a shadow file; bake the scene into one',
    );
  }
  if (!MAGIC.startsWith(start)) throw foreign('shadow file', start, MAGIC, 'adumbra bake');
  // Another version may have a shorter header, so the version is checked before the length.
  if (bytes.length >= 16) {
    const version = fields.u32(2);
    const length = fields.u32(3);
    if (version > LATEST_VERSION) {
      throw new ShadowFileError(
        'FutureVersion',
        `format version ${version}, but this reader knows up to ${LATEST_VERSION}; update adumbra-three, or bake again`,
        { version, supported: LATEST_VERSION },
      );
    }
    check(version === LATEST_VERSION, 'version', version, LATEST_VERSION);
    check(length === HEADER_BYTES, 'header_bytes', length, HEADER_BYTES);
  }
  if (bytes.length < HEADER_BYTES) throw truncated('header', HEADER_BYTES, bytes.length);
  checkChecksum(bytes.subarray(0, HEADER_BYTES - 4), fields.u32(63));
}
