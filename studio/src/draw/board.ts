/** A map as an interactive picture: floor, values, walls, things, marks, a cursor. */

import { h, set, svg } from "../core/elements";
import type { Cell } from "../core/protocol";
import { cellOf } from "../core/scene";
import type { World } from "../core/world";
import { movesOf, roseOf } from "./arrows";
import { box, clamp, corner, everyCell, redraw, same, square, UNIT } from "./cells";
import { colourOf, inDigits, inkOn, type Scale } from "./colours";
import { use } from "./shapes";
import type { Stood } from "./things";

const LEGIBLE = 11; // pixels: the letters of values
const FONT = 32; // units: those letters where cells are large
const FAINT = 0.3; // of what lies under a number
const TOLERATED = 1.15; // how much smaller than that they may still be
const LARGEST = 46; // units: those letters where cells are small
const ACROSS = 165; // units: so many letters fit side by side, times their size

export interface Mark {
  cell: Cell;
  /** Its relative probability, from 0 to 1. */
  weight: number;
}

export interface Picture {
  world: Pick<World, "height" | "width" | "walls">;
  /** The things to draw. */
  things: readonly Stood[];
  /** Bits for each cell, with the scale of their colours. */
  values?: { grid: (number | null)[][]; scale: Scale; unlabelled?: boolean } | null;
  /** Drawings that stay in their cells, below the things. */
  still?: readonly { cell: Cell; drawing: string }[];
  /** An image of the whole board, instead of drawings. */
  image?: string | null;
  /** Cells that the sensor observes. */
  chosen?: Cell[];
  /** Reachable cells; the values fade while they are shown. */
  marks?: Mark[] | null;
  /** Arrows from cells: lengths north, east, south, west. */
  arrows?: (number[] | null)[][] | null;
  /** The probabilities of the agent's next moves: north, east, south, west. */
  now?: number[] | null;
  /** The description of a cell for screen readers. */
  label: (cell: Cell) => string;
}

export interface Board {
  readonly element: HTMLElement;
  readonly picture: SVGSVGElement;
  draw(picture: Picture): void;
  /** The cell under the pointer. */
  cellAt(event: PointerEvent): Cell | null;
  cursor(): Cell;
  moveCursor(cell: Cell): void;
}

/** An empty board. `name` is what it is called for those who hear it. */
export function createBoard(name: string, id: string, moving = false): Board {
  const picture = svg("svg", {
    id,
    class: moving ? "board moving" : "board",
    role: "grid",
    tabindex: 0,
    "aria-label": name,
    preserveAspectRatio: "xMidYMid meet",
  });
  const layer = (kind: string) => {
    const group = svg("g", { class: kind });
    picture.append(group);
    return group;
  };
  const [floor, image, heat, walls] = [layer("floor"), layer("image"), layer("heat"), layer("walls")];
  const [labels, arrows, things] = [layer("labels"), layer("arrows"), layer("things")];
  const [goal, chosen, marks] = [layer("goal"), layer("chosen"), layer("marks")];
  const [now, cursors, cells] = [layer("now"), layer("cursor"), layer("cells")];
  const ring = svg("rect", { width: UNIT, height: UNIT, rx: 12, class: "ring" });
  cursors.append(ring);
  const element = h("div", { class: "board-box" }, picture);
  const standing = new Map<string, SVGGElement>();
  let shown: Picture | null = null;
  let at: Cell = [0, 0];
  let size = "";

  function draw(next: Picture): void {
    const { height, width, walls: walled } = next.world;
    if (size !== `${height}x${width}`) {
      size = `${height}x${width}`;
      set(picture, "viewBox", `0 0 ${width * UNIT} ${height * UNIT}`);
      element.style.setProperty("--ratio", String(width / height));
      element.style.setProperty("--rows", String(height));
      floor.innerHTML = everyCell(next.world, (cell) => box("floor", cell));
      const most: Cell = [Math.min(at[0], height - 1), Math.min(at[1], width - 1)];
      at = most;
    }
    shown = next;
    const wall = ([row, column]: Cell) => walled[row * width + column] ?? false;
    const number = ([row, column]: Cell) => (next.values?.grid[row]?.[column] ?? null) !== null;
    const still = (next.still ?? []).map(({ cell, drawing }) => {
      const shape = use(drawing, ...corner(cell), UNIT);
      return number(cell) ? `<g opacity="${FAINT}">${shape}</g>` : shape;
    }).join("");
    redraw(walls, everyCell(next.world, (cell) => (wall(cell) ? use("wall", ...corner(cell), UNIT) : "")) + still);
    picture.classList.toggle("pictured", Boolean(next.image));
    redraw(image, next.image ? `<image href="${next.image}" width="${width * UNIT}" height="${height * UNIT}"/>` : "");
    drawValues(next);
    redraw(chosen, (next.chosen ?? []).map((cell) => box("chosen", cell, 8)).join(""));
    redraw(marks, (next.marks ?? []).map((mark) => markOf(mark, isThing(next, mark.cell))).join(""));
    redraw(arrows, next.arrows ? everyCell(next.world, (cell) => arrowsOf(next, cell)) : "");
    const agent = next.things.find(({ thing }) => thing.what === "agent");
    redraw(now, next.now && agent ? movesOf(agent.cell, next.now) : "");
    picture.classList.toggle("marked", (next.marks?.length ?? 0) > 0);
    drawThings(next);
    redraw(cells, everyCell(next.world, (cell) => nameOf(next, cell), '<g role="row">', "</g>"));
    moveCursor(at);
  }

  function drawValues(next: Picture): void {
    const values = next.values;
    if (!values) {
      redraw(heat, "");
      redraw(labels, "");
      return;
    }
    const value = ([row, column]: Cell) => values.grid[row]?.[column] ?? null;
    redraw(
      heat,
      everyCell(next.world, (cell) => {
        const bits = value(cell);
        return bits === null
          ? ""
          : box("value", cell, 1, ` fill="${colourOf(bits, values.scale)}"`);
      }),
    );
    const { digits } = values.scale;
    const needed = (UNIT * LEGIBLE) / (picture.clientWidth / next.world.width);
    const all = next.world.walls.map((_, cell) => value(cellOf(next.world, cell)));
    const longest = Math.max(...all.map((bits) => (bits === null ? 0 : inDigits(bits, digits).length)));
    const fitting = Math.min(LARGEST, ACROSS / longest);
    const letters = Math.min(Math.max(needed, FONT), fitting);
    const small = values.unlabelled || needed > letters * TOLERATED;
    labels.style.fontSize = `${letters}px`;
    redraw(
      labels,
      everyCell(next.world, (cell) => {
        const bits = value(cell);
        if (bits === null || small) return "";
        const [x, y] = corner(cell);
        const [kind, below] = isThing(next, cell) ? ["small", 81] : ["", 51];
        const look = `class="${kind}" fill="${inkOn(bits, values.scale)}"`;
        return `<text x="${x + 50}" y="${y + below}" ${look}>${inDigits(bits, digits)}</text>`;
      }),
    );
  }

  function drawThings(next: Picture): void {
    const valued = (cell: Cell) => (next.values?.grid[cell[0]]?.[cell[1]] ?? null) !== null;
    const left = new Set(standing.keys());
    const corners: string[] = [];
    for (const { thing, cell, drawing, turn, badge, hidden, whole } of next.things) {
      const [x, y] = corner(cell);
      if (hidden) {
        corners.push(use(drawing, x + 56, y + 54, 44));
        continue;
      }
      const id = `${thing.what}${thing.of}`;
      left.delete(id);
      let group = standing.get(id);
      if (group === undefined) {
        group = svg("g", { class: `thing ${thing.what}` });
        standing.set(id, group);
      }
      things.append(group);
      group.style.transform = `translate(${x}px, ${y}px)`;
      if (whole) {
        redraw(group, use(drawing, 0, 0, UNIT));
        continue;
      }
      const [at, top, wide] = !next.values ? [4, 4, 92] : valued(cell) ? [21, 4, 58] : [10, 10, 80];
      const plate = use("plate", at, top, wide);
      const around = `rotate(${turn} ${at + wide / 2} ${top + wide / 2})`;
      const mark = badge ? use(badge, at + 0.28 * wide, top + 0.36 * wide, 0.44 * wide) : "";
      redraw(group, `${plate}<g transform="${around}">${use(drawing, at, top, wide)}</g>${mark}`);
    }
    for (const id of left) {
      standing.get(id)!.remove();
      standing.delete(id);
    }
    redraw(goal, corners.join(""));
  }

  function moveCursor(cell: Cell): void {
    if (shown === null) return;
    at = [clamp(cell[0], shown.world.height - 1), clamp(cell[1], shown.world.width - 1)];
    const [x, y] = corner(at);
    set(ring, "x", x);
    set(ring, "y", y);
    set(picture, "aria-activedescendant", cellId(at));
  }

  const cellId = ([row, column]: Cell) => `${id}-${row}-${column}`;
  const nameOf = (next: Picture, cell: Cell) =>
    `<rect role="gridcell" id="${cellId(cell)}" ${square(cell)} aria-label="${next.label(cell)}"/>`;

  new ResizeObserver(() => shown && drawValues(shown)).observe(picture);
  return {
    element,
    picture,
    draw,
    cellAt(event) {
      const matrix = picture.getScreenCTM();
      if (shown === null || matrix === null) return null;
      const point = new DOMPoint(event.clientX, event.clientY).matrixTransform(matrix.inverse());
      const cell: Cell = [Math.floor(point.y / UNIT), Math.floor(point.x / UNIT)];
      const inside = cell[0] >= 0 && cell[1] >= 0 && cell[0] < shown.world.height && cell[1] < shown.world.width;
      return inside ? cell : null;
    },
    cursor: () => at,
    moveCursor,
  };
}

function isThing({ things }: Picture, cell: Cell): boolean {
  return things.some((thing) => same(thing.cell, cell));
}

function arrowsOf(picture: Picture, cell: Cell): string {
  const shares = picture.arrows?.[cell[0]]?.[cell[1]];
  return shares && !isThing(picture, cell) ? roseOf(cell, shares) : "";
}

/** A dot, the larger the likelier; a frame where a dot would hide a thing. */
function markOf({ cell, weight }: Mark, occupied: boolean): string {
  if (occupied) return `<rect class="mark frame" ${square(cell, 4)} rx="14"/>`;
  const [x, y] = corner(cell);
  const radius = 14 + 20 * Math.sqrt(weight);
  return `<circle class="mark" cx="${x + 50}" cy="${y + 50}" r="${radius.toFixed(1)}"/>`;
}
