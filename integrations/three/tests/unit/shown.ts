// A baked shadow in a separate scene, and drawings of it without a GPU, which make three's calls around and
// within a drawing.

import { DirectionalLight, Mesh, MeshLambertMaterial, OrthographicCamera, Scene } from 'three';
import type { Camera, DataTexture, Object3D, Texture, WebGLProgramParametersWithUniforms, WebGLRenderer } from 'three';
import type { NodeFrame } from 'three/webgpu';

import { BakedShadowFile } from '../../src/index.js';
import { asPlaced } from '../../src/light/options.js';
import type { FileChoice, LightSettings } from '../../src/light/options.js';
import { attachBakedShadow } from '../../src/webgl/index.js';
import type { BakedShadow } from '../../src/webgl/index.js';
import { BakedShadowNode } from '../../src/webgpu/index.js';
import { validBytes } from './vectors.js';

const upright = new BakedShadowFile(validBytes('upright_depths'));

/** A shadow in a separate scene. */
export interface Shown {
  readonly scene: Scene;
  readonly shadow: BakedShadow;
  readonly light: DirectionalLight;
  /** Returns the texture of parameters that the GPU has. */
  headers(): DataTexture;
  /** A stand-in for the renderer. */
  readonly renderer: { shadowMap: { needsUpdate?: boolean } };
  /** Draws. Calls `drawMap` where three would draw the light's shadow map. */
  frame(drawMap?: () => void): void;
}

/** A stand-in for a WebGLRenderer, with the properties that it keeps of materials. */
export function webglRenderer() {
  const kept = new WeakMap<object, object>();
  const get = (material: object): Record<string, unknown> => {
    if (!kept.has(material)) kept.set(material, {});
    return kept.get(material) as Record<string, unknown>;
  };
  return { isWebGLRenderer: true, shadowMap: {}, properties: { get } };
}

/** Draws a scene from a camera, and calls `meanwhile` within the drawing. */
function draw(scene: Scene, renderer: object, camera: Camera, meanwhile?: () => void): void {
  const hooks = scene as unknown as Record<'onBeforeRender' | 'onAfterRender', (renderer: object, scene: Scene, camera: Camera) => void>;
  hooks.onBeforeRender(renderer, scene, camera);
  meanwhile?.();
  hooks.onAfterRender(renderer, scene, camera);
}

/** Draws a scene as WebGLRenderer does: once for all maps. */
export function drawWithWebGL(scene: Scene, renderer: object, drawMap?: () => void): void {
  scene.updateMatrixWorld();
  draw(scene, renderer, new OrthographicCamera(), drawMap);
}

/**
 * Draws a scene as WebGPURenderer does: each map separately, within the drawing of the scene, from the
 * light's camera.
 */
export function drawWithWebGPU(scene: Scene, renderer: object, node: BakedShadowNode, light: DirectionalLight, drawMap?: () => void): void {
  scene.updateMatrixWorld();
  draw(scene, renderer, new OrthographicCamera(), () => {
    node.updateBefore({ renderer, scene } as unknown as NodeFrame);
    light.shadow.updateMatrices(light);
    draw(scene, renderer, light.shadow.camera, drawMap);
  });
}

/** Returns a scene as an app has it, with the light, and with roots that have no parent yet. */
function sceneOf(light: DirectionalLight, files: FileChoice, options: LightSettings): Scene {
  const roots: Object3D[] = [...asPlaced(files).flatMap(({ root }) => root ?? []), ...[options.statics ?? []].flat()];
  return new Scene().add(light, light.target, ...roots.filter(({ parent }) => parent === null)) as Scene;
}

/** A light in a scene that WebGLRenderer draws. */
function webgl(options: LightSettings, files: FileChoice = upright, light = new DirectionalLight()): Shown {
  const material = new MeshLambertMaterial();
  const scene = sceneOf(light, files, options).add(new Mesh(undefined, material)) as Scene;
  const shadow = attachBakedShadow(scene, light, { file: files, ...options });
  const shader = { fragmentShader: '#include <lights_fragment_begin>\n#include <normal_fragment_begin>\nvoid main() {}', vertexShader: '', uniforms: {} };
  material.onBeforeCompile(shader as unknown as WebGLProgramParametersWithUniforms, {} as WebGLRenderer);
  const uniforms = Object.entries(shader.uniforms as Record<string, { value: DataTexture }>);
  const headers = uniforms.find(([name]) => name.endsWith('_headers'))![1];
  const renderer = webglRenderer();
  const frame: Shown['frame'] = (drawMap) => drawWithWebGL(scene, renderer, drawMap);
  return { scene, shadow, light, renderer, headers: () => headers.value, frame };
}

/** A light in a scene that WebGPURenderer draws. */
function webgpu(options: LightSettings, files: FileChoice = upright, light = new DirectionalLight()): Shown {
  const scene = sceneOf(light, files, options);
  const shadow = new BakedShadowNode(light, { file: files, ...options });
  let headers: Texture | null = null;
  const renderer = { shadowMap: {}, initTexture: (texture: Texture) => (headers = texture) };
  const frame: Shown['frame'] = (drawMap) => drawWithWebGPU(scene, renderer, shadow, light, drawMap);
  frame();
  return { scene, shadow, light, renderer, headers: () => headers as unknown as DataTexture, frame };
}

/** Both renderers, by name. */
export const RENDERERS = [
  ['WebGLRenderer', webgl],
  ['WebGPURenderer', webgpu],
] as const;
