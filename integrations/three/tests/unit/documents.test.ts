// The guide shows the page that its commands build.

import { readFileSync } from 'node:fs';

import { expect, test } from 'vitest';

const read = (path: string): string => readFileSync(new URL(path, import.meta.url), 'utf8');

test('the guide has the first page word for word', () => {
  const guide = read('../../../../docs/guides/use-it-on-a-web-page.md');
  expect(guide).toContain(`\`\`\`ts\n${read('../../examples/first-page.ts')}\`\`\``);
});
