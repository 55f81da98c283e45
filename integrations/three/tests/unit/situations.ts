// Shared by tests of situations: casters, drawings without a GPU, warnings.

import { Mesh, ShaderLib } from 'three';
import type { DirectionalLight, Material, Object3D, Scene, WebGLProgramParametersWithUniforms, WebGLRenderer } from 'three';
import { afterEach, beforeEach, expect, vi } from 'vitest';

import { BakedShadowFile } from '../../src/index.js';
import type { Shown } from './shown.js';
import { validBytes } from './vectors.js';

export const file = new BakedShadowFile(validBytes('upright_depths'));
export const SUN = { x: file.grid.sun[0], y: file.grid.sun[1], z: file.grid.sun[2] };

/** Records the warnings of each test. Returns a function that returns them. */
export function keepWarnings(): () => string {
  let warn: ReturnType<typeof vi.spyOn>;
  beforeEach(() => {
    warn = vi.spyOn(console, 'warn').mockImplementation(() => undefined);
  });
  afterEach(() => warn.mockRestore());
  return () => warn.mock.calls.map((all: unknown[]) => String(all[0])).join('\n');
}

/** An object that casts. */
export function caster(name = ''): Mesh {
  return Object.assign(new Mesh(), { castShadow: true, name });
}

/** Which objects cast while the light's map is drawn. */
export function castIn(shown: Shown, ...objects: Object3D[]): boolean[] {
  let casts: boolean[] = [];
  const before = objects.map(({ castShadow }) => castShadow);
  shown.frame(() => (casts = objects.map(({ castShadow }) => castShadow)));
  expect(objects.map(({ castShadow }) => castShadow)).toEqual(before);
  return casts;
}

/** The vector from the target to the light, in the world, as three will have it. */
export function towards(light: DirectionalLight) {
  light.updateWorldMatrix(true, true);
  light.target.updateWorldMatrix(true, false);
  const [from, to] = [light, light.target].map((each) => each.position.clone().setFromMatrixPosition(each.matrixWorld));
  return from!.sub(to!);
}
export const offSun = (light: DirectionalLight): number => towards(light).normalize().distanceTo(SUN);

/** Draws a scene from a camera. */
export function drawFrom(scene: Scene, renderer: object, camera: object, meanwhile?: () => void): void {
  const hooks = scene as unknown as Record<'onBeforeRender' | 'onAfterRender', (...all: object[]) => void>;
  hooks.onBeforeRender(renderer, scene, camera);
  meanwhile?.();
  hooks.onAfterRender(renderer, scene, camera);
}

/** A material's shader, as three compiles it. */
export function compiled(material: Material, fragmentShader = ShaderLib.lambert.fragmentShader, more: object = {}) {
  const shader = { fragmentShader, vertexShader: 'void main() {}', uniforms: {} as Record<string, { value: unknown }>, ...more };
  material.onBeforeCompile(shader as unknown as WebGLProgramParametersWithUniforms, {} as WebGLRenderer);
  return shader;
}
export const lookUps = (text: string): number => (text.match(/adumbra\d+_visibility\( adumbra\d+_p/g) ?? []).length;
