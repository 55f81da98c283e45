// The directory: an entry per level of detail, with the placement of its voxels in the world and the places
// of its parts in the file. Each check is written so that a NaN anywhere fails. Counterpart of
// `crates/adumbra/src/file/directory.rs`.
//
// Offsets and lengths have 64 bits and are not trusted. Above 2^53 they are rounded here. No file is that
// long, so such a part is refused: it is not at its place, or it is truncated.

import { LARGEST_RATIO } from '../coder/rans.js';
import { ShadowFileError } from '../error.js';
import { obliqueAxes, obliqueEdges } from '../grid/light-grid.js';
import type { LightGrid } from '../grid/light-grid.js';
import { cross, dot } from '../grid/vec3.js';
import type { Mat3 } from '../grid/vec3.js';
import { bundleDims } from '../quadtree/pages.js';
import { GRID_BYTES, check } from './faults.js';
import { Fields } from './fields.js';
import { directoryEndOf } from './header.js';
import type { ShadowFileHeader } from './header.js';
import { BUNDLE_ENTRY_BYTES, isPlausible } from './table.js';

/** A level has voxels this many times as large as those of the level before it. */
export const LEVEL_STEP = 4;

/** Tolerance for unit vectors and axes: far above rounding errors, and far below a texel. */
const UNIT_TOLERANCE = 1e-9;

/** A part of a file. */
export interface Section {
  /** Its name in messages, such as `common section of level 0`. */
  readonly name: string;
  /** Where it begins, bytes from the file's first. */
  readonly offset: number;
  /** Its length, bytes. */
  readonly length: number;
  /** CRC-32 of its bytes; 0 for the bundles, because each bundle has a checksum. */
  readonly checksum: number;
}

/** A directory entry. */
export interface GridEntry {
  /** Placement of the voxels in the world. */
  readonly grid: LightGrid;
  /** The table of bundles. */
  readonly table: Section;
  /** The common section. */
  readonly common: Section;
  /** Length of the words of the common section, bytes. */
  readonly commonRawBytes: number;
  /** All bundles, one after the other. */
  readonly bundles: Section;
}

/** Reads and checks a directory. The other arguments are the header's. */
export function parseDirectory(bytes: Uint8Array, { fileBytes, isCoded }: Pick<ShadowFileHeader, 'fileBytes' | 'isCoded'>): GridEntry[] {
  const entries: GridEntry[] = [];
  for (let at = 0; at < bytes.length; at += GRID_BYTES) {
    entries.push(parseEntry(bytes.subarray(at, at + GRID_BYTES), entries.length));
  }
  checkGrids(entries);
  checkPlaces(entries, fileBytes, isCoded);
  return entries;
}

/** Returns the parts of a file in the order in which they are stored. */
export function partsOf(entries: readonly GridEntry[]): Section[] {
  const coarsestFirst = [...entries].reverse();
  return [...entries.map(({ table }) => table), ...coarsestFirst.flatMap(({ common, bundles }) => [common, bundles])];
}

function parseEntry(bytes: Uint8Array, level: number): GridEntry {
  const fields = new Fields(bytes, ` of level ${level}`);
  fields.reserved(37);
  const section = (what: string, word: number): Section => {
    fields.reserved(word + 5);
    return { name: `${what} of level ${level}`, offset: fields.u64(word), length: fields.u64(word + 2), checksum: fields.u32(word + 4) };
  };
  const table = section('table', 40);
  const common = section('common section', 46);
  const bundles = section('bundles', 52);
  fields.reserved(60, 64);
  check(fields.u32(3) === level, 'level', fields.u32(3), level);
  check(bundles.checksum === 0, 'checksum of all bundles', bundles.checksum, 0);
  const sun = fields.f64s(6);
  check(isNear(dot(sun, sun), 1) && sun[1] > 0, 'sun', sun, 'a unit vector with y above zero');
  const frame = fields.u32(36);
  const isOblique = frame === 1;
  const yawRadians = fields.f64(38);
  check(frame <= 1, 'frame', frame, '0 (light) or 1 (oblique)');
  check(isOblique || fields.isZero(38, 40), 'yaw', yawRadians, 'zero, because the frame is that of the light');
  check(Math.abs(yawRadians) <= Math.PI, 'yaw', yawRadians, 'from -pi to pi');
  const axes: Mat3 = [fields.f64s(18), fields.f64s(24), fields.f64s(30)];
  const grid: LightGrid = {
    sun,
    frame: isOblique ? 'oblique' : 'light',
    yawRadians,
    voxelSize: fields.f64(4),
    corner: fields.f64s(12),
    axes,
    edges: isOblique ? obliqueEdges(sun, axes) : axes,
    size: fields.u32s(0),
  };
  return { grid, table, common, commonRawBytes: fields.u64(58), bundles };
}

/** Checks the placement of all grids. */
function checkGrids(entries: readonly GridEntry[]): void {
  const [{ grid: first }] = entries as [GridEntry];
  entries.forEach(({ grid }, level) => {
    const { size, voxelSize, corner, axes, frame, sun, yawRadians } = grid;
    check(!size.includes(0), 'size', size, 'at least 1 along each axis');
    check(isFinite(voxelSize) && voxelSize > 0, 'voxel_size', voxelSize, 'a finite number above zero');
    check(corner.every(isFinite), 'corner', corner, 'finite numbers');
    if (frame === 'light') {
      check(isAlongLight(grid), 'axes', axes.join(), 'orthonormal, right-handed, the third away from the sun');
    } else check(isUpright(grid), 'axes', axes.join(), 'those of the oblique frame for this sun and yaw');
    const isSame = sun.every((c, a) => c === first.sun[a]) && frame === first.frame && yawRadians === first.yawRadians;
    check(isSame, 'sun', `${sun}, ${frame}, ${yawRadians}`, 'that of the first grid');
    const expected = first.voxelSize * LEVEL_STEP ** level;
    check(voxelSize === expected, 'voxel_size', voxelSize, expected);
  });
}

/**
 * Checks that every part begins where the parts before it end, that common sections can have the length of
 * their words, and that the file ends with the last part.
 */
function checkPlaces(entries: readonly GridEntry[], fileBytes: number, isCoded: boolean): void {
  const tableBytes = new Map(
    entries.map(({ grid, table }) => {
      const [across, down] = bundleDims(grid.size);
      return [table, BUNDLE_ENTRY_BYTES * across * down];
    }),
  );
  const begins = new Map<Section, number>();
  let end = directoryEndOf(entries.length);
  for (const section of partsOf(entries)) {
    begins.set(section, end);
    end += tableBytes.get(section) ?? section.length;
  }
  for (const { table, common, commonRawBytes, bundles } of entries) {
    for (const section of [table, common, bundles]) {
      checkPlace(section, 'offset', section.offset, begins.get(section)!);
      checkPlace(section, 'length', section.length, tableBytes.get(section) ?? section.length);
    }
    if (!isCoded) checkPlace(common, 'raw length', commonRawBytes, common.length);
    else if (!isPlausible(common.length, commonRawBytes) || (common.length === 0) !== (commonRawBytes === 0)) {
      throw boundsError(common, 'raw length', commonRawBytes, `whole words, and at most ${LARGEST_RATIO} times its length`);
    }
  }
  check(end === fileBytes, 'file_bytes', fileBytes, end);
}

function checkPlace(section: Section, field: string, value: number, expected: number): void {
  if (value !== expected) throw boundsError(section, field, value, String(expected));
}

function boundsError({ name }: Section, field: string, value: number, expected: string): ShadowFileError {
  return new ShadowFileError(
    'SectionBounds',
    `the section ${name} has ${field} ${value}, but must have ${expected}; bake it again`,
    { section: name, field, value: String(value), expected },
  );
}

/** Whether two numbers that follow from unit vectors are equal within rounding. */
function isNear(value: number, wanted: number): boolean {
  return Math.abs(value - wanted) <= UNIT_TOLERANCE;
}

function isAlongLight({ axes, sun }: LightGrid): boolean {
  const [x, y, z] = axes;
  return (
    axes.every((axis) => isNear(dot(axis, axis), 1)) &&
    isNear(dot(x, y), 0) &&
    isNear(dot(y, z), 0) &&
    isNear(dot(z, x), 0) &&
    dot(cross(x, y), z) > 0 &&
    sun.every((c, a) => isNear(z[a as 0 | 1 | 2], -c))
  );
}

function isUpright({ axes, sun, yawRadians }: LightGrid): boolean {
  const expected = obliqueAxes(sun, yawRadians).flat();
  // Scale the tolerance, because the shear is large under a low sun.
  return axes.flat().every((c, i) => Math.abs(c - expected[i]) <= UNIT_TOLERANCE * (1 + Math.abs(expected[i])));
}
