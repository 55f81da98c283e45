import { useLoader } from '@react-three/fiber';
import { ShadowFileLoader } from 'adumbra-three';
import { BakedShadowNode } from 'adumbra-three/webgpu';
import { useLayoutEffect, useRef } from 'react';
import type { DirectionalLight } from 'three';

export function Sun({ url }: { url: string }) {
  const file = useLoader(ShadowFileLoader, url);
  const light = useRef<DirectionalLight>(null!);
  useLayoutEffect(() => {
    const node = new BakedShadowNode(light.current, { file });
    light.current.shadow.shadowNode = node;
    return () => node.dispose();
  }, [file]);
  return <directionalLight ref={light} castShadow intensity={3} />;
}
