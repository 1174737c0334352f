/** Which trained run can be acted out: that of the folder, then whatever was trained last. */

import type { RunAbout } from "./protocol";

export interface Acted {
  current(): RunAbout | null;
  show(about: RunAbout): void;
  watch(watcher: (about: RunAbout | null) => void): void;
}

export function createActed(first: RunAbout | null): Acted {
  let about = first;
  const watchers: ((about: RunAbout | null) => void)[] = [];
  return {
    current: () => about,
    show(next) {
      about = next;
      for (const watcher of watchers) watcher(about);
    },
    watch(watcher) {
      watchers.push(watcher);
      watcher(about);
    },
  };
}
