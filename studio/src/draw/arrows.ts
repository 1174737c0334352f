/** Action probabilities as arrows. */

import type { Cell } from "../core/protocol";
import { corner } from "./cells";

/** A rose around the cell's centre, with lengths proportional to action probabilities. */
export function roseOf(cell: Cell, shares: number[]): string {
  return wedges(cell, shares, (share) => `M-9 0L0 ${-10 - 36 * share}L9 0Z`);
}

/** From the agent's sides into the cells around it. */
export function movesOf(agent: Cell, shares: number[]): string {
  return wedges(agent, shares, (share) => `M-15 -46L0 ${-50 - 50 * share}L15 -46Z`);
}

function wedges(cell: Cell, shares: number[], path: (share: number) => string): string {
  const [x, y] = corner(cell);
  const drawn = shares.slice(0, 4).map((share, side) => {
    const place = `translate(${x + 50} ${y + 50}) rotate(${90 * side})`;
    return share < 0.03 ? "" : `<path class="arrow" transform="${place}" d="${path(share)}"/>`;
  });
  return drawn.join("");
}
