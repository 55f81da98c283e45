// The functions that three's nodes call. The first two parameters only bind the textures, which the text of a
// look-up names.

/** In WGSL. */
export const WGSL = `fn adumbra_entry(words: u32, headers: u32, p: vec3<f32>, n: vec3<f32>, at: vec2<f32>) -> f32 {
  return adumbra_visibility(p, n, at);
}`;

/** In GLSL. */
export const GLSL = `float adumbra_entry(uint words, uint headers, vec3 p, vec3 n, vec2 at) {
  return adumbra_visibility(p, n, at);
}`;
