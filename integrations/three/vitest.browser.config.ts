// Tests that draw in a browser: `npm run test:browser`, and `npm run test:truth` for those that the machine's
// OpenGL draws. They use what `npm run build` has made.

import { defineConfig } from 'vitest/config';

export default defineConfig({
  test: {
    include: ['tests/browser/*.test.ts'],
    fileParallelism: false,
    testTimeout: 300_000,
    hookTimeout: 300_000,
  },
});
