import { test } from 'vitest';
import { mkdtempSync, symlinkSync, writeFileSync, existsSync } from 'node:fs';
import { execFileSync } from 'node:child_process';
import { Npz } from './npz.js';
import { Stage, VERSIONS } from './stage.js';
test('x', async () => {
  const folder = mkdtempSync('/tmp/dbg-'); symlinkSync('/work/shared/scenes', folder + '/scenes');
  const stage = await Stage.start(folder);
  for (const [name, ext] of [['kaykit_city_21','glb'],['alpine-2','glb'],['zdm2','glb']] as const) {
    const { page } = await stage.open(VERSIONS['0.187.0'], 'truth.js');
    const truth = new Npz(`/work/shared/truth/${name}.npz`); const camera = truth.camera();
    const f = `/tmp/${name}.adumbra`;
    if (!existsSync(f)) execFileSync(process.env['ADUMBRA_BIN']!, ['bake', `/work/shared/scenes/${name}.${ext}`, '--resolution','16384','--sun',camera.sun.join(','),'--ignore-alpha','-o',f],{stdio:'pipe'});
    symlinkSync(f, `${folder}/${name}.adumbra`);
    const text = await page.evaluate((a) => (window as any).draw(a), { backend: 'webgl', scene: `/files/scenes/${name}.${ext}`, file: `/files/${name}.adumbra`, eye: camera.eye, target: camera.target, fov: camera.fov_y });
    writeFileSync(`/tmp/drawn_${name}.f32`, Buffer.from(text, 'base64'));
  }
  await stage.stop();
});
