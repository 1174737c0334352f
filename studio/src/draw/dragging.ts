/** Things on a board that are taken up and put elsewhere with the mouse. */

import type { Cell, Placement } from "../core/protocol";
import type { Board } from "./board";
import { same } from "./cells";

export type Dragged = keyof Placement;
const DRAGGED: readonly Dragged[] = ["agent", "tool", "object"];

/** What is in a cell, if it can be dragged. */
export function draggedAt(things: Partial<Placement>, cell: Cell): Dragged | null {
  return DRAGGED.find((thing) => things[thing] && same(things[thing], cell)) ?? null;
}

/**
 * Lets things be dragged. `shown` is where they are, or null where nothing may be dragged; `move`
 * is told of every cell that a thing in hand comes to, `drop` when it is let go.
 */
export function letDrag(
  { picture, cellAt }: Board,
  shown: () => Partial<Placement> | null,
  move: (thing: Dragged, cell: Cell) => void,
  drop: () => void,
): void {
  let hand: Dragged | null = null;
  const under = (event: PointerEvent): Dragged | null => {
    const [cell, things] = [cellAt(event), shown()];
    return cell && things && draggedAt(things, cell);
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
