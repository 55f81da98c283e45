// The parts of three's nodes that baked shadows need. Each name is written out, so that a bundler can still
// leave out unused code.

import * as TSL from 'three/tsl';
import * as WEBGPU from 'three/webgpu';

import type { Hooks } from '../light/three.js';

/** The members of a class, which may be missing, by name. */
function membersOf(type: { prototype: unknown } | undefined): Readonly<Record<string, unknown>> {
  return (type?.prototype ?? {}) as Record<string, unknown>;
}

/** The first revision of three with all hooks. */
export const OLDEST = 183;

/** Returns the hooks by name; `undefined` is missing. */
export function nodeHooks(): Hooks {
  return {
    ShadowBaseNode: WEBGPU.ShadowBaseNode,
    'AnalyticLightNode.disposeShadow': membersOf(WEBGPU.AnalyticLightNode)['disposeShadow'],
    'NodeBuilder.addSequentialNode': membersOf(WEBGPU.NodeBuilder)['addSequentialNode'],
    'NodeBuilder.isFlatShading': membersOf(WEBGPU.NodeBuilder)['isFlatShading'],
    'TextureNode.load': membersOf(WEBGPU.TextureNode)['load'],
    'TextureNode.setName': membersOf(WEBGPU.TextureNode)['setName'],
    'WebGPURenderer.initTexture': membersOf(WEBGPU.WebGPURenderer)['initTexture'],
    code: TSL.code,
    faceDirection: TSL.faceDirection,
    getCurrentStack: TSL.getCurrentStack,
    glslFn: TSL.glslFn,
    mix: TSL.mix,
    normalWorldGeometry: TSL.normalWorldGeometry,
    positionWorld: TSL.positionWorld,
    reference: TSL.reference,
    renderGroup: TSL.renderGroup,
    screenCoordinate: TSL.screenCoordinate,
    shadow: TSL.shadow,
    texture: TSL.texture,
    uvec2: TSL.uvec2,
    wgslFn: TSL.wgslFn,
  };
}
