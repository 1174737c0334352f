/** The things on a board: the agent, tools, objects and their bins. */

import type { Cell, Grid, Placement } from "../core/protocol";
import { namesOf, type Standing, type Tool, type World } from "../core/world";
import { cellOf, indexOf } from "../core/scene";
import { same } from "./cells";
import { drawingOf } from "./shapes";

/** A thing to be drawn. */
export interface Stood {
  readonly thing: Standing;
  readonly cell: Cell;
  readonly drawing: string;
  /** Its clockwise rotation in degrees. */
  readonly turn: number;
  /** A small drawing on top: the object that a bin belongs to. */
  readonly badge: string | null;
  /** Whether something covers it; it is then drawn small. */
  readonly hidden: boolean;
  /** Whether its drawing fills its cell, or goes beyond it. */
  readonly whole?: boolean;
}

/** The things to draw, back to front. */
export function stood(world: World, tools: readonly Tool[], placement: Placement): Stood[] {
  const plain = { turn: 0, badge: null, hidden: false };
  const kinds = new Set(world.objects.map(({ kind }) => kind));
  const found: Stood[] = [];
  const others = [placement.agent, ...placement.tools];
  world.objects.forEach(({ kind, goal }, of) => {
    const cell = placement.objects[of]!;
    const at = goal === null ? null : cellOf(world, goal);
    const done = at !== null && same(cell, at);
    if (!done) found.push({ ...plain, thing: { what: "object", of }, cell, drawing: kind });
    if (at === null) return;
    const over = [...others, ...placement.objects].some((other) => same(other, at)) && !done;
    const badge = kinds.size > 1 || world.objects.length > 1 ? kind : null;
    const drawing = done ? "full bin" : "bin";
    found.push({ ...plain, thing: { what: "goal", of }, cell: at, drawing, badge, hidden: over });
  });
  tools.forEach(({ kind }, of) => {
    const cell = placement.tools[of]!;
    const held = placement.held === undefined ? true : placement.held === of;
    const turn = held ? facing(placement.agent, cell) : 0;
    found.push({ ...plain, thing: { what: "tool", of }, cell, drawing: drawingOf(kind), turn });
  });
  found.push({ ...plain, thing: { what: "agent", of: 0 }, cell: placement.agent, drawing: "agent" });
  return found;
}

/** The contents of a cell in words: its things, or wall or floor. */
export function contentOf(world: World, things: readonly Stood[], cell: Cell): string {
  const there = things.filter((one) => same(one.cell, cell)).map(({ thing, drawing }) => {
    if (thing.what === "agent") return "agent";
    if (thing.what === "tool") return namesOf(world.tools)[thing.of]!;
    const name = namesOf(world.objects)[thing.of]!;
    if (thing.what === "object") return name;
    const bin = world.objects.length > 1 ? `bin of the ${name}` : "bin";
    return drawing === "full bin" ? `${name} in its ${bin}` : bin;
  });
  if (there.length) return there.join(", ");
  return world.walls[indexOf(world, cell)] ? "wall" : "floor";
}

/** A cell, its contents, and its value. */
export function labelOf(
  world: World, things: readonly Stood[], cell: Cell, grid: Grid | null | undefined, unit: string,
): string {
  const content = contentOf(world, things, cell);
  const value = grid?.[cell[0]]?.[cell[1]] ?? null;
  const words = content === "floor" && value !== null ? [] : [content];
  if (value !== null) words.push(`${value.toFixed(2)} ${unit}`);
  return `${rowColumn(cell)}: ${words.join(", ")}`;
}

/** The name of a cell. Rows and columns are counted from 0, as in the library. */
export function rowColumn([row, column]: Cell): string {
  return `row ${row}, column ${column}`;
}

/** A tool in hand faces away from the agent; drawings face south. */
function facing(agent: Cell, tool: Cell): number {
  const side = `${tool[0] - agent[0]},${tool[1] - agent[1]}`;
  return { "0,-1": 90, "-1,0": 180, "0,1": 270 }[side] ?? 0;
}

