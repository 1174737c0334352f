/** The trained run to watch: that of the folder, then whichever was trained last. */

import type { RunAbout } from "./protocol";

export interface Watchable extends RunAbout {
  /** The name to request it by; absent for the folder's own run. */
  readonly asked?: string;
}

export interface Watched {
  current(): Watchable | null;
  show(about: Watchable): void;
  watch(watcher: (about: Watchable | null) => void): void;
}

export function createWatched(first: Watchable | null): Watched {
  let about = first;
  const watchers: ((about: Watchable | null) => void)[] = [];
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
