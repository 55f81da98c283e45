// The look-up as a node: the generated text of a light's files, and a function that calls it.

import type { DataTexture } from 'three';
import * as TSL from 'three/tsl';
import type { Node, NodeBuilder } from 'three/webgpu';

import { withPrefix } from '../look-ups/look-up.js';
import type { LookUp } from '../look-ups/look-up.js';
import type { LightTextures } from '../light/textures.js';

/** A point whose visibility is asked for. */
export interface LookedUp {
  /** World position. */
  readonly pWorld: Node<'vec3'>;
  /** Unit normal in world space; zero in the air. */
  readonly normal: Node<'vec3'>;
  /** Pixel coordinate, which varies the noise of penumbrae. */
  readonly pixel: Node<'vec2'>;
}

/** Makes nodes of look-ups in the files of one light. */
export class LookUpNodes {
  readonly #lookUp: LookUp;
  readonly #textures: LightTextures;
  readonly #prefix: string;

  /** `prefix` tells the texts of several lights apart in one shader. */
  constructor(lookUp: LookUp, textures: LightTextures, prefix: string) {
    this.#lookUp = lookUp;
    this.#textures = textures;
    this.#prefix = prefix;
  }

  /** Returns a node for the visibility of a point, 1 = lit. */
  visibility(builder: NodeBuilder, { pWorld, normal, pixel }: LookedUp): Node<'float'> {
    const isWebGPU = 'isWebGPUBackend' in builder.renderer.backend;
    const prefix = this.#prefix;
    const language = isWebGPU ? 'wgsl' : 'glsl';
    const text = TSL.code(withPrefix(this.#lookUp[language], prefix), [], language);
    // The first two parameters only bind the textures, which the text names.
    const look = isWebGPU
      ? TSL.wgslFn(
          `fn ${prefix}_entry(words: u32, headers: u32, p: vec3<f32>, n: vec3<f32>, at: vec2<f32>) -> f32 {
            return ${prefix}_visibility(p, n, at);
          }`,
          [text],
        )
      : TSL.glslFn(
          `float ${prefix}_entry(uint words, uint headers, vec3 p, vec3 n, vec2 at) {
            return ${prefix}_visibility(p, n, at);
          }`,
          [text],
        );
    const call = look as unknown as (inputs: Record<string, Node>) => Node<'float'>;
    return call({
      words: this.#bound(this.#textures.words, 'words'),
      headers: this.#bound(this.#textures.headers, 'headers'),
      p: pWorld,
      n: normal,
      at: pixel,
    });
  }

  /** A node that binds a texture under a name of the text. */
  #bound(data: DataTexture, name: string): Node {
    const texel = TSL.texture(data).load(TSL.uvec2(0, 0));
    return (texel.setName(`${this.#prefix}_${name}`) as unknown as { x: Node }).x;
  }
}
