// Situations with lights, files and options in apps: clones, shared materials, mistakes, objects that apps go
// on using.

import { DirectionalLight, Group, Mesh, MeshLambertMaterial, Object3D, OrthographicCamera, Scene, SpotLight } from 'three';
import { describe, expect, test } from 'vitest';

import { placedGrid } from '../../src/index.js';
import type { FileChoice, LightSettings } from '../../src/light/options.js';
import { attachBakedShadow } from '../../src/webgl/index.js';
import type { BakedShadow } from '../../src/webgl/index.js';
import { BakedShadowNode } from '../../src/webgpu/index.js';
import { RENDERERS, drawWithWebGL, drawWithWebGPU, webglRenderer } from './shown.js';
import type { Shown } from './shown.js';
import { caster, castIn, compiled, drawFrom, file, keepWarnings, lookUps, towards } from './situations.js';

const warnings = keepWarnings();
const [FILTER, BIAS] = [96, 88];

describe.each(RENDERERS)('%s', (name, show) => {
  const isWebGL = name === 'WebGLRenderer';
  const wordsOf = (shown: Shown) => shown.headers().image.data as Uint32Array;
  const anchorX = (shown: Shown) => new Float32Array(wordsOf(shown).buffer)[4]!;
  const attach = (scene: Scene, light: DirectionalLight, files: FileChoice, options: LightSettings = {}): BakedShadow =>
    isWebGL ? attachBakedShadow(scene, light, { file: files, ...options }) : new BakedShadowNode(light, { file: files, ...options });
  const renderer = isWebGL ? webglRenderer() : { shadowMap: {}, initTexture: () => undefined };
  const drawOf = (scene: Scene, light: DirectionalLight, shadow: BakedShadow, map?: () => void): void =>
    isWebGL ? drawWithWebGL(scene, renderer, map) : drawWithWebGPU(scene, renderer, shadow as BakedShadowNode, light, map);
  const castsOf = (scene: Scene, light: DirectionalLight, shadow: BakedShadow, ...objects: Object3D[]): boolean[] => {
    let seen: boolean[] = [];
    drawOf(scene, light, shadow, () => (seen = objects.map(({ castShadow }) => castShadow)));
    return seen;
  };
  const isClean = (scene: Scene, light: object): boolean =>
    !Object.hasOwn(scene, 'onBeforeRender') && !Object.hasOwn(scene, 'onAfterRender') && !Object.hasOwn(light, 'dispatchEvent');

  // Expected: the clone is a light without a file. WebGPURenderer draws its map separately, so all objects
  // cast there. With WebGLRenderer it has the file's shadow, because it has the same direction. Neither light
  // disturbs the other.
  test('light.clone() beside the sun is a light without a file', () => {
    const [city, house] = [new Group(), caster()];
    const shown = show({ statics: city.add(house) });
    shown.light.castShadow = true;
    shown.frame();
    const twin = shown.light.clone();
    shown.scene.add(twin, twin.target);
    expect(Object.hasOwn(twin, 'dispatchEvent')).toBe(false);
    expect(castIn(shown, house)).toEqual([false]);
    let casts = false;
    if (!isWebGL) {
      shown.frame(() => {
        twin.shadow.updateMatrices(twin);
        drawFrom(shown.scene, shown.renderer, twin.shadow.camera, () => (casts = house.castShadow));
      });
      expect.soft(casts).toBe(true);
    }
    twin.dispose();
    expect(shown.shadow.isActive).toBe(true);
    shown.shadow.dispose();
    expect(house.castShadow).toBe(true);
  });

  // Expected: a scene without a file. All objects in it cast, and its hooks are three's.
  test('scene.clone() drawn by itself is a scene without a file', () => {
    const [city, house] = [new Group(), caster('house')];
    const shown = show({ statics: city.add(house) });
    shown.frame();
    const copy = shown.scene.clone();
    expect(Object.hasOwn(copy, 'onBeforeRender')).toBe(false);
    const twin = copy.getObjectByName('house')!;
    expect(twin.castShadow).toBe(true);
    copy.updateMatrixWorld();
    drawFrom(copy, shown.renderer, new OrthographicCamera(), () => expect(twin.castShadow).toBe(true));
    expect(castIn(shown, house, twin)).toEqual([false, true]);
    shown.shadow.dispose();
    expect([house.castShadow, twin.castShadow]).toEqual([true, true]);
  });

  // Expected: a preview of one house has no shadows of the city, although its sun shines from the same
  // direction.
  test('a material shared with a scene without a file has no shadow there', () => {
    if (!isWebGL) return; // Materials are built for each scene's lights.
    const material = new MeshLambertMaterial();
    const [scene, preview, sun, other] = [new Scene(), new Scene(), new DirectionalLight(), new DirectionalLight()];
    scene.add(sun, sun.target, new Mesh(undefined, material));
    other.position.set(...file.grid.sun);
    preview.add(other, other.target, new Mesh(undefined, material));
    const shadow = attachBakedShadow(scene, sun, { file });
    const { uniforms, fragmentShader } = compiled(material);
    expect(lookUps(fragmentShader)).toBe(2);
    const intensity = Object.entries(uniforms).find(([key]) => key.endsWith('_intensity'))![1];
    let seen: unknown[] = [];
    drawWithWebGL(scene, renderer, () => seen.push(intensity.value));
    drawWithWebGL(preview, renderer, () => seen.push(intensity.value));
    drawWithWebGL(scene, renderer, () => seen.push(intensity.value));
    shadow.dispose();
    expect(seen).toEqual([1, 0, 1]);
  });

  // Expected: an error or a warning names it; shadows do not disappear without a message.
  test('a SpotLight is named in an error or a warning', () => {
    const [scene, spot, city] = [new Scene(), new SpotLight(), new Group()];
    scene.add(spot, spot.target, city.add(caster()));
    let refused: unknown;
    let shadow: BakedShadow | undefined;
    try {
      shadow = attach(scene, spot as unknown as DirectionalLight, file, { statics: city });
    } catch (error) {
      refused = error;
    }
    const said = `${String(refused ?? '')} ${warnings()}`;
    shadow?.dispose();
    expect(said).toMatch(/SpotLight|DirectionalLight/);
    expect(isClean(scene, spot)).toBe(true);
  });

  // Expected: the same as after setFiles([]), because the first tile comes later.
  test('attaches with an empty list, and takes files later', () => {
    const [tile, house] = [new Group(), caster()];
    const shown = show({}, []);
    shown.scene.add(tile.add(house));
    expect(castIn(shown, house)).toEqual([true]);
    expect(shown.shadow.status).toMatchObject({ filesInUse: 0, missing: 0 });
    shown.shadow.setFiles({ file, root: tile });
    expect(castIn(shown, house)).toEqual([false]);
  });

  // Expected: an error on attaching that names the missing object, or a scene that goes on. Not a TypeError
  // in every frame, and not a file in a wrong place.
  test.each([
    ['in statics', (world: Scene) => ({ statics: [world.getObjectByName('city'), world.getObjectByName('town')] }), () => file, /statics/],
    ['as a root', () => ({}), (world: Scene) => ({ file, root: world.getObjectByName('town') }), /root is undefined/],
  ] as const)('undefined %s is named (getObjectByName found nothing)', (_, options, files, said) => {
    const [scene, light] = [new Scene(), new DirectionalLight()];
    scene.add(light, light.target, Object.assign(new Group(), { name: 'city' }).add(caster()));
    let refused: unknown;
    let shadow: BakedShadow | undefined;
    try {
      shadow = attach(scene, light, files(scene) as FileChoice, options(scene) as LightSettings);
    } catch (error) {
      refused = error;
    }
    if (refused === undefined) expect.soft(() => drawOf(scene, light, shadow!)).not.toThrow();
    shadow?.dispose();
    expect.soft(`${String(refused ?? '')} ${warnings()}`).toMatch(said);
    expect(isClean(scene, light)).toBe(true);
  });

  // Expected: the error says that it is not a file (or to await it), and nothing is changed.
  test('refuses a promise of a file (await is forgotten)', () => {
    const [scene, light] = [new Scene(), new DirectionalLight()];
    scene.add(light, light.target);
    const promise = Promise.resolve(file) as unknown as typeof file;
    let refused: unknown;
    try {
      attach(scene, light, promise);
    } catch (error) {
      refused = error;
    }
    expect(isClean(scene, light)).toBe(true);
    expect(light.position.toArray()).toEqual([0, 1, 0]);
    expect(String(refused)).toMatch(/await|promise|shadow file|BakedShadowFile|ShadowFileLoader/i);
  });

  // Expected: nothing changes until setOptions, whatever a panel of controls does to the object that the app
  // gave.
  test('changes to the options’ object have no effect before setOptions', () => {
    const city = new Group();
    const options = { filter: 5 as 5 | 9, bias: { constantTexels: 1, slopeTexels: 2, normalOffsetTexels: 1 } };
    const shown = show(options, { file, root: city });
    shown.frame();
    const before = [wordsOf(shown)[FILTER], wordsOf(shown)[BIAS]];
    options.filter = 9;
    options.bias.constantTexels = 6;
    city.position.x += 1;
    shown.frame();
    expect.soft([wordsOf(shown)[FILTER], wordsOf(shown)[BIAS]]).toEqual(before);
    // A slider in between.
    options.filter = 4 as 5;
    city.position.x += 1;
    shown.frame();
    expect.soft(shown.shadow.status.filesInUse).toBe(1);
    shown.shadow.setOptions({ filter: 9 });
    expect(wordsOf(shown)[FILTER]).toBe(9);
  });

  // Expected: nothing changes until setFiles; frames in between are drawn as before.
  test('changes to the app’s own tiles have no effect before setFiles', () => {
    const [a, b, house, barn] = [new Group(), new Group(), caster(), caster()];
    b.position.x = 40;
    const tile: { file: typeof file; root: Group; name: string } = { file, root: a.add(house), name: '3/7' };
    const shown = show({}, [tile]);
    shown.scene.add(b.add(barn));
    shown.frame();
    const x = anchorX(shown);
    tile.root = b;
    expect.soft(castIn(shown, house, barn)).toEqual([false, true]);
    expect.soft(anchorX(shown)).toBe(x);
    Object.assign(tile, { root: null, file: null });
    expect.soft(() => shown.frame()).not.toThrow();
    Object.assign(tile, { root: b, file });
    shown.shadow.setFiles([tile]);
    expect(castIn(shown, house, barn)).toEqual([true, false]);
    expect(anchorX(shown) - x).toBeCloseTo(40, 3);
  });

  // Expected: each object rests once, and is restored afterwards. A stretched root casts, although it is in
  // statics.
  test('nested and repeated statics rest once and are restored', () => {
    const [scene, light, city, street, house, car, tent] = [new Scene(), new DirectionalLight(), new Group(), new Group(), caster(), caster(), caster()];
    car.userData['adumbra'] = { cast: true };
    scene.add(light, light.target, city.add(street.add(house, car)), tent);
    const shadow = attach(scene, light, [{ file, root: city }, file], { statics: [scene, city, city, house, street] });
    drawOf(scene, light, shadow);
    expect(castsOf(scene, light, shadow, house, car, tent)).toEqual([false, true, false]);
    expect([house.castShadow, car.castShadow, tent.castShadow]).toEqual([true, true, true]);
    city.scale.x = 2;
    drawOf(scene, light, shadow);
    expect(shadow.status).toMatchObject({ filesInUse: 1, missing: 1 });
    // An ancestor in statics must not make it rest.
    expect(castsOf(scene, light, shadow, house, car)).toEqual([true, true]);
    city.scale.x = 1;
    expect(castsOf(scene, light, shadow, house, car, tent)).toEqual([false, true, false]);
    shadow.dispose();
    expect([house.castShadow, car.castShadow, tent.castShadow]).toEqual([true, true, true]);
    expect(isClean(scene, light)).toBe(true);
  });

  // Expected: the light has the sun of the root wherever the root goes, and is restored.
  test.each([
    ['carries its target', true],
    ['has its target nowhere', false],
  ])('a sun below the root of its file follows it, and %s', (_, carries) => {
    const [scene, light, model, node, house] = [new Scene(), new DirectionalLight(), new Group(), new Group(), caster()];
    light.target.position.set(0, 0, -1);
    if (carries) light.add(light.target);
    else light.target.position.set(0, 0, 0);
    node.rotation.set(-0.5, 0.4, 0);
    model.add(node.add(light), house);
    const was = { position: light.position.toArray(), quaternion: light.quaternion.toArray() };
    const shadow = attach(scene, light, { file, root: model });
    model.rotation.y = 0.8;
    model.position.set(5, 0, 2);
    model.scale.setScalar(0.5);
    scene.add(model);
    for (let i = 0; i < 3; i += 1) {
      model.rotation.y += 0.2;
      drawOf(scene, light, shadow);
      const sun = placedGrid(file.grid, model.matrixWorld.elements).sun;
      expect([shadow.isActive, towards(light).normalize().distanceTo({ x: sun[0], y: sun[1], z: sun[2] }) < 1e-5]).toEqual([true, true]);
    }
    expect(castsOf(scene, light, shadow, house)).toEqual([false]);
    shadow.dispose();
    expect({ position: light.position.toArray(), quaternion: light.quaternion.toArray() }).toEqual(was);
    expect(castsOf(scene, light, shadow, house)).toEqual([true]);
  });

  // Expected: each has its own options, words and end, in either order.
  test.each(['first', 'second'])('two lights with one file are independent; the %s ends first', (early) => {
    const [city, district, house, barn] = [new Group(), new Group(), caster(), caster()];
    const shown = show({ statics: city.add(house) }, file);
    // The helper returns the texture that was uploaded last, of any light.
    const words0 = wordsOf(shown);
    const [light, { scene }] = [new DirectionalLight(), shown];
    district.rotation.y = 1.2;
    scene.add(light, light.target, district.add(barn));
    const other = attach(scene, light, { file, root: district });
    const both = (): [boolean, boolean] => [castIn(shown, house)[0]!, castsOf(scene, light, other, barn)[0]!];
    both();
    expect(both()).toEqual([false, false]);
    expect([shown.shadow.status.filesInUse, other.status.filesInUse]).toEqual([1, 1]);
    const words = words0.slice();
    other.setOptions({ filter: 9 });
    both();
    expect(words0).toEqual(words);
    const isFirst = early === 'first';
    (isFirst ? shown.shadow : other).dispose();
    expect(both()).toEqual(isFirst ? [true, false] : [false, true]);
    expect([shown.shadow.isActive, other.isActive]).toEqual([!isFirst, isFirst]);
    (isFirst ? other : shown.shadow).dispose();
    expect(both()).toEqual([true, true]);
    expect(isClean(scene, light) && isClean(scene, shown.light)).toBe(true);
    expect(light.position.toArray()).toEqual([0, 1, 0]);
  });
});
