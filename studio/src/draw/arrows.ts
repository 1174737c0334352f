/** Action probabilities as arrows. */

import type { Cell } from "../core/protocol";
import { corner } from "./cells";

const LEAST = 0.03; // the probability below which there is no arrow

/** A rose around the cell's centre: areas, as eyes compare them, grow with action probabilities. */
export function roseOf(cell: Cell, shares: number[]): string {
  const [x, y] = corner(cell);
  // One outline, so that no wedge's border crosses another.
  const parts = shares.slice(0, 4).map((share, side) => {
    if (share < LEAST) return "";
    const [wide, long] = [7 + 9 * Math.sqrt(share), 9 + 39 * Math.sqrt(share)];
    const points = [[-wide, 0], [0, -long], [wide, 0]].map(([across, along]) => {
      const [right, down] = turned(across!, along!, side);
      return `${(x + 50 + right).toFixed(1)} ${(y + 50 + down).toFixed(1)}`;
    });
    return `M${points.join("L")}Z`;
  });
  const outline = parts.join("");
  return outline ? `<path class="arrow" d="${outline}"/>` : "";
}

/** A point turned clockwise by so many right angles. */
function turned(x: number, y: number, quarters: number): [number, number] {
  return quarters ? turned(-y, x, quarters - 1) : [x, y];
}

/** From the agent's sides into the cells around it. */
export function movesOf(agent: Cell, shares: number[]): string {
  return wedges(agent, shares, (share) => `M-20 -44L0 ${-57 - 43 * share}L20 -44Z`);
}

function wedges(cell: Cell, shares: number[], path: (share: number) => string): string {
  const [x, y] = corner(cell);
  const drawn = shares.slice(0, 4).map((share, side) => {
    const place = `translate(${x + 50} ${y + 50}) rotate(${90 * side})`;
    return share < LEAST ? "" : `<path class="arrow" transform="${place}" d="${path(share)}"/>`;
  });
  return drawn.join("");
}
