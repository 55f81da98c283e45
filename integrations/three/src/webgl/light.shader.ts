// The GLSL that multiplies a light's colour by the visibility from its files.

/** What the main function uses. */
export const DECLARATIONS = `uniform highp usampler2D adumbra_words;
uniform highp usampler2D adumbra_headers;
uniform vec3 adumbra_towards_light;
uniform float adumbra_intensity;
float adumbra_seen = -1.0;
`;

/** Directions in a shader that differ by less are the same light's. */
const SAME_LIGHT = '2e-3';

/** The shadow of a light. All cascades of a light have its direction, and one look-up serves them. */
export function shadowOf(light: string): string {
  return `if ( receiveShadow && distance( ${light}.direction, ( viewMatrix * vec4( adumbra_towards_light, 0.0 ) ).xyz ) < ${SAME_LIGHT} ) {
  if ( adumbra_seen < 0.0 ) {
    vec3 adumbra_p = ( ( vec4( geometryPosition, 1.0 ) - viewMatrix[ 3 ] ) * viewMatrix ).xyz;
    vec3 adumbra_n = normalize( ( vec4( nonPerturbedNormal, 0.0 ) * viewMatrix ).xyz );
    adumbra_seen = mix( 1.0, adumbra_visibility( adumbra_p, adumbra_n, gl_FragCoord.xy ), adumbra_intensity );
  }
  directLight.color *= adumbra_seen;
}`;
}
