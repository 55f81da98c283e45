// Shared by tests of attaching: scenes with a file attached, and the shaders of their materials.

import { DirectionalLight, Mesh, MeshLambertMaterial, Scene, ShaderLib } from 'three';
import type { Material, WebGLProgramParametersWithUniforms, WebGLRenderer } from 'three';

import { BakedShadowFile } from '../../src/index.js';
import { attachBakedShadow } from '../../src/webgl/index.js';
import type { AttachedShadow } from '../../src/webgl/index.js';
import { drawWithWebGL, webglRenderer } from './shown.js';
import { validBytes } from './vectors.js';

export const file = new BakedShadowFile(validBytes('upright_depths'));
export const LAMBERT = ShaderLib.lambert.fragmentShader;

/** The shadows that `disposeAttached` ends. */
export const attached: AttachedShadow[] = [];

/** Ends the shadows of a test; for `afterEach`. */
export function disposeAttached(): void {
  for (const each of attached.splice(0)) each.dispose();
}

/** Attaches the file to a scene with a new light. */
export function attach(scene: Scene, options = {}): AttachedShadow {
  const shadow = attachBakedShadow(scene, new DirectionalLight(), { file, ...options });
  attached.push(shadow);
  return shadow;
}

/** A scene with one mesh. */
export function world(material: Material = new MeshLambertMaterial()) {
  const scene = new Scene();
  const mesh = new Mesh(undefined, material);
  scene.add(mesh);
  return { scene, mesh, material };
}

/** The shader that three would compile. */
export function compiled(material: Material, fragmentShader = LAMBERT, vertexShader = 'void main() {}') {
  const shader = { fragmentShader, vertexShader, uniforms: {} as Record<string, { value: unknown }> };
  material.onBeforeCompile(shader as unknown as WebGLProgramParametersWithUniforms, {} as WebGLRenderer);
  return shader;
}

/** How many look-ups there are in a text. */
export function lookUps(fragmentShader: string, prefix = 'adumbra1'): number {
  return fragmentShader.split(`${prefix}_visibility( ${prefix}_p`).length - 1;
}

/** Draws a frame. */
export function frame(scene: Scene): void {
  drawWithWebGL(scene, webglRenderer());
}
