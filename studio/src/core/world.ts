/** A map as the page edits it: immutable values, and functions that derive new ones. */

import type { Cell, Drawn } from "./protocol";

export interface Tool {
  readonly kind: string;
  readonly cell: number;
  /** The probability that its effect fails. */
  readonly slip: number;
}

export interface Thing {
  readonly kind: string;
  readonly cell: number;
  readonly goal: number | null;
}

/** Cells are `row * width + column`. There is an object, and the first has a goal. */
export interface World {
  readonly height: number;
  readonly width: number;
  readonly walls: readonly boolean[];
  readonly agent: number;
  readonly tools: readonly Tool[];
  readonly objects: readonly Thing[];
  /** Whether a tool can be dropped. */
  readonly drop: boolean;
}

/** A thing on a map: the agent, a tool, an object or the goal of an object. */
export interface Standing {
  readonly what: "agent" | "tool" | "object" | "goal";
  readonly of: number;
}

/** All things on a map, with their cells. */
export function standing(world: World): [Standing, number][] {
  const all: [Standing, number][] = [[{ what: "agent", of: 0 }, world.agent]];
  world.tools.forEach(({ cell }, of) => all.push([{ what: "tool", of }, cell]));
  world.objects.forEach(({ cell }, of) => all.push([{ what: "object", of }, cell]));
  world.objects.forEach(({ goal }, of) => goal !== null && all.push([{ what: "goal", of }, goal]));
  return all;
}

/** The thing in a cell, if any. */
export function thingAt(world: World, cell: number): Standing | null {
  return standing(world).find(([, at]) => at === cell)?.[0] ?? null;
}

export function cellOfThing(world: World, { what, of }: Standing): number | null {
  if (what === "agent") return world.agent;
  if (what === "tool") return world.tools[of]?.cell ?? null;
  return (what === "goal" ? world.objects[of]?.goal : world.objects[of]?.cell) ?? null;
}

/** With a thing in a cell, whatever else is there. */
function put(world: World, { what, of }: Standing, cell: number): World {
  if (what === "agent") return { ...world, agent: cell };
  if (what === "tool") {
    return { ...world, tools: world.tools.with(of, { ...world.tools[of]!, cell }) };
  }
  const thing = world.objects[of]!;
  const next = what === "goal" ? { ...thing, goal: cell } : { ...thing, cell };
  return { ...world, objects: world.objects.with(of, next) };
}

/** With or without a wall in a cell; a cell with a thing stays unchanged. */
export function withWall(world: World, cell: number, wall: boolean): World {
  if (world.walls[cell] === wall || thingAt(world, cell) !== null) return world;
  return { ...world, walls: world.walls.with(cell, wall) };
}

/** With a thing moved to a cell, if that is free. */
export function moved(world: World, thing: Standing, cell: number): World {
  if (world.walls[cell] || thingAt(world, cell) !== null) return world;
  return put(world, thing, cell);
}

/** With a tool moved out of the way, for a map whose agent uses none. */
export function toolsAside(world: World, cell: number): World {
  const there = thingAt(world, cell);
  if (there?.what !== "tool") return world;
  const blocked = { ...world, walls: world.walls.with(cell, true) };
  const aside = settled(blocked, there, cell);
  return { ...aside, walls: aside.walls.with(cell, false) };
}

/** With one more tool, in the free cell nearest to the agent. */
export function withTool(world: World, kind: string): World {
  const tools = [...world.tools, { kind, cell: -1, slip: 0 }];
  return settled({ ...world, tools }, { what: "tool", of: tools.length - 1 }, world.agent);
}

/** With one more object, near the first. */
export function withObject(world: World, kind: string): World {
  const objects = [...world.objects, { kind, cell: -1, goal: null }];
  return settled({ ...world, objects }, { what: "object", of: objects.length - 1 }, objects[0]!.cell);
}

/** With a goal for an object that has none. */
export function withGoal(world: World, of: number): World {
  return settled(world, { what: "goal", of }, world.objects[of]!.cell);
}

/** Without a thing; the agent, the first object and its goal stay. */
export function without(world: World, { what, of }: Standing): World {
  const others = <One>(all: readonly One[]) => all.filter((_, place) => place !== of);
  if (what === "tool") return { ...world, tools: others(world.tools) };
  if (what === "agent" || of === 0) return world;
  if (what === "object") return { ...world, objects: others(world.objects) };
  return { ...world, objects: world.objects.with(of, { ...world.objects[of]!, goal: null }) };
}

/** The map cropped or extended at its right and lower side; cropped things move back inside. */
export function resized(world: World, height: number, width: number): World {
  const old = (cell: number): Cell => [Math.floor(cell / world.width), cell % world.width];
  const walls = Array.from({ length: height * width }, (_, cell) => {
    const [row, column] = [Math.floor(cell / width), cell % width];
    return row < world.height && column < world.width && world.walls[row * world.width + column]!;
  });
  const cut: [Standing, Cell][] = [];
  let next: World = { ...world, height, width, walls };
  for (const [thing, cell] of standing(world)) {
    const [row, column] = old(cell);
    const inside = row < height && column < width;
    next = put(next, thing, inside ? row * width + column : -1);
    if (!inside) cut.push([thing, [row, column]]);
  }
  for (const [thing, [row, column]] of cut) {
    const near = Math.min(row, height - 1) * width + Math.min(column, width - 1);
    next = settled(next, thing, near);
  }
  return next;
}

/** With the thing in the nearest empty cell, or in a wall's cell if there is no other. */
function settled(world: World, thing: Standing, near: number): World {
  const cells = world.walls.map((_, cell) => cell).filter((cell) => thingAt(world, cell) === null);
  const away = (cell: number) =>
    Math.abs(Math.floor(cell / world.width) - Math.floor(near / world.width)) +
    Math.abs((cell % world.width) - (near % world.width)) +
    (world.walls[cell] ? world.height + world.width : 0);
  const cell = cells.reduce((best, other) => (away(other) < away(best) ? other : best));
  return put({ ...world, walls: world.walls.with(cell, false) }, thing, cell);
}

/** The places of things in the order in which they are numbered: as a map is read, goals first. */
function numbered(things: readonly (Tool | Thing)[]): number[] {
  const late = (of: number) => Number("goal" in things[of]! && (things[of] as Thing).goal === null);
  return things
    .map((_, of) => of)
    .sort((a, b) => late(a) - late(b) || things[a]!.cell - things[b]!.cell);
}

/** Names for things by their kinds: the second can is "can2". */
export function namesOf(things: readonly (Tool | Thing)[]): string[] {
  const names: string[] = [];
  const count = new Map<string, number>();
  for (const of of numbered(things)) {
    const kind = things[of]!.kind.split(":").at(-1)!;
    const before = count.get(kind) ?? 0;
    count.set(kind, before + 1);
    names[of] = before ? `${kind}${before + 1}` : kind;
  }
  return names;
}

/** Whether there is more than one tool or object, or tools can be put down. */
export function several({ tools, objects, drop }: World): boolean {
  return tools.length > 1 || objects.length > 1 || (drop && tools.length > 0);
}

/** In the server's format. */
export function drawnOf(world: World): Drawn {
  const { tools, objects } = world;
  const at = (cell: number): Cell => [Math.floor(cell / world.width), cell % world.width];
  const row = (k: number) => world.walls.slice(k * world.width, (k + 1) * world.width);
  return {
    ground: Array.from({ length: world.height }, (_, k) =>
      row(k).map((wall) => (wall ? "#" : ".")).join(""),
    ).join("\n"),
    agent: at(world.agent),
    tools: tools.map((tool) => ({ ...tool, cell: at(tool.cell) })),
    objects: objects.map(({ kind, cell, goal }) => ({
      kind, cell: at(cell), goal: goal === null ? null : at(goal),
    })),
    drop: world.drop,
  };
}

export function worldOf({ ground, agent, tools, objects, drop }: Drawn): World {
  const rows = ground.split("\n");
  const width = rows[0]!.length;
  const at = ([row, column]: Cell) => row * width + column;
  return {
    height: rows.length,
    width,
    walls: [...rows.join("")].map((mark) => mark === "#"),
    agent: at(agent),
    tools: tools.map((tool) => ({ ...tool, cell: at(tool.cell) })),
    objects: objects.map(({ kind, cell, goal }) => ({
      kind, cell: at(cell), goal: goal === null ? null : at(goal),
    })),
    drop,
  };
}
