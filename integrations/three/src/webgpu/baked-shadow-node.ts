// The shadow of a light from its files, as a node of WebGPURenderer.

import { FrontSide, Vector3 } from 'three';
import * as TSL from 'three/tsl';
import * as WEBGPU from 'three/webgpu';
import type { Node, NodeBuilder, NodeFrame, ShadowBaseNode } from 'three/webgpu';

import type { BakedShadowFile } from '../file/shadow-file.js';
import { alignLight, towardsLight } from '../light/direction.js';
import type { SunLike } from '../light/direction.js';
import { asList } from '../light/options.js';
import type { BakedShadowOptions, ShadowSettings } from '../light/options.js';
import { Statics } from '../light/statics.js';
import { LightTextures } from '../light/textures.js';
import { checkThree } from '../light/three.js';
import { depths } from '../look-ups/depths.js';
import type { LookUp } from '../look-ups/look-up.js';
import { nodeHooks } from './hooks.js';
import { LookUpNodes } from './look-up-node.js';

/** What casts besides the files: `'shadow'` for the light's own shadow map, a shadow node such as `CSMShadowNode`, or nothing. */
export type Movers = 'shadow' | ShadowBaseNode;

/** Options of a {@link BakedShadowNode}. */
export interface BakedShadowNodeOptions extends BakedShadowOptions {
  /** The light's file, or several: tiles, suns. */
  file: BakedShadowFile | readonly BakedShadowFile[];
  /**
   * What casts besides the files. Without it the light draws no shadow map. `'shadow'` is for a `DirectionalLight`; a
   * `SunLight` takes `sunShadow(light)`, from three's addons.
   */
  movers?: Movers;
}

/** A builder with what its types leave out. */
type Builder = NodeBuilder & {
  addSequentialNode(node: Node): void;
  /** From three 0.183 on. */
  isFlatShading?(): boolean;
  readonly context: { readonly shadowPositionWorld?: Node<'vec3'> };
  readonly material: {
    readonly flatShading?: boolean;
    readonly receivedShadowPositionNode?: Node<'vec3'> | null;
    readonly receivedShadowNode?: ((node: Node) => Node) | null;
  };
};

/** The class that three's shadow nodes have in common. Where it is missing, no node can be made, but the import goes on. */
const Base = (WEBGPU.ShadowBaseNode ?? Object) as typeof ShadowBaseNode;

/** The first revision of three with all that is needed. */
const OLDEST = 182;

/** Numbers of the nodes, which tell their texts apart in a shader. */
let nodes = 0;

/**
 * The shadow of a light from its files: `light.shadow.shadowNode = new BakedShadowNode(light, { file })`. The light must
 * cast (`light.castShadow`), and the renderer's shadow maps must be enabled. A node of this kind that the light had before is
 * disposed.
 */
export class BakedShadowNode extends Base {
  readonly #sun: SunLike;
  readonly #lookUp: LookUp;
  readonly #nodes: LookUpNodes;
  readonly #movers: Node | null;
  readonly #statics: Statics;
  readonly #textures: LightTextures;
  readonly #direction = new Vector3();
  #isDisposed = false;

  /**
   * Creates a node. Cost: one copy of the files' words.
   *
   * @throws MissingHookError if this version of three lacks what is needed.
   * @throws ShadowFileError of the kind `Layout` or `TooLarge`, if a file does not fit the look-up or the GPU.
   * @throws RangeError if an option is out of its range.
   */
  constructor(light: SunLike, options: BakedShadowNodeOptions) {
    super(light);
    checkThree(OLDEST, { ...nodeHooks(), 'LightShadow.intensity': light.shadow.intensity });
    const files = asList(options.file);
    this.#sun = light;
    this.#lookUp = options.lookUp ?? depths;
    this.#textures = new LightTextures(files, this.#lookUp, options);
    nodes += 1;
    this.#nodes = new LookUpNodes(this.#lookUp, this.#textures, `adumbra${nodes}`);
    const { movers } = options;
    if (movers === 'shadow' && 'isSunLight' in light) {
      throw new RangeError(
        "movers: 'shadow' is for a DirectionalLight; pass movers: sunShadow(light), from 'three/addons/lights/SunShadowNode.js'",
      );
    }
    this.#movers = movers === 'shadow' ? TSL.shadow(light) : (movers ?? null);
    this.#statics = new Statics(asList(options.statics));
    if (options.align ?? true) alignLight(light, files[0]!.grid.sun);
    this.#update();
    // What was in use until now is dropped, and materials are built anew.
    const before = light.shadow.shadowNode as unknown;
    if (before instanceof BakedShadowNode) before.dispose();
    else if (before === undefined || before !== movers) light.dispatchEvent({ type: 'dispose' });
  }

  /** Whether the light shines from the sun of a file. Otherwise shadows are those of `movers`, if there are any. */
  get isActive(): boolean {
    return !this.#isDisposed && this.#textures.use(this.#direction) > 0;
  }

  /**
   * Changes filter, bias or softness; what is left out stays. Nothing is compiled anew.
   *
   * @throws RangeError if a setting is out of its range.
   */
  setLookUp(settings: ShadowSettings): void {
    this.#textures.setLookUp(settings);
  }

  /** For three: builds the shadow's node. */
  override build(builder: NodeBuilder, output: string | null = null): Node | string | null {
    // Before the nodes of `movers`, so that a shadow map is drawn with the casters of the same frame.
    (builder as Builder).addSequentialNode(this);
    return super.build(builder, output);
  }

  /** For three: the shadow's node in a material. */
  override setup(builder: NodeBuilder): Node {
    const { context, material } = builder as Builder;
    // A flat normal faces the camera as it is.
    const isFlat = (builder as Builder).isFlatShading?.() ?? material.flatShading;
    const normal = TSL.normalWorldGeometry;
    const baked = this.#nodes.visibility(builder, {
      pWorld: material.receivedShadowPositionNode ?? context.shadowPositionWorld ?? TSL.positionWorld,
      normal: material.side === FrontSide || isFlat === true ? normal : normal.mul(TSL.faceDirection),
      pixel: TSL.screenCoordinate,
    });
    const intensity = TSL.reference('intensity', 'float', this.#sun.shadow).setGroup(TSL.renderGroup) as Node<'float'>;
    const lit = TSL.mix(1, baked, intensity);
    const shadowed = (material.receivedShadowNode?.(lit) ?? lit) as Node<'float'>;
    // Three's shadow nodes have done the same with the shadows of movers.
    return this.#movers === null ? shadowed : shadowed.min(this.#movers as Node<'float'>);
  }

  /** For three: follows the light before a frame. */
  override updateBefore({ renderer }: NodeFrame): undefined {
    if (this.#isDisposed) return;
    this.#update();
    // Three binds the textures of an object that stays as it is only once, so it would not see the change of one.
    renderer?.initTexture(this.#textures.headers);
  }

  /** Frees what the GPU holds, gives casters their shadows back, and leaves the light. */
  override dispose(): void {
    if (this.#isDisposed) return;
    // Three drops the shadow of a light that does not cast while it builds a material. The light may cast again.
    if (TSL.getCurrentStack() !== null) {
      this.#statics.rest(false);
      return;
    }
    this.#isDisposed = true;
    this.#statics.release();
    this.#textures.dispose();
    this.#movers?.dispose();
    super.dispose();
    if (this.#sun.shadow.shadowNode === this) delete this.#sun.shadow.shadowNode;
    // Three's node of the light drops the shadow then, and has materials built anew.
    this.#sun.dispatchEvent({ type: 'dispose' });
  }

  #update(): void {
    const count = this.#textures.use(towardsLight(this.#sun, this.#direction));
    this.#statics.rest(count > 0);
  }
}
