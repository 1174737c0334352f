/** Dragging on a board, with the mouse or a finger, from cell to cell. */

import type { Cell } from "../core/protocol";
import type { Board } from "./board";

/** A drag in progress. */
export interface Hold {
  /** What is dragged, which determines the pointer's look. */
  readonly kind: "thing" | "wall" | "sight";
  /** It has moved through these cells; the first call has the starting cell. */
  move(path: Cell[]): void;
  /** It was dropped outside the board, if that has a meaning. */
  off?(): void;
  /** The drag has ended. */
  drop?(): void;
}

/**
 * Adds dragging to a board. `take` returns what a press in a cell picks up, if anything; `over` gets
 * the cell under the pointer while nothing is dragged, and returns what is there.
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

/** The cells of a line, so that fast drags leave no gaps. */
function between(from: Cell, to: Cell): Cell[] {
  const steps = Math.max(Math.abs(to[0] - from[0]), Math.abs(to[1] - from[1]), 1);
  return Array.from({ length: steps + 1 }, (_, k) => [
    Math.round(from[0] + ((to[0] - from[0]) * k) / steps),
    Math.round(from[1] + ((to[1] - from[1]) * k) / steps),
  ]);
}
