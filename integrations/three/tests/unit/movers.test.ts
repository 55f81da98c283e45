// A file that was baked for static receivers gives wrong answers on moving objects; one warning says so.

import { DirectionalLight, Group, Mesh, Scene, SkinnedMesh } from 'three';
import type { NodeFrame } from 'three/webgpu';
import { beforeEach, expect, it, vi } from 'vitest';

import { BakedShadowFile } from '../../src/index.js';
import { drawWithWebGL, webglRenderer } from './shown.js';
import { validBytes } from './vectors.js';

const ofStatics = new BakedShadowFile(validBytes('sphere_depths'));
const ofAll = new BakedShadowFile(validBytes('example_8_depths'));

const warn = vi.spyOn(console, 'warn').mockImplementation(() => undefined);

beforeEach(() => {
  warn.mockClear();
  vi.resetModules();
});

/** A scene with a static house and a car. */
function world() {
  const scene = new Scene();
  const statics = new Group();
  const house = new Mesh();
  const car = new Mesh();
  car.name = 'car';
  for (const each of [house, car]) each.receiveShadow = true;
  scene.add(statics.add(house), car);
  return { scene, statics, house, car };
}

type World = ReturnType<typeof world>;

async function attach({ scene }: World, file: BakedShadowFile, statics?: Group): Promise<void> {
  const { attachBakedShadow } = await import('../../src/webgl/index.js');
  const shadow = attachBakedShadow(scene, new DirectionalLight(), { file, ...(statics && { statics }) });
  for (let frame = 0; frame < 2; frame += 1) drawWithWebGL(scene, webglRenderer());
  shadow.dispose();
}

async function draw({ scene }: World, file: BakedShadowFile, statics?: Group): Promise<void> {
  const { BakedShadowNode } = await import('../../src/webgpu/index.js');
  const node = new BakedShadowNode(new DirectionalLight(), { file, ...(statics && { statics }) });
  for (let frame = 0; frame < 2; frame += 1) node.updateBefore({ renderer: null, scene } as unknown as NodeFrame);
  node.dispose();
}

const EACH = [['WebGLRenderer', attach], ['WebGPURenderer', draw]] as const;

it('the files are what the tests need', () => {
  expect([ofStatics.settings.receivers, ofAll.settings.receivers]).toEqual(['static', 'all']);
});

it.each(EACH)('with %s, a receiver outside of the statics is named once', async (_, show) => {
  const w = world();
  await show(w, ofStatics, w.statics);
  await show(w, ofStatics, w.statics);
  expect(warn).toHaveBeenCalledTimes(1);
  expect(warn.mock.calls[0]![0]).toContain("'car' moves");
  expect(warn.mock.calls[0]![0]).toContain('--receivers static');
});

it.each(EACH)('with %s, no warning without moving receivers or for other files', async (_, show) => {
  const w = world();
  await show(w, ofAll, w.statics);
  // Without statics, nothing says which objects move.
  await show(w, ofStatics);
  w.car.receiveShadow = false;
  await show(w, ofStatics, w.statics);
  expect(warn).not.toHaveBeenCalled();
});

it.each(EACH)('with %s, skinned meshes and marked casters count as movers', async (_, show) => {
  const w = world();
  const skinned = Object.assign(new SkinnedMesh(), { receiveShadow: true, name: 'walker' });
  w.scene.add(skinned);
  await show(w, ofStatics);
  expect(warn.mock.calls[0]![0]).toContain("'walker' moves");
  vi.resetModules();
  warn.mockClear();
  w.scene.remove(skinned, w.car);
  w.house.userData['adumbra'] = { cast: true };
  await show(w, ofStatics, w.statics);
  expect(warn).toHaveBeenCalledTimes(1);
});
