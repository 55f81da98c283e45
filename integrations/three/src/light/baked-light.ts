// A light with its files: what both renderers have in common.

import { Vector3 } from 'three';
import type { DataTexture, Object3D } from 'three';

import { filtered } from '../look-ups/filtered.js';
import type { LookUp } from '../look-ups/look-up.js';
import { alignLight, towardsLight } from './direction.js';
import type { SunLike } from './direction.js';
import { asList } from './options.js';
import type { BakedShadowOptions, ShadowOptions } from './options.js';
import { isMover, staticsOf } from './statics.js';
import type { AnyRenderer, LightFile, StreamedFile } from './streamed.js';
import { lightTextures } from './textures.js';
import { warnOnce } from './warn.js';

/** A light with its files. */
export interface BakedLight {
  readonly lookUp: LookUp;
  /** What the names of its texts begin with, which tells them apart from those of other lights. */
  readonly prefix: string;
  /** Unit vector towards the light, world space, as of the last update. */
  readonly towards: Vector3;
  /** The files' words, one per texel. */
  readonly words: DataTexture;
  /** The files' parameters, one row per file. The files in use come first. */
  readonly headers: DataTexture;
  /** Changes options; what is left out stays. Nothing is changed if it throws a RangeError. */
  setOptions(options: ShadowOptions): void;
  /** Whether the light shines from the sun of a file. */
  isActive(): boolean;
  /**
   * Follows the light, and takes casters out of shadow maps while a file is in use, before `renderer` draws. Returns false
   * after `dispose`.
   */
  update(renderer?: AnyRenderer | null): boolean;
  /** Gives casters back, though the light may come back. */
  rest(): void;
  /** Warns once if something below `object` gets wrong answers from a file that is for static surfaces only. */
  warnOfMovers(object: Object3D): void;
  /** Gives casters back, and frees what the GPU holds. Returns false after the first time. */
  dispose(): boolean;
}

/** Files whose sun is farther than this from the light are not in use: the distance of two unit vectors. */
const SAME_SUN = 1.5e-3;

/** Numbers in use. A number that is free is used again, so that shaders are too. */
const inUse = new Set<number>();

/** Reads the options of a light, and prepares its files. */
export function bakedLight(light: SunLike, file: LightFile | readonly LightFile[], options: BakedShadowOptions): BakedLight {
  const files = asList(file);
  const lookUp = (files[0] as StreamedFile | undefined)?.lookUp ?? options.lookUp ?? filtered;
  const textures = lightTextures(files, lookUp, options);
  if (options.align ?? true) alignLight(light, files[0]!.grid.sun);
  const roots = asList(options.statics);
  const statics = staticsOf(roots);
  const towards = new Vector3();
  const isForStatics = files.some(({ settings }) => settings.receivers === 'static');
  let isDisposed = false;
  let number = 1;
  while (inUse.has(number)) number += 1;
  inUse.add(number);
  /** The numbers of the files whose sun is in a direction. */
  const filesTowards = ({ x, y, z }: Vector3): number[] =>
    [...files.keys()].filter((i) => {
      const { sun } = files[i]!.grid;
      return Math.hypot(sun[0] - x, sun[1] - y, sun[2] - z) <= SAME_SUN;
    });
  return {
    lookUp,
    prefix: `adumbra${number}`,
    towards,
    words: textures.words,
    headers: textures.headers,
    setOptions: textures.setOptions,
    isActive: () => !isDisposed && filesTowards(towardsLight(light, new Vector3())).length > 0,
    update(renderer) {
      if (isDisposed) return false;
      if (renderer) textures.follow(renderer);
      const now = filesTowards(towardsLight(light, towards));
      textures.use(now);
      statics.rest(now.length > 0);
      return true;
    },
    rest: () => statics.rest(false),
    warnOfMovers(object) {
      if (!isForStatics) return;
      object.traverse((each) => {
        if (!each.receiveShadow || !isMover(each, roots)) return;
        warnOnce(
          `'${each.name || each.type}' moves, and a file baked with --receivers static is wrong at 1 to 3 % of it; bake without`,
          'movers',
        );
      });
    },
    dispose() {
      if (isDisposed) return false;
      isDisposed = true;
      statics.release();
      textures.dispose();
      inUse.delete(number);
      return true;
    },
  };
}
