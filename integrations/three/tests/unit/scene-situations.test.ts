// Situations with objects, files and hooks in apps: another order, another kind, several of one thing.

import { DirectionalLight, Group, LOD, OrthographicCamera, Scene } from 'three';
import { describe, expect, test, vi } from 'vitest';

import { placedGrid } from '../../src/index.js';
import { attachBakedShadow } from '../../src/webgl/index.js';
import { BakedShadowNode } from '../../src/webgpu/index.js';
import { RENDERERS, drawWithWebGL, webglRenderer } from './shown.js';
import type { Shown } from './shown.js';
import { SUN, caster, castIn, drawFrom, file, keepWarnings, towards } from './situations.js';
import { validBytes } from './vectors.js';

const warnings = keepWarnings();

describe.each(RENDERERS)('%s', (name, show) => {
  const isWebGL = name === 'WebGLRenderer';
  const wordsOf = (shown: Shown) => shown.headers().image.data as Uint32Array;

  describe('objects', () => {
    test('objects with null userData rest', () => {
      const [city, house, odd] = [new Group(), caster(), caster()];
      Object.assign(odd, { userData: null });
      const shown = show({ statics: city.add(house, odd) });
      expect(castIn(shown, house, odd)).toEqual([false, false]);
    });

    test('an object whose castShadow is a getter does not stop the others', () => {
      // Three itself cannot draw an object that is frozen: it writes matrixWorldNeedsUpdate.
      const [city, house, odd] = [new Group(), caster(), caster()];
      const shown = show({ statics: city.add(odd, house) });
      Object.defineProperty(odd, 'castShadow', { get: () => true });
      let during = true;
      expect(() => shown.frame(() => (during = house.castShadow))).not.toThrow();
      expect(during).toBe(false);
    });

    test('castShadow is restored whatever a walk over the statics throws', async () => {
      const [city, house, odd] = [new Group(), caster(), caster()];
      const shown = show({ statics: city.add(house, odd) });
      let value = true;
      Object.defineProperty(odd, 'castShadow', {
        get: () => value,
        set: (each: boolean) => {
          if (!each) throw new Error('app');
          value = each;
        },
      });
      try {
        shown.frame();
      } catch {
        // The error of the app.
      }
      await Promise.resolve();
      expect(house.castShadow).toBe(true);
    });

    test('a castShadow that is only truthy keeps its value', () => {
      const [city, house] = [new Group(), caster()];
      Object.assign(house, { castShadow: 1 });
      const shown = show({ statics: city.add(house) });
      shown.frame();
      expect(house.castShadow).toBe(1);
    });

    test('levels of detail rest, shown or not', () => {
      const [lod, near, far] = [new LOD(), caster(), caster()];
      lod.addLevel(near, 0);
      lod.addLevel(far, 50);
      far.visible = false;
      const shown = show({ statics: lod });
      expect(castIn(shown, near, far)).toEqual([false, false]);
    });

    test('missing statics, as an unset ref of React, do no harm', () => {
      let shown: Shown | undefined;
      try {
        shown = show({ statics: null as unknown as Group });
      } catch (error) {
        // It may be refused, but the error must name the option.
        expect(String(error)).toMatch(/statics/);
      }
      expect(() => shown?.frame()).not.toThrow();
    });

    test('statics rest in a reflector, a cube camera and other nested draws', () => {
      const [city, house] = [new Group(), caster()];
      const shown = show({ statics: city.add(house) });
      const seen: boolean[] = [];
      shown.frame(() => {
        seen.push(house.castShadow);
        // An object's onBeforeRender does the same.
        shown.frame(() => seen.push(house.castShadow));
        expect(house.castShadow).toBe(true);
      });
      expect(seen).toEqual([false, false]);
      expect(castIn(shown, house)).toEqual([false]);
    });

    test('castShadow is restored after a camera that looks as the sun shines', () => {
      const [city, house] = [new Group(), caster()];
      const shown = show({ statics: city.add(house) });
      shown.frame();
      const camera = new OrthographicCamera();
      camera.position.set(...file.grid.sun);
      camera.lookAt(0, 0, 0);
      camera.updateMatrixWorld();
      drawFrom(shown.scene, shown.renderer, camera);
      expect(house.castShadow).toBe(true);
    });
  });

  describe('files', () => {
    test('setFiles([]) when the last tile goes leaves no file in use', () => {
      const [tile, house] = [new Group(), caster()];
      const shown = show({}, { file, root: tile.add(house) });
      shown.frame();
      shown.scene.remove(tile);
      expect(() => shown.shadow.setFiles([])).not.toThrow();
      shown.scene.add(tile);
      expect(castIn(shown, house)).toEqual([true]);
      expect(shown.shadow.status.filesInUse).toBe(0);
      shown.shadow.setFiles({ file, root: tile });
      expect(castIn(shown, house)).toEqual([false]);
    });

    test('the last of several setFiles before the first frame counts', () => {
      const [a, b] = [new Group(), new Group()];
      b.position.x = 40;
      const shown = show({}, file);
      shown.shadow.setFiles([file, file]);
      shown.shadow.setFiles([{ file, root: a }, { file, root: b }]);
      shown.shadow.setFiles({ file, root: b });
      shown.shadow.setFiles({ file, root: b });
      shown.scene.add(b);
      shown.frame();
      expect(shown.shadow.status).toMatchObject({ filesInUse: 1, missing: 0 });
      const anchor = new Float32Array(wordsOf(shown).buffer)[4]!;
      shown.shadow.setFiles(file);
      shown.frame();
      expect(anchor - new Float32Array(wordsOf(shown).buffer)[4]!).toBeCloseTo(40, 3);
    });

    test('setFiles during a drawing takes effect in the next', () => {
      const [a, b, house, barn] = [new Group(), new Group(), caster(), caster()];
      const shown = show({}, { file, root: a.add(house) });
      shown.scene.add(b.add(barn));
      shown.frame(() => shown.shadow.setFiles({ file, root: b }));
      expect([house.castShadow, barn.castShadow]).toEqual([true, true]);
      expect(castIn(shown, house, barn)).toEqual([true, false]);
    });

    test('setFiles in the app’s onBeforeRender takes effect in that frame', () => {
      const [a, b, house, barn] = [new Group(), new Group(), caster(), caster()];
      const shown = show({}, { file, root: a.add(house) });
      shown.scene.add(b.add(barn));
      let isDone = false;
      shown.scene.onBeforeRender = () => {
        if (!isDone) shown.shadow.setFiles({ file, root: b });
        isDone = true;
      };
      expect(castIn(shown, house, barn)).toEqual([true, false]);
    });

    test('files that do not fit leave everything as it was', () => {
      const shown = show({ maxTextureSize: 256 }, file);
      shown.frame();
      const [words, status] = [wordsOf(shown).slice(), shown.shadow.status];
      for (const length of [10]) expect(() => shown.shadow.setFiles(Array.from({ length }, () => file))).toThrow();
      shown.frame();
      expect([wordsOf(shown).slice(), shown.shadow.status]).toEqual([words, status]);
    });

    test('a root that is missing is refused, and the scene goes on', () => {
      const scene = new Scene();
      const light = new DirectionalLight();
      scene.add(light);
      const choice = { file, root: null as unknown as Group };
      let refused: unknown;
      try {
        if (isWebGL) attachBakedShadow(scene, light, { file: choice });
        else new BakedShadowNode(light, { file: choice });
      } catch (error) {
        refused = error;
      }
      expect(() => drawWithWebGL(scene, webglRenderer())).not.toThrow();
      if (refused !== undefined) {
        for (const [object, method] of [[scene, 'onBeforeRender'], [light, 'dispatchEvent']] as const) {
          expect(Object.hasOwn(object, method)).toBe(false);
        }
        expect(String(refused)).toContain('root is');
      }
    });

    test('a root that is missing in setFiles changes nothing', () => {
      const [city, house] = [new Group(), caster()];
      const shown = show({}, { file, root: city.add(house) });
      shown.frame();
      try {
        shown.shadow.setFiles({ file, root: null as unknown as Group });
      } catch {
        // It may be refused.
        expect(castIn(shown, house)).toEqual([false]);
      }
      expect(() => shown.frame()).not.toThrow();
    });

    test('the file of a root without size is not in use until it has one', () => {
      const [city, house] = [new Group(), caster()];
      const shown = show({}, { file, root: city.add(house) });
      expect(castIn(shown, house)).toEqual([false]);
      city.scale.setScalar(0);
      expect(castIn(shown, house)).toEqual([true]);
      expect(shown.shadow.status).toMatchObject({ filesInUse: 0, missing: 1 });
      city.scale.setScalar(1);
      expect(castIn(shown, house)).toEqual([false]);
    });

    test.each([
      ['two negative scales, which are a turn, are followed', [-1, 1, -1], 1],
      ['three negative scales, which mirror, are not followed', [-2, -2, -2], 0],
    ] as const)('%s', (_, scale, count) => {
      const [city, house] = [new Group(), caster()];
      city.scale.fromArray([...scale]);
      const shown = show({}, { file, root: city.add(house) });
      expect(castIn(shown, house)).toEqual([count === 0]);
      expect(shown.shadow.status).toMatchObject({ filesInUse: count, missing: 1 - count });
      if (count === 1) expect(towards(shown.light).normalize().distanceTo({ x: -SUN.x, y: SUN.y, z: -SUN.z })).toBeLessThan(1e-5);
    });

    test('a file follows a root taken out and put below something else', () => {
      const [city, ship] = [new Group(), new Group()];
      const shown = show({}, { file, root: city });
      shown.frame();
      shown.scene.remove(city);
      shown.frame();
      expect(shown.shadow.status.filesInUse).toBe(1);
      ship.rotation.y = 1;
      shown.scene.add(ship.add(city));
      shown.frame();
      const sun = placedGrid(file.grid, city.matrixWorld.elements).sun;
      expect(towards(shown.light).normalize().distanceTo({ x: sun[0], y: sun[1], z: sun[2] })).toBeLessThan(1e-5);
    });

    test('a file follows its root with matrixWorldAutoUpdate = false', () => {
      const city = new Group();
      const shown = show({}, { file, root: city });
      shown.scene.matrixWorldAutoUpdate = false;
      city.rotation.y = 1;
      shown.light.target.position.set(4, 0, 0);
      // The app's own update.
      shown.scene.updateMatrixWorld();
      shown.frame();
      const sun = placedGrid(file.grid, city.matrixWorld.elements).sun;
      expect(shown.shadow.status.filesInUse).toBe(1);
      expect(towards(shown.light).normalize().distanceTo({ x: sun[0], y: sun[1], z: sun[2] })).toBeLessThan(1e-5);
    });

    test('setOptions and setFiles after dispose do nothing', () => {
      const shown = show({});
      shown.frame();
      shown.shadow.dispose();
      shown.shadow.dispose();
      shown.shadow.setOptions({ filter: 9 });
      shown.shadow.setFiles([file, file]);
      shown.frame();
      expect(shown.shadow.isActive).toBe(false);
      expect(Object.hasOwn(shown.scene, 'onBeforeRender')).toBe(false);
    });
  });

  describe('order', () => {
    test('dispose during a drawing or in the app’s hook restores casters', () => {
      for (const isHook of [false, true]) {
        const [city, house] = [new Group(), caster()];
        const shown = show({ statics: city.add(house) });
        shown.frame();
        const dispose = (): void => shown.shadow.dispose();
        if (isHook) shown.scene.onBeforeRender = dispose;
        let casts = false;
        shown.frame(() => {
          if (!isHook) dispose();
          casts = house.castShadow;
        });
        expect([casts, house.castShadow]).toEqual([true, true]);
        expect(Object.hasOwn(shown.scene, 'onAfterRender')).toBe(false);
      }
    });

    test('a hook of the scene that somebody deletes is restored', () => {
      const [city, house] = [new Group(), caster()];
      const shown = show({ statics: city.add(house), align: false });
      shown.light.position.set(...file.grid.sun);
      shown.frame();
      delete (shown.scene as Partial<Scene>).onBeforeRender;
      shown.frame();
      expect(castIn(shown, house)).toEqual([false]);
    });

    test('hooks that a library saves and puts back after dispose do nothing', () => {
      const [city, house] = [new Group(), caster()];
      const shown = show({ statics: city.add(house) });
      shown.frame();
      const saved = shown.scene.onBeforeRender;
      shown.scene.onBeforeRender = function (this: Scene, ...all) {
        saved.apply(this, all);
      };
      shown.shadow.dispose();
      shown.scene.onBeforeRender = saved;
      expect(castIn(shown, house)).toEqual([true]);
    });

    test('a static root that is moved later, as by a floating origin, is warned of', async () => {
      vi.resetModules();
      const fresh = await import('./shown.js');
      const show36 = fresh.RENDERERS.find(([each]) => each === name)![1];
      const city = new Group();
      const shown = show36({ statics: city }, new (await import('../../src/index.js')).BakedShadowFile(validBytes('upright_depths')));
      shown.frame();
      city.position.x -= 1000;
      shown.frame();
      shown.frame();
      expect(warnings()).toMatch(/in statics is moved/);
    });

    test('a scene that is moved as a whole while its file follows nothing is warned of', async () => {
      vi.resetModules();
      const fresh = await import('./shown.js');
      const show37 = fresh.RENDERERS.find(([each]) => each === name)![1];
      const shown = show37({}, new (await import('../../src/index.js')).BakedShadowFile(validBytes('upright_depths')));
      shown.scene.scale.setScalar(0.01);
      shown.frame();
      shown.frame();
      expect(warnings()).toMatch(/moved/);
    });
  });
});
