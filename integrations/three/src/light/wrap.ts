// Methods of the app's objects that the package adds something to, whatever the app sets there before or afterwards.

/** A method that something was added to. */
export interface Wrapped<F> {
  /** What the app set last. */
  theirs(): F;
  /** Whether it goes on. Whoever deletes the property, as three's addon CSM does, ends it. */
  isInPlace(): boolean;
  /** Ends it. The object then has what the app last set. */
  remove(): void;
}

/** What is called in place of a method, with that method and whether that has ended. */
const wrappers = new WeakMap<object, { readonly theirs: object; readonly use: { isOver: boolean } }>();

/**
 * Adds something to a method of an object. `wrapper` returns what is called in place of a method of the app; it must do no harm
 * if it is called twice, because a later method of the app may call an earlier one.
 */
export function wrap<T extends object, K extends keyof T, F extends T[K] & object>(object: T, name: K, wrapper: (theirs: F) => F): Wrapped<F> {
  const use = { isOver: false };
  let now: F;
  const set = (value: F): void => {
    now = value;
    if (wrappers.get(value)?.use === use) return;
    now = wrapper(value);
    wrappers.set(now, { theirs: value, use });
  };
  const get = (): F => now;
  const { enumerable = false } = Object.getOwnPropertyDescriptor(object, name) ?? {};
  set(object[name] as F);
  Object.defineProperty(object, name, { get, set, configurable: true, enumerable });
  return {
    theirs: () => wrappers.get(now)!.theirs as F,
    isInPlace: () => Object.getOwnPropertyDescriptor(object, name)?.get === get,
    remove() {
      use.isOver = true;
      const top = object[name] as object;
      let value = top;
      for (let outer = wrappers.get(value); outer?.use.isOver === true; outer = wrappers.get(value)) value = outer.theirs;
      // Otherwise somebody has added more since, and goes on with what does nothing any more.
      if (value === top) return;
      delete object[name];
      if (object[name] !== value) object[name] = value as F;
    },
  };
}
