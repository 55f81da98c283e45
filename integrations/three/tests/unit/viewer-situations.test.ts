// Situations of viewers, editors, map pages and menus.

import {
  BoxGeometry,
  Camera,
  DirectionalLight,
  Group,
  LoaderUtils,
  LoadingManager,
  Material,
  Matrix4,
  Mesh,
  MeshLambertMaterial,
  Object3D,
  ObjectLoader,
  PerspectiveCamera,
  Scene,
  ShaderChunk,
  Vector3,
} from 'three';
import * as TSL from 'three/tsl';
import { AnalyticLightNode } from 'three/webgpu';
import type { NodeFrame } from 'three/webgpu';
import { afterEach, describe, expect, test, vi } from 'vitest';

import { GLTFBakedShadow } from '../../src/gltf/index.js';
import type { NamedShadow } from '../../src/gltf/index.js';
import { toWorld } from '../../src/grid/light-grid.js';
import { BakedShadowFile } from '../../src/index.js';
import type { FileChoice, LightSettings } from '../../src/light/options.js';
import { StreamedShadowFile } from '../../src/stream/index.js';
import { attachBakedShadow } from '../../src/webgl/index.js';
import type { BakedShadow } from '../../src/webgl/index.js';
import { BakedShadowNode } from '../../src/webgpu/index.js';
import { RENDERERS, drawWithWebGL, drawWithWebGPU, webglRenderer } from './shown.js';
import { SUN, caster, castIn, compiled, drawFrom, file, keepWarnings, lookUps, offSun } from './situations.js';
import { serve } from './stream-server.js';
import { validBytes } from './vectors.js';

const warnings = keepWarnings();
afterEach(() => vi.unstubAllGlobals());

type LightNode = AnalyticLightNode<DirectionalLight> & { shadowNode: unknown; colorNode: unknown; setupShadow(builder: object): void; disposeShadow(): void };
const BUILDER = { renderer: { shadowMap: { enabled: true } }, context: {} };

describe('WebGPURenderer alone', () => {
  test('a menu may switch to three’s own shadow without dispose', () => {
    const [scene, sun, city, house] = [new Scene(), new DirectionalLight(), new Group(), caster()];
    sun.castShadow = true;
    scene.add(sun, sun.target, city.add(house));
    const node = new BakedShadowNode(sun, { file, statics: city });
    sun.shadow.shadowNode = node;
    const lightNode = new AnalyticLightNode(sun) as LightNode;
    lightNode.setupShadow(BUILDER);
    const frame = (): boolean => {
      scene.updateMatrixWorld();
      let casts = true;
      drawFrom(scene, {}, new PerspectiveCamera(), () => {
        if (lightNode.shadowNode === node) node.updateBefore({ renderer: {}, scene } as unknown as NodeFrame);
        sun.shadow.updateMatrices(sun);
        drawFrom(scene, {}, sun.shadow.camera, () => (casts = house.castShadow));
      });
      return casts;
    };
    expect(frame()).toBe(false);
    // Off: three drops the node while it builds a material.
    sun.castShadow = false;
    const { setCurrentStack } = TSL as unknown as { setCurrentStack?(stack: object | null): void };
    if (setCurrentStack) {
      setCurrentStack({});
      lightNode.disposeShadow();
      setCurrentStack(null);
    } else TSL.Fn(() => (lightNode.disposeShadow(), TSL.float(1)))();
    expect([lightNode.shadowNode, node.isActive, node.status.filesInUse]).toEqual([null, false, 0]);
    frame();
    // Three's own.
    delete (sun.shadow as { shadowNode?: unknown }).shadowNode;
    sun.castShadow = true;
    lightNode.setupShadow(BUILDER);
    expect(lightNode.shadowNode).not.toBe(node);
    expect(frame()).toBe(true);
  });

  test('selective lights: both of a sun’s nodes have the shadow', () => {
    const [scene, sun, city, house] = [new Scene(), new DirectionalLight(), new Group(), caster()];
    sun.castShadow = true;
    scene.add(sun, sun.target, city.add(house));
    const node = new BakedShadowNode(sun, { file, statics: city });
    sun.shadow.shadowNode = node;
    const nodes = [0, 1].map(() => new AnalyticLightNode(sun) as LightNode);
    const lit = nodes.map(({ colorNode }) => colorNode);
    const build = (): void => nodes.forEach((each) => each.setupShadow(BUILDER));
    build();
    expect(nodes.map(({ shadowNode }) => shadowNode)).toEqual([node, node]);
    const renderer = { shadowMap: {}, initTexture: () => undefined };
    let casts = true;
    drawWithWebGPU(scene, renderer, node, sun, () => (casts = house.castShadow));
    expect(casts).toBe(false);
    node.setFiles([file, new BakedShadowFile(validBytes('levels_coded_depths')), file]);
    expect(nodes.map(({ shadowNode }) => shadowNode)).toEqual([null, null]);
    expect(nodes.map(({ colorNode }) => colorNode)).toEqual(lit);
    build();
    expect(nodes.map(({ shadowNode }) => shadowNode)).toEqual([node, node]);
    drawWithWebGPU(scene, renderer, node, sun, () => (casts = house.castShadow));
    expect([casts, node.isActive, node.status.filesInUse]).toEqual([false, true, 3]);
    const ends = vi.fn();
    sun.addEventListener('dispose', ends);
    node.dispose();
    expect(ends).toHaveBeenCalledTimes(1);
    expect(nodes.map(({ shadowNode }) => shadowNode)).toEqual([null, null]);
    expect(nodes.map(({ colorNode }) => colorNode)).toEqual(lit);
    build();
    expect(nodes.every(({ shadowNode }) => shadowNode !== null && shadowNode !== node)).toBe(true);
    drawFrom(scene, renderer, sun.shadow.camera, () => (casts = house.castShadow));
    expect([casts, sun.position.toArray()]).toEqual([true, [0, 1, 0]]);
    expect(Object.hasOwn(sun, 'dispatchEvent')).toBe(false);
  });

  test('StrictMode: a node made twice keeps the app’s movers', () => {
    const [scene, sun] = [new Scene(), new DirectionalLight()];
    sun.castShadow = true;
    sun.position.set(5, 5, 0);
    scene.add(sun, sun.target);
    const movers = Object.assign(TSL.float(1), { dispose: vi.fn() });
    const make = () => new BakedShadowNode(sun, { file, movers: movers as never });
    make();
    const node = make();
    // Both have the app's movers.
    expect(movers.dispose).not.toHaveBeenCalled();
    sun.shadow.shadowNode = node;
    drawWithWebGPU(scene, { shadowMap: {}, initTexture: () => undefined }, node, sun);
    expect(node.isActive).toBe(true);
    node.dispose();
    expect(movers.dispose).toHaveBeenCalledTimes(1);
    expect(sun.position.toArray()).toEqual([5, 5, 0]);
    expect(Object.hasOwn(sun, 'dispatchEvent')).toBe(false);
  });
});

describe('WebGLRenderer alone', () => {
  test('a later onBeforeCompile that replaces three’s lights is kept', () => {
    const toon = ShaderChunk.lights_fragment_begin.replaceAll('RE_Direct( directLight', '/* toon */ directLight.color = floor( directLight.color ); RE_Direct( directLight');
    const patch = (material: Material): void => {
      const before = material.onBeforeCompile;
      material.onBeforeCompile = function (shader, renderer) {
        before.call(this, shader, renderer);
        shader.fragmentShader = shader.fragmentShader.replace('#include <lights_fragment_begin>', toon);
      };
    };
    // One material without the package, one patched before attaching, one after.
    const [plain, early, late] = [new MeshLambertMaterial(), new MeshLambertMaterial(), new MeshLambertMaterial()];
    patch(plain);
    patch(early);
    expect(compiled(plain).fragmentShader).toContain('/* toon */');
    const [scene, sun] = [new Scene(), new DirectionalLight()];
    scene.add(sun, sun.target, new Mesh(undefined, early), new Mesh(undefined, late));
    const shadow = attachBakedShadow(scene, sun, { file });
    patch(late);
    drawWithWebGL(scene, webglRenderer());
    const texts = [early, late].map((each) => compiled(each).fragmentShader);
    shadow.dispose();
    expect(texts.map(lookUps)).toEqual([2, 2]);
    expect(texts.map((text) => text.includes('/* toon */'))).toEqual([true, true]);
  });
});

describe.each(RENDERERS)('%s', (name, show) => {
  const isWebGL = name === 'WebGLRenderer';
  const attach = (scene: Scene, light: DirectionalLight, files: FileChoice, options: LightSettings = {}): BakedShadow =>
    isWebGL ? attachBakedShadow(scene, light, { file: files, ...options }) : new BakedShadowNode(light, { file: files, ...options });
  const renderer = isWebGL ? webglRenderer() : { shadowMap: {}, initTexture: () => undefined };
  const drawOf = (scene: Scene, light: DirectionalLight, shadow: BakedShadow, map?: () => void): void =>
    isWebGL ? drawWithWebGL(scene, renderer, map) : drawWithWebGPU(scene, renderer, shadow as BakedShadowNode, light, map);

  test('a sun is aligned in a world whose matrices are frozen', () => {
    const [city, house, sun] = [new Group(), caster(), new DirectionalLight()];
    sun.position.set(30, 40, 0);
    const was = new Matrix4();
    for (const each of [city.add(house), house, sun, sun.target]) {
      each.updateMatrixWorld();
      each.matrixAutoUpdate = each.matrixWorldAutoUpdate = false;
    }
    was.copy(sun.matrixWorld);
    const shown = show({ statics: city }, file, sun);
    shown.frame();
    // The direction that three draws with.
    const drawn = new Vector3().setFromMatrixPosition(sun.matrixWorld).sub(new Vector3().setFromMatrixPosition(sun.target.matrixWorld)).normalize();
    expect(drawn.distanceTo(SUN)).toBeLessThan(1e-5);
    expect([shown.shadow.isActive, castIn(shown, house)]).toEqual([true, [false]]);
    shown.shadow.dispose();
    expect(sun.position.toArray()).toEqual([30, 40, 0]);
    expect(sun.matrixWorld.elements).toEqual(was.elements);
  });

  test.each(['statics', 'root'] as const)('a glTF file in place of its scene, as %s, is refused', (option) => {
    const [scene, sun, city] = [new Scene(), new DirectionalLight(), new Group()];
    scene.add(sun, sun.target, city);
    const gltf = { scene: city, scenes: [city], animations: [], cameras: [], asset: {}, userData: {} } as unknown as Group;
    const make = (): BakedShadow => (option === 'statics' ? attach(scene, sun, file, { statics: gltf }) : attach(scene, sun, { file, root: gltf }));
    expect(make).toThrow(new RegExp(`${option} is .*gltf.scene`));
    expect([Object.hasOwn(scene, 'onBeforeRender'), Object.hasOwn(sun, 'dispatchEvent'), sun.position.toArray()]).toEqual([false, false, [0, 1, 0]]);
  });

  test('a sun is aligned in a frozen rig that carries its target', () => {
    const [sun, arm] = [new DirectionalLight(), new Group()];
    arm.position.set(0, -1, -1);
    sun.add(arm.add(sun.target));
    sun.updateMatrixWorld(true);
    for (const each of [sun, arm, sun.target]) each.matrixAutoUpdate = each.matrixWorldAutoUpdate = false;
    const shown = show({}, file, sun);
    shown.frame();
    const [from, to] = [sun, sun.target].map((each) => new Vector3().setFromMatrixPosition(each.matrixWorld)) as [Vector3, Vector3];
    expect(from.sub(to).normalize().distanceTo(SUN)).toBeLessThan(1e-5);
    expect([sun, arm, sun.target].map((each) => each.matrixWorldAutoUpdate)).toEqual([false, false, false]);
  });

  test('a scene that an editor saves has no trace of the package', () => {
    const [scene, sun, city] = [new Scene(), new DirectionalLight(), new Group()];
    const house = new Mesh(new BoxGeometry(), new MeshLambertMaterial());
    const list: [Object3D, string][] = [[sun, 'sun'], [city, 'city'], [house, 'house']];
    for (const [object, label] of list) object.name = label;
    house.castShadow = sun.castShadow = true;
    scene.add(sun, sun.target, city.add(house));
    const shadow = attach(scene, sun, file, { statics: city });
    if (!isWebGL) sun.shadow.shadowNode = shadow as BakedShadowNode;
    drawOf(scene, sun, shadow);
    const text = JSON.stringify(scene.toJSON());
    expect(text).not.toMatch(/adumbra/i);
    const opened = new ObjectLoader().parse(JSON.parse(text)) as Scene;
    const [sun2, city2, house2] = ['sun', 'city', 'house'].map((label) => opened.getObjectByName(label)) as [DirectionalLight, Group, Mesh];
    expect([house2.castShadow, sun2.castShadow]).toEqual([true, true]);
    const again = attach(opened, sun2, file, { statics: city2 });
    if (!isWebGL) sun2.shadow.shadowNode = again as BakedShadowNode;
    drawOf(opened, sun2, again);
    shadow.dispose();
    let casts = true;
    drawOf(opened, sun2, again, () => (casts = house2.castShadow));
    expect([casts, again.isActive, shadow.isActive]).toEqual([false, true, false]);
    if (isWebGL) expect(lookUps(compiled(house2.material as Material).fragmentShader)).toBe(2);
    again.dispose();
    expect(house2.castShadow).toBe(true);
  });

  test('a panel reads the right isActive right after it set the light', () => {
    const shown = show({ align: false });
    shown.frame();
    const { light, shadow } = shown;
    const seen: boolean[] = [];
    for (const sign of [1, -1, 1]) {
      light.position.set(SUN.x, SUN.y, SUN.z).multiplyScalar(sign * 100);
      const now = shadow.isActive;
      shown.frame();
      seen.push(now, shadow.isActive);
    }
    expect(seen).toEqual([true, true, false, false, true, true]);
  });

  test('menus of hours and of detail move the light to each sun', () => {
    const [evening, large] = ['upright_turned_low_depths', 'levels_coded_depths'].map((each) => new BakedShadowFile(validBytes(each))) as [BakedShadowFile, BakedShadowFile];
    expect(large.levelCount).toBe(3);
    const [a, b] = [file.grid.sun, evening.grid.sun];
    expect(Math.hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2])).toBeGreaterThan(0.01);
    const [city, house, sun] = [new Group(), caster(), new DirectionalLight()];
    sun.position.set(5, 5, 0);
    const shown = show({ statics: city.add(house) }, file, sun);
    shown.frame();
    for (const next of [evening, file, large.level(2)!, large.level(1)!, large, evening, large.level(1)!, file]) {
      shown.shadow.setFiles(next);
      expect(castIn(shown, house)).toEqual([false]);
      const [x, y, z] = next.grid.sun;
      const drawn = new Vector3().setFromMatrixPosition(sun.matrixWorld).normalize();
      expect(drawn.distanceTo({ x, y, z })).toBeLessThan(1e-5);
      expect(shown.shadow.status).toMatchObject({ filesInUse: 1, missing: 0 });
    }
    expect(offSun(sun)).toBeLessThan(1e-5);
    expect(warnings()).not.toMatch(/was turned/);
    shown.shadow.dispose();
    expect(sun.position.toArray()).toEqual([5, 5, 0]);
  });
});

describe('loading', () => {
  test('the camera of a map library chooses the same bundles', async () => {
    const bytes = validBytes('levels_coded_depths');
    const { grid } = new BakedShadowFile(bytes);
    const middle = new Vector3(...toWorld(grid, [grid.size[0] / 2, grid.size[1] / 2, grid.size[2] / 2]));
    serve(bytes);
    const chosen = async (away: number, detail: number, isMap: boolean): Promise<object> => {
      const usual = new PerspectiveCamera(50, 1.5, 0.1, 1e5);
      usual.position.set(0.3, 1, 0.2).multiplyScalar(away).add(middle);
      usual.lookAt(middle);
      usual.updateMatrixWorld();
      const camera = isMap ? new Camera() : usual;
      if (isMap) {
        camera.projectionMatrix.multiplyMatrices(usual.projectionMatrix, usual.matrixWorldInverse);
        camera.projectionMatrixInverse.copy(camera.projectionMatrix).invert();
      }
      const stream = await StreamedShadowFile.open('file', { budgetBytes: 1024 * 1024, worker: false, detailPixels: detail });
      for (let i = 0; i < 30; i += 1) {
        stream.update(camera, 1080);
        await new Promise((resolve) => setTimeout(resolve));
      }
      const { chosen: count, levels } = stream.stats;
      stream.dispose();
      return { away, count, resident: levels.map(({ resident }) => resident) };
    };
    for (const [away, detail] of [[20, 8], [5000, 1]] as const) {
      expect(await chosen(away, detail, true)).toEqual(await chosen(away, detail, false));
    }
  });

  test('dropped files are found through the URLs of a manager', async () => {
    vi.stubGlobal('ProgressEvent', class extends Event {});
    const dropped = new Map([['city/city.adumbra', new Blob([validBytes('upright_depths')])]]);
    const url = 'blob:http://viewer/1234';
    const base = LoaderUtils.extractUrlBase(url);
    const manager = new LoadingManager();
    const blobs: string[] = [];
    manager.setURLModifier((each) => {
      const found = dropped.get('city/' + decodeURI(each).replace(base, '').replace(/^(\.?\/)/, ''));
      if (!found) return each;
      const blob = URL.createObjectURL(found);
      blobs.push(blob);
      return blob;
    });
    const order: string[] = [];
    manager.onLoad = () => order.push('manager');
    const sun = new DirectionalLight();
    sun.userData['adumbra'] = { shadow: 'city.adumbra' };
    const scene = new Group().add(sun);
    const parser = { options: { manager, path: base, requestHeader: {} } };
    const onError = vi.fn();
    let named: NamedShadow | undefined;
    await new GLTFBakedShadow(parser as never, (each) => {
      order.push('attach');
      named = each;
    }, onError).afterRoot({ scenes: [scene], scene, animations: [] } as never);
    await vi.waitFor(() => expect(order).toContain('manager'));
    expect(onError).not.toHaveBeenCalled();
    expect(named?.light).toBe(sun);
    expect(named?.file).toBeInstanceOf(BakedShadowFile);
    expect([order, blobs.length]).toEqual([['attach', 'manager'], 1]);
  });
});
