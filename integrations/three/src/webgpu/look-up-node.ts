// The look-up as a node: the generated text of a light's files, and a function that calls it.

import type { DataTexture } from 'three';
import * as TSL from 'three/tsl';
import type { Node, NodeBuilder } from 'three/webgpu';

import { withPrefix } from '../look-ups/look-up.js';
import { GLSL, WGSL } from './entry.shader.js';
import type { BakedLight } from '../light/baked-light.js';

/** A point whose visibility is looked up. */
export interface LookedUp {
  /** World position. */
  readonly pWorld: Node<'vec3'>;
  /** Unit normal in world space; zero in the air. */
  readonly normal: Node<'vec3'>;
  /** Pixel coordinate, which varies the noise of penumbrae. */
  readonly pixel: Node<'vec2'>;
}

/** Returns a node for the visibility of a point under a light, 1 = lit. */
export function visibilityNode(builder: NodeBuilder, { lookUp, prefix, textures }: BakedLight, { pWorld, normal, pixel }: LookedUp): Node<'float'> {
  const { words, headers } = textures();
  // Three's bridge to WebGLRenderer says false.
  const isWebGPU = (builder.renderer.backend as { isWebGPUBackend?: boolean }).isWebGPUBackend === true;
  const language = isWebGPU ? 'wgsl' : 'glsl';
  const text = TSL.code(withPrefix(lookUp[language], prefix), [], language);
  const look = (isWebGPU ? TSL.wgslFn : TSL.glslFn)(withPrefix(isWebGPU ? WGSL : GLSL, prefix), [text]);
  /** A node that binds a texture under a name of the text. */
  const bound = (data: DataTexture, name: string): Node => {
    const texel = TSL.texture(data).load(TSL.uvec2(0, 0));
    return (texel.setName(`${prefix}_${name}`) as unknown as { x: Node }).x;
  };
  const call = look as unknown as (inputs: Record<string, Node>) => Node<'float'>;
  return call({ words: bound(words, 'words'), headers: bound(headers, 'headers'), p: pWorld, n: normal, at: pixel });
}
