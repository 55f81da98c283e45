// The files of a light: their textures, and where they are in the app's world.

import { Matrix4 } from 'three';
import type { Object3D } from 'three';

import type { LightGrid } from '../grid/light-grid.js';
import type { Vec3 } from '../grid/vec3.js';
import type { LookUp } from '../look-ups/look-up.js';
import { asPlaced } from './options.js';
import type { FileChoice, LightSettings } from './options.js';
import type { AnyRenderer, StreamedFile } from './streamed.js';
import { lightTextures } from './textures.js';
import type { LightTextures } from './textures.js';
import { warnOnce } from './warn.js';

/** The files of a light. */
export interface Files {
  readonly textures: LightTextures;
  /** The roots that they follow, by file. */
  readonly roots: readonly (Object3D | undefined)[];
  /** Whether one of them is for static surfaces only. */
  readonly isForStatics: boolean;
  /** Their suns in the app's world; `undefined` for a file that cannot follow its root. */
  suns(): readonly (Vec3 | undefined)[];
  /** Follows the roots, and streamed files in a renderer. */
  follow(renderer?: AnyRenderer | null): void;
}

/** Returns the look-up of some files. A streamed file may bring its own. */
export function lookUpOf(file: FileChoice): LookUp | undefined {
  return (asPlaced(file)[0]?.file as StreamedFile | undefined)?.lookUp;
}

/**
 * Prepares files. The textures of `earlier` files are reused if they have room. Cost: one copy of the words.
 *
 * @throws ShadowFileError of the kind `TooLarge`, if a file does not fit the texture.
 * @throws RangeError if an option is out of its range.
 */
export function openFiles(choice: FileChoice, lookUp: LookUp, options: LightSettings, earlier?: Files): Files {
  const placed = asPlaced(choice);
  // Without files, keep the earlier textures.
  const textures = placed.length === 0 && earlier ? earlier.textures : lightTextures(placed.map(({ file }) => file), lookUp, options, earlier?.textures);
  /** The suns of files with a root, as of the last time. */
  const placedSuns: (Vec3 | undefined)[] = [];
  /** The grids of those files, and the roots' matrices. The grid of a sun path changes. */
  const followed = placed.map(() => ({ grid: {} as LightGrid, matrix: new Matrix4() }));
  for (const { root } of placed) root?.updateWorldMatrix(true, false);
  return {
    textures,
    roots: placed.map(({ root }) => root),
    isForStatics: placed.some(({ file }) => file.settings.receivers === 'static'),
    suns: () => placed.map(({ file, root }, i) => (root ? placedSuns[i] : file.grid.sun)),
    follow(renderer) {
      if (renderer) textures.follow(renderer);
      placed.forEach(({ file: { grid }, root }, i) => {
        const last = followed[i]!;
        if (root === undefined || (last.grid === grid && last.matrix.equals(root.matrixWorld))) return;
        last.grid = grid;
        last.matrix.copy(root.matrixWorld);
        try {
          placedSuns[i] = textures.place(i, [...last.matrix.elements] as typeof last.matrix.elements);
        } catch (error) {
          placedSuns[i] = undefined;
          warnOnce(`the shadow file of '${root.name || root.type}' is not in use: ${(error as Error).message}`, `place ${root.id}`);
        }
      });
    },
  };
}
