// The change of three's shaders: behind a light's own information, its colour is multiplied by the visibility from the
// files. Whatever follows there, three's own shadow map or nothing, goes on multiplying.

import { ShaderChunk } from 'three';

import { withPrefix } from '../look-ups/look-up.js';

const INCLUDE = '#include <lights_fragment_begin>';

/** The head of a shader's main function. */
const MAIN = /void\s+main\s*\(\s*(void)?\s*\)/;

/**
 * Where the chunk has the information of a light, and the light's structure. Three has one place for each kind of lights,
 * its addon CSM one for each way to blend cascades.
 */
const PLACES = [
  /getDirectionalLightInfo\( (directionalLight|directionalLights\[0\]), directLight \);/g,
  /getSunLightInfo\( (sunLight), directLight \);/g,
];

/** Whether a fragment shader is lit by three's lights. */
export function isLit(fragmentShader: string): boolean {
  return fragmentShader.includes(INCLUDE) || fragmentShader.search(PLACES[0]!) !== -1;
}

/**
 * Returns a fragment shader with a look-up.
 *
 * @throws Error if three's chunk is not as expected.
 */
export function withLookUp(fragmentShader: string, lookUp: string, prefix: string): string {
  let text = fragmentShader.replace(INCLUDE, () => ShaderChunk.lights_fragment_begin);
  for (const place of PLACES) {
    if (text.search(place) === -1) {
      throw new Error(
        `three's chunk lights_fragment_begin has nothing like ${place.source}; ` +
          'adumbra-three works with the chunks of three 0.186 to 0.187 and of its addon CSM',
      );
    }
    text = text.replace(place, (found, light: string) => `${found}\n${withPrefix(shadowOf(light), prefix)}`);
  }
  return text.replace(MAIN, (main) => `${withPrefix(DECLARATIONS + lookUp, prefix)}\n${main}`);
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
