// The settings of a bake, as the file's header holds them, and the settings of look-ups. Counterpart of
// `crates/adumbra/src/settings.rs`.

import type { Bounds } from './grid/light-grid.js';
import type { WorldFromFile } from './grid/placement.js';

/** How far a look-up moves its point before it reads the grid, in texels (1 texel = `voxelSize`). */
export interface Bias {
  /** Distance towards the sun, on every surface. */
  readonly constantTexels: number;
  /** Distance towards the sun, multiplied by the slope of the surface, at most 9.95. */
  readonly slopeTexels: number;
  /** Distance along the normal. */
  readonly normalOffsetTexels: number;
}

/** The settings that determine what a file answers. */
export interface FileSettings {
  /** Number of texels that were requested on the longest side; at least 1. */
  readonly resolution: number;
  /** How far below an open surface its shadow may begin, world units; 0 = the bias at the surface's slope. */
  readonly thicknessWorld: number;
  /** Whether the bake assumed that no static surface is behind the last one of a column. */
  readonly assumeGround: boolean;
  /** Whether voxels inside closed solids may be lit or shadowed. */
  readonly closedRegions: boolean;
  /** Whether alpha masks were ignored. */
  readonly ignoreAlpha: boolean;
  /** Whether Z points up in the scene's own file: its (x, y, z) is (x, z, −y) in the world, in which Y does. */
  readonly sceneIsZUp: boolean;
  /** The points at which the file is correct: all in space, or those on static surfaces. */
  readonly receivers: 'all' | 'static';
  /**
   * How far behind its first surface a column may switch, voxels; 0 = anywhere that no look-up from a surface
   * reads.
   */
  readonly switchWithinVoxels: number;
  /**
   * For marches to another sun: a ray that is hidden from both keys for this many voxels from its start on is
   * taken to meet a surface. 0 = never.
   */
  readonly darkAfterVoxels: number;
  /** The box that was given for the bake, world space; `null` if none was. */
  readonly bounds: Bounds | null;
  /**
   * The region of a world that the file covers: its numbers along x and y of the grid, and its texels per
   * side; `null` if the file covers a whole world. Positions are relative to the region's origin, which the
   * world's manifest has.
   */
  readonly region: { readonly x: number; readonly y: number; readonly texels: number } | null;
  /** The bias that the file was baked for. */
  readonly bias: Bias;
  /** Number of triangles that were baked, every instance counted; rounded above 2^53. */
  readonly triangles: number;
  /** Number of instances that were baked; rounded above 2^53. */
  readonly instances: number;
}

/** Width of a filter in texels: K × K taps. */
export type FilterWidth = 1 | 3 | 5 | 9 | 17;

/** The widths that a filter can have, texels. */
export const FILTER_WIDTHS: readonly FilterWidth[] = [1, 3, 5, 9, 17];

/** Settings of look-ups. */
export interface LookUpOptions {
  /** Width of the filter in texels, by default 5. With 1, the answer is 0 or 1. */
  readonly filter?: FilterWidth | undefined;
  /** The bias; that of the file by default. */
  readonly bias?: Bias | undefined;
  /** Where the app has placed the file's world; by default where it was baked. */
  readonly placement?: WorldFromFile | undefined;
}

/** What look-ups use where their options are left out. */
export const LOOK_UP_DEFAULTS = { filter: 5 } as const;

/** Returns options with the defaults of those that are left out or `undefined`. */
export function withDefaults<O extends object, D extends { readonly [K in keyof O]?: unknown }>(
  defaults: D,
  options: O,
): O & { readonly [K in keyof D & keyof O]-?: NonNullable<O[K]> } {
  const all = { ...options } as Record<string, unknown>;
  for (const name in defaults) all[name] ??= defaults[name];
  return all as never;
}

/** Throws the error of an option that is out of its range, unless `isGood`. */
export function checkOption(isGood: boolean, name: string, value: number, range: string): void {
  if (!isGood) throw new RangeError(`${name} is ${value}, but must be ${range}`);
}

/** Checks that an option is from `low` to `high`. */
export function checkRange(name: string, value: number, low: number, high: number): void {
  checkOption(value >= low && value <= high, name, value, `from ${low} to ${high}`);
}

/**
 * Checks the width of a filter.
 *
 * @throws RangeError if it is not one of {@link FILTER_WIDTHS}.
 */
export function checkFilter(filter: number): void {
  checkOption((FILTER_WIDTHS as readonly number[]).includes(filter), "the filter's width", filter, `one of ${FILTER_WIDTHS}`);
}
