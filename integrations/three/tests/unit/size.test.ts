// The size that the package adds to a page, with one renderer or with both: at most 25 KB gzip without
// shaders, 35 KB with one, and no import but three. The aim is 17 KB. Reading, decoding and checking files
// are some six tenths of it, and a tenth are the texts of errors.

import { mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { gzipSync } from 'node:zlib';

import { build } from 'vite';
import { expect, test } from 'vitest';

const source = (name: string): string => fileURLToPath(new URL(`../../src/${name}`, import.meta.url));

/** Bundles a text as a page would, minified, and returns its bytes after gzip -9 and what it imports. */
async function bundled(text: string, external: RegExp[]): Promise<{ bytes: number; imports: string[] }> {
  const folder = mkdtempSync(join(tmpdir(), 'adumbra-size-'));
  const entry = join(folder, 'entry.ts');
  writeFileSync(entry, text);
  const built = await build({
    configFile: false,
    logLevel: 'silent',
    build: {
      write: false,
      minify: 'oxc',
      modulePreload: false,
      rolldownOptions: { input: entry, external: [/^three/, ...external], preserveEntrySignatures: 'strict' },
    },
  });
  rmSync(folder, { recursive: true });
  const outputs = (Array.isArray(built) ? built : [built]).flatMap((one) => ('output' in one ? one.output : []));
  const chunks = outputs.filter((one) => one.type === 'chunk');
  return {
    // Remove the folder of this checkout from the paths of external modules.
    bytes: gzipSync(chunks.map((chunk) => chunk.code.replace(/"[^"]*\/(generated|webgl|webgpu)\//g, '"./$1/')).join('\n'), { level: 9 }).length,
    imports: chunks.flatMap((chunk) => chunk.imports),
  };
}

const KB = 1024;

const exportAll = (...names: string[]): string =>
  names.map((name) => `export * from ${JSON.stringify(source(name))};`).join('\n');

/** All that a page can use with one renderer, and with both. */
const PAGES = {
  webgpu: ['index.ts', 'gltf/index.ts', 'webgpu/index.ts'],
  webgl: ['index.ts', 'gltf/index.ts', 'webgl/index.ts'],
  'both renderers': ['index.ts', 'gltf/index.ts', 'webgpu/index.ts', 'webgl/index.ts'],
};

/** The files whose text is GLSL or WGSL: look-ups, and the code that calls them. */
const SHADERS = [/generated/, /\.shader\.js$/];

test.each(Object.entries(PAGES))('all of %s takes at most 25 KB, 35 KB with a shader', async (page, names) => {
  const { bytes, imports } = await bundled(exportAll(...names), SHADERS);
  console.log(`all of ${page} without shaders: ${bytes} bytes after gzip`);
  expect(bytes).toBeGreaterThan(5 * KB);
  expect(bytes).toBeLessThanOrEqual(25 * KB);
  expect(imports.filter((name) => !SHADERS.some((shader) => shader.test(name))).every((name) => name.startsWith('three'))).toBe(true);
  for (const [kept, left] of [['wgsl', /glsl/], ['glsl', /wgsl/]] as const) {
    const { bytes: withShader } = await bundled(exportAll(...names), [left]);
    console.log(`all of ${page} with the shader in ${kept}: ${withShader} bytes after gzip`);
    expect(withShader).toBeLessThanOrEqual(35 * KB);
  }
});

test('a page carries only what it uses', async () => {
  const page = `import { ShadowFileLoader } from ${JSON.stringify(source('index.ts'))};
    import { BakedShadowNode } from ${JSON.stringify(source('webgpu/index.ts'))};
    console.log(ShadowFileLoader, BakedShadowNode);`;
  const [all, used] = [await bundled(exportAll(...PAGES.webgpu), SHADERS), await bundled(page, SHADERS)];
  console.log(`a page with the loader and the node, without shaders: ${used.bytes} bytes after gzip`);
  expect(used.bytes).toBeLessThan(all.bytes - KB);
});

test.each([['streaming', 'stream', 8], ['a sun path', 'path', 7]] as const)('%s comes only to pages that name adumbra-three/%s, in at most %i KB', async (what, entry, most) => {
  const [named, without] = await Promise.all([[...PAGES.webgl, `${entry}/index.ts`], PAGES.webgl].map((names) => bundled(exportAll(...names), [...SHADERS, /worker/])));
  console.log(`${what}: ${named!.bytes - without!.bytes} bytes after gzip, without shaders and the worker`);
  expect(named!.bytes - without!.bytes).toBeLessThanOrEqual(most * KB);
});
