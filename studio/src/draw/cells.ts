/** Cells as parts of a picture. */

import type { Cell } from "../core/protocol";

export const UNIT = 100; // of the picture, a cell; letters smaller than one unit render badly

export function same(a: Cell, b: Cell): boolean {
  return a[0] === b[0] && a[1] === b[1];
}

export function corner([row, column]: Cell): [number, number] {
  return [column * UNIT, row * UNIT];
}

export function square(cell: Cell, inset = 0): string {
  const [x, y] = corner(cell);
  const side = UNIT - 2 * inset;
  return `x="${x + inset}" y="${y + inset}" width="${side}" height="${side}"`;
}

export function box(kind: string, cell: Cell, inset = 1.3, more = ""): string {
  return `<rect class="${kind}-cell" ${square(cell, inset)}${more}/>`;
}

/** Markup for every cell, row by row. */
export function everyCell(
  { height, width }: { height: number; width: number },
  drawn: (cell: Cell) => string,
  open = "",
  close = "",
): string {
  const parts: string[] = [];
  for (let row = 0; row < height; row++) {
    parts.push(open);
    for (let column = 0; column < width; column++) parts.push(drawn([row, column]));
    parts.push(close);
  }
  return parts.join("");
}

export function clamp(value: number, most: number): number {
  return Math.min(Math.max(value, 0), most);
}

/** Redraws a layer if it has changed. */
export function redraw(group: SVGGElement & { drawn?: string }, markup: string): void {
  if (group.drawn === markup) return;
  group.drawn = markup;
  group.innerHTML = markup;
}
