/** A map as a picture that can be pointed at: floor, values, walls, things, marks, a cursor. */

import { h, set, svg } from "../core/elements";
import type { Cell, Placement } from "../core/protocol";
import { movesOf, roseOf } from "./arrows";
import { box, clamp, corner, everyCell, redraw, same, square, UNIT } from "./cells";
import { colourOf, inkOn, type Scale } from "./heat";
import { drawingOf, use } from "./shapes";

const READABLE = 29; // pixels of a cell in which its value can be read

export interface Mark {
  cell: Cell;
  /** From 0 to 1, how likely. */
  weight: number;
}

export interface Picture {
  height: number;
  width: number;
  walls: readonly boolean[];
  goal: Cell | null;
  things: Partial<Placement>;
  tool: string;
  /** Bits for each cell, with the scale of their colours. */
  values?: { grid: (number | null)[][]; scale: Scale; unlabelled?: boolean } | null;
  /** Cells that the sensor can see. */
  chosen?: Cell[];
  /** Where something could be; the values fade then. */
  marks?: Mark[] | null;
  /** Arrows from cells: lengths north, east, south, west. */
  arrows?: (number[] | null)[][] | null;
  /** How probable the agent's next moves are: north, east, south, west. */
  now?: number[] | null;
  /** What a cell is called for those who hear it. */
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
  const [floor, heat, walls] = [layer("floor"), layer("heat"), layer("walls")];
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
    const { height, width } = next;
    if (size !== `${height}x${width}`) {
      size = `${height}x${width}`;
      set(picture, "viewBox", `0 0 ${width * UNIT} ${height * UNIT}`);
      element.style.setProperty("--ratio", String(width / height));
      element.style.setProperty("--rows", String(height));
      floor.innerHTML = everyCell(next, (cell) => box("floor", cell));
      const most: Cell = [Math.min(at[0], height - 1), Math.min(at[1], width - 1)];
      at = most;
    }
    shown = next;
    const wall = ([row, column]: Cell) => next.walls[row * width + column] ?? false;
    redraw(walls, everyCell(next, (cell) => (wall(cell) ? use("wall", ...corner(cell), UNIT) : "")));
    drawValues(next);
    redraw(chosen, (next.chosen ?? []).map((cell) => box("chosen", cell, 8)).join(""));
    redraw(marks, (next.marks ?? []).map((mark) => markOf(mark, isThing(next, mark.cell))).join(""));
    redraw(arrows, next.arrows ? everyCell(next, (cell) => arrowsOf(next, cell)) : "");
    redraw(now, next.now && next.things.agent ? movesOf(next.things.agent, next.now) : "");
    picture.classList.toggle("marked", (next.marks?.length ?? 0) > 0);
    drawThings(next);
    redraw(cells, everyCell(next, (cell) => nameOf(next, cell), '<g role="row">', "</g>"));
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
      everyCell(next, (cell) => {
        const bits = value(cell);
        return bits === null
          ? ""
          : box("value", cell, 1, ` fill="${colourOf(bits, values.scale)}"`);
      }),
    );
    const small = values.unlabelled || picture.clientWidth / next.width < READABLE;
    redraw(
      labels,
      everyCell(next, (cell) => {
        const bits = value(cell);
        if (bits === null || small) return "";
        const [x, y] = corner(cell);
        const [kind, below] = isThing(next, cell) ? ["small", 80] : ["", 51];
        const look = `class="${kind}" fill="${inkOn(bits, values.scale)}"`;
        return `<text x="${x + 50}" y="${y + below}" ${look}>${bits.toFixed(1).replace("-", "−")}</text>`;
      }),
    );
  }

  function drawThings(next: Picture): void {
    const { agent, tool, object } = next.things;
    const inBin = object !== undefined && next.goal !== null && same(object, next.goal);
    const over = [agent, tool].some((cell) => cell && next.goal && same(cell, next.goal));
    const valued = (cell: Cell) => (next.values?.grid[cell[0]]?.[cell[1]] ?? null) !== null;
    const stand = (name: string, cell: Cell | null | undefined, drawing: string, turn = 0) => {
      let group = standing.get(name);
      if (!cell) {
        group?.remove();
        standing.delete(name);
        return;
      }
      if (group === undefined) {
        group = svg("g", { class: `thing ${name}` });
        standing.set(name, group);
      }
      things.append(group);
      const [x, y] = corner(cell);
      const [left, top, wide] = !next.values ? [4, 4, 92] : valued(cell) ? [21, 4, 58] : [10, 10, 80];
      group.style.transform = `translate(${x}px, ${y}px)`;
      const plate = use("plate", left, top, wide);
      const around = `rotate(${turn} ${left + wide / 2} ${top + wide / 2})`;
      redraw(group, `${plate}<g transform="${around}">${use(drawing, left, top, wide)}</g>`);
    };
    stand("object", inBin ? null : object, "can");
    const turn = agent && tool ? facing(agent, tool) : 0;
    stand("tool", tool, drawingOf(next.tool), turn);
    stand("agent", agent, "agent");
    stand("goal", over ? null : next.goal, inBin ? "full bin" : "bin");
    const corners = over && next.goal ? corner(next.goal) : null;
    redraw(goal, corners ? use("bin", corners[0] + 56, corners[1] + 54, 44) : "");
  }

  function moveCursor(cell: Cell): void {
    if (shown === null) return;
    at = [clamp(cell[0], shown.height - 1), clamp(cell[1], shown.width - 1)];
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
      const inside = cell[0] >= 0 && cell[1] >= 0 && cell[0] < shown.height && cell[1] < shown.width;
      return inside ? cell : null;
    },
    cursor: () => at,
    moveCursor,
  };
}

function isThing({ things, goal }: Picture, cell: Cell): boolean {
  const cells = [things.agent, things.tool, things.object, goal];
  return cells.some((other) => other && same(other, cell));
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

/** A tool in hand faces away from the agent; drawings face south. */
function facing(agent: Cell, tool: Cell): number {
  const side = `${tool[0] - agent[0]},${tool[1] - agent[1]}`;
  return { "0,-1": 90, "-1,0": 180, "0,1": 270 }[side] ?? 0;
}
