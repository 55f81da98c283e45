// Makes what the page shows: the city, its shadows, and the truth of one view by rays. The program `adumbra` does it
// all, in seconds; `ADUMBRA_BIN` says where it is, if not in the path.

import { spawnSync } from 'node:child_process';
import { mkdirSync, renameSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { fileURLToPath } from 'node:url';

const SUN = [0.5, 0.8, 0.35];
const COLUMNS = 16384;
const VIEW = { eye: [-150, 38, 175], target: [-75, 4, 75], fov: 45, width: 480, height: 270 };

const folder = fileURLToPath(new URL('public', import.meta.url));
const program = process.env.ADUMBRA_BIN ?? 'adumbra';

/** Runs the program. The output has its name only once it is complete. */
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
