/** The map editor: walls are drawn by dragging, things are dragged or moved by keys. */

import type { App } from "../core/app";
import type { Cell } from "../core/protocol";
import { fitted, indexOf, startOf, toolsOf, type Scene } from "../core/scene";
import {
  cellOfThing, moved, thingAt, toolsAside, without, withWall, type Standing, type World,
} from "../core/world";
import { createBoard, type Board } from "../draw/board";
import { letDrag, type Hold } from "../draw/dragging";
import { contentOf, rowColumn, stood } from "../draw/things";

const KEYS: Record<string, Standing["what"]> = { a: "agent", t: "tool", c: "object", b: "goal" };
export const ARROWS: Record<string, Cell> = {
  ArrowUp: [-1, 0],
  ArrowRight: [0, 1],
  ArrowDown: [1, 0],
  ArrowLeft: [0, -1],
};

export function createEditor({ store }: App): Board {
  const board = createBoard("The world: draw walls, drag things", "world-board");
  const { picture } = board;
  let drags = 0;

  const makeRoom = ({ world, bare }: Scene, cell: number) =>
    bare ? toolsAside(world, cell) : world;

  function put(thing: Standing, cell: Cell, gesture?: string): void {
    const scene = store.scene();
    const at = indexOf(scene.world, cell);
    const world = moved(makeRoom(scene, at), thing, at);
    const [before, after] = [scene.world, world].map((one) => cellOfThing(one, thing));
    if (after === at && before !== at) store.change({ world }, gesture);
  }

  /** Removes a thing from the map, if the map does not need it. */
  function remove(thing: Standing, gesture?: string): void {
    const scene = store.scene();
    const world = without(scene.world, thing);
    if (world !== scene.world) store.change(fitted({ ...scene, world }), gesture);
  }

  function paint(cells: Cell[], wall: boolean, gesture?: string): void {
    const scene = store.scene();
    const world = cells.reduce((world: World, cell) => {
      const at = indexOf(world, cell);
      return withWall(makeRoom({ ...scene, world }, at), at, wall);
    }, scene.world);
    if (world !== scene.world) store.change({ world }, gesture);
  }

  const carried = (thing: Standing, gesture: string): Hold => ({
    kind: "thing",
    move: (path) => put(thing, path.at(-1)!, gesture),
    off: () => remove(thing, gesture),
  });
  const drawn = (wall: boolean, gesture: string): Hold => ({
    kind: "wall",
    move: (path) => paint(path, wall, gesture),
  });
  const thingIn = (cell: Cell) => seenAt(store.scene(), indexOf(store.scene().world, cell));
  letDrag(
    board,
    (cell) => {
      const gesture = `drag ${(drags += 1)}`;
      board.moveCursor(cell);
      const { world } = store.scene();
      const thing = thingIn(cell);
      return thing ? carried(thing, gesture) : drawn(!world.walls[indexOf(world, cell)], gesture);
    },
    (cell) => (thingIn(cell) ? "thing" : "cell"),
  );
  picture.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const [row, column] = board.cursor();
    const step = ARROWS[event.key];
    const what = KEYS[event.key.toLowerCase()];
    if (step) board.moveCursor([row + step[0], column + step[1]]);
    else if (event.key === " " || event.key === "Enter") {
      const { world } = store.scene();
      paint([[row, column]], !world.walls[indexOf(world, [row, column])]);
    } else if (event.key === "Delete" || event.key === "Backspace") {
      const there = thingIn([row, column]);
      if (there) remove(there);
    } else if (what && !(what === "tool" && !toolsOf(store.scene()).length)) {
      put({ what, of: 0 }, [row, column]);
    } else return;
    event.preventDefault();
  });

  store.watch((scene) => {
    const { world } = scene;
    const things = stood(world, toolsOf(scene), startOf(scene));
    board.draw({
      world,
      things,
      label: (cell) => `${rowColumn(cell)}: ${contentOf(world, things, cell)}`,
    });
  });
  return board;
}

/** The visible thing in a cell: tools are hidden if the agent uses none. */
function seenAt({ world, bare }: Scene, cell: number): Standing | null {
  const thing = thingAt(world, cell);
  return bare && thing?.what === "tool" ? null : thing;
}
