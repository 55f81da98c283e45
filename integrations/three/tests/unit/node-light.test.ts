// How three's node of a light handles a shadow node, without a GPU.

import { DirectionalLight, Mesh, PerspectiveCamera, Scene } from 'three';
import { AnalyticLightNode } from 'three/webgpu';
import type { NodeBuilder, NodeFrame } from 'three/webgpu';
import { expect, test, vi } from 'vitest';

import { BakedShadowFile } from '../../src/index.js';
import { BakedShadowNode } from '../../src/webgpu/index.js';
import { visibilityNode } from '../../src/webgpu/look-up-node.js';
import type { BakedLight } from '../../src/light/baked-light.js';
import { validBytes } from './vectors.js';

const file = new BakedShadowFile(validBytes('upright_depths'));

/** Members that the types leave out. */
type LightNode = AnalyticLightNode<DirectionalLight> & { shadowNode: unknown; colorNode: unknown; setupShadow(builder: object): void };

/** A light with a shadow, and three's node of it after its first build. */
function built() {
  const light = new DirectionalLight();
  light.castShadow = true;
  new Scene().add(light);
  const shadow = new BakedShadowNode(light, { file });
  light.shadow.shadowNode = shadow;
  const node = new AnalyticLightNode(light) as LightNode;
  const lit = node.colorNode;
  const build = (): void => node.setupShadow({ renderer: { shadowMap: { enabled: true } }, context: {} });
  build();
  return { light, shadow, node, lit, build };
}

test.each([
  ['the light is disposed', ({ light }: ReturnType<typeof built>) => light.dispose()],
  ['somebody says so to its listeners', ({ light }: ReturnType<typeof built>) => light.dispatchEvent({ type: 'dispose' })],
  ['the shadow is disposed', ({ shadow }: ReturnType<typeof built>) => shadow.dispose()],
  ['another shadow takes its place', ({ light }: ReturnType<typeof built>) => void (light.shadow.shadowNode = new BakedShadowNode(light, { file }))],
])('three goes on without the shadow after %s', (_, end) => {
  const parts = built();
  const { light, shadow, node, lit, build } = parts;
  expect(node.shadowNode).toBe(shadow);
  end(parts);
  expect([node.shadowNode, node.colorNode]).toEqual([null, lit]);
  expect(shadow.isActive).toBe(false);
  expect(light.shadow.shadowNode).not.toBe(shadow);
  build();
  expect(node.shadowNode).not.toBeNull();
  (light.shadow.shadowNode as BakedShadowNode | undefined)?.dispose();
  expect(Object.hasOwn(light, 'dispatchEvent')).toBe(false);
});

test('a new node aligns the light at once, whatever it had before', () => {
  const { light } = built();
  const where = light.position.clone();
  const again = new BakedShadowNode(light, { file });
  expect(again.isActive).toBe(true);
  expect(light.position.distanceTo(where)).toBeLessThan(1e-6);
  again.dispose();
  expect(light.position.toArray()).toEqual([0, 1, 0]);
});

test('three drops a shadow that ends within another event', () => {
  const { light, shadow, node, lit } = built();
  light.addEventListener('removed', () => shadow.dispose());
  light.removeFromParent();
  expect([node.shadowNode, node.colorNode]).toEqual([null, lit]);
});

test('a lamp’s camera is never taken for the sun’s shadow camera', () => {
  const { light, shadow } = built();
  const scene = light.parent as Scene;
  const house = Object.assign(new Mesh(), { castShadow: true });
  scene.add(house);
  const again = new BakedShadowNode(light, { file, statics: house });
  scene.updateMatrixWorld();
  again.updateBefore({ renderer: null, scene } as unknown as NodeFrame);
  light.shadow.updateMatrices(light);
  const lamp = new PerspectiveCamera();
  lamp.matrixWorld.copy(light.shadow.camera.matrixWorld);
  for (const [camera, casts] of [[light.shadow.camera, false], [lamp, true]] as const) {
    (scene.onBeforeRender as (...all: unknown[]) => void)({}, scene, camera);
    expect(house.castShadow).toBe(casts);
    (scene.onAfterRender as (...all: unknown[]) => void)({}, scene, camera);
  }
  again.dispose();
  shadow.dispose();
});

test('a light without a shadow gets no second dispose event', () => {
  const { light, shadow } = built();
  const listener = vi.fn();
  light.addEventListener('dispose', listener);
  light.dispose();
  shadow.dispose();
  shadow.updateBefore({ renderer: null, scene: light.parent } as unknown as NodeFrame);
  expect(listener).toHaveBeenCalledTimes(1);
});

test('a backend other than WebGPU gets GLSL', () => {
  const texts: string[] = [];
  const lookUp = { name: 'filtered', isSoft: false, get wgsl() { return texts.push('wgsl'), ''; }, get glsl() { return texts.push('glsl'), ''; } };
  for (const backend of [{ isWebGPUBackend: true }, { isWebGPUBackend: false }, {}]) {
    try {
      visibilityNode({ renderer: { backend } } as unknown as NodeBuilder, { lookUp, prefix: 'adumbra1', textures: () => ({}) } as unknown as BakedLight, {} as never);
    } catch {
      // Expected: this test has no nodes.
    }
  }
  expect(texts).toEqual(['wgsl', 'glsl', 'glsl']);
});
