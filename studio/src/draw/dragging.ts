/** What is taken up on a board with the mouse or a finger, and led from cell to cell. */

import type { Cell } from "../core/protocol";
import type { Board } from "./board";

/** What is in hand. */
export interface Hold {
  /** What it is, by which the pointer's look goes. */
  readonly kind: "thing" | "wall" | "sight";
  /** It has come along these cells, at first to that where it was taken up. */
  move(path: Cell[]): void;
  /** It was let go off the board, if that means something. */
  off?(): void;
  /** It is in hand no longer. */
  drop?(): void;
}

/**
 * Lets a board be dragged upon. `take` gives what a press in a cell takes up, if anything; `over` is
 * told where an empty hand points, and says what is there.
 */
export function letDrag(
  { picture, cellAt }: Board,
  take: (cell: Cell) => Hold | null,
  over: (cell: Cell) => string,
): void {
  let hand: Hold | null = null;
  let last: Cell = [0, 0];
  let outside = false;
  picture.addEventListener("pointerdown", (event) => {
    const cell = cellAt(event);
    hand = cell !== null && event.button === 0 ? take(cell) : null;
    if (cell === null || hand === null) return;
    picture.setPointerCapture(event.pointerId);
    picture.dataset.hand = hand.kind;
    [last, outside] = [cell, false];
    hand.move([cell]);
  });
  picture.addEventListener("pointermove", (event) => {
    const cell = cellAt(event);
    outside = cell === null && hand?.off !== undefined;
    picture.dataset.off = String(outside);
    if (cell === null) return;
    if (hand === null) {
      picture.dataset.over = over(cell);
      return;
    }
    hand.move(between(last, cell));
    last = cell;
  });
  for (const end of ["pointerup", "pointercancel"]) {
    picture.addEventListener(end, () => {
      const held = hand;
      hand = null;
      delete picture.dataset.hand;
      picture.dataset.off = "false";
      if (end === "pointerup" && outside) held?.off?.();
      held?.drop?.();
    });
  }
}

/** The cells of a line, so that a fast drag leaves no gaps. */
function between(from: Cell, to: Cell): Cell[] {
  const steps = Math.max(Math.abs(to[0] - from[0]), Math.abs(to[1] - from[1]), 1);
  return Array.from({ length: steps + 1 }, (_, k) => [
    Math.round(from[0] + ((to[0] - from[0]) * k) / steps),
    Math.round(from[1] + ((to[1] - from[1]) * k) / steps),
  ]);
}
