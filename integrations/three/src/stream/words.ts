// The pool of a streamed file as a texture that follows it. Only rows that have changed are uploaded.

import type { DataTexture } from 'three';

import { ShadowFileError } from '../error.js';
import type { LookUpHeader } from '../gpu/look-up-header.js';
import { RowUpload } from '../light/row-upload.js';
import type { AnyRenderer, StreamedWords } from '../light/streamed.js';
import { dataTexture } from '../light/textures.js';
import type { Pool } from './pool.js';

/** The words of a pool for one light. */
export class PoolWords implements StreamedWords {
  readonly texture: DataTexture;
  readonly lookUps: readonly LookUpHeader[];
  readonly #pool: Pool;
  readonly #onDispose: (words: PoolWords) => void;
  /** The revision of the pool that each renderer has. */
  readonly #revisions = new Map<AnyRenderer, number>();
  readonly #rows: RowUpload;

  /** Makes the texture, which every renderer uploads whole when it draws with it first. */
  constructor(pool: Pool, lookUps: readonly LookUpHeader[], maxSide: number, onDispose: (words: PoolWords) => void) {
    const { width, height } = pool.layout;
    if (Math.max(width, height) > maxSide) {
      throw new ShadowFileError('TooLarge', `the budget needs a texture of ${width} × ${height}, but a side may have ${maxSide} texels; lower it`, {
        width,
        height,
        maxSide,
      });
    }
    this.#pool = pool;
    this.lookUps = lookUps;
    this.#onDispose = onDispose;
    this.texture = dataTexture(pool.words, width, height);
    this.#rows = new RowUpload(this.texture);
  }

  /** Makes the texture follow the pool in a renderer, which is about to draw with it for the first time. */
  follow(renderer: AnyRenderer): void {
    if (!this.#revisions.has(renderer)) this.#revisions.set(renderer, this.#pool.revision);
  }

  /** Uploads changed rows to all renderers that draw with the texture. Do not call it while one draws. */
  upload(): void {
    const { revision } = this.#pool;
    for (const [renderer, had] of this.#revisions) {
      if (had === revision) continue;
      this.#pool.forEachChange(had, (from, to) => this.#rows.upload(renderer, from, to));
      this.#revisions.set(renderer, revision);
    }
  }

  dispose(): void {
    this.#revisions.clear();
    this.texture.dispose();
    this.#rows.dispose();
    this.#onDispose(this);
  }
}
