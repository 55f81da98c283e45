// Sun paths key by key: which keys are loaded, which ones answer meanwhile, and the words that lights get.

import { DirectionalLight, Scene, Vector3 } from 'three';
import type { Texture } from 'three';
import { afterEach, describe, expect, it, vi } from 'vitest';

import { BakedShadowFile, Sampler } from '../../src/index.js';
import type { Vec3 } from '../../src/index.js';
import { SunPathFile } from '../../src/path/index.js';
import { attachBakedShadow } from '../../src/webgl/index.js';
import { pathFile, repairPath } from './path-files.js';
import { surfacesOf } from './points.js';
import { drawWithWebGL, webglRenderer } from './shown.js';
import { pause, serve } from './stream-server.js';
import { validBytes } from './vectors.js';

const KEY = validBytes('slopes_depths');
const WHOLE = new BakedShadowFile(KEY);
const SUN = WHOLE.grid.sun;
/** A sun whose rays are half a degree or so off. */
const ASIDE = ((): Vec3 => {
  const { x, y, z } = new Vector3(...SUN).add(new Vector3(0.01, 0, 0.005)).normalize();
  return [x, y, z];
})();
const TIMES = [0, 100, 200, 300, 400];
/** The sun does not move, but is aside at 250, and down at 500. */
const BYTES = pathFile(
  [[0, SUN], [200, SUN], [250, ASIDE], [300, SUN], [400, SUN], [500, [1, 0, 0]]],
  TIMES.map((seconds) => [seconds, KEY]),
);

afterEach(() => {
  vi.unstubAllGlobals();
  vi.restoreAllMocks();
});

/** Waits for keys that are loading, and takes them in. */
async function settle(file: SunPathFile, seconds: number): Promise<void> {
  file.update(seconds);
  for (let i = 0; i < 200 && (i < 3 || file.stats.loading.length > 0); i++) {
    await pause();
    file.update(seconds);
  }
}

describe('loading', () => {
  it('begins with one key, and requests no more than it needs', async () => {
    const served = serve(BYTES);
    const file = await SunPathFile.open('day', { seconds: 10 });
    expect(served.ranges[0]).toEqual([0, 65_535]);
    expect(file.stats).toMatchObject({ resident: [0], answering: [0], isExact: false });
    expect(file.keySeconds).toEqual(TIMES);
    expect(file.spanSeconds).toEqual([0, 500]);
    await settle(file, 10);
    expect(file.stats).toMatchObject({ resident: [0, 1, 2], loading: [], isExact: true });
    file.dispose();
  });

  it('has at most three keys as time goes on and back', async () => {
    serve(BYTES);
    const file = await SunPathFile.open('day');
    const resident = async (seconds: number): Promise<readonly number[]> => {
      await settle(file, seconds);
      expect(file.stats.isExact).toBe(true);
      return file.stats.resident;
    };
    expect(await resident(150)).toEqual([1, 2, 3]);
    expect(await resident(250)).toEqual([2, 3, 4]);
    expect(await resident(120)).toEqual([0, 1, 2]);
    expect(await resident(400)).toEqual(expect.arrayContaining([4]));
    expect(file.stats.residentBytes).toBe(3 * 4 * (WHOLE.top.length + WHOLE.code.length));
    file.dispose();
  });

  it('jumps without a gap: a resident key answers until those of the moment come', async () => {
    serve(BYTES);
    const file = await SunPathFile.open('day');
    await settle(file, 10);
    file.update(350);
    expect(file.stats).toMatchObject({ answering: [2], isExact: false });
    expect(file.sampler({ filter: 1 }).isExact).toBe(false);
    await file.load(350);
    expect(file.stats).toMatchObject({ answering: [3, 4], isExact: true });
    file.dispose();
  });

  it('loads the whole file from a server without ranges, with a warning', async () => {
    const warn = vi.spyOn(console, 'warn').mockImplementation(() => {});
    const served = serve(BYTES, { noRanges: true });
    const file = await SunPathFile.open('whole-day');
    await settle(file, 250);
    expect(file.stats).toMatchObject({ resident: [2, 3, 4], isExact: true });
    expect(served.ranges.length).toBe(1);
    expect(warn).toHaveBeenCalledTimes(1);
    file.dispose();
  });

  it('requests a failed key again', async () => {
    vi.spyOn(console, 'warn').mockImplementation(() => {});
    const served = serve(BYTES);
    // The front and the first key arrive.
    served.faults.answer = ({ number }) => (number < 2 ? undefined : new Response(null, { status: 500 }));
    const file = await SunPathFile.open('failing-day');
    const errors: unknown[] = [];
    file.addEventListener('error', ({ error, key }) => errors.push([error.kind, error.url, key]));
    await settle(file, 10);
    expect(errors).toEqual([['Io', 'failing-day', 1], ['Io', 'failing-day', 2]]);
    expect(file.stats).toMatchObject({ resident: [0], isExact: false });
    await expect(file.load(110)).rejects.toMatchObject({ kind: 'Io' });
    delete served.faults.answer;
    file.retry();
    await settle(file, 110);
    expect(file.stats).toMatchObject({ resident: [1, 2, 3], isExact: true });
    file.dispose();
  });

  it('refuses a key that is damaged', async () => {
    vi.spyOn(console, 'warn').mockImplementation(() => {});
    const bytes = BYTES.slice();
    bytes[bytes.length - 1]! ^= 1;
    serve(bytes);
    const file = await SunPathFile.open('damaged-day');
    await expect(file.load(400)).rejects.toMatchObject({ kind: 'SectionChecksum', url: 'damaged-day' });
    expect(file.stats.isExact).toBe(false);
    file.dispose();
  });

  it('refuses a key with more or fewer words than the path says', async () => {
    vi.spyOn(console, 'warn').mockImplementation(() => {});
    const bytes = BYTES.slice();
    const view = new DataView(bytes.buffer);
    const lastKey = 128 + 32 * (6 + TIMES.length - 1);
    view.setUint32(lastKey + 24, view.getUint32(lastKey + 24, true) + 1, true);
    repairPath(bytes);
    serve(bytes);
    const file = await SunPathFile.open('other-day');
    await expect(file.load(400)).rejects.toMatchObject({ kind: 'HeaderField', message: expect.stringContaining('words of key 4 is') });
    expect(file.stats.resident).not.toContain(4);
    file.dispose();
  });

  it('says that the file has changed, and loads no more', async () => {
    vi.spyOn(console, 'warn').mockImplementation(() => {});
    const served = serve(BYTES);
    const file = await SunPathFile.open('changed-day');
    served.etag = '"2"';
    let changes = 0;
    file.addEventListener('changed', () => (changes += 1));
    await settle(file, 10);
    const requests = served.ranges.length;
    await settle(file, 300);
    expect(changes).toBe(1);
    expect(served.ranges.length).toBe(requests);
    file.dispose();
  });

  it.each([
    ['Truncated', BYTES.slice(0, -1)],
    ['TrailingBytes', Uint8Array.of(...BYTES, 0)],
    ['OtherKind', KEY],
  ])('refuses a file: %s', async (kind, bytes) => {
    serve(bytes);
    await expect(SunPathFile.open('day')).rejects.toMatchObject({ name: 'ShadowFileError', kind, url: 'day' });
  });

  it('ends when its signal aborts', async () => {
    const served = serve(BYTES);
    const control = new AbortController();
    const file = await SunPathFile.open('day', { signal: control.signal });
    control.abort();
    const requests = served.ranges.length;
    await settle(file, 300);
    expect(served.ranges.length).toBe(requests);
    expect(file.stats.answering.length).toBe(1);
    await expect(file.load(300)).rejects.toMatchObject({ name: 'AbortError' });
    const late = SunPathFile.open('day', { signal: control.signal });
    await expect(late).rejects.toMatchObject({ name: 'AbortError' });
  });

  it('refuses options that are out of their range', async () => {
    serve(BYTES);
    await expect(SunPathFile.open('day', { timeoutSeconds: 0 })).rejects.toThrow(RangeError);
    await expect(SunPathFile.open('day', { seconds: NaN })).rejects.toThrow(RangeError);
    const file = await SunPathFile.open('day');
    expect(() => file.update(Infinity)).toThrow(RangeError);
    expect(() => file.sampler({ filter: 2 as 1 })).toThrow(RangeError);
    file.dispose();
  });
});

describe('look-ups', () => {
  it("answer at a key's own sun as its file does", async () => {
    serve(BYTES);
    const file = await SunPathFile.open('day');
    const { points } = surfacesOf(WHOLE, 2000, 1);
    expect(file.sampler({ filter: 1 }).visibilities(points)).toEqual(new Sampler(WHOLE, { filter: 1 }).visibilities(points));
    file.dispose();
  });

  it('find all in shadow at night', async () => {
    serve(BYTES);
    const file = await SunPathFile.open('day');
    await settle(file, 600);
    expect(file.stats).toMatchObject({ answering: [], isExact: true });
    expect(file.sampler({ filter: 5 }).visibility({ x: 0, y: 1e6, z: 0 })).toBe(0);
    expect(file.sampler({ filter: 5 }, 0).visibility({ x: 0, y: 1e6, z: 0 })).toBe(1);
    file.dispose();
  });
});

describe('a light', () => {
  const wordsOf = (texture: Texture): Uint32Array => (texture.image as { data: Uint32Array }).data;

  it('gets both keys and the slope towards the sun', async () => {
    serve(BYTES);
    const file = await SunPathFile.open('day');
    const { texture, lookUps } = file.openWords({ filter: 5 }, 8192);
    const words = wordsOf(texture);
    const width = (texture.image as { width: number }).width;
    const [first, second] = [words.subarray(0, 128), words.subarray(128, 256)];
    expect([first[104], second[104], first[106]]).toEqual([width, width, 0]);
    expect(words.slice(width, width + WHOLE.top.length)).toEqual(WHOLE.top);
    await settle(file, 250);
    expect(new Set([first[104], second[104]]).size).toBe(2);
    const slopes = new Int32Array(words.buffer).slice(107, 109);
    expect(slopes.some((c) => Math.abs(c) > 100)).toBe(true);
    lookUps[0]!.setLookUp({ filter: 9 });
    expect(first[16 + 80]).toBe(9);
    expect(() => lookUps[0]!.setLookUp({ filter: 2 as 1 })).toThrow(RangeError);
    await settle(file, 600);
    expect(first[106]).toBe(1);
    file.dispose();
  });

  it('takes a path, and follows its sun', async () => {
    serve(BYTES);
    const file = await SunPathFile.open('day');
    const light = new DirectionalLight();
    const scene = new Scene().add(light) as Scene;
    const attached = attachBakedShadow(scene, light, { file });
    expect(attached.isActive).toBe(true);
    await settle(file, 250);
    expect(attached.isActive).toBe(false);
    const warn = vi.spyOn(console, 'warn').mockImplementation(() => undefined);
    drawWithWebGL(scene, { ...webglRenderer(), copyTextureToTexture: () => undefined });
    expect(attached.isActive).toBe(true);
    expect(light.position.clone().normalize().distanceTo({ x: ASIDE[0], y: ASIDE[1], z: ASIDE[2] })).toBeLessThan(1e-6);
    expect(warn).not.toHaveBeenCalled();
    warn.mockRestore();
    expect(() => attachBakedShadow(new Scene(), light, { file: [file, WHOLE] })).toThrow(/only one of its light/);
    expect(() => file.openWords({ filter: 5 }, 128)).toThrow(/but a side may have 128 texels/);
    attached.dispose();
    file.dispose();
  });
});
