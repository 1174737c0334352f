/** A map as the page edits it: values that are never changed, and what makes others of them. */

/** Cells are `row * width + column`. The tool keeps its place while the agent has none. */
export interface World {
  readonly height: number;
  readonly width: number;
  readonly walls: readonly boolean[];
  readonly agent: number;
  readonly tool: number | null;
  readonly object: number;
  readonly goal: number;
}

export type Thing = "agent" | "tool" | "object" | "goal";
export const THINGS: readonly Thing[] = ["agent", "tool", "object", "goal"];

const MARKS: Record<Exclude<Thing, "tool">, string> = { agent: "A", object: "C", goal: "G" };

/** What is in a cell, if anything. */
export function thingAt(world: World, cell: number): Thing | null {
  return THINGS.find((thing) => world[thing] === cell) ?? null;
}

/** With a wall there or without; a thing in the way stays, and the map as it was. */
export function withWall(world: World, cell: number, wall: boolean): World {
  if (world.walls[cell] === wall || thingAt(world, cell) !== null) return world;
  return { ...world, walls: world.walls.with(cell, wall) };
}

/** With a thing elsewhere, if that cell is free. */
export function moved(world: World, thing: Thing, cell: number): World {
  if (world.walls[cell] || thingAt(world, cell) !== null) return world;
  return { ...world, [thing]: cell };
}

/** With the tool out of the way, for a map whose agent has none. */
export function toolAside(world: World, cell: number): World {
  if (world.tool !== cell) return world;
  const taken = { ...world, tool: null, walls: world.walls.with(cell, true) };
  const aside = settled(taken, "tool", cell);
  return { ...aside, walls: aside.walls.with(cell, false) };
}

/** With a place for the tool: its own, or the nearest free one to the agent. */
export function withToolPlace(world: World): World {
  return world.tool === null ? settled(world, "tool", world.agent) : world;
}

/** The map cut or extended at its right and lower side; what was cut off comes back inside. */
export function resized(world: World, height: number, width: number): World {
  const old = (cell: number) => Math.floor(cell / world.width) * width + (cell % world.width);
  const inside = (cell: number) =>
    Math.floor(cell / world.width) < height && cell % world.width < width;
  const walls = Array.from({ length: height * width }, (_, cell) => {
    const [row, column] = [Math.floor(cell / width), cell % width];
    return row < world.height && column < world.width && world.walls[row * world.width + column]!;
  });
  let next: World = { height, width, walls, agent: -1, tool: null, object: -1, goal: -1 };
  const cut: Thing[] = [];
  for (const thing of THINGS) {
    const cell = world[thing];
    if (cell === null) continue;
    if (inside(cell)) next = { ...next, [thing]: old(cell) };
    else cut.push(thing);
  }
  for (const thing of cut) {
    const cell = world[thing]!;
    const row = Math.min(Math.floor(cell / world.width), height - 1);
    next = settled(next, thing, row * width + Math.min(cell % world.width, width - 1));
  }
  return next;
}

/** The thing in the nearest cell where nothing is, a wall's if there is no other. */
function settled(world: World, thing: Thing, near: number): World {
  const cells = world.walls.map((_, cell) => cell).filter((cell) => thingAt(world, cell) === null);
  const away = (cell: number) =>
    Math.abs(Math.floor(cell / world.width) - Math.floor(near / world.width)) +
    Math.abs((cell % world.width) - (near % world.width)) +
    (world.walls[cell] ? world.height + world.width : 0);
  const cell = cells.reduce((best, other) => (away(other) < away(best) ? other : best));
  return { ...world, walls: world.walls.with(cell, false), [thing]: cell };
}

/** The map as text; `tool` is the character of the tool, "" to leave plain floor. */
export function mapText(world: World, tool: string): string {
  const cells: string[] = world.walls.map((wall) => (wall ? "#" : "."));
  for (const [thing, mark] of Object.entries(MARKS)) cells[world[thing as Thing]!] = mark;
  if (world.tool !== null && tool) cells[world.tool] = tool;
  return Array.from({ length: world.height }, (_, row) =>
    cells.slice(row * world.width, (row + 1) * world.width).join(""),
  ).join("\n");
}

/** The rows of a map's text, without what is said about it. */
export function rowsOf(text: string): string[] {
  const rows = text.replace(/^\uFEFF/, "").split("\n").map((line) => line.trimEnd());
  return rows.filter((line) => line && !line.startsWith(";"));
}

/** A map from text that the server has found to be one, and the character of its tool. */
export function parseMap(text: string): { world: World; tool: string | null } {
  const rows = rowsOf(text);
  const cells = rows.join("");
  const toolAt = [...cells].findIndex((mark) => !"#.ACG".includes(mark));
  return {
    world: {
      height: rows.length,
      width: rows[0]?.length ?? 0,
      walls: [...cells].map((mark) => mark === "#"),
      agent: cells.indexOf(MARKS.agent),
      tool: toolAt < 0 ? null : toolAt,
      object: cells.indexOf(MARKS.object),
      goal: cells.indexOf(MARKS.goal),
    },
    tool: toolAt < 0 ? null : cells[toolAt]!,
  };
}
