/** The current scene with its undo and redo history, and its observers. */

import type { Scene } from "./scene";

export interface Store {
  scene(): Scene;
  /** Shows another scene. Changes within one gesture, such as a drag, are undone together. */
  show(next: Scene, gesture?: string): void;
  change(part: Partial<Scene>, gesture?: string): void;
  undo(): void;
  redo(): void;
  canUndo(): boolean;
  canRedo(): boolean;
  /** Calls back now, and after every change. */
  watch(watcher: (scene: Scene, before: Scene | null) => void): void;
}

const REMEMBERED = 300;

export function createStore(first: Scene): Store {
  let current = first;
  let past: Scene[] = [];
  let future: Scene[] = [];
  let lastGesture: string | undefined;
  const watchers: ((scene: Scene, before: Scene | null) => void)[] = [];

  function turnTo(next: Scene): void {
    const before = current;
    current = next;
    for (const watcher of watchers) watcher(current, before);
  }

  function show(next: Scene, gesture?: string): void {
    if (next === current) return;
    if (gesture === undefined || gesture !== lastGesture) {
      past = [...past.slice(1 - REMEMBERED), current];
    }
    lastGesture = gesture;
    future = [];
    turnTo(next);
  }

  return {
    scene: () => current,
    show,
    change: (part, gesture) => show({ ...current, ...part }, gesture),
    undo() {
      const before = past.pop();
      if (before === undefined) return;
      future.push(current);
      lastGesture = undefined;
      turnTo(before);
    },
    redo() {
      const after = future.pop();
      if (after === undefined) return;
      past.push(current);
      lastGesture = undefined;
      turnTo(after);
    },
    canUndo: () => past.length > 0,
    canRedo: () => future.length > 0,
    watch(watcher) {
      watchers.push(watcher);
      watcher(current, null);
    },
  };
}
