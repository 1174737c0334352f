/** The whole state in the link's fragment: `#w=10x10.AAA.28.66.77.35&t=picker&h=3`. */

import type { ActionSet, Sensor } from "./protocol";
import { ACTION_SETS, NO_TOOL, SENSORS, toolOf, type Scene } from "./scene";
import { standing, thingAt, type Thing, type Tool, type World } from "./world";

export const FRESH: Omit<Scene, "world" | "bare"> = {
  sensor: "object",
  thing: 0,
  cells: [],
  horizon: 3,
  actions: "all",
  slip: 0,
};

/** What there is to choose from. */
export interface Known {
  readonly tools: readonly string[];
  readonly objects: readonly string[];
  readonly limits: { readonly side: readonly [number, number]; readonly things: number };
}

/** What comes after the `#`; what is as in a fresh page is left out. */
export function toFragment(scene: Scene, view: string): string {
  const { world } = scene;
  const tool = toolOf(scene) ?? world.tools[0]!.kind;
  const parts = [`w=${worldCode(world)}`, `t=${encodeURIComponent(tool)}`];
  const [first, ...things] = world.objects;
  const more = [...world.tools.slice(1).map(toolCode), ...things.map(thingCode)];
  if (more.length) parts.push(`m=${more.join(",")}`);
  if (first!.kind !== FIRST_OBJECT) parts.push(`o=${first!.kind}`);
  if (world.tools[0]?.slip) parts.push(`f=${world.tools[0].slip}`);
  if (world.drop) parts.push("d=1");
  if (scene.sensor !== FRESH.sensor) parts.push(`s=${scene.sensor}`);
  if (scene.thing) parts.push(`n=${scene.thing}`);
  if (scene.sensor === "cells" && scene.cells.length) parts.push(`c=${scene.cells.join(".")}`);
  if (scene.horizon !== FRESH.horizon) parts.push(`h=${scene.horizon}`);
  if (scene.actions !== FRESH.actions) parts.push(`x=${scene.actions}`);
  if (scene.slip !== FRESH.slip) parts.push(`p=${scene.slip}`);
  if (view !== "design") parts.push(`v=${view}`);
  return parts.join("&");
}

/** The scene and the view that a fragment says, or null if it is none of ours. */
export function fromFragment(fragment: string, known: Known): { scene: Scene; view: string } | null {
  const said = new URLSearchParams(fragment.replace(/^#/, ""));
  const world = worldOf(said, known);
  if (world === null) return null;
  const number = (name: string, fresh: number, most: number) => {
    const value = Number(said.get(name) ?? fresh);
    return Number.isFinite(value) ? Math.min(Math.max(value, 0), most) : fresh;
  };
  const one = <Name extends string>(name: string, of: object, fresh: Name): Name => {
    const value = said.get(name);
    return value !== null && Object.hasOwn(of, value) ? (value as Name) : fresh;
  };
  const count = world.height * world.width;
  const bare = !world.tools.length || !known.tools.includes(said.get("t") ?? "") || said.get("t") === NO_TOOL;
  const sensor = one<Sensor>("s", SENSORS, FRESH.sensor);
  const among = sensor === "tool" ? world.tools : world.objects;
  return {
    scene: {
      world,
      bare,
      sensor: bare && sensor === "tool" ? FRESH.sensor : sensor,
      thing: Math.round(number("n", 0, Math.max(among.length - 1, 0))),
      cells: (said.get("c") ?? "")
        .split(".")
        .filter((part) => /^\d+$/.test(part) && Number(part) < count)
        .map(Number),
      horizon: Math.round(number("h", FRESH.horizon, 10)),
      actions: one<ActionSet>("x", ACTION_SETS, FRESH.actions),
      slip: number("p", FRESH.slip, 0.5),
    },
    view: said.get("v") ?? "design",
  };
}

const FIRST_OBJECT = "can";

const toolCode = ({ kind, cell, slip }: Tool) =>
  `${encodeURIComponent(kind)}@${cell}${slip ? `*${slip}` : ""}`;
const thingCode = ({ kind, cell, goal }: Thing) => `${kind}@${cell}${goal === null ? "" : `>${goal}`}`;

function worldCode(world: World): string {
  const [tool, thing] = [world.tools[0], world.objects[0]!];
  const places = [world.agent, tool?.cell ?? "-", thing.cell, thing.goal ?? "-"];
  return [`${world.height}x${world.width}`, bitsCode(world.walls), ...places].join(".");
}

function worldOf(said: URLSearchParams, { tools, objects, limits }: Known): World | null {
  const [size = "", bits = "", ...places] = (said.get("w") ?? "").split(".");
  const [least, most] = limits.side;
  const [height = 0, width = 0] = size.split("x").map(Number);
  const fits = (side: number) => Number.isInteger(side) && side >= least && side <= most;
  if (!fits(height) || !fits(width) || places.length !== 4) return null;
  const walls = bitsOf(bits, height * width);
  if (walls === null) return null;
  const [agent, tool, cell, goal] = places.map((place) => (place === "-" ? null : Number(place)));
  if (agent === null || cell === null || goal === null) return null;
  const kind = said.get("t") ?? NO_TOOL;
  const usual = tools.includes(kind) && kind !== NO_TOOL ? kind : tools[0]!;
  const slip = (value: string | undefined) => Math.min(Math.max(Number(value) || 0, 0), 1);
  const drawn = { tools: [] as Tool[], objects: [] as Thing[] };
  if (tool !== null) drawn.tools.push({ kind: usual, cell: tool!, slip: slip(said.get("f") ?? "") });
  const first = said.get("o") ?? FIRST_OBJECT;
  if (!objects.includes(first)) return null;
  drawn.objects.push({ kind: first, cell: cell!, goal: goal! });
  for (const code of (said.get("m") ?? "").split(",").filter(Boolean)) {
    const [, name = "", at, fails, to] = /^([^@]+)@(\d+)(?:\*([\d.]+))?(?:>(\d+))?$/.exec(code) ?? [];
    if (objects.includes(name)) {
      drawn.objects.push({ kind: name, cell: Number(at), goal: to === undefined ? null : Number(to) });
    } else if (tools.includes(name)) drawn.tools.push({ kind: name, cell: Number(at), slip: slip(fails) });
    else return null;
  }
  if (Math.max(drawn.tools.length, drawn.objects.length) > limits.things) return null;
  const drop = said.get("d") === "1";
  const world: World = { height, width, walls, agent: agent!, ...drawn, drop };
  const sound = standing(world).every(([thing, at]) => {
    const there = thingAt(world, at);
    return walls[at] === false && there?.what === thing.what && there.of === thing.of;
  });
  return sound ? world : null;
}

function bitsCode(bits: readonly boolean[]): string {
  const bytes = new Uint8Array(Math.ceil(bits.length / 8));
  bits.forEach((bit, k) => {
    if (bit) bytes[k >> 3]! |= 128 >> (k & 7);
  });
  const base64 = btoa(String.fromCharCode(...bytes));
  return base64.replaceAll("+", "-").replaceAll("/", "_").replace(/=+$/, "");
}

function bitsOf(code: string, count: number): boolean[] | null {
  try {
    const bytes = atob(code.replaceAll("-", "+").replaceAll("_", "/"));
    if (bytes.length !== Math.ceil(count / 8)) return null;
    return Array.from(
      { length: count },
      (_, k) => (bytes.charCodeAt(k >> 3) & (128 >> (k & 7))) > 0,
    );
  } catch {
    return null;
  }
}
