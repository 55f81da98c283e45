// The halves of the picture: the world with a file's shadows, and the world with three's own.

import { Mesh, Vector3 } from 'three';
import type { BufferGeometry, PerspectiveCamera } from 'three';
import type { BakedShadowFile } from 'adumbra-three';
import type { LookUp } from 'adumbra-three/look-ups';

import { drive } from './bus.js';
import type { Drawing, FileSettings, Shadows } from './drawing.js';
import { disposeStage, makeStage } from './scene.js';
import type { Stage, World } from './scene.js';
import type { Technique } from './stock-shadows.js';

/** Counts of the depth passes of a frame. */
export class DepthPasses {
  passes = 0;
  triangles = 0;

  /** Begins another frame. */
  reset(): void {
    this.passes = 0;
    this.triangles = 0;
  }

  /** Counts the draws of a stage into shadow maps. */
  watch({ bus, statics }: Stage, isOfMovers: boolean): void {
    let inEachPass: Mesh | null = bus;
    const watched: Mesh[] = bus === null ? [] : [bus];
    statics.traverse((object) => {
      if (object instanceof Mesh) watched.push(object);
    });
    if (inEachPass === null && !isOfMovers) {
      inEachPass = watched[0] ?? null;
      if (inEachPass !== null) inEachPass.frustumCulled = false;
    }
    for (const mesh of watched) {
      const { index, attributes } = mesh.geometry as BufferGeometry;
      const triangles = (index?.count ?? attributes['position']?.count ?? 0) / 3;
      mesh.onBeforeShadow = () => {
        this.triangles += triangles;
        if (mesh === inEachPass) this.passes += 1;
      };
    }
  }
}

/** One half. */
export class Half {
  readonly stage: Stage;
  readonly #shadows: Shadows | null;

  constructor(stage: Stage, shadows: Shadows | null) {
    this.stage = stage;
    this.#shadows = shadows;
  }

  /** Makes ready for a frame. */
  update(camera: PerspectiveCamera, seconds: number): void {
    if (this.stage.bus !== null) drive(this.stage.bus, seconds);
    this.#shadows?.update(camera);
  }

  /** Changes how the file is looked up. */
  setOptions(settings: FileSettings): void {
    this.#shadows?.setOptions(settings);
  }

  /** Makes the shadows as strong as this, 0 to 1. */
  setIntensity(intensity: number): void {
    this.#shadows?.setIntensity(intensity);
  }

  /** Frees everything that belongs to this half. */
  dispose(): void {
    this.#shadows?.dispose();
    disposeStage(this.stage);
  }
}

/** Direction towards the sun without a file. */
const NO_FILE_SUN = new Vector3(0.5, 0.8, 0.35).normalize();

/** Direction towards the sun. */
function sunOf(file: BakedShadowFile | null): Vector3 {
  return file === null ? NO_FILE_SUN : new Vector3(...file.grid.sun);
}

/** Makes the half with a file's shadows; without a file it has none. */
export function bakedHalf(
  drawing: Drawing,
  world: World,
  file: BakedShadowFile | null,
  lookUp: LookUp | undefined,
  settings: FileSettings,
  passes: DepthPasses,
): Half {
  const stage = makeStage(world, sunOf(file));
  passes.watch(stage, true);
  const shadows = file === null ? null : drawing.bake(stage, file, lookUp, settings);
  return new Half(stage, shadows);
}

/** Makes the half with three's own shadows, of the same sun. */
export function stockHalf(
  drawing: Drawing,
  world: World,
  file: BakedShadowFile | null,
  technique: Technique,
  camera: PerspectiveCamera,
  passes: DepthPasses,
): Half {
  const stage = makeStage(world, sunOf(file));
  passes.watch(stage, false);
  return new Half(stage, drawing.stock(stage, technique, camera));
}
