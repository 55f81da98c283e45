// The guides show the page that their commands build, and examples that are tested.

import { readFileSync } from 'node:fs';

import { expect, test } from 'vitest';

const read = (path: string): string => readFileSync(new URL(path, import.meta.url), 'utf8');

test.each([
  ['use-it-on-a-web-page', 'ts', 'first-page.ts'],
  ['use-it-on-a-web-page', 'tsx', 'react-three-fiber.tsx'],
  ['use-it-on-a-web-page', 'tsx', 'react-three-fiber-webgl.tsx'],
  ['a-day-of-suns', 'ts', 'day.ts'],
])('the guide %s has, as %s, %s word for word', (topic, language, name) => {
  const guide = read(`../../../../docs/guides/${topic}.md`);
  expect(guide).toContain(`\`\`\`${language}\n${read(`../../examples/${name}`)}\`\`\``);
});
