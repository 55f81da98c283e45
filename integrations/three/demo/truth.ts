// The share of wrong pixels in one view, for which the page has a picture of shadows by rays.

import { Color } from 'three';
import type { PerspectiveCamera } from 'three';

import type { Drawing } from './drawing.js';
import type { Half } from './halves.js';

/** A view and its truth. */
export interface Truth {
  readonly eye: [number, number, number];
  readonly target: [number, number, number];
  /** Vertical angle of view, degrees. */
  readonly fov: number;
  readonly width: number;
  readonly height: number;
  readonly sun: [number, number, number];
  /** Whether each pixel is lit, from the top left. */
  readonly isLit: readonly boolean[];
}

/** The result of a comparison. */
export interface Wrong {
  readonly pixels: number;
  readonly compared: number;
}

/**
 * Loads the truth.
 *
 * @throws Error if it cannot be fetched.
 */
export async function loadTruth(): Promise<Truth> {
  const [view, picture] = await Promise.all(
    ['truth.json', 'truth.png'].map(async (url) => {
      const response = await fetch(url);
      if (!response.ok) throw new Error(`${url} cannot be fetched: ${response.status}`);
      return response;
    }),
  );
  const truth = (await view!.json()) as Omit<Truth, 'isLit'>;
  const bitmap = await createImageBitmap(await picture!.blob(), { colorSpaceConversion: 'none' });
  const canvas = new OffscreenCanvas(truth.width, truth.height);
  const context = canvas.getContext('2d')!;
  context.drawImage(bitmap, 0, 0);
  const { data } = context.getImageData(0, 0, truth.width, truth.height);
  const isLit = Array.from({ length: truth.width * truth.height }, (_, i) => data[4 * i]! > 127);
  return { ...truth, isLit };
}

/** Light below which a surface counts as turned away from the sun; surfaces of the city that face it are well above. */
const DARK = 0.003;

/**
 * Counts the pixels of a half whose shadow is on the wrong side of one half. Only surfaces that face the sun
 * are compared; the bus is left out. The camera is restored afterwards.
 */
export async function compare(drawing: Drawing, half: Half, camera: PerspectiveCamera, truth: Truth): Promise<Wrong> {
  const { stage } = half;
  const { aspect, fov } = camera;
  const [position, quaternion] = [camera.position.clone(), camera.quaternion.clone()];
  const [background, sky] = [stage.scene.background, stage.sky.intensity];
  camera.position.set(...truth.eye);
  camera.lookAt(...truth.target);
  Object.assign(camera, { aspect: truth.width / truth.height, fov: truth.fov });
  camera.updateProjectionMatrix();
  stage.scene.background = new Color(0);
  stage.sky.intensity = 0;
  if (stage.bus !== null) stage.bus.visible = false;
  const light = async (intensity: number): Promise<Float32Array> => {
    half.setIntensity(intensity);
    half.update(camera, 0);
    return drawing.read(stage.scene, camera, truth.width, truth.height);
  };
  try {
    // Draw once before: some techniques take their number of cascades, or their programs, from the previous
    // frame.
    await light(1);
    const [shadowed, unshadowed] = [await light(1), await light(0)];
    let [pixels, compared] = [0, 0];
    truth.isLit.forEach((isLit, i) => {
      const most = unshadowed[4 * i]!;
      if (most < DARK) return;
      compared += 1;
      pixels += Number(shadowed[4 * i]! > most / 2 !== isLit);
    });
    return { pixels, compared };
  } finally {
    half.setIntensity(1);
    stage.scene.background = background;
    stage.sky.intensity = sky;
    if (stage.bus !== null) stage.bus.visible = true;
    camera.position.copy(position);
    camera.quaternion.copy(quaternion);
    Object.assign(camera, { aspect, fov });
    camera.updateProjectionMatrix();
  }
}
