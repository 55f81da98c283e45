// Wraps methods of the app's objects. The wrapper stays, whatever method the app sets before or afterwards.

/** A wrapped method. */
export interface Wrapped<F> {
  /** The method that the app set last. */
  theirs(): F;
  /** Whether the wrapper is in place. Deleting the property, as three's addon CSM does, removes it. */
  isInPlace(): boolean;
  /** Removes the wrapper. The object then has the method that the app set last. */
  remove(): void;
}

/**
 * The functions that are called in place of methods, each with its method and whether its wrapper was
 * removed.
 */
const wrappers = new WeakMap<object, { readonly theirs: object; readonly use: { isOver: boolean } }>();

/**
 * Wraps a method of an object. `wrapper` returns the function that is called in place of a method of the app.
 * The function must do no harm if it is called twice, because a later method of the app may call an earlier
 * one.
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
      // Stop if another wrapper was added later: it keeps calling this one, which does nothing any more.
      if (value === top) return;
      delete object[name];
      if (object[name] !== value) object[name] = value as F;
    },
  };
}
