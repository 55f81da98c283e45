// The 384 bytes before the sections. `spec/adumbra-file.md`, "Header", has the words; the checks are in its order, so
// that every reader names the same fault. Counterpart of `crates/adumbra/src/file/header.rs` and `fields.rs`.

import { ShadowFileError, hex } from '../error.js';
import { obliqueEdges } from '../grid/light-grid.js';
import type { Bounds, LightGrid } from '../grid/light-grid.js';
import { dot, map3 } from '../grid/vec3.js';
import type { Mat3, Vec3 } from '../grid/vec3.js';
import { QUADTREE } from '../settings.js';
import type { FileSettings } from '../settings.js';
import { HEADER_BYTES, check, checkChecksum, truncated } from './faults.js';
import { checkGrid, checkSettings, isNear } from './header-checks.js';
import { checkSections, readSections } from './sections.js';
import type { Sections } from './sections.js';

/** The latest version of the format that is read; the earliest is 1. */
export const LATEST_VERSION = 3;

const MAGIC = 'ADUMBRA\n';

/** The header of a file. Every field has been checked. */
export interface ShadowFileHeader {
  /** Version of the format, 1 to 3. */
  readonly version: number;
  /** Placement of the voxels in the world. */
  readonly grid: LightGrid;
  /** Settings of the bake. */
  readonly settings: FileSettings;
  /** A root spans 2^rootLevel columns along each side; 3 to 20. */
  readonly rootLevel: number;
  /** Number of roots along x, y, z. Only x and y count. */
  readonly topDims: Vec3;
  /** The section table. */
  readonly sections: Sections;
  /** Length of the whole file, bytes. */
  readonly fileBytes: number;
}

/**
 * Reads and checks the header at the start of `bytes`, which may go on behind it. The first 384 bytes of a file are
 * enough.
 *
 * @throws ShadowFileError of the kind `Magic`, `OtherKind`, `FutureVersion`, `Truncated`, `HeaderChecksum`, `Layout`,
 * `HeaderField` or `SectionBounds`.
 */
export function parseHeader(bytes: Uint8Array): ShadowFileHeader {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  const u32 = (word: number): number => view.getUint32(4 * word, true);
  const f64 = (word: number): number => view.getFloat64(4 * word, true);
  const u32s = (word: number): Vec3 => [u32(word), u32(word + 1), u32(word + 2)];
  const f64s = (word: number): Vec3 => [f64(word), f64(word + 2), f64(word + 4)];
  const u64 = (word: number): number => Number(view.getBigUint64(4 * word, true));
  const zero = (word: number): void => check(u32(word) === 0, `reserved word ${word}`, hex(u32(word)), 0);

  identify(bytes, view);
  const version = u32(2);
  const sections = readSections(view, zero);
  const reserved = [92, 93, 94, ...(version === 1 ? [13, 88] : []), ...(version < 3 ? [89] : [])];
  reserved.forEach(zero);

  checkLayout(u32(13));
  const ASSUME_GROUND = 1;
  const CLOSED_REGIONS = 2;
  const IGNORE_ALPHA = 4;
  const STATIC_RECEIVERS = 8;
  const HAS_BOUNDS = 16;
  const flags = u32(4);
  check(flags <= 31, 'flags', hex(flags), 'limited to bits 0 to 4');
  const has = (flag: number): boolean => (flags & flag) !== 0;
  const box: Bounds = { min: f64s(54), max: f64s(60) };
  for (let word = 54; word < 66; word++) {
    check(has(HAS_BOUNDS) || u32(word) === 0, 'bounds', `${box.min}, ${box.max}`, 'zero, because flag bit 4 is not set');
  }
  const sun = f64s(16);
  check(isNear(dot(sun, sun), 1) && sun[1] > 0, 'sun', sun, 'a unit vector with y above zero');
  const frame = u32(89);
  const yawRadians = f64(90);
  check(frame <= 1, 'frame', frame, '0 (light) or 1 (oblique)');
  const isOblique = frame === 1;
  check(isOblique || (u32(90) | u32(91)) === 0, 'yaw', yawRadians, 'zero, because the frame is that of the light');
  check(Math.abs(yawRadians) <= Math.PI, 'yaw', yawRadians, 'from -pi to pi');

  const voxelSize = f64(14);
  const axes: Mat3 = [f64s(28), f64s(34), f64s(40)];
  // Up to version 2 the header held the world position of the corner.
  const place = f64s(22);
  const corner = version < 3 ? map3(place, (_, a) => dot(axes[a], place) / voxelSize) : place;
  const grid: LightGrid = {
    sun,
    frame: isOblique ? 'oblique' : 'light',
    yawRadians,
    voxelSize,
    corner,
    axes,
    edges: isOblique ? obliqueEdges(sun, axes) : axes,
    size: u32s(6),
  };
  const [constantTexels, slopeTexels, normalOffsetTexels] = f64s(48);
  const settings: FileSettings = {
    resolution: u32(5),
    thicknessWorld: f64(46),
    assumeGround: has(ASSUME_GROUND),
    closedRegions: has(CLOSED_REGIONS),
    ignoreAlpha: has(IGNORE_ALPHA),
    receivers: has(STATIC_RECEIVERS) ? 'static' : 'all',
    switchWithinVoxels: u32(88),
    bounds: has(HAS_BOUNDS) ? box : null,
    bias: { constantTexels, slopeTexels, normalOffsetTexels },
    triangles: u64(66),
    instances: u64(68),
  };
  checkSettings(settings);
  checkGrid(grid);
  const rootLevel = u32(9);
  check(rootLevel >= 3 && rootLevel <= 20, 'root_level', rootLevel, 'from 3 to 20');
  const topDims = u32s(10);
  const expected = map3(grid.size, (n) => Math.ceil(n / 2 ** rootLevel)).join();
  check(topDims.join() === expected, 'top_dims', topDims, `${expected}, for size ${grid.size} and root_level ${rootLevel}`);
  const fileBytes = checkSections(sections, topDims);
  return { version, grid, settings, rootLevel, topDims, sections, fileBytes };
}

/** Checks that the voxels are a quadtree. Other layouts are refused by name. */
function checkLayout(layout: number): void {
  const name = ['plain', 'packed'][layout];
  if (name !== undefined) {
    throw new ShadowFileError('Layout', `this file has the layout ${name}, which this version does not read; bake it again`, { layout: name });
  }
  check(layout === QUADTREE, 'layout', layout, `${QUADTREE} (depths)`);
}

/** Checks that `bytes` begin with a header: magic, version, length, and the checksum in its last word. */
function identify(bytes: Uint8Array, view: DataView): void {
  /** The first bytes of a file with a world-aligned tree, see `spec/adumbra-tree.md`. */
  const TREE_MAGIC = 'ADUMTREE';
  const start = String.fromCharCode(...bytes.subarray(0, MAGIC.length));
  if (start === TREE_MAGIC) {
    throw new ShadowFileError(
      'OtherKind',
      'this is a tree file, not a shadow file; bake the scene into one',
    );
  }
  if (!MAGIC.startsWith(start)) {
    throw new ShadowFileError(
      'Magic',
      `not a shadow file: it begins with ${JSON.stringify(start)} instead of ${JSON.stringify(MAGIC)}; give a file that \`adumbra bake\` has written, and copy it as binary`,
      { found: start },
    );
  }
  // Another version may have a shorter header, so the version is checked before the length.
  if (bytes.length >= 16) {
    const version = view.getUint32(8, true);
    const length = view.getUint32(12, true);
    if (version > LATEST_VERSION) {
      throw new ShadowFileError(
        'FutureVersion',
        `format version ${version}, but this reader knows versions up to ${LATEST_VERSION}; update adumbra-three, or bake the scene again`,
        { version, supported: LATEST_VERSION },
      );
    }
    check(version >= 1, 'version', version, `1 to ${LATEST_VERSION}`);
    check(length === HEADER_BYTES, 'header_bytes', length, HEADER_BYTES);
  }
  if (bytes.length < HEADER_BYTES) throw truncated('header', HEADER_BYTES, bytes.length);
  const end = HEADER_BYTES - 4;
  checkChecksum('HeaderChecksum', 'header', bytes.subarray(0, end), view.getUint32(end, true));
}
