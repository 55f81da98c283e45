// Other versions of three: each can be imported, an untested version is warned of once, and a missing hook is
// named when a light is attached.

import { DirectionalLight, Material, Scene, ShaderChunk, ShaderLib } from 'three';
import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';

import { BakedShadowFile } from '../../src/index.js';
import { shaderHooks } from '../../src/webgl/shader.js';
import { nodeHooks } from '../../src/webgpu/hooks.js';
import { validBytes } from './vectors.js';

const file = new BakedShadowFile(validBytes('upright_depths'));

const warn = vi.spyOn(console, 'warn').mockImplementation(() => undefined);

beforeEach(() => {
  warn.mockClear();
  vi.resetModules();
});

afterEach(() => {
  for (const name of ['three', 'three/tsl', 'three/webgpu']) vi.doUnmock(name);
});

/** Replaces parts of a module of three. */
function change(name: string, parts: object): void {
  vi.doMock(name, async (original) => ({ ...(await original<object>()), ...parts }));
}

async function attach(light = new DirectionalLight(), scene = new Scene()): Promise<void> {
  const { attachBakedShadow } = await import('../../src/webgl/index.js');
  attachBakedShadow(scene, light, { file }).dispose();
}

async function makeNode(light = new DirectionalLight()): Promise<void> {
  const { BakedShadowNode } = await import('../../src/webgpu/index.js');
  new BakedShadowNode(light, { file }).dispose();
}

/** The error of an attachment, which must be the one of this hook. */
async function expectMissing(attachment: Promise<void>, hook: string, oldest: string): Promise<void> {
  const error = await attachment.catch((reason: unknown) => reason);
  expect(error).toMatchObject({ name: 'MissingHookError', hook, versions: [oldest, '0.187'] });
  const { message } = error as Error;
  expect(message).toContain(` has no ${hook}, which three ${oldest} to 0.187 have; install`);
}

const ENTRIES = {
  '.': () => import('../../src/index.js'),
  './gltf': () => import('../../src/gltf/index.js'),
  './webgpu': () => import('../../src/webgpu/index.js'),
  './webgl': () => import('../../src/webgl/index.js'),
};

it.each(Object.entries(ENTRIES))('importing %s works with an old, new or incomplete three', async (_, entry) => {
  for (const REVISION of ['100', '999', 'next']) {
    vi.resetModules();
    change('three', { REVISION });
    change('three/webgpu', { ShadowBaseNode: undefined });
    expect(Object.keys(await entry())).not.toHaveLength(0);
  }
  expect(warn).not.toHaveBeenCalled();
});

it.each(['188', '188dev', '1870', '', 'next'])('r%s is warned of once, whatever is attached', async (REVISION) => {
  change('three', { REVISION });
  await attach();
  await attach();
  await makeNode();
  expect(warn).toHaveBeenCalledTimes(1);
  const [text] = warn.mock.calls[0] as [string];
  expect(text).toContain(`r${REVISION};`);
  expect(text).toContain('install three@0.187');
});

it.each(['166', '186', '187', '187dev', '186.1'])('r%s is not warned of', async (REVISION) => {
  change('three', { REVISION });
  await attach();
  expect(warn).not.toHaveBeenCalled();
});

it('the three that is installed is not warned of', async () => {
  await attach();
  await makeNode();
  expect(warn).not.toHaveBeenCalled();
});

describe('WebGLRenderer', () => {
  it.each(['onBeforeCompile', 'customProgramCacheKey'] as const)('Material.%s is named if it is missing', async (name) => {
    const before = Material.prototype[name];
    (Material.prototype as unknown as Record<string, unknown>)[name] = undefined;
    try {
      await expectMissing(attach(), `Material.${name}`, '0.166');
    } finally {
      (Material.prototype as unknown as Record<string, unknown>)[name] = before;
    }
  });

  it('Scene.onBeforeRender is named if it is missing', async () => {
    const scene = Object.assign(new Scene(), { onBeforeRender: undefined });
    await expectMissing(attach(undefined, scene as unknown as Scene), 'Scene.onBeforeRender', '0.166');
  });

  it('LightShadow.intensity is named if it is missing, and may be 0', async () => {
    const light = new DirectionalLight();
    light.shadow.intensity = 0;
    await attach(light);
    delete (light.shadow as { intensity?: number }).intensity;
    await expectMissing(attach(light), 'LightShadow.intensity', '0.166');
  });

  const chunks = Object.keys(shaderHooks()).filter((hook) => hook.startsWith('ShaderChunk.'));

  it('counts the shader chunks among the hooks', () => {
    expect(chunks).toHaveLength(5);
  });

  it.each(chunks.flatMap((hook) => [[hook, 'changed'], [hook, 'gone']]))('%s is named if it is %s', async (hook, how) => {
    const [chunk, part] = hook!.slice('ShaderChunk.'.length).split(': ') as ['common', string];
    const before = ShaderChunk[chunk];
    if (how === 'gone') delete (ShaderChunk as Partial<typeof ShaderChunk>)[chunk];
    else ShaderChunk[chunk] = before.replace(new RegExp(part, 'g'), 'other');
    try {
      const first = chunks.find((each) => each.startsWith(`ShaderChunk.${chunk}:`))!;
      await expectMissing(attach(), how === 'gone' ? first : hook!, '0.166');
    } finally {
      ShaderChunk[chunk] = before;
    }
  });

  it('materials without the chunk of lights are named', async () => {
    const before = ShaderLib.lambert.fragmentShader;
    ShaderLib.lambert.fragmentShader = before.replace('<lights_fragment_begin>', '<lights_begin>');
    try {
      await expectMissing(attach(), 'ShaderLib.lambert: <lights_fragment_begin>', '0.166');
    } finally {
      ShaderLib.lambert.fragmentShader = before;
    }
  });
});

describe('WebGPURenderer', () => {
  const hooks = Object.keys(nodeHooks());
  const classes = ['ShadowBaseNode'];
  const methods = hooks.filter((hook) => hook.includes('.'));
  const functions = hooks.filter((hook) => !hook.includes('.') && !hook.includes(' ') && !classes.includes(hook));

  it('counts methods and functions among the hooks', () => {
    expect([methods.length, functions.length]).toEqual([6, 14]);
  });

  it.each([...classes, ...methods])('the first of %s is named if its class is missing', async (hook) => {
    const [name] = hook.split('.');
    change('three/webgpu', { [name!]: undefined });
    await expectMissing(makeNode(), hooks.find((each) => each.split('.')[0] === name)!, '0.183');
  });

  it.each(methods)('%s is named if the class lacks it', async (hook) => {
    const [name, method] = hook.split('.') as [string, string];
    const three = (await import('three/webgpu')) as unknown as Record<string, { prototype: object }>;
    const prototype = Object.create(three[name]!.prototype, { [method]: { value: undefined } }) as object;
    change('three/webgpu', { [name]: { prototype } });
    await expectMissing(makeNode(), hook, '0.183');
  });

  it.each(functions)('%s is named if it is missing', async (hook) => {
    change('three/tsl', { [hook]: undefined });
    await expectMissing(makeNode(), hook, '0.183');
  });

  it('LightShadow.intensity is named if it is missing', async () => {
    const light = new DirectionalLight();
    delete (light.shadow as { intensity?: number }).intensity;
    await expectMissing(makeNode(light), 'LightShadow.intensity', '0.183');
  });
});
