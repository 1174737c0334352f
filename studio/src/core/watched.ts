/** The trained run to watch: that of the folder, then whichever was trained last. */

import type { RunAbout } from "./protocol";

export interface Watched {
  current(): RunAbout | null;
  show(about: RunAbout): void;
  watch(watcher: (about: RunAbout | null) => void): void;
}

export function createWatched(first: RunAbout | null): Watched {
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
