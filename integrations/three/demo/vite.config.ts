// The demo pages as a folder of files that any static server can show, below any path.

import { fileURLToPath } from 'node:url';

import { defineConfig } from 'vite';

const inFolder = (path: string): string => fileURLToPath(new URL(path, import.meta.url));

export default defineConfig({
  root: inFolder('.'),
  base: './',
  build: {
    target: 'es2022',
    chunkSizeWarningLimit: 1000,
    rolldownOptions: { input: ['index.html', 'metropolis.html'].map(inFolder) },
  },
  worker: { format: 'es' },
  resolve: {
    alias: [
      { find: /^adumbra-three\/(.*)$/, replacement: `${inFolder('../src')}/$1/index.ts` },
      { find: /^adumbra-three$/, replacement: inFolder('../src/index.ts') },
    ],
  },
});
