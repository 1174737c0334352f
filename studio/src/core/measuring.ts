/** Requests the landscape and the averages of the current scene; the newest request wins. */

import type { Asked, Connection } from "./connection";
import type { Grid, Verdict } from "./protocol";
import { message, type Scene } from "./scene";
import type { Store } from "./store";

export interface Measured {
  /** The scene of the values; null before the first. */
  scene: Scene | null;
  landscape: Grid | null;
  least: number;
  most: number;
  /** By how much a value may be too low at most. */
  gap: number;
  averages: Record<string, number | null>;
  within: Record<string, number>;
  /** The reason for a missing average. */
  why: string | null;
  verdicts: Record<string, Verdict>;
  /** The tools whose averages belong to this scene; the others' belong to the previous one. */
  compared: readonly string[];
  /** Whether values are still being computed; and the progress, from 0 to 1. */
  pending: boolean;
  progress: number | null;
  error: string | null;
}

export interface Measuring {
  latest(): Measured;
  watch(watcher: (measured: Measured) => void): void;
  /** Repeats the request after the connection was lost. */
  again(): void;
}

const NOTHING: Measured = {
  scene: null,
  landscape: null,
  least: 0,
  most: 0,
  gap: 0,
  averages: {},
  within: {},
  why: null,
  verdicts: {},
  compared: [],
  pending: true,
  progress: null,
  error: null,
};

export function createMeasuring(connection: Connection, store: Store): Measuring {
  let measured = NOTHING;
  let asked: Asked | null = null;
  let due = false;
  const watchers: ((measured: Measured) => void)[] = [];

  function tell(next: Partial<Measured>): void {
    measured = { ...measured, ...next };
    for (const watcher of watchers) watcher(measured);
  }

  function ask(): void {
    due = false;
    const scene = store.scene();
    asked = connection.ask("measure", { scene: message(scene) }, (answer) => {
      if (answer.lost) return; // keep the old values until the next request
      if (answer.error !== undefined) {
        tell({ ...NOTHING, error: answer.error, pending: false, scene });
      } else if (answer.progress !== undefined) tell({ progress: answer.progress });
      if (answer.landscape) {
        const [least, most] = [answer.least ?? 0, answer.most ?? 0];
        tell({ scene, landscape: answer.landscape, least, most, gap: answer.gap ?? 0, pending: false, progress: null, error: null });
      }
      if (answer.averages) {
        tell({
          averages: { ...measured.averages, ...answer.averages },
          within: { ...measured.within, ...answer.within },
          verdicts: { ...measured.verdicts, ...answer.verdicts },
          why: answer.why ?? measured.why,
          compared: [...new Set([...measured.compared, ...Object.keys(answer.averages)])],
        });
      }
    });
  }

  /** Marks the values as outdated. Sends at most one request per frame: dragging fires more events than that. */
  function soon(): void {
    tell({ pending: true, progress: null, compared: [], why: null });
    if (due) return;
    due = true;
    asked?.forget();
    requestAnimationFrame(ask);
  }

  store.watch(soon);
  return {
    latest: () => measured,
    watch(watcher) {
      watchers.push(watcher);
      watcher(measured);
    },
    again: soon,
  };
}
