/** Things on a board that are taken up and put elsewhere with the mouse. */

import type { Cell } from "../core/protocol";
import type { Standing } from "../core/world";
import type { Board } from "./board";
import { same } from "./cells";
import type { Stood } from "./things";

/**
 * Lets things be dragged, bins not. `shown` is where they are; `move` is told of every cell that a thing in hand comes to, `drop` when it is let go.
 */
export function letDrag(
  { picture, cellAt }: Board,
  shown: () => readonly Stood[],
  move: (thing: Standing, cell: Cell) => void,
  drop: () => void,
): void {
  let hand: Standing | null = null;
  const under = (event: PointerEvent): Standing | null => {
    const cell = cellAt(event);
    const there = shown().find((one) => cell && same(one.cell, cell) && one.thing.what !== "goal");
    return there?.thing ?? null;
  };
  picture.addEventListener("pointerdown", (event) => {
    hand = event.button === 0 ? under(event) : null;
    if (hand === null) return;
    picture.setPointerCapture(event.pointerId);
    picture.dataset.hand = "thing";
  });
  picture.addEventListener("pointermove", (event) => {
    const cell = cellAt(event);
    if (hand === null) picture.dataset.over = under(event) ? "thing" : "";
    else if (cell) move(hand, cell);
  });
  for (const end of ["pointerup", "pointercancel"]) {
    picture.addEventListener(end, () => {
      if (hand === null) return;
      hand = null;
      delete picture.dataset.hand;
      drop();
    });
  }
}
