/** The map under the pointer and the keys: walls are drawn by dragging, things are dragged. */

import type { App } from "../core/app";
import type { Cell } from "../core/protocol";
import { cellOf, indexOf, startOf, type Scene } from "../core/scene";
import { moved, thingAt, toolAside, withWall, type Thing, type World } from "../core/world";
import { createBoard, type Board } from "../draw/board";

const WORDS: Record<Thing, string> = { agent: "agent", tool: "tool", object: "can", goal: "bin" };
const KEYS: Record<string, Thing> = { a: "agent", t: "tool", c: "object", b: "goal" };
export const ARROWS: Record<string, Cell> = {
  ArrowUp: [-1, 0],
  ArrowRight: [0, 1],
  ArrowDown: [1, 0],
  ArrowLeft: [0, -1],
};

type Hand = { thing: Thing } | { wall: boolean; last: Cell };

export function createEditor({ store }: App): Board {
  const board = createBoard("The world: draw walls, drag things", "world-board");
  const { picture } = board;
  let hand: Hand | null = null;
  let gesture = 0;

  /** What is there as one sees it: the tool is not, when the agent has none. */
  const seenAt = (scene: Scene, cell: number) => {
    const thing = thingAt(scene.world, cell);
    return thing === "tool" && scene.tool === "none" ? null : thing;
  };
  const makeRoom = ({ world, tool }: Scene, cell: number) =>
    tool === "none" ? toolAside(world, cell) : world;

  function put(thing: Thing, cell: Cell, gesture?: string): void {
    const scene = store.scene();
    const at = indexOf(scene.world, cell);
    const world = moved(makeRoom(scene, at), thing, at);
    if (world[thing] === at && scene.world[thing] !== at) store.change({ world }, gesture);
  }

  function paint(cells: Cell[], wall: boolean, gesture?: string): void {
    const scene = store.scene();
    const world = cells.reduce((world: World, cell) => {
      const at = indexOf(world, cell);
      return withWall(makeRoom({ ...scene, world }, at), at, wall);
    }, scene.world);
    if (world !== scene.world) store.change({ world }, gesture);
  }

  picture.addEventListener("pointerdown", (event) => {
    const cell = board.cellAt(event);
    if (cell === null || event.button !== 0) return;
    picture.setPointerCapture(event.pointerId);
    gesture += 1;
    board.moveCursor(cell);
    const scene = store.scene();
    const at = indexOf(scene.world, cell);
    const thing = seenAt(scene, at);
    hand = thing === null ? { wall: !scene.world.walls[at], last: cell } : { thing };
    picture.dataset.hand = thing === null ? "wall" : "thing";
    if ("wall" in hand) paint([cell], hand.wall, `drag ${gesture}`);
  });
  picture.addEventListener("pointermove", (event) => {
    const cell = board.cellAt(event);
    if (cell === null) return;
    if (hand === null) {
      const scene = store.scene();
      picture.dataset.over = seenAt(scene, indexOf(scene.world, cell)) ? "thing" : "cell";
    } else if ("thing" in hand) put(hand.thing, cell, `drag ${gesture}`);
    else {
      paint(between(hand.last, cell), hand.wall, `drag ${gesture}`);
      hand.last = cell;
    }
  });
  for (const end of ["pointerup", "pointercancel"]) {
    picture.addEventListener(end, () => {
      hand = null;
      delete picture.dataset.hand;
    });
  }
  picture.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const [row, column] = board.cursor();
    const step = ARROWS[event.key];
    const thing = KEYS[event.key.toLowerCase()];
    if (step) board.moveCursor([row + step[0], column + step[1]]);
    else if (event.key === " " || event.key === "Enter") {
      const { world } = store.scene();
      paint([[row, column]], !world.walls[indexOf(world, [row, column])]);
    } else if (thing && !(thing === "tool" && store.scene().tool === "none")) {
      put(thing, [row, column]);
    } else return;
    event.preventDefault();
  });

  store.watch((scene) => {
    const { world, tool } = scene;
    board.draw({
      height: world.height,
      width: world.width,
      walls: world.walls,
      goal: cellOf(world, world.goal),
      things: startOf(scene),
      tool,
      label: (cell) => `${rowColumn(cell)}: ${contentOf(scene, seenAt, indexOf(world, cell))}`,
    });
  });
  return board;
}

export function rowColumn([row, column]: Cell): string {
  return `row ${row + 1}, column ${column + 1}`;
}

function contentOf(
  scene: Scene,
  seenAt: (scene: Scene, cell: number) => Thing | null,
  cell: number,
): string {
  const thing = seenAt(scene, cell);
  if (thing !== null) return WORDS[thing];
  return scene.world.walls[cell] ? "wall" : "floor";
}

/** The cells of a line, so that a fast drag leaves no gaps. */
function between(from: Cell, to: Cell): Cell[] {
  const steps = Math.max(Math.abs(to[0] - from[0]), Math.abs(to[1] - from[1]), 1);
  return Array.from({ length: steps + 1 }, (_, k) => [
    Math.round(from[0] + ((to[0] - from[0]) * k) / steps),
    Math.round(from[1] + ((to[1] - from[1]) * k) / steps),
  ]);
}
