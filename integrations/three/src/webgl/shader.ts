// The change of three's shaders: behind a light's own information, its colour is multiplied by the visibility from the
// files. Whatever follows there, three's own shadow map or nothing, goes on multiplying.

import { ShaderChunk } from 'three';

import { withPrefix } from '../look-ups/look-up.js';

const INCLUDE = '#include <lights_fragment_begin>';

/** The head of a shader's main function. */
const MAIN = /void\s+main\s*\(\s*(void)?\s*\)/;

/** A place in the chunk, which must be there once, and the light's structure. */
const ANCHORS = [
  { text: 'getDirectionalLightInfo( directionalLight, directLight );', light: 'directionalLight' },
  { text: 'getSunLightInfo( sunLight, directLight );', light: 'sunLight' },
];

/** Whether a fragment shader is lit by three's lights. */
export function isLit(fragmentShader: string): boolean {
  return fragmentShader.includes(INCLUDE) || fragmentShader.includes(ANCHORS[0]!.text);
}

/**
 * Returns a fragment shader with a look-up.
 *
 * @throws Error if three's chunk is not as expected.
 */
export function withLookUp(fragmentShader: string, lookUp: string, prefix: string): string {
  let text = fragmentShader.replace(INCLUDE, () => ShaderChunk.lights_fragment_begin);
  for (const { text: anchor, light } of ANCHORS) {
    const count = text.split(anchor).length - 1;
    if (count !== 1) {
      throw new Error(
        `three's chunk lights_fragment_begin has ${JSON.stringify(anchor)} ${count} times instead of once; ` +
          'adumbra-three works with three 0.186 to 0.187, whose chunks no other code has changed',
      );
    }
    text = text.replace(anchor, () => `${anchor}\n${withPrefix(shadowOf(light), prefix)}`);
  }
  return text.replace(MAIN, (main) => `${withPrefix(DECLARATIONS + lookUp, prefix)}\n${main}`);
}

const DECLARATIONS = `uniform highp usampler2D adumbra_words;
uniform highp usampler2D adumbra_headers;
uniform vec3 adumbra_towards_light;
uniform float adumbra_intensity;
`;

/** Directions in a shader that differ by less are the same light's. */
const SAME_LIGHT = '2e-3';

function shadowOf(light: string): string {
  return `if ( receiveShadow && distance( ${light}.direction, ( viewMatrix * vec4( adumbra_towards_light, 0.0 ) ).xyz ) < ${SAME_LIGHT} ) {
  vec3 adumbra_p = ( ( vec4( geometryPosition, 1.0 ) - viewMatrix[ 3 ] ) * viewMatrix ).xyz;
  vec3 adumbra_n = normalize( ( vec4( nonPerturbedNormal, 0.0 ) * viewMatrix ).xyz );
  directLight.color *= mix( 1.0, adumbra_visibility( adumbra_p, adumbra_n, gl_FragCoord.xy ), adumbra_intensity );
}`;
}
