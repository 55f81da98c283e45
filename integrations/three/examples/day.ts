import { SunPathFile } from 'adumbra-three/path';
import { BakedShadowNode } from 'adumbra-three/webgpu';
import type { DirectionalLight, PerspectiveCamera, Scene } from 'three';
import type { WebGPURenderer } from 'three/webgpu';

/** Lets the sun of a path go across the sky, a minute of its day in a second. */
export async function drawDay(renderer: WebGPURenderer, scene: Scene, camera: PerspectiveCamera, sun: DirectionalLight): Promise<void> {
  const day = await SunPathFile.open('day.adumbra');
  sun.castShadow = true;
  sun.shadow.shadowNode = new BakedShadowNode(sun, { file: day, filter: 3 });

  const [sunrise, sunset] = day.spanSeconds;
  renderer.setAnimationLoop((milliseconds) => {
    const seconds = sunrise + ((0.06 * milliseconds) % (sunset - sunrise));
    day.update(seconds);
    sun.intensity = day.sunAt(seconds) === undefined ? 0 : 3;
    renderer.render(scene, camera);
  });
}
