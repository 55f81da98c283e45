// The interface between the page and a renderer.

import type { Camera, PerspectiveCamera, Scene } from 'three';
import type { BakedShadowFile, FilterWidth } from 'adumbra-three';
import type { LookUp } from 'adumbra-three/look-ups';
import type { StreamedShadowFile } from 'adumbra-three/stream';

import type { Stage } from './scene.js';
import type { Technique } from './stock-shadows.js';

/** A renderer, as the page's address names it. */
export type RendererKind = 'webgpu' | 'webgl2' | 'webgl';

/** Shadows on a stage. */
export interface Shadows {
  /** Is called before each frame. */
  update(camera: PerspectiveCamera): void;
  /** Makes all shadows as strong as this, 0 to 1. */
  setIntensity(intensity: number): void;
  /** Changes how a file is looked up. */
  setOptions(settings: FileSettings): void;
  dispose(): void;
}

/** How a file is looked up: by a filter, or with the penumbrae of a sun that is a disc of this many degrees. */
export type FileSettings = { readonly filter: FilterWidth } | { readonly sunDegrees: number };

/** A renderer. */
export interface Drawing {
  readonly kind: RendererKind;
  setSize(width: number, height: number, pixelRatio: number): void;
  /** Draws within these columns of the canvas, CSS pixels. */
  draw(scene: Scene, camera: Camera, from: number, to: number): void;
  /** Draws into floats, four per pixel, from the top left. */
  read(scene: Scene, camera: Camera, width: number, height: number): Promise<Float32Array>;
  /** Gives a stage a file's shadows. Moving objects cast in a shadow map. */
  bake(stage: Stage, file: BakedShadowFile | StreamedShadowFile, lookUp: LookUp | undefined, settings: FileSettings): Shadows;
  /** Gives a stage three's own shadows. */
  stock(stage: Stage, technique: Technique, camera: PerspectiveCamera): Shadows;
  /** Calls back if the GPU is lost. */
  onLost(callback: () => void): void;
  /** Calls back before each frame that the screen shows. */
  loop(frame: (milliseconds: number) => void): void;
}
