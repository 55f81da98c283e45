// The example for React Three Fiber in a page: a ground seen from above, under the sun of one file, then of
// another, then of none.

import { Canvas } from '@react-three/fiber';
import { StrictMode, Suspense, useState } from 'react';
import { createRoot } from 'react-dom/client';
import { WebGPURenderer } from 'three/webgpu';
import type { WebGPURendererParameters } from 'three/webgpu';

import { Sun as SunOfWebGL } from '../../../examples/react-three-fiber-webgl.js';
import { Sun as SunOfWebGPU } from '../../../examples/react-three-fiber.js';

/** Whether the canvas has the renderer of its own choice. */
const isWebGL = new URLSearchParams(location.search).get('renderer') === 'webgl';
const Sun = isWebGL ? SunOfWebGL : SunOfWebGPU;

type Page = Window & { isReady?: boolean; setUrl: (url: string | null) => void };

function World() {
  const [url, setUrl] = useState<string | null>(null);
  (window as unknown as Page).setUrl = setUrl;
  return (
    <>
      <mesh receiveShadow rotation={[-Math.PI / 2, 0, 0]}>
        <planeGeometry args={[40, 40]} />
        <meshLambertMaterial />
      </mesh>
      <Suspense>{url !== null && <Sun url={url} />}</Suspense>
    </>
  );
}

const root = document.body.appendChild(document.createElement('div'));
Object.assign(document.body.style, { margin: '0', background: 'black' });
Object.assign(root.style, { width: '200px', height: '200px' });
createRoot(root).render(
  <StrictMode>
    <Canvas
      shadows="percentage"
      flat
      orthographic
      camera={{ position: [0, 50, 0], up: [0, 0, -1], zoom: 10 }}
      {...(isWebGL
        ? {}
        : {
            gl: async (canvas) => {
              const renderer = new WebGPURenderer(canvas as WebGPURendererParameters);
              await renderer.init();
              return renderer;
            },
          })}
      onCreated={() => void ((window as unknown as Page).isReady = true)}
    >
      <World />
    </Canvas>
  </StrictMode>,
);
