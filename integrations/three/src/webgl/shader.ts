// The change of three's shaders: after a light's own information, its colour is multiplied by the visibility
// from the files. Code that follows, such as three's own shadow map, goes on multiplying. A mask of all
// shadows is changed in the same way.

import { ShaderChunk, ShaderLib } from 'three';
import type { WebGLProgramParametersWithUniforms } from 'three';

import type { Hooks } from '../light/three.js';
import { withPrefix } from '../look-ups/look-up.js';
import { DECLARATIONS, MASK, MASK_HEAD, MASK_VERTEX, MASK_VERTEX_END, shadowOf } from './light.shader.js';

/** Matches like three: an include that is commented out does not count. */
const INCLUDE = /^[ \t]*#include +<lights_fragment_begin>/m;

/** The head of a shader's main function. */
const MAIN = /void\s+main\s*\(/;

/**
 * Where three's chunk, or a shader with a custom loop, has the information of a light, and the light's
 * structure. Three has one place for each kind of light, its addon CSM one for each way to blend cascades.
 */
const PLACES = /get(?:Directional|Sun)LightInfo\( (\w+(?:\[0\])?), directLight \);/g;

/**
 * The code that a look-up needs around it: a light, the surface's point, and its normal without a normal map.
 */
const NEEDS = [PLACES, /^\s*vec3 geometryPosition/m, /^\s*#include <normal_fragment_begin>|vec3 nonPerturbedNormal/m];

/** The parts of three's own shaders that are needed: of all lit materials, and of chunks. */
const PARTS = [
  ['lights_fragment_begin', 'getDirectionalLightInfo.+directLight'],
  ['lights_fragment_begin', 'vec3 geometryPosition'],
  ['normal_fragment_begin', 'vec3 nonPerturbedNormal'],
  ['lights_pars_begin', 'receiveShadow'],
  ['common', 'struct IncidentLight'],
] as const;

/** Returns the parts of three's own shaders that are needed. */
export function shaderHooks(): Hooks {
  const hooks: Record<string, boolean> = {
    'ShaderLib.lambert: <lights_fragment_begin>': INCLUDE.test(ShaderLib.lambert?.fragmentShader),
  };
  for (const [chunk, part] of PARTS) hooks[`ShaderChunk.${chunk}: ${part}`] = new RegExp(part).test(ShaderChunk[chunk]);
  return hooks;
}

/** Whether a fragment shader is lit. */
export function isLit(fragmentShader: string): boolean {
  return /lights_(?:pars|fragment)_begin|directionalLights|getShadowMask/.test(fragmentShader);
}

/** A mask of shadows, as `ShadowMaterial` and addons such as `Water` have it. */
const MASK_INCLUDE = /^[ \t]*#include +<shadowmask_pars_fragment>/m;
const MASK_FUNCTION = /float\s+getShadowMask\s*\(\s*\)\s*\{/;

/** The text of a shader, and the precision that it asks for. */
export type Shader = Pick<WebGLProgramParametersWithUniforms, 'fragmentShader' | 'vertexShader'> & { readonly precision?: string };

/** Returns a shader with a look-up, or `null` if it is not lit as three's own materials are. */
export function withLookUp({ fragmentShader, vertexShader, precision = 'highp' }: Shader, lookUp: string, prefix: string): Shader | null {
  const text = fragmentShader.replace(INCLUDE, () => ShaderChunk.lights_fragment_begin).replace(MASK_INCLUDE, () => ShaderChunk.shadowmask_pars_fragment);
  const isMask = MASK_FUNCTION.test(text) && /#include +<lights_pars_begin>|uniform bool receiveShadow/.test(text);
  const hasLights = NEEDS.every((pattern) => text.search(pattern) !== -1);
  if (!isMask && !hasLights) return null;
  // The look-up needs 32 bits, whatever precision the app's own text asks for.
  const from = (each: string): string => (precision === 'highp' ? '' : `precision ${each} float;\nprecision ${each} int;\n`);
  const own = withPrefix(DECLARATIONS + from('highp') + lookUp + (isMask ? MASK : '') + from(precision), prefix);
  const mask = isMask ? text.replace(MASK_FUNCTION, withPrefix(MASK_HEAD, prefix)) : text;
  return {
    fragmentShader: mask
      .replace(PLACES, (found, light: string) => (hasLights ? `${found}\n${withPrefix(shadowOf(light), prefix)}` : found))
      .replace(MAIN, (main) => `${own}\n${main}`),
    // One position serves all lights.
    vertexShader: isMask && !vertexShader.includes(MASK_VERTEX) ? MASK_VERTEX + vertexShader + MASK_VERTEX_END : vertexShader,
  };
}
