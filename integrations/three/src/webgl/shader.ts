// The change of three's shaders: behind a light's own information, its colour is multiplied by the visibility from the
// files. Whatever follows there, three's own shadow map or nothing, goes on multiplying.

import { ShaderChunk, ShaderLib } from 'three';

import type { Hooks } from '../light/three.js';
import { withPrefix } from '../look-ups/look-up.js';
import { DECLARATIONS, shadowOf } from './light.shader.js';

/** As three finds it: what is commented out is none. */
const INCLUDE = /^[ \t]*#include +<lights_fragment_begin>/m;

/** The head of a shader's main function. */
const MAIN = /void\s+main\s*\(/;

/**
 * Where three's chunk, or a shader with a loop of its own, has the information of a light, and the light's structure. Three
 * has one place for each kind of light, its addon CSM one for each way to blend cascades.
 */
const PLACES = /get(?:Directional|Sun)LightInfo\( (\w+(?:\[0\])?), directLight \);/g;

/** What a look-up needs around it: a light, the surface's point, and its normal without a normal map. */
const NEEDS = [PLACES, /^\s*vec3 geometryPosition/m, /^\s*#include <normal_fragment_begin>|vec3 nonPerturbedNormal/m];

/** What is needed of three's own shaders: of all lit materials, and of chunks. */
const PARTS = [
  ['lights_fragment_begin', 'getDirectionalLightInfo.+directLight'],
  ['lights_fragment_begin', 'vec3 geometryPosition'],
  ['normal_fragment_begin', 'vec3 nonPerturbedNormal'],
  ['lights_pars_begin', 'receiveShadow'],
  ['common', 'struct IncidentLight'],
] as const;

/** Returns what is needed of three's own shaders. */
export function shaderHooks(): Hooks {
  const hooks: Record<string, boolean> = {
    'ShaderLib.lambert: <lights_fragment_begin>': INCLUDE.test(ShaderLib.lambert?.fragmentShader),
  };
  for (const [chunk, part] of PARTS) hooks[`ShaderChunk.${chunk}: ${part}`] = new RegExp(part).test(ShaderChunk[chunk]);
  return hooks;
}

/** Returns a fragment shader with a look-up, or `null` if it is not lit as three's own materials are. */
export function withLookUp(fragmentShader: string, lookUp: string, prefix: string): string | null {
  const text = fragmentShader.replace(INCLUDE, () => ShaderChunk.lights_fragment_begin);
  if (NEEDS.some((pattern) => text.search(pattern) === -1)) return null;
  return text
    .replace(PLACES, (found, light: string) => `${found}\n${withPrefix(shadowOf(light), prefix)}`)
    .replace(MAIN, (main) => `${withPrefix(DECLARATIONS + lookUp, prefix)}\n${main}`);
}
