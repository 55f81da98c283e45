// Objects in the files do not cast into shadow maps while a file is in use. At any other time, `castShadow`
// is as the app set it.

import { DirectionalLight, Group, Mesh, Scene, SkinnedMesh } from 'three';
import type { Object3D } from 'three';
import { describe, expect, test, vi } from 'vitest';

import { BakedShadowFile } from '../../src/index.js';
import { RENDERERS } from './shown.js';
import type { Shown } from './shown.js';
import { validBytes } from './vectors.js';

const file = new BakedShadowFile(validBytes('upright_depths'));

/** An object that casts. */
function caster(name = ''): Mesh {
  return Object.assign(new Mesh(), { castShadow: true, name });
}

/** Which objects cast while the light's map is drawn. */
function castIn(shown: Shown, ...objects: Object3D[]): boolean[] {
  let casts: boolean[] = [];
  const before = objects.map(({ castShadow }) => castShadow);
  shown.frame(() => (casts = objects.map(({ castShadow }) => castShadow)));
  // `castShadow` is restored.
  expect(objects.map(({ castShadow }) => castShadow)).toEqual(before);
  return casts;
}

/** Turns a light away from the file's sun. */
const turnAway = (shown: Shown): void => void shown.light.position.negate();

describe.each(RENDERERS)('%s', (name, show) => {
  test('statics rest, whenever they were added or given castShadow', () => {
    const [city, street, house, lamp] = [new Group(), new Group(), caster(), caster()];
    const shown = show({ statics: city.add(street) });
    street.add(house.add(lamp));
    const late = new Mesh();
    street.add(late);
    expect(castIn(shown, house, lamp, late)).toEqual([false, false, false]);
    late.castShadow = true;
    expect(castIn(shown, house, lamp, late)).toEqual([false, false, false]);
    street.remove(house);
    shown.scene.add(house);
    expect(castIn(shown, house, lamp, late)).toEqual([true, true, false]);
    shown.shadow.dispose();
    expect(castIn(shown, house, lamp, late)).toEqual([true, true, true]);
  });

  test('castShadow reads, clones and serialises as the app set it', () => {
    const [city, house] = [new Group(), caster()];
    const shown = show({ statics: city.add(house) });
    shown.frame();
    expect([house.clone().castShadow, house.toJSON().object.castShadow]).toEqual([true, true]);
    house.castShadow = false;
    shown.frame();
    shown.shadow.dispose();
    expect(house.castShadow).toBe(false);
  });

  test('moving objects cast below a static root', () => {
    const city = new Group();
    const shown = show({ statics: city });
    const [walker, car, wheel, glass] = [Object.assign(new SkinnedMesh(), { castShadow: true }), caster(), caster(), new Mesh()];
    car.userData['adumbra'] = { cast: true };
    city.add(walker, car.add(wheel), glass);
    expect(castIn(shown, walker, car, wheel, glass)).toEqual([true, true, true, false]);
  });

  test('a lamp below a static root goes on casting', () => {
    const [city, lamp] = [new Group(), new DirectionalLight()];
    lamp.castShadow = true;
    const shown = show({ statics: city.add(lamp) });
    expect(castIn(shown, lamp)).toEqual([true]);
  });

  test('the app’s onBeforeRender runs before objects rest', () => {
    const [city, house, barn] = [new Group(), caster(), caster()];
    const shown = show({ statics: city.add(house, barn) });
    let isNested = false;
    shown.scene.onBeforeRender = () => {
      barn.castShadow = false;
      if (isNested) return;
      isNested = true;
      // An app does the same for a map in a corner.
      shown.frame();
    };
    const seen: boolean[][] = [];
    shown.frame(() => seen.push([house.castShadow, barn.castShadow]));
    expect(seen.at(-1)).toEqual([false, false]);
    expect([house.castShadow, barn.castShadow]).toEqual([true, false]);
  });

  test('statics cast while the light is away from the file’s sun', () => {
    const [city, house] = [new Group(), caster()];
    const shown = show({ statics: city.add(house), align: false });
    expect(castIn(shown, house)).toEqual([true]);
    shown.light.position.set(...file.grid.sun);
    expect(castIn(shown, house)).toEqual([false]);
    turnAway(shown);
    expect(castIn(shown, house)).toEqual([true]);
  });

  test.each([
    ['is not visible', ({ light }: Shown) => void (light.visible = false)],
    ['is in a group that is not visible', ({ light, scene }: Shown) => void scene.add(Object.assign(new Group().add(light), { visible: false }))],
    ['has no intensity', ({ light }: Shown) => void (light.intensity = 0)],
    ['has shadows without intensity', ({ light }: Shown) => void (light.shadow.intensity = 0)],
  ])('a sun that %s lets statics cast', (_, put) => {
    const [city, house] = [new Group(), caster()];
    const shown = show({ statics: city.add(house) });
    expect([castIn(shown, house), shown.shadow.isActive, shown.shadow.status.filesInUse]).toEqual([[false], true, 1]);
    put(shown);
    expect(castIn(shown, house)).toEqual([true]);
    expect([shown.shadow.isActive, shown.shadow.status.filesInUse]).toEqual([false, 0]);
  });

  test('a sun that is in no scene lets statics cast', () => {
    const [city, house] = [new Group(), caster()];
    const shown = show({ statics: city.add(house) });
    expect(castIn(shown, house)).toEqual([false]);
    shown.scene.remove(shown.light);
    expect(castIn(shown, house)).toEqual([true]);
  });

  test('objects below the root of a file rest while that file is in use', () => {
    const [here, there, house, barn] = [new Group(), new Group(), caster(), caster()];
    there.rotation.y = 0.5;
    const shown = show({ align: false }, [{ file, root: here.add(house) }, { file, root: there.add(barn) }]);
    shown.light.position.set(...file.grid.sun);
    expect(castIn(shown, house, barn)).toEqual([false, true]);
    shown.light.position.applyAxisAngle(there.up, 0.5);
    expect(castIn(shown, house, barn)).toEqual([true, false]);
  });

  test('the root of a file not in use casts, also below a root in use', () => {
    const [city, street, house] = [new Group(), new Group(), caster()];
    const shown = show({ align: false }, [{ file, root: city.add(street.add(house)) }, { file, root: street }]);
    street.rotation.y = 0.5;
    shown.light.position.set(...file.grid.sun);
    expect(castIn(shown, house)).toEqual([true]);
    expect(shown.shadow.status).toMatchObject({ filesInUse: 1, missing: 0 });
  });

  test('maps that the app has frozen are redrawn when casters change', () => {
    const shown = show({ statics: new Group().add(caster()), align: false });
    shown.light.position.set(...file.grid.sun);
    shown.light.shadow.autoUpdate = false;
    const isRedrawn = (): boolean[] => {
      shown.frame();
      const both = [shown.light.shadow.needsUpdate, shown.renderer.shadowMap.needsUpdate ?? false];
      Object.assign(shown.light.shadow, { needsUpdate: false });
      Object.assign(shown.renderer.shadowMap, { needsUpdate: false });
      return both;
    };
    // WebGPURenderer has one switch, at the light.
    const yes = [true, name === 'WebGLRenderer'];
    expect([isRedrawn(), isRedrawn()]).toEqual([yes, [false, false]]);
    turnAway(shown);
    expect([isRedrawn(), isRedrawn()]).toEqual([yes, [false, false]]);
    turnAway(shown);
    expect(isRedrawn()).toEqual(yes);
    // Also when the light is removed before the shadow.
    const { light, scene } = shown;
    const lamp = new DirectionalLight();
    lamp.shadow.autoUpdate = false;
    scene.add(lamp).remove(light);
    shown.shadow.dispose();
    expect([lamp.shadow.needsUpdate, shown.renderer.shadowMap.needsUpdate ?? false]).toEqual(yes);
  });

  test('castShadow is restored whatever a drawing throws', async () => {
    const house = caster();
    const shown = show({ statics: new Group().add(house) });
    const fault = new Error('lost context');
    expect(() => shown.frame(() => {
      throw fault;
    })).toThrow(fault);
    await Promise.resolve();
    expect(house.castShadow).toBe(true);
    expect(castIn(shown, house)).toEqual([false]);
  });

  test('hooks that the app gives the scene later are called, and stay after dispose', () => {
    const house = caster();
    const shown = show({ statics: new Group().add(house) });
    const calls: string[] = [];
    const earlier = shown.scene.onBeforeRender;
    shown.scene.onBeforeRender = function (this: Scene, ...all) {
      calls.push('before');
      earlier.apply(this, all);
    };
    const after = () => void calls.push('after');
    shown.scene.onAfterRender = after;
    expect(castIn(shown, house)).toEqual([false]);
    expect(calls).toContain('before');
    expect(calls).toContain('after');
    const { length } = calls;
    shown.shadow.dispose();
    expect(castIn(shown, house)).toEqual([true]);
    expect(calls.length).toBeGreaterThan(length);
    expect(shown.scene.onAfterRender).toBe(after);
  });
});

describe('the light of an app', () => {
  describe.each(RENDERERS)('%s', (_, show) => {
    const towards = (light: DirectionalLight) => light.position.clone().sub(light.target.position).normalize();

    test('is kept at the sun of its file, whatever it follows, with one warning', () => {
      const warn = vi.spyOn(console, 'warn').mockImplementation(() => undefined);
      const shown = show({});
      const { light } = shown;
      light.name = 'sun';
      for (const x of [10, 20, 30]) {
        light.target.position.set(x, 0, 5);
        light.position.set(x + 3, 8, 5);
        shown.frame();
        expect(towards(light).distanceTo({ x: file.grid.sun[0], y: file.grid.sun[1], z: file.grid.sun[2] })).toBeLessThan(1e-6);
        expect(light.position.distanceTo(light.target.position)).toBeCloseTo(Math.hypot(3, 8), 6);
        expect(shown.shadow.isActive).toBe(true);
      }
      expect(warn.mock.calls.filter(([text]) => /'sun' was turned.*0\.\d+.*align: false/.test(String(text)))).toHaveLength(1);
      shown.shadow.dispose();
      // The app set this position last.
      expect(light.position.toArray()).toEqual([33, 8, 5]);
      warn.mockRestore();
    });

    test('stays at its distance from a target that moves alone', () => {
      const warn = vi.spyOn(console, 'warn').mockImplementation(() => undefined);
      const shown = show({});
      const { light } = shown;
      light.position.set(0, 50, 0);
      const away: number[] = [];
      for (let x = 0; x < 60; x += 5) {
        light.target.position.set(x, 0, 0.5 * x);
        shown.frame();
        away.push(light.position.distanceTo(light.target.position));
      }
      expect(Math.max(...away) - Math.min(...away)).toBeLessThan(1e-6);
      shown.shadow.dispose();
      warn.mockRestore();
    });

    test('has its position back though the app has turned it since', () => {
      const light = new DirectionalLight();
      light.position.set(5, 5, 0);
      const shown = show({}, file, light);
      shown.frame();
      expect(light.position.y).not.toBe(5);
      light.rotation.set(0.1, 0.2, 0.3);
      shown.frame();
      shown.shadow.dispose();
      expect(light.position.toArray()).toEqual([5, 5, 0]);
      expect(light.rotation.x).toBeCloseTo(0.1);
    });

    test('keeps its distance though three has not updated its matrices yet', () => {
      const light = new DirectionalLight();
      light.position.set(30, 40, 0);
      const shown = show({}, file, light);
      expect(light.position.length()).toBeCloseTo(50, 6);
      shown.shadow.dispose();
    });

    test('is left where the app sets it after it was turned', () => {
      const shown = show({});
      shown.light.position.set(1, 2, 3);
      shown.shadow.dispose();
      expect(shown.light.position.toArray()).toEqual([1, 2, 3]);
    });

    test('turns without automatic matrices too', () => {
      const light = new DirectionalLight();
      light.matrixAutoUpdate = false;
      light.position.set(5, 5, 0);
      light.updateMatrix();
      const shown = show({}, file, light);
      shown.frame();
      expect([shown.shadow.isActive, shown.shadow.status.degrees]).toEqual([true, expect.closeTo(0, 4)]);
      shown.shadow.dispose();
      expect(light.position.toArray()).toEqual([5, 5, 0]);
      expect(light.matrix.elements.slice(12, 15)).toEqual([5, 5, 0]);
    });

    test('goes from sun to sun, if its files have several', () => {
      const turned = new Group();
      turned.rotation.y = 1;
      const shown = show({}, [file, { file, root: turned }]);
      const sun = shown.light.position.clone().set(...file.grid.sun);
      for (const angle of [0, 1, 0.5]) {
        shown.light.position.copy(sun).applyAxisAngle(turned.up, angle);
        shown.frame();
        expect(shown.shadow.status.filesInUse).toBe(angle === 0.5 ? 0 : 1);
      }
      const { degrees } = shown.shadow.status;
      expect(degrees).toBeGreaterThan(1);
      expect(degrees).toBeLessThan(0.5 * (180 / Math.PI) + 1e-6);
    });
  });
});
