// Makes the assets of the pages: the city, its shadows, the truth of one view by rays, and the shadows of
// 2 × 2 km. The program `adumbra` makes all of them. It takes seconds, except for the shadows of 2 × 2 km,
// which take about half a minute. Those are baked only if they are missing, so remove `demo/public` to bake
// them again. `ADUMBRA_BIN` is the path of the program, if it is not in `PATH`.

import { spawnSync } from 'node:child_process';
import { existsSync, mkdirSync, readFileSync, renameSync, rmSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { fileURLToPath } from 'node:url';

import { multiplied, places } from './metropolis-copies.mjs';

const SUN = [0.5, 0.8, 0.35];
const COLUMNS = 16384;
const METROPOLIS_COLUMNS = 65536;
const VIEW = { eye: [-150, 38, 175], target: [-75, 4, 75], fov: 45, width: 480, height: 270 };

const folder = fileURLToPath(new URL('public', import.meta.url));
const program = process.env.ADUMBRA_BIN ?? 'adumbra';

/** Runs the program. The output gets its final name only once it is complete. */
function make(name, ...args) {
  const output = join(folder, name);
  const unfinished = join(folder, `unfinished-${name}`);
  const { error, status } = spawnSync(program, [...args, '-o', unfinished], { stdio: ['ignore', 'ignore', 'inherit'] });
  if (error?.code === 'ENOENT') {
    fail(
      `the demo's city and shadows are made by the program ${JSON.stringify(program)}, which was not found.\n` +
        'Install it (cargo install --path crates/adumbra-cli), or say where it is: ADUMBRA_BIN=…/target/release/adumbra npm run demo',
    );
  }
  if (error !== undefined || status !== 0) fail(`${program} ${args[0]} failed: ${error?.message ?? `exit code ${status}`}`);
  renameSync(unfinished, output);
}

function fail(message) {
  console.error(message);
  process.exit(1);
}

mkdirSync(folder, { recursive: true });
const city = join(folder, 'city.glb');
const sun = SUN.join(',');
make('city.glb', 'generate', 'city');
make('city.adumbra', 'bake', city, '--sun', sun, '--resolution', String(COLUMNS), '--progress', 'none');
const { eye, target, fov, width, height } = VIEW;
make(
  'truth.png',
  ...['render', city, '--truth', '--layer', 'shadow', '--sun', sun, '--antialias', '1', '--size', `${width}x${height}`],
  ...[`--eye=${eye.join(',')}`, `--target=${target.join(',')}`, '--fov', String(fov)],
);
writeFileSync(join(folder, 'truth.json'), JSON.stringify({ ...VIEW, sun: SUN }));

writeFileSync(join(folder, 'metropolis.json'), JSON.stringify(places()));
if (!existsSync(join(folder, 'metropolis.adumbra'))) {
  const metropolis = join(folder, 'metropolis.glb');
  writeFileSync(metropolis, multiplied(readFileSync(city)));
  make('metropolis.adumbra', 'bake', metropolis, '--sun', sun, '--resolution', String(METROPOLIS_COLUMNS), '--progress', 'none');
  // Pages put the copies together themselves.
  rmSync(metropolis);
}
