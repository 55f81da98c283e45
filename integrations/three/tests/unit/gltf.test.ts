// Lights of glTF files whose shadow file is missing.

import { DirectionalLight, Group, LoadingManager, Object3D } from 'three';
import type { GLTF, GLTFParser } from 'three/addons/loaders/GLTFLoader.js';
import { expect, test, vi } from 'vitest';

import { GLTFBakedShadow } from '../../src/gltf/index.js';
import type { NamedShadow } from '../../src/gltf/index.js';

const parser = { options: { manager: new LoadingManager(), path: 'http://127.0.0.1:1/', requestHeader: {} } } as unknown as GLTFParser;

/** A glTF file with a light that names a file, and one that does not. */
function city() {
  const [sun, lamp] = [new DirectionalLight(), new DirectionalLight()];
  sun.userData['adumbra'] = { shadow: 'gone.adumbra' };
  const scene: Object3D = new Group().add(sun, lamp);
  return { sun, gltf: { animations: [], scenes: [scene] } as unknown as GLTF };
}

test('a missing shadow file is reported, and its light loads without', async () => {
  const { sun, gltf } = city();
  const [attach, onError] = [vi.fn<(shadow: NamedShadow) => void>(), vi.fn<(error: unknown, light: unknown) => void>()];
  await new GLTFBakedShadow(parser, attach, onError).afterRoot(gltf);
  expect(attach).not.toHaveBeenCalled();
  expect(onError.mock.calls).toEqual([[expect.objectContaining({ kind: 'Io', url: 'http://127.0.0.1:1/gone.adumbra' }), sun]]);
  const printed = vi.spyOn(console, 'error').mockImplementation(() => undefined);
  await new GLTFBakedShadow(parser, attach).afterRoot(gltf);
  expect(printed).toHaveBeenCalledTimes(1);
  printed.mockRestore();
});

test('the load of the glTF file is rejected if onError throws', async () => {
  const { gltf } = city();
  const strict = new GLTFBakedShadow(parser, () => undefined, (error) => {
    throw error;
  });
  await expect(strict.afterRoot(gltf)).rejects.toMatchObject({ name: 'ShadowFileError', kind: 'Io' });
});
