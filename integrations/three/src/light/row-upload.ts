// Uploads the rows of a texture whose words change, instead of the whole texture.

import { Box2, Vector2 } from 'three';
import type { DataTexture } from 'three';

import type { AnyRenderer } from './streamed.js';
import { dataTexture } from './textures.js';

/** WebGL's first texture unit. */
const TEXTURE0 = 0x84c0;
/** Words that are uploaded at once. */
const UPLOAD_WORDS = 16384;

/** Uploads rows of one texture of words. */
export class RowUpload {
  readonly #target: DataTexture;
  /** A few rows on their way to the target. */
  readonly #rows: DataTexture;

  /** Makes the texture of a few rows. */
  constructor(target: DataTexture) {
    const { width, height } = target.image as { width: number; height: number };
    const rows = Math.min(Math.max(Math.floor(UPLOAD_WORDS / width), 1), height);
    this.#target = target;
    this.#rows = dataTexture(new Uint32Array(width * rows), width, rows);
  }

  /**
   * Uploads the rows from one up to another to a renderer that draws with the texture. Do not call it while
   * the renderer draws.
   */
  upload(renderer: AnyRenderer, from: number, to: number): void {
    const words = this.#target.image.data as Uint32Array;
    const { width, height, data } = this.#rows.image as { width: number; height: number; data: Uint32Array };
    for (let row = from; row < to; row += height) {
      const end = Math.min(row + height, to);
      data.set(words.subarray(row * width, end * width));
      this.#rows.needsUpdate = true;
      // Up to 0.183, WebGLRenderer copies into the texture of the unit that was active last.
      renderer.state?.activeTexture(TEXTURE0);
      renderer.copyTextureToTexture(this.#rows, this.#target, new Box2(new Vector2(), new Vector2(width, end - row)), new Vector2(0, row));
    }
  }

  /** Frees GPU resources. */
  dispose(): void {
    this.#rows.dispose();
  }
}
