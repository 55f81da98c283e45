// Tests that draw in a browser; `npm run test:browser`, and `npm run test:views` for those of whole scenes and of the demo.
// They use what `npm run build` has made.

import { defineConfig } from 'vitest/config';

export default defineConfig({
  test: {
    include: process.env['ADUMBRA_VIEWS'] === undefined ? ['tests/browser/{points,scene}.test.ts'] : ['tests/browser/{truth,demo}.test.ts'],
    fileParallelism: false,
    testTimeout: 300_000,
    hookTimeout: 300_000,
  },
});
