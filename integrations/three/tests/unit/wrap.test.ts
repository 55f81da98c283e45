// Wrappers of methods, in whatever order they are removed and the app sets other methods.

import { expect, test } from 'vitest';

import { wrap } from '../../src/light/wrap.js';

/** An object with a method in its prototype, whose calls are listed. */
function subject() {
  const calls: string[] = [];
  class Subject {
    run(): void {
      calls.push('own');
    }
  }
  const object = new Subject();
  const add = (name: string) => wrap(object, 'run', (theirs: () => void) => () => {
    calls.push(name);
    theirs.call(object);
  });
  const run = (): string => {
    calls.length = 0;
    object.run();
    return calls.join();
  };
  return { object, calls, add, run };
}

test.each([['first', 'second'], ['second', 'first']])('the %s wrapper may be removed before the %s', (early, late) => {
  const { object, add, run } = subject();
  const added = { first: add('first'), second: add('second') } as Record<string, ReturnType<typeof add>>;
  expect(run()).toBe('second,first,own');
  added[early]!.remove();
  expect(run()).toContain(late);
  added[late]!.remove();
  expect([run(), Object.hasOwn(object, 'run')]).toEqual(['own', false]);
});

test('a method that the app sets is called, and stays', () => {
  const { object, calls, add, run } = subject();
  const added = add('ours');
  const before = object.run;
  const later = (): void => void calls.push('later');
  object.run = later;
  expect([run(), added.theirs()]).toEqual(['ours,later', later]);
  // Set back to the method that was read.
  object.run = before;
  expect(run()).toBe('ours,own');
  object.run = () => {
    calls.push('chain');
    before();
  };
  expect(run()).toBe('ours,chain,ours,own');
  object.run = later;
  added.remove();
  expect([run(), object.run]).toEqual(['later', later]);
});
