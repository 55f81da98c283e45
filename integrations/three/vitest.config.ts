// Unit tests run in Node; `npm test`.

import { defineConfig } from 'vitest/config';

export default defineConfig({
  test: { include: ['tests/unit/**/*.test.ts'], maxWorkers: '100%', testTimeout: 120_000, hookTimeout: 300_000 },
});
