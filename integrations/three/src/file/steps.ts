// Work in steps, so that a page can do other things in between.

/** Work that is done in steps, each of them short, and its result. */
export type Steps<T> = Generator<void, T, void>;

/** Does all steps at once. */
export function run<T>(steps: Steps<T>): T {
  let step = steps.next();
  while (step.done !== true) step = steps.next();
  return step.value;
}

/**
 * Does steps in slices of about ten milliseconds, and lets the event loop go on before each. The promise
 * rejects with the reason of `signal`, once it aborts. `now` returns the time in milliseconds.
 */
export async function runInSlices<T>(steps: Steps<T>, signal?: AbortSignal, now: () => number = () => performance.now()): Promise<T> {
  /** Milliseconds of a slice. */
  const SLICE = 10;
  for (;;) {
    await nextTask();
    const end = now() + SLICE;
    do {
      signal?.throwIfAborted();
      const step = steps.next();
      if (step.done === true) return step.value;
    } while (now() < end);
  }
}

/**
 * Waits for another task of the event loop. Unlike timers, messages are not throttled in a page in the
 * background.
 */
function nextTask(): Promise<void> {
  return new Promise((resolve) => {
    const { port1, port2 } = new MessageChannel();
    port1.onmessage = () => {
      port1.close();
      resolve();
    };
    port2.postMessage(null);
  });
}
