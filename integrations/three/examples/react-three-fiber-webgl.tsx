import { useLoader, useThree } from '@react-three/fiber';
import { ShadowFileLoader } from 'adumbra-three';
import { attachBakedShadow } from 'adumbra-three/webgl';
import { useLayoutEffect, useRef } from 'react';
import type { DirectionalLight } from 'three';

export function Sun({ url }: { url: string }) {
  const file = useLoader(ShadowFileLoader, url);
  const scene = useThree((state) => state.scene);
  const light = useRef<DirectionalLight>(null!);
  useLayoutEffect(() => {
    const shadow = attachBakedShadow(scene, light.current, { file });
    return () => shadow.dispose();
  }, [scene, file]);
  return <directionalLight ref={light} intensity={3} />;
}
