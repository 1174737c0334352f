/** A game on the board: actions are sent to the server one after the other. */

import type { App } from "../core/app";
import type { BoardAbout, Placement } from "../core/protocol";
import type { Question } from "./question";

export interface BoardGame {
  readonly placement: Placement;
  /** The placements from the start to the current one. */
  readonly path: readonly Placement[];
  readonly image: string | null;
  /** At the start and after every step; null while unknown. */
  readonly bits: readonly (number | null)[];
  readonly total: number;
  readonly ended: boolean;
  readonly error: string | null;
}

export interface BoardPlayer {
  game(): BoardGame;
  act(action: number): void;
  reset(): void;
  /** Plays a shortest plan from here; calls `onPlan` with null if there is none. */
  showPlan(onPlan: (steps: number | null) => void): void;
  showing(): boolean;
  stop(): void;
  seen(seen: boolean): void;
}

const WAITING = 6; // actions queued while the server is busy
const PACE = 320; // milliseconds a step of the plan takes

export function createBoardPlayer(
  { connection }: App, board: BoardAbout, question: Question, onChange: () => void,
): BoardPlayer {
  let game = fresh();
  let queue: number[] = [];
  let busy = false;
  let turn = 0; // counts games: answers to an earlier one are ignored
  let plan: number[] | null = null;
  let timer = 0;
  let looking = false;

  function fresh(): BoardGame {
    return { placement: board.start, path: [board.start], image: board.image, bits: [null], total: 0, ended: false, error: null };
  }

  function reset(): void {
    turn += 1;
    [queue, busy] = [[], false];
    stop();
    game = fresh();
    if (looking) send(null);
    onChange();
  }

  /** Takes an action; null asks for the bits of the start. */
  function send(action: number | null): void {
    const of = turn;
    busy = true;
    const body = { scene: question.message(), placement: game.placement, action };
    const asked = connection.ask("step", body, (answer) => {
      if (of !== turn || answer.progress !== undefined) return;
      asked.forget();
      busy = false;
      if (answer.error !== undefined) {
        stop();
        queue = [];
        if (!answer.lost) game = { ...game, error: answer.error };
      } else {
        const bits = answer.bits ?? null;
        const placement = answer.placement ?? game.placement;
        game = {
          placement,
          path: action === null ? game.path : [...game.path, placement],
          image: answer.image ?? game.image,
          bits: action === null ? game.bits.with(-1, bits) : [...game.bits, bits],
          total: game.total + (answer.reward ?? 0),
          ended: answer.ended ?? false,
          error: null,
        };
      }
      onChange();
      next();
    });
  }

  function next(): void {
    if (busy || game.ended) return;
    const action = queue.shift();
    if (action !== undefined) send(action);
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
    plan = [];
    const body = { scene: question.message(), placement: game.placement };
    const asked = connection.ask("solve", body, (answer) => {
      if (of !== turn || plan === null || answer.progress !== undefined) return;
      asked.forget();
      if (answer.error !== undefined || answer.steps === null) {
        stop();
        if (answer.error !== undefined && !answer.lost) game = { ...game, error: answer.error };
        if (answer.error === undefined) onPlan(null);
        return onChange();
      }
      onPlan(answer.steps ?? null);
      plan = [...(answer.actions ?? [])];
      follow();
    });
  }

  /** Plays the plan's next step, once the server has answered the previous one. */
  function follow(): void {
    if (!busy) {
      const action = plan?.shift();
      if (action === undefined) {
        stop();
        return onChange();
      }
      act(action);
    }
    timer = window.setTimeout(follow, PACE);
  }

  question.watch(() => {
    // Of another question, the bits so far would be of another kind.
    game = { ...game, bits: [null] };
    if (looking && !busy) send(null);
  });
  return {
    game: () => game,
    act(action) {
      if (plan !== null) stop();
      act(action);
    },
    reset,
    showPlan,
    showing: () => plan !== null,
    stop,
    seen(seen) {
      looking = seen;
      if (!seen) stop();
      else if (game.bits.at(-1) === null && !busy) send(null);
    },
  };
}
