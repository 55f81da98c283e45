// The guide shows the page that its commands build, and the example that is tested.

import { readFileSync } from 'node:fs';

import { expect, test } from 'vitest';

const read = (path: string): string => readFileSync(new URL(path, import.meta.url), 'utf8');

test.each([['ts', 'first-page.ts'], ['tsx', 'react-three-fiber.tsx']])('the guide has, as %s, %s word for word', (language, name) => {
  const guide = read('../../../../docs/guides/use-it-on-a-web-page.md');
  expect(guide).toContain(`\`\`\`${language}\n${read(`../../examples/${name}`)}\`\`\``);
});
