// The change of three's shaders: behind a light's own information, its colour is multiplied by the visibility from the
// files. Whatever follows there, three's own shadow map or nothing, goes on multiplying.

import { ShaderChunk, ShaderLib } from 'three';

import type { Hooks } from '../light/three.js';
import { withPrefix } from '../look-ups/look-up.js';

/** As three finds it: what is commented out is none. */
const INCLUDE = /^[ \t]*#include +<lights_fragment_begin>/m;

/** The head of a shader's main function. */
const MAIN = /void\s+main\s*\(/;

/**
 * Where three's chunk, or a shader with a loop of its own, has the information of a light, and the light's structure. Three
 * has one place for each kind of light, its addon CSM one for each way to blend cascades.
 */
const PLACES = /get(?:Directional|Sun)LightInfo\( (\w+(?:\[0\])?), directLight \);/g;

const POSITION = /^\s*vec3 geometryPosition/m;
const NORMAL = /^\s*#include <normal_fragment_begin>|vec3 nonPerturbedNormal/m;

/** What a look-up needs around it: a light, the surface's point, and its normal without a normal map. */
const NEEDS = [PLACES, POSITION, NORMAL];

/** What is needed of three's own shaders. */
export function shaderHooks(): Hooks {
  const { common, lights_fragment_begin, lights_pars_begin, normal_fragment_begin } = ShaderChunk;
  const has = (text: string | undefined, pattern: RegExp): boolean => text !== undefined && text.search(pattern) !== -1;
  return {
    "'#include <lights_fragment_begin>' in ShaderLib.lambert": has(ShaderLib.lambert?.fragmentShader, INCLUDE),
    "'getDirectionalLightInfo( …, directLight )' in ShaderChunk.lights_fragment_begin": has(lights_fragment_begin, PLACES),
    "'geometryPosition' in ShaderChunk.lights_fragment_begin": has(lights_fragment_begin, POSITION),
    "'nonPerturbedNormal' in ShaderChunk.normal_fragment_begin": has(normal_fragment_begin, NORMAL),
    "'receiveShadow' in ShaderChunk.lights_pars_begin": has(lights_pars_begin, /receiveShadow/),
    "'IncidentLight' in ShaderChunk.common": has(common, /IncidentLight/),
  };
}

/** Returns a fragment shader with a look-up, or `null` if it is not lit as three's own materials are. */
export function withLookUp(fragmentShader: string, lookUp: string, prefix: string): string | null {
  const text = fragmentShader.replace(INCLUDE, () => ShaderChunk.lights_fragment_begin);
  if (NEEDS.some((pattern) => text.search(pattern) === -1)) return null;
  return text
    .replace(PLACES, (found, light: string) => `${found}\n${withPrefix(shadowOf(light), prefix)}`)
    .replace(MAIN, (main) => `${withPrefix(DECLARATIONS + lookUp, prefix)}\n${main}`);
}

const DECLARATIONS = `uniform highp usampler2D adumbra_words;
uniform highp usampler2D adumbra_headers;
uniform vec3 adumbra_towards_light;
uniform float adumbra_intensity;
float adumbra_seen = -1.0;
`;

/** Directions in a shader that differ by less are the same light's. */
const SAME_LIGHT = '2e-3';

/** The shadow of a light. All cascades of a light have its direction, and one look-up serves them. */
function shadowOf(light: string): string {
  return `if ( receiveShadow && distance( ${light}.direction, ( viewMatrix * vec4( adumbra_towards_light, 0.0 ) ).xyz ) < ${SAME_LIGHT} ) {
  if ( adumbra_seen < 0.0 ) {
    vec3 adumbra_p = ( ( vec4( geometryPosition, 1.0 ) - viewMatrix[ 3 ] ) * viewMatrix ).xyz;
    vec3 adumbra_n = normalize( ( vec4( nonPerturbedNormal, 0.0 ) * viewMatrix ).xyz );
    adumbra_seen = mix( 1.0, adumbra_visibility( adumbra_p, adumbra_n, gl_FragCoord.xy ), adumbra_intensity );
  }
  directLight.color *= adumbra_seen;
}`;
}
