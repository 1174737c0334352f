/** A game from the map's start: actions are sent to the server one after the other. */

import type { App } from "../core/app";
import type { Placement } from "../core/protocol";
import { message, startOf, type Scene } from "../core/scene";

export interface Game {
  placement: Placement;
  /** The placements from the start to the current one. */
  path: Placement[];
  /** At the start and after every step; null while unknown. */
  bits: (number | null)[];
  equipped: boolean;
  attached: boolean;
  ended: boolean;
  error: string | null;
}

export interface Player {
  game(): Game;
  act(action: number): void;
  reset(): void;
  /** Plays a shortest plan from here; calls `onPlan` with null if there is none. */
  showPlan(onPlan: (steps: number | null) => void): void;
  showing(): boolean;
  /** The placements of a shortest plan from here. */
  plan(): Promise<Placement[]>;
  stop(): void;
  /** Whether the view is visible; only then are the bits of the start requested. */
  seen(seen: boolean): void;
}

const WAITING = 6; // actions queued while the server is busy
const PACE = 320; // milliseconds a step of the plan takes

export function createPlayer({ connection, store }: App, onChange: () => void): Player {
  let game = fresh(store.scene());
  let queue: number[] = [];
  let busy = false;
  let turn = 0; // counts games: answers to an earlier one are ignored
  let plan: number[] | null = null;
  let timer = 0;
  let looking = false;

  function fresh(scene: Scene): Game {
    const start = startOf(scene);
    return {
      placement: start,
      path: [start],
      bits: [null],
      equipped: false,
      attached: false,
      ended: false,
      error: null,
    };
  }

  function reset(): void {
    turn += 1;
    [queue, busy] = [[], false];
    stop();
    game = fresh(store.scene());
    if (looking) askStart();
    onChange();
  }

  /** The scene and placement of a request. */
  function asking() {
    return { scene: message(store.scene()), placement: game.placement };
  }

  function askStart(): void {
    const of = turn;
    const body = { ...asking(), action: null };
    const asked = connection.ask("step", body, (answer) => {
      if (of !== turn || answer.progress !== undefined || answer.lost) return;
      asked.forget();
      game = {
        ...game,
        placement: game.bits.length > 1 ? game.placement : (answer.placement ?? game.placement),
        path: answer.placement ? game.path.with(0, answer.placement) : game.path,
        bits: game.bits.with(0, answer.bits ?? null),
        equipped: game.bits.length > 1 ? game.equipped : (answer.equipped ?? false),
        attached: game.bits.length > 1 ? game.attached : (answer.attached ?? false),
        error: answer.error ?? game.error,
      };
      onChange();
    });
  }

  function next(): void {
    if (busy || game.ended) return;
    const action = queue.shift();
    if (action === undefined) return;
    busy = true;
    const of = turn;
    const body = { ...asking(), action };
    const asked = connection.ask("step", body, (answer) => {
      if (of !== turn) return;
      if (answer.progress !== undefined) return;
      asked.forget();
      busy = false;
      if (answer.error !== undefined) {
        stop();
        queue = [];
        if (!answer.lost) game = { ...game, error: answer.error };
      } else {
        game = {
          placement: answer.placement ?? game.placement,
          path: [...game.path, answer.placement ?? game.placement],
          bits: [...game.bits, answer.bits ?? null],
          equipped: answer.equipped ?? false,
          attached: answer.attached ?? false,
          ended: answer.ended ?? false,
          error: null,
        };
      }
      onChange();
      next();
    });
  }

  function act(action: number): void {
    if (game.ended || queue.length >= WAITING) return;
    queue.push(action);
    next();
  }

  function stop(): void {
    plan = null;
    clearTimeout(timer);
  }

  function showPlan(onPlan: (steps: number | null) => void): void {
    if (game.ended) reset();
    const of = turn;
    const asked = connection.ask("solve", asking(), (answer) => {
      if (of !== turn || answer.progress !== undefined) return;
      asked.forget();
      if (answer.error !== undefined || answer.steps === null) {
        stop();
        if (answer.error !== undefined && !answer.lost) game = { ...game, error: answer.error };
        onChange();
        if (answer.error === undefined) onPlan(null);
        return;
      }
      onPlan(answer.steps ?? null);
      plan = [...(answer.actions ?? [])];
      follow();
    });
    plan = [];
  }

  /** Plays the plan's next step, once the server has answered the previous one. */
  function follow(): void {
    if (busy) {
      timer = window.setTimeout(follow, PACE);
      return;
    }
    const action = plan?.shift();
    if (action === undefined) {
      stop();
      return onChange();
    }
    act(action);
    timer = window.setTimeout(follow, PACE);
  }

  function planned(): Promise<Placement[]> {
    return new Promise((resolve, reject) => {
      const asked = connection.ask("solve", asking(), ({ progress, placements, error }) => {
        if (progress !== undefined) return;
        asked.forget();
        if (placements) resolve(placements);
        else reject(new Error(error ?? "The goal is unreachable from here."));
      });
    });
  }

  store.watch((_, before) => before && reset());
  return {
    game: () => game,
    act(action) {
      if (plan !== null) stop();
      act(action);
    },
    reset,
    showPlan,
    plan: planned,
    showing: () => plan !== null,
    stop,
    seen(seen) {
      looking = seen;
      if (!seen) stop();
      else if (game.bits[0] === null) askStart();
    },
  };
}
