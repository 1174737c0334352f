/** Remembered by the browser over a reload: what this page trains, and which failures were dismissed. */

const TRAINING = "habilis-training";
const GONE = "habilis-dismissed";
const MOST = 500; // names of dismissed trainings

/** The name of the training of this page that is under way. */
export const UNDER_WAY = {
  get: (): string | null => read(() => sessionStorage.getItem(TRAINING)),
  set(name: string | null): void {
    read(() => {
      if (name === null) sessionStorage.removeItem(TRAINING);
      else sessionStorage.setItem(TRAINING, name);
      return null;
    });
  },
};

/** The names of dismissed trainings. */
export const DISMISSED = {
  has: (name: string): boolean => names().includes(name),
  add(name: string): void {
    const all = JSON.stringify([...names(), name].slice(-MOST));
    read(() => (localStorage.setItem(GONE, all), null));
  },
};

function names(): string[] {
  const kept: unknown = read(() => JSON.parse(localStorage.getItem(GONE) ?? "[]"));
  return Array.isArray(kept) ? kept.filter((name) => typeof name === "string") : [];
}

/** What is stored; null where storage is disabled, or something else is stored. */
function read<Value>(from: () => Value): Value | null {
  try {
    return from();
  } catch {
    return null;
  }
}
