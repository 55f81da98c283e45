// Situations of ordinary apps over several frames, drawn by three's own renderers.

import {
  Bone,
  BoxGeometry,
  DataTexture,
  DirectionalLight,
  EquirectangularReflectionMapping,
  Float32BufferAttribute,
  Fog,
  Group,
  Matrix4,
  Mesh,
  MeshLambertMaterial,
  MeshNormalMaterial,
  MeshStandardMaterial,
  OrthographicCamera,
  PerspectiveCamera,
  Scene,
  Skeleton,
  SkinnedMesh,
  Uint16BufferAttribute,
  Vector3,
  WebGLRenderTarget,
  WebGLRenderer,
} from 'three';
import type { Camera, Material, Object3D } from 'three';
import { clone as cloneSkinned } from 'three/addons/utils/SkeletonUtils.js';
import { RenderTarget, WebGPURenderer } from 'three/webgpu';
import { afterEach, beforeEach, describe, expect, test, vi } from 'vitest';

import { placedGrid } from '../../src/index.js';
import type { FileChoice, LightSettings } from '../../src/light/options.js';
import { attachBakedShadow } from '../../src/webgl/index.js';
import type { BakedShadow } from '../../src/webgl/index.js';
import { BakedShadowNode } from '../../src/webgpu/index.js';
import { recordingCanvas } from './recording-gl.js';
import type { Draw, Program } from './recording-gl.js';
import { file, keepWarnings } from './situations.js';

/** The members that both renderers have. */
interface Renderer {
  readonly shadowMap: { enabled: boolean };
  init(): Promise<unknown>;
  setAnimationLoop(loop: () => void): void;
  render(scene: Scene, camera: Camera): void;
  compile(scene: Scene, camera: Camera): unknown;
  compileAsync(scene: Scene, camera: Camera): Promise<unknown>;
  setRenderTarget(target: RenderTarget | WebGLRenderTarget | null): void;
  dispose(): void;
}

type Box = Mesh<BoxGeometry, Material>;

const warnings = keepWarnings();
/** The callbacks that three has requested for the next frame. */
let asked: (() => void)[] = [];
beforeEach(() => {
  asked = [];
  vi.stubGlobal('self', globalThis);
  vi.stubGlobal('requestAnimationFrame', (callback: () => void) => asked.push(callback));
  vi.stubGlobal('cancelAnimationFrame', () => undefined);
  vi.stubGlobal('ImageBitmap', class {});
});
afterEach(() => vi.unstubAllGlobals());

/** A renderer, and a function that draws a frame with it and returns the draws. */
async function rendererOf(isWebGL: boolean) {
  const { canvas, context, programs, draws } = recordingCanvas();
  const parameters = { canvas, context } as object;
  const renderer = (isWebGL ? new WebGLRenderer(parameters) : new WebGPURenderer({ ...parameters, forceWebGL: true })) as unknown as Renderer;
  renderer.shadowMap.enabled = true;
  let job: (() => void) | null = null;
  if (!isWebGL) {
    await renderer.init();
    // Three tells frames apart by its own loop.
    renderer.setAnimationLoop(() => {
      job?.();
      job = null;
    });
  }
  const inFrame = (draw: () => void): Draw[] => {
    draws.length = 0;
    if (isWebGL) draw();
    else {
      job = draw;
      for (const callback of asked.splice(0)) callback();
      expect(job).toBe(null);
    }
    return [...draws];
  };
  return { renderer, programs, draws, inFrame };
}

let boxes = 0;
/** A box with a unique number of indices, which identifies its draws. */
const box = () => new BoxGeometry(1, 1, 1, (boxes += 1), 1, 1);

/** Makes an object cast, receive, and be drawn wherever it is. */
const shown = <T extends Mesh>(object: T): T => Object.assign(object, { castShadow: true, receiveShadow: true, frustumCulled: false });
const meshOf = (): Box => shown(new Mesh(box(), new MeshLambertMaterial()));
const meshesBelow = (root: Object3D): Box[] => {
  const meshes: Box[] = [];
  root.traverse((each) => {
    if (each instanceof Mesh) meshes.push(each as Box);
  });
  return meshes;
};

/** Disposes everything below an object, as apps do. */
function disposeBelow(root: Object3D): void {
  for (const { geometry, material } of meshesBelow(root)) {
    geometry.dispose();
    material.dispose();
  }
}

const looksUp = ({ fragment }: Program): boolean => /adumbra\d+_visibility/.test(fragment);
/**
 * Whether a program draws shadow maps: WebGLRenderer names the material, and WebGPURenderer's program does
 * not use light or the screen.
 */
const isOfMaps = ({ fragment }: Program): boolean => /MeshDepthMaterial/.test(fragment) || !/directDiffuse|gl_FragCoord/.test(fragment);
const ofMesh = (draws: Draw[], { geometry }: Mesh): Draw[] => draws.filter(({ count }) => count === geometry.index!.count);

/** How often an object was drawn: into shadow maps, with the look-up and its uploaded words, without the look-up, and in all but maps. */
function drawn(draws: Draw[], mesh: Mesh) {
  const all = ofMesh(draws, mesh);
  const lit = all.filter(({ program }) => !isOfMaps(program));
  const isWhole = ({ uploads }: Draw): boolean => {
    const words = Object.values(uploads) as (Uint32Array | undefined)[];
    return words.length === 2 && words.every((each) => each !== undefined && each.length > 0);
  };
  return {
    maps: all.length - lit.length,
    withFile: lit.filter((each) => looksUp(each.program) && isWhole(each)).length,
    without: lit.filter(({ program }) => !looksUp(program)).length,
    total: lit.length,
  };
}
const RESTS = { maps: 0, withFile: 1, without: 0, total: 1 };
const CASTS = { maps: 1, withFile: 1, without: 0, total: 1 };

/** Where the file is along x, as the GPU has it while it draws an object. */
function anchorX(draws: Draw[], mesh: Mesh): number {
  const { uploads } = ofMesh(draws, mesh).find(({ program }) => looksUp(program))!;
  const [, headers] = Object.entries(uploads).find(([name]) => name.endsWith('headers'))!;
  return new Float32Array((headers as Uint32Array).buffer)[4]!;
}

/** A house that rests, a car that moves, a sun and a camera. */
async function worldOf(isWebGL: boolean) {
  const rendering = await rendererOf(isWebGL);
  const [scene, sun, city, house, car, camera] = [new Scene(), new DirectionalLight(), new Group(), meshOf(), meshOf(), new PerspectiveCamera()];
  sun.castShadow = true;
  sun.position.set(5, 5, 0);
  camera.position.z = 5;
  scene.add(sun, sun.target, city.add(house), car, camera);
  const attach = (files: FileChoice = file, options: LightSettings = { statics: city }): BakedShadow => {
    if (isWebGL) return attachBakedShadow(scene, sun, { file: files, ...options });
    const node = new BakedShadowNode(sun, { file: files, movers: 'shadow', ...options });
    sun.shadow.shadowNode = node;
    return node;
  };
  const frame = (): Draw[] => rendering.inFrame(() => rendering.renderer.render(scene, camera));
  const houseAndCar = (draws: Draw[]) => [drawn(draws, house), drawn(draws, car)];
  return { ...rendering, scene, sun, city, house, car, camera, attach, frame, houseAndCar };
}

describe.each([
  ['WebGLRenderer', true],
  ['WebGPURenderer', false],
] as const)('%s', (_, isWebGL) => {
  test('a file that arrives after frames were drawn is used at once', async () => {
    const { programs, attach, frame, houseAndCar } = await worldOf(isWebGL);
    const before = { maps: 1, withFile: 0, without: 1, total: 1 };
    for (let i = 0; i < 3; i += 1) expect(houseAndCar(frame())).toEqual([before, before]);
    attach();
    expect(houseAndCar(frame())).toEqual([RESTS, CASTS]);
    const { length } = programs;
    expect(houseAndCar(frame())).toEqual([RESTS, CASTS]);
    expect(programs.length).toBe(length);
    expect(warnings()).toBe('');
  });

  const methods = ['compile', 'compileAsync'] as const;
  test.each(isWebGL ? methods : methods.slice(1))('a loading screen compiles beforehand, and only once (%s)', async (method) => {
    const { renderer, programs, scene, house, camera, attach, frame, houseAndCar } = await worldOf(isWebGL);
    attach();
    await renderer[method](scene, camera);
    const built = programs.filter(looksUp).length;
    expect(houseAndCar(frame())).toEqual([RESTS, CASTS]);
    expect(house.castShadow).toBe(true);
    expect(built).toBeGreaterThan(0);
    expect(programs.filter(looksUp).length).toBe(built);
    expect(warnings()).toBe('');
  });

  test('overrideMaterial has the shadows, and builds no program anew', async () => {
    const { programs, scene, house, attach, frame, houseAndCar } = await worldOf(isWebGL);
    attach();
    const [normals, clay] = [new MeshNormalMaterial(), new MeshLambertMaterial()];
    let length = 0;
    for (let i = 0; i < 4; i += 1) {
      scene.overrideMaterial = normals;
      const unlit = ofMesh(frame(), house);
      expect([unlit.length, unlit.some(({ program }) => looksUp(program))]).toEqual([1, false]);
      scene.overrideMaterial = clay;
      expect(houseAndCar(frame())).toEqual([RESTS, CASTS]);
      scene.overrideMaterial = null;
      expect(houseAndCar(frame())).toEqual([RESTS, CASTS]);
      if (i === 0) ({ length } = programs);
    }
    expect(programs.length).toBe(length);
    expect([house.castShadow, warnings()]).toEqual([true, '']);
  });

  test('shadows stay when textures, fog and environments arrive later', async () => {
    const { scene, house, attach, frame, houseAndCar } = await worldOf(isWebGL);
    const material = new MeshStandardMaterial();
    house.material = material;
    attach();
    expect(drawn(frame(), house)).toEqual(RESTS);
    const texture = new DataTexture(new Uint8Array(4), 1, 1);
    texture.needsUpdate = true;
    material.map = texture;
    material.needsUpdate = true;
    expect.soft(drawn(frame(), house)).toEqual(RESTS);
    scene.fog = new Fog(0xffffff, 1, 10);
    expect.soft(drawn(frame(), house)).toEqual(RESTS);
    const sky = new DataTexture(new Uint8Array(4 * 8 * 4), 8, 4);
    sky.mapping = EquirectangularReflectionMapping;
    sky.needsUpdate = true;
    scene.environment = sky;
    for (let i = 0; i < 2; i += 1) {
      expect.soft(houseAndCar(frame())).toMatchObject([
        { maps: 0, withFile: 1, without: 0 },
        { maps: 1, withFile: 1, without: 0 },
      ]);
    }
    scene.fog = null;
    expect(houseAndCar(frame())).toEqual([RESTS, CASTS]);
    expect(house.castShadow).toBe(true);
  });

  test('floors on layers rest and have the shadows', async () => {
    const { city, camera, attach, frame, houseAndCar } = await worldOf(isWebGL);
    const floor = meshOf();
    floor.layers.set(2);
    city.add(floor);
    attach();
    for (let i = 0; i < 3; i += 1) {
      camera.layers.disable(2);
      let draws = frame();
      expect(houseAndCar(draws)).toEqual([RESTS, CASTS]);
      expect(drawn(draws, floor)).toMatchObject({ maps: 0, total: 0 });
      camera.layers.enable(2);
      draws = frame();
      expect([...houseAndCar(draws), drawn(draws, floor)]).toEqual([RESTS, CASTS, RESTS]);
    }
    expect([floor.castShadow, warnings()]).toEqual([true, '']);
  });

  test('clones of movers cast and have the shadows', async () => {
    const { city, car, attach, frame, house } = await worldOf(isWebGL);
    car.userData['adumbra'] = { cast: true };
    const geometry = box();
    const { count } = geometry.attributes.position!;
    geometry.setAttribute('skinIndex', new Uint16BufferAttribute(new Array(4 * count).fill(0), 4));
    geometry.setAttribute('skinWeight', new Float32BufferAttribute(new Array(4 * count).fill(0.25), 4));
    const [walker, skin, bone] = [new Group(), shown(new SkinnedMesh(geometry, new MeshLambertMaterial())), new Bone()];
    skin.add(bone);
    skin.bind(new Skeleton([bone]));
    city.add(car, walker.add(skin));
    attach();
    frame();
    const clones = [car.clone(), cloneSkinned(walker)];
    for (const mesh of clones.flatMap(meshesBelow)) mesh.material = mesh.material.clone();
    city.add(...clones);
    const twice = { maps: 2, withFile: 2, without: 0, total: 2 };
    for (let i = 0; i < 2; i += 1) {
      const draws = frame();
      expect([house, car, skin].map((each) => drawn(draws, each))).toEqual([RESTS, twice, twice]);
    }
    city.remove(...clones);
    const draws = frame();
    expect([house, car, skin].map((each) => drawn(draws, each))).toEqual([RESTS, CASTS, CASTS]);
  });

  test('a reload with setFiles shows the new file in the next frame', async () => {
    const { scene, city, house, car, attach, frame, houseAndCar } = await worldOf(isWebGL);
    const shadow = attach({ file, root: city }, {});
    expect(houseAndCar(frame())).toEqual([RESTS, CASTS]);
    const anchors: number[] = [];
    let root = city;
    for (const x of [10, 20, 30]) {
      scene.remove(root);
      disposeBelow(root);
      const barn = meshOf();
      root = new Group().add(barn);
      root.position.x = x;
      scene.add(root);
      shadow.setFiles({ file, root });
      const draws = frame();
      anchors.push(anchorX(draws, barn));
      expect([drawn(draws, barn), drawn(draws, car)]).toEqual([RESTS, CASTS]);
      expect(shadow.status).toMatchObject({ filesInUse: 1, missing: 0 });
    }
    expect(anchors[1]! - anchors[0]!).toBeCloseTo(10, 3);
    expect(anchors[2]! - anchors[1]!).toBeCloseTo(10, 3);
    // The first root is used again, without a file.
    scene.add(city);
    expect(drawn(frame(), house)).toEqual(CASTS);
    expect([house.castShadow, warnings()]).toEqual([true, '']);
  });

  test('another renderer draws the same after the first is disposed', async () => {
    const { renderer, scene, house, camera, attach, frame, houseAndCar } = await worldOf(isWebGL);
    attach();
    // Three's own shadow node skips the map of a frame with the number of the last one, as after a single
    // frame.
    for (let i = 0; i < 3; i += 1) frame();
    renderer.dispose();
    const next = await rendererOf(isWebGL);
    for (let i = 0; i < 2; i += 1) {
      const draws = next.inFrame(() => next.renderer.render(scene, camera));
      expect(houseAndCar(draws)).toEqual([RESTS, CASTS]);
    }
    expect([house.castShadow, warnings()]).toEqual([true, '']);
  });

  test('dispose restores everything although all else is gone before', async () => {
    const { renderer, scene, sun, house, car, attach, frame } = await worldOf(isWebGL);
    const shadow = attach();
    frame();
    disposeBelow(scene);
    scene.clear();
    renderer.dispose();
    for (let i = 0; i < 2; i += 1) expect(() => shadow.dispose()).not.toThrow();
    for (const { material } of [house, car]) {
      for (const name of ['onBeforeCompile', 'customProgramCacheKey']) expect(Object.hasOwn(material, name)).toBe(false);
    }
    for (const name of ['onBeforeRender', 'onAfterRender']) expect(Object.hasOwn(scene, name)).toBe(false);
    expect(Object.hasOwn(sun, 'dispatchEvent')).toBe(false);
    expect(sun.shadow.shadowNode ?? null).toBe(null);
    expect([house.castShadow, car.castShadow, sun.position.toArray()]).toEqual([true, true, [5, 5, 0]]);
    expect([shadow.isActive, warnings()]).toEqual([false, '']);
  });

  test('a file follows a root whose matrix the app writes', async () => {
    const { sun, city, house, attach, frame, houseAndCar } = await worldOf(isWebGL);
    city.matrixAutoUpdate = false;
    city.matrix.makeTranslation(3, 0, 0);
    city.matrixWorldNeedsUpdate = true;
    const shadow = attach({ file, root: city }, {});
    const anchors: number[] = [];
    for (const angle of [0, 0.7, 1.4, 0]) {
      city.matrix.makeRotationY(angle).setPosition(100 * angle, 0, 0);
      city.matrixWorldNeedsUpdate = true;
      const draws = frame();
      expect(houseAndCar(draws)).toEqual([RESTS, CASTS]);
      const [from, to] = [sun, sun.target].map((each) => new Vector3().setFromMatrixPosition(each.matrixWorld)) as [Vector3, Vector3];
      const wanted = new Vector3(...placedGrid(file.grid, city.matrix.elements).sun);
      expect(from.sub(to).normalize().distanceTo(wanted)).toBeLessThan(1e-5);
      expect(shadow.status).toMatchObject({ filesInUse: 1, missing: 0 });
      anchors.push(anchorX(draws, house));
    }
    expect(new Set(anchors).size).toBe(3);
    expect(anchors[0]).toBe(anchors[3]);
    // The app's own matrix stays.
    expect(city.matrix.equals(new Matrix4())).toBe(true);
    expect(warnings()).toBe('');
  });

  test('a minimap into a target has the same shadows', async () => {
    const { renderer, programs, draws: recorded, inFrame, scene, house, car, camera, attach, houseAndCar } = await worldOf(isWebGL);
    const marker = meshOf();
    marker.layers.set(1);
    scene.add(marker);
    attach();
    const above = new OrthographicCamera(-5, 5, 5, -5, 0.1, 100);
    above.position.set(0, 50, 0);
    above.lookAt(0, 0, 0);
    above.layers.enable(1);
    const target = isWebGL ? new WebGLRenderTarget(64, 64) : new RenderTarget(64, 64);
    let length = 0;
    for (let i = 0; i < 4; i += 1) {
      let count = 0;
      const draws = inFrame(() => {
        renderer.render(scene, camera);
        count = recorded.length;
        renderer.setRenderTarget(target);
        renderer.render(scene, above);
        renderer.setRenderTarget(null);
      });
      const [main, map] = [draws.slice(0, count), draws.slice(count)];
      expect(houseAndCar(main)).toEqual([RESTS, CASTS]);
      expect(drawn(main, marker).total).toBe(0);
      expect(houseAndCar(map)).toMatchObject([RESTS, { withFile: 1, without: 0 }]);
      expect(drawn(map, marker)).toMatchObject({ withFile: 1, without: 0 });
      expect([house.castShadow, car.castShadow]).toEqual([true, true]);
      if (i === 0) ({ length } = programs);
    }
    expect(programs.length).toBe(length);
    expect(warnings()).toBe('');
  });

  test('shadow map sizes may change at any time', async () => {
    const { sun, house, attach, frame, houseAndCar } = await worldOf(isWebGL);
    sun.shadow.mapSize.set(512, 512);
    attach();
    frame();
    // WebGPURenderer keeps its own reference, and resizes that map.
    const first = sun.shadow.map!;
    for (const size of [1024, 256, 2048]) {
      sun.shadow.mapSize.set(size, size);
      sun.shadow.map?.dispose();
      sun.shadow.map = null;
      for (let i = 0; i < 2; i += 1) expect(houseAndCar(frame())).toEqual([RESTS, CASTS]);
      expect((isWebGL ? sun.shadow.map! : first).width).toBe(size);
    }
    expect([house.castShadow, warnings()]).toEqual([true, '']);
  });
});
