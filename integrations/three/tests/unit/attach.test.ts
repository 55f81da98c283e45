// Effects of attaching a file on lights, materials and scenes of WebGLRenderer, without a GPU.

import { DirectionalLight, Group, Material, MeshLambertMaterial, Object3D, Scene, Vector3 } from 'three';
import type { WebGLProgramParametersWithUniforms, WebGLRenderer } from 'three';
import type { NodeFrame } from 'three/webgpu';
import { afterEach, expect, test, vi } from 'vitest';

import { attachBakedShadow } from '../../src/webgl/index.js';
import { BakedShadowNode } from '../../src/webgpu/index.js';
import { LAMBERT, attach, attached, compiled, disposeAttached, file, frame, lookUps, world } from './attaching.js';
import { drawWithWebGL, webglRenderer } from './shown.js';

afterEach(disposeAttached);

test('isActive does not change the direction that is drawn', () => {
  const { scene, material } = world();
  const light = new DirectionalLight();
  const shadow = attachBakedShadow(scene, light, { file });
  attached.push(shadow);
  const { value } = compiled(material).uniforms['adumbra1_towards_light'] as { value: Vector3 };
  const drawn = value.clone();
  light.position.negate();
  light.updateMatrixWorld();
  expect(shadow.isActive).toBe(false);
  expect(value).toEqual(drawn);
});

test.each([
  ['moves around its target', (light: DirectionalLight) => new Scene().add(light.target)],
  ['turns with the target that it carries', (light: DirectionalLight) => light.add(light.target)],
])('a light below a turned parent %s', (_, place) => {
  const light = new DirectionalLight();
  light.target.position.set(1, -3, 2);
  place(light);
  const parent = new Group().add(light);
  parent.position.set(30, 0, -5);
  parent.rotation.set(0.4, 1.1, -0.3);
  attached.push(attachBakedShadow(new Scene(), light, { file }));
  const towards = light.getWorldPosition(new Vector3()).sub(light.target.getWorldPosition(new Vector3())).normalize();
  expect(towards.distanceTo(new Vector3(...file.grid.sun))).toBeLessThan(1e-6);
});

test('nothing is hooked again after dispose', () => {
  const { scene, material } = world();
  const shadow = attach(scene);
  expect(lookUps(compiled(material).fragmentShader)).toBeGreaterThan(0);
  shadow.dispose();
  expect(shadow.isActive).toBe(false);
  (scene.onBeforeRender as () => void)();
  expect(compiled(material).fragmentShader).toBe(LAMBERT);
  expect(material.onBeforeCompile).toBe(Material.prototype.onBeforeCompile);
});

test('the scene is restored after shadows that overlap have ended', () => {
  const { scene } = world();
  const { onBeforeRender, onAfterRender } = scene;
  let last = attach(scene);
  for (let swap = 0; swap < 3; swap += 1) {
    const next = attach(scene);
    last.dispose();
    last = next;
  }
  last.dispose();
  expect(scene).toMatchObject({ onBeforeRender, onAfterRender });
  for (const name of ['onBeforeRender', 'onAfterRender']) expect(Object.hasOwn(scene, name)).toBe(false);
});

test.each([
  ['that comes later', (_: Material, later: Material) => later],
  ['that is a clone', (material: Material) => material.clone()],
])('a material %s has the shadows from the next frame on', (_, make) => {
  const { scene, mesh, material } = world();
  attach(scene);
  frame(scene);
  mesh.material = make(material, new MeshLambertMaterial());
  frame(scene);
  expect(lookUps(compiled(mesh.material).fragmentShader)).toBe(2);
  // A page may copy the hook too.
  const copied = Object.assign(material.clone(), { onBeforeCompile: material.onBeforeCompile });
  mesh.material = copied;
  frame(scene);
  expect(lookUps(compiled(copied).fragmentShader)).toBe(2);
});

test('copied hooks keep the programs of their materials apart', () => {
  const { scene, mesh, material } = world();
  const { mesh: other, material: second } = world();
  scene.add(other);
  material.onBeforeCompile = (shader) => void (shader.fragmentShader += '// red');
  second.onBeforeCompile = (shader) => void (shader.fragmentShader += '// green');
  attach(scene);
  const [red, green] = [material, second].map((each) => Object.assign(each.clone(), { onBeforeCompile: each.onBeforeCompile }));
  expect(red!.customProgramCacheKey()).not.toBe(green!.customProgramCacheKey());
  mesh.material = red!;
  other.material = green!;
  frame(scene);
  expect(red!.customProgramCacheKey()).not.toBe(green!.customProgramCacheKey());
  expect(compiled(green!).fragmentShader).toContain('// green');
});

test('a deleted hook is restored in the next frame', () => {
  const { scene, material } = world();
  attach(scene);
  // Three's addon CSM does the same on dispose.
  delete (material as Partial<Material>).onBeforeCompile;
  expect(lookUps(compiled(material).fragmentShader)).toBe(0);
  frame(scene);
  expect(lookUps(compiled(material).fragmentShader)).toBe(2);
});

test('a later hook may replace the uniforms by a copy', () => {
  const { scene, material } = world();
  attach(scene);
  const ours = material.onBeforeCompile;
  const shader = { fragmentShader: LAMBERT, vertexShader: '', uniforms: { diffuse: { value: 1 } } as Record<string, { value: unknown }> };
  material.onBeforeCompile = (each, renderer) => {
    ours(each, renderer);
    each.uniforms = { ...each.uniforms, time: { value: 0 } };
  };
  material.onBeforeCompile(shader as unknown as WebGLProgramParametersWithUniforms, {} as WebGLRenderer);
  expect(Object.keys(shader.uniforms)).toEqual(expect.arrayContaining(['diffuse', 'adumbra1_words', 'time']));
});

test('missing materials are skipped, and overrideMaterial has the shadows', () => {
  const { scene, mesh } = world();
  attach(scene);
  Object.assign(mesh, { material: [undefined, new MeshLambertMaterial()] });
  scene.add(Object.assign(new Object3D(), { material: null, visible: false }));
  scene.overrideMaterial = new MeshLambertMaterial();
  frame(scene);
  expect(lookUps(compiled(scene.overrideMaterial).fragmentShader)).toBe(2);
});

test('a material that is no longer drawn is released', () => {
  const { scene, mesh, material } = world();
  attach(scene);
  scene.remove(mesh);
  for (let i = 0; i < 250; i += 1) frame(scene);
  expect(Object.hasOwn(material, 'onBeforeCompile')).toBe(false);
  scene.add(mesh);
  frame(scene);
  expect(lookUps(compiled(material).fragmentShader)).toBe(2);
});

test('another renderer or kind of shadow on the light does no harm', () => {
  const warn = vi.spyOn(console, 'warn').mockImplementation(() => undefined);
  const { scene } = world();
  const light = new DirectionalLight();
  scene.add(light);
  const node = new BakedShadowNode(light, { file });
  node.updateBefore({ renderer: null, scene } as unknown as NodeFrame);
  attached.push(attachBakedShadow(scene, light, { file }));
  drawWithWebGL(scene, {});
  expect(warn.mock.calls.filter(([text]) => String(text).includes('is for WebGLRenderer'))).toHaveLength(1);
  node.dispose();
  // A late call from three does not hook the scene again.
  node.updateBefore({ renderer: null, scene } as unknown as NodeFrame);
  attached.pop()!.dispose();
  expect(Object.hasOwn(scene, 'onBeforeRender')).toBe(false);
  warn.mockRestore();
});

test('a disposed material is released, and hooked again when drawn', () => {
  const { scene, mesh, material } = world();
  attach(scene);
  const { length } = listenersOf(material);
  expect(length).toBe(1);
  material.dispose();
  expect([Object.hasOwn(material, 'onBeforeCompile'), listenersOf(material).length]).toEqual([false, 0]);
  scene.remove(mesh);
  frame(scene);
  expect(Object.hasOwn(material, 'onBeforeCompile')).toBe(false);
  scene.add(mesh);
  frame(scene);
  expect(lookUps(compiled(material).fragmentShader)).toBe(2);
});

/** The listeners to a material's `dispose` event. */
function listenersOf(material: Material): unknown[] {
  return (material as unknown as { _listeners?: Record<string, unknown[]> })._listeners?.['dispose'] ?? [];
}

test('materials are not disposed, and are as they were after dispose', () => {
  const { scene, material } = world();
  let isDisposed = false;
  material.addEventListener('dispose', () => (isDisposed = true));
  const shadow = attach(scene);
  shadow.dispose();
  expect(isDisposed).toBe(false);
  for (const name of ['onBeforeCompile', 'customProgramCacheKey']) expect(Object.hasOwn(material, name)).toBe(false);
  expect(listenersOf(material)).toHaveLength(1);
});

test('a kept program gets the uniforms of a shadow attached again', () => {
  const { scene, material } = world();
  const renderer = webglRenderer();
  const first = attach(scene);
  const [{ uniforms }, key] = [compiled(material), material.customProgramCacheKey()];
  const kept = renderer.properties.get(material);
  kept['uniforms'] = uniforms;
  first.dispose();
  expect(uniforms['adumbra1_words']!.value).toBeNull();
  // Three may or may not compile the material without the shadow in between.
  for (const between of [{ diffuse: { value: 1 } }, uniforms]) {
    kept['uniforms'] = between;
    kept['uniformsList'] = [];
    const again = attach(scene);
    expect(material.customProgramCacheKey()).toBe(key);
    drawWithWebGL(scene, renderer);
    const now = kept['uniforms'] as typeof uniforms;
    expect(now['adumbra1_words']!.value).not.toBeNull();
    expect([kept['uniformsList'], now['diffuse']]).toEqual([null, between['diffuse']]);
    again.dispose();
  }
});

test('a light that is attached again has its shadow once', () => {
  const { scene, material } = world();
  const light = new DirectionalLight();
  scene.add(light);
  const [first, second] = [0, 1].map(() => attachBakedShadow(scene, light, { file }));
  attached.push(second!);
  const { fragmentShader, uniforms } = compiled(material);
  expect(fragmentShader.match(/adumbra\d+_visibility\( adumbra\d+_p/g)).toHaveLength(2);
  expect(Object.keys(uniforms)).toHaveLength(4);
  expect([first!.isActive, second!.isActive]).toEqual([false, true]);
  first!.dispose();
  expect(second!.isActive).toBe(true);
});

test('refuses a part of a scene, and a scene of another three', () => {
  const light = new DirectionalLight();
  expect(() => attachBakedShadow(new Group() as unknown as Scene, light, { file })).toThrow(/to the Scene that is drawn/);
  const { scene } = world();
  const foreign = Object.setPrototypeOf(Object.assign({}, scene), {}) as Scene;
  expect(() => attachBakedShadow(foreign, light, { file })).toThrow(/another copy of three/);
});

test('refuses a call without { file }, and a root that is not with its file', () => {
  const light = new DirectionalLight();
  const attach = attachBakedShadow as (...theirs: unknown[]) => void;
  for (const options of [{}, file, [file], { filter: 5 }]) {
    expect(() => attach(new Scene(), light, options)).toThrow(/give file/);
  }
  expect(() => attach(new Scene(), light, { file, root: new Group() })).toThrow(/file: \{ file, root \}/);
});

test('hooks that a page gives a material later are called, and stay after dispose', () => {
  const { scene, material } = world();
  const shadow = attach(scene);
  const once = lookUps(compiled(material).fragmentShader);
  const theirs: Material['onBeforeCompile'] = (shader) => void (shader.fragmentShader = `// theirs\n${shader.fragmentShader}`);
  const before = material.customProgramCacheKey();
  material.onBeforeCompile = theirs;
  expect(material.customProgramCacheKey()).not.toBe(before);
  const { fragmentShader } = compiled(material);
  expect(fragmentShader).toContain('// theirs');
  expect(lookUps(fragmentShader)).toBe(once);
  shadow.dispose();
  expect(material.onBeforeCompile).toBe(theirs);
});

test('a later hook that calls the earlier one adds no second look-up', () => {
  const { scene, material } = world();
  attach(scene);
  const once = lookUps(compiled(material).fragmentShader);
  const ours = material.onBeforeCompile;
  material.onBeforeCompile = (shader, renderer) => ours.call(material, shader, renderer);
  expect(lookUps(compiled(material).fragmentShader)).toBe(once);
});

test('foreign hooks between those of two lights keep programs apart', () => {
  const scene = new Scene();
  const materials = ['red', 'green'].map((name) => {
    const { mesh, material } = world();
    scene.add(mesh);
    return { name, material };
  });
  attach(scene);
  for (const { name, material } of materials) {
    const ours = material.onBeforeCompile;
    const theirs = { red: 'rgb.gb *= 0.0', green: 'rgb.rb *= 0.0' }[name]!;
    material.onBeforeCompile = new Function('ours', `return (...all) => { ours(...all); '${theirs}'; }`)(ours) as typeof ours;
  }
  attach(scene);
  const keys = materials.map(({ material }) => material.customProgramCacheKey());
  expect(keys[0]).not.toBe(keys[1]);
  expect(lookUps(compiled(materials[0]!.material).fragmentShader, 'adumbra2')).toBeGreaterThan(0);
});
