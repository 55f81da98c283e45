// The three renderers, each loaded only when it is needed.

import type { Drawing, RendererKind } from './drawing.js';

/** Returns an available renderer: WebGL2 in place of WebGPU if the browser or the machine has no WebGPU. */
export async function available(wanted: RendererKind): Promise<RendererKind> {
  if (wanted !== 'webgpu') return wanted;
  const adapter = await navigator.gpu?.requestAdapter().catch(() => null);
  return adapter === null || adapter === undefined ? 'webgl2' : 'webgpu';
}

/**
 * Opens a renderer.
 *
 * @throws Error if the browser does not have it.
 */
export async function open(kind: RendererKind, canvas: HTMLCanvasElement, antialias: boolean): Promise<Drawing> {
  if (kind === 'webgl') return (await import('./renderer-webgl.js')).open(canvas, antialias);
  return (await import('./renderer-nodes.js')).open(kind, canvas, antialias);
}
