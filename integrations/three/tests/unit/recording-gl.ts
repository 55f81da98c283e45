// A WebGL2 context that draws nothing and records what three compiles, uploads and draws, so that three's own
// renderers run in Node.

/** A program, and the texture unit of each of its samplers. */
export interface Program {
  fragment: string;
  readonly units: Map<string, number>;
}

/** A drawing: the number of indices, and the last upload to each texture of integers that its program has. */
export interface Draw {
  readonly program: Program;
  readonly count: number;
  readonly uploads: Readonly<Record<string, unknown>>;
}

interface Shader {
  readonly type: number;
  text: string;
}

interface Texture {
  upload?: unknown;
}

interface Location {
  readonly program: Program;
  readonly name: string;
}

/** Three looks this type up by its number. The other constants only have to differ. */
const UNSIGNED_INT_SAMPLER_2D = 0x8dd2;

/**
 * Returns a function that numbers constants by their names. It leaves gaps, because three adds to some of
 * them, such as TEXTURE0.
 */
function constants(): (name: string) => number {
  const numbers = new Map<string, number>();
  return (name) => {
    if (!numbers.has(name)) numbers.set(name, 0x10000 + 64 * numbers.size);
    return numbers.get(name)!;
  };
}

/** The names of a program's textures of integers. */
function samplersOf({ fragment }: Program): string[] {
  return [...fragment.matchAll(/uniform (?:highp )?usampler2D (\w+);/g)].map((found) => found[1]!);
}

/** Returns a canvas, its context, and what the context records. */
export function recordingCanvas() {
  const programs: Program[] = [];
  const draws: Draw[] = [];
  const canvas = { width: 300, height: 150, addEventListener: () => undefined, removeEventListener: () => undefined };
  const constant = constants();
  const textures: (Texture | null)[] = [];
  let program: Program;
  let unit = 0;

  const methods: Record<string, (...all: never[]) => unknown> = {
    getContextAttributes: () => ({}),
    getExtension: (name: string) => (name === 'KHR_parallel_shader_compile' ? {} : null),
    getSupportedExtensions: () => [],
    getParameter: (name: number) => (name === constant('VERSION') ? 'WebGL 2.0' : 8192),
    getShaderPrecisionFormat: () => ({ precision: 23 }),
    createShader: (type: number): Shader => ({ type, text: '' }),
    shaderSource: (shader: Shader, text: string) => (shader.text = text),
    getShaderInfoLog: () => '',
    createProgram: () => {
      const made: Program = { fragment: '', units: new Map() };
      programs.push(made);
      return made;
    },
    attachShader: (to: Program, { type, text }: Shader) => {
      if (type === constant('FRAGMENT_SHADER')) to.fragment = text;
    },
    getProgramParameter: (of: Program, name: number) => {
      if (name === constant('ACTIVE_UNIFORMS')) return samplersOf(of).length;
      return name === constant('ACTIVE_ATTRIBUTES') ? 0 : true;
    },
    getProgramInfoLog: () => '',
    getActiveUniform: (of: Program, index: number) => ({ name: samplersOf(of)[index], size: 1, type: UNSIGNED_INT_SAMPLER_2D }),
    getUniformLocation: (of: Program, name: string): Location => ({ program: of, name }),
    uniform1i: ({ program: of, name }: Location, value: number) => of.units.set(name, value),
    useProgram: (next: Program) => (program = next),
    activeTexture: (name: number) => (unit = name - constant('TEXTURE0')),
    bindTexture: (_target: number, texture: Texture | null) => (textures[unit] = texture),
    texSubImage2D: (...all: unknown[]) => (textures[unit]!.upload = all.at(-1)),
    drawElements: (_mode: number, count: number) => {
      const uploads = samplersOf(program).map((name) => [name, textures[program.units.get(name) ?? -1]?.upload] as const);
      draws.push({ program, count, uploads: Object.fromEntries(uploads) });
    },
  };

  const context = new Proxy({ canvas, ...methods } as Record<string | symbol, unknown>, {
    get(target, name) {
      if (name in target) return target[name];
      if (typeof name === 'symbol') return undefined;
      if (/^[A-Z0-9_]+$/.test(name)) return constant(name);
      // Other members do nothing.
      return name.startsWith('create') ? () => ({}) : () => undefined;
    },
  });
  return { canvas, context, programs, draws };
}
