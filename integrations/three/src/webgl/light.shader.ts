// The GLSL that multiplies a light's colour, or a mask of shadows, by the visibility from its files.

/** The declarations that the main function uses. */
export const DECLARATIONS = `uniform highp usampler2D adumbra_words;
uniform highp usampler2D adumbra_headers;
uniform vec3 adumbra_towards_light;
uniform float adumbra_intensity;
float adumbra_seen = -1.0;
`;

/** Directions in a shader that differ by less are the same light's. */
const SAME_LIGHT = '2e-3';

/**
 * The shadow of a light. All cascades of a light have its direction, and one look-up serves them. A camera
 * below a scaled parent scales its view along its axes.
 */
export function shadowOf(light: string): string {
  return `if ( receiveShadow && distance( ${light}.direction, normalize( ( viewMatrix * vec4( adumbra_towards_light, 0.0 ) ).xyz ) ) < ${SAME_LIGHT} ) {
  if ( adumbra_seen < 0.0 ) {
    mat3 adumbra_m = mat3( viewMatrix );
    vec3 adumbra_s = adumbra_m[ 0 ] * adumbra_m[ 0 ] + adumbra_m[ 1 ] * adumbra_m[ 1 ] + adumbra_m[ 2 ] * adumbra_m[ 2 ];
    vec3 adumbra_p = ( ( geometryPosition - viewMatrix[ 3 ].xyz ) / adumbra_s ) * adumbra_m;
    vec3 adumbra_n = normalize( nonPerturbedNormal * adumbra_m );
    adumbra_seen = mix( 1.0, adumbra_visibility( adumbra_p, adumbra_n, gl_FragCoord.xy ), adumbra_intensity );
  }
  directLight.color *= adumbra_seen;
}`;
}

/**
 * Goes before a vertex shader, and renames its main function. Declares a world position for shadow masks of
 * all lights.
 */
export const MASK_VERTEX = `varying highp vec3 bakedShadowPosition;
#define main mainBeforeBakedShadow
`;

/**
 * Goes after the vertex shader. Sets the fourth component of the view position to 1, which it is up to
 * rounding.
 */
export const MASK_VERTEX_END = `
#undef main
void main() {
  mainBeforeBakedShadow();
  bakedShadowPosition = ( inverse( viewMatrix ) * vec4( ( inverse( projectionMatrix ) * gl_Position ).xyz, 1.0 ) ).xyz;
}
`;

/** Replaces the head of a shadow mask. */
export const MASK_HEAD = `float getShadowMask();
float adumbra_mask() {`;

/**
 * The mask with the shadows of the files. The surface counts as flat, because such a shader need not have a
 * normal.
 */
export const MASK = `
#ifndef BAKED_SHADOW_POSITION
#define BAKED_SHADOW_POSITION
varying highp vec3 bakedShadowPosition;
#endif
float getShadowMask() {
  if ( ! receiveShadow ) return adumbra_mask();
  vec3 adumbra_n = normalize( cross( dFdx( bakedShadowPosition ), dFdy( bakedShadowPosition ) ) );
  return adumbra_mask() * mix( 1.0, adumbra_visibility( bakedShadowPosition, adumbra_n, gl_FragCoord.xy ), adumbra_intensity );
}
`;
