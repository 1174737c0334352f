/** The whole state in the link's fragment: `#w=10x10.AAA.28.66.77.35&t=picker&h=3`. */

import { FRESH_KIND, KIND_NAMES, kindParts } from "./kinds";
import type { ActionSet, Kind } from "./protocol";
import { ACTION_SETS, NO_TOOL, SENSORS, toolOf, type Scene, type Sensor } from "./scene";
import { standing, thingAt, type Standing, type Thing, type Tool, type World } from "./world";

export const FRESH: Omit<Scene, "world" | "bare"> = {
  sensor: "object",
  thing: 0,
  cells: [],
  horizon: 3,
  actions: "all",
  slip: 0,
  ...FRESH_KIND,
};

/** The available choices, from the server's greeting. */
export interface Known {
  readonly tools: readonly string[];
  readonly objects: readonly string[];
  readonly limits: {
    readonly side: readonly [number, number];
    readonly things: number;
    readonly horizon: number;
    readonly discount: number;
    readonly slack: number;
    readonly slip: number;
    readonly tool_slip: number;
  };
}

/** The readable part of a link. */
export interface Opened {
  /** Null where there is no link, or its map cannot be read. */
  readonly shown: { readonly scene: Scene; readonly view: string } | null;
  /** Its problems, each a clause. */
  readonly faults: readonly string[];
}

const FIELDS = ["w", "t", "m", "o", "f", "d", "s", "n", "c", "h", "k", "g", "l", "x", "p", "v"];
const FIRST_OBJECT = "can";
const FIRST_VIEW = "design";
const LONGEST = 40; // characters of a link that are quoted

/** The part after the `#`; defaults are omitted. */
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
  parts.push(...kindParts(scene));
  if (scene.actions !== FRESH.actions) parts.push(`x=${scene.actions}`);
  if (scene.slip !== FRESH.slip) parts.push(`p=${scene.slip}`);
  if (view !== FIRST_VIEW) parts.push(`v=${view}`);
  return parts.join("&");
}

/** The scene and the view of a fragment, and the parts of it that cannot be shown. */
export function fromFragment(fragment: string, known: Known, views: readonly string[]): Opened {
  const fields = new URLSearchParams(fragment.replace(/^#/, ""));
  const names = [...fields.keys()];
  if (!names.length) return { shown: null, faults: [] };
  if (!names.some((name) => FIELDS.includes(name))) {
    return { shown: null, faults: [`${quoted(fragment)} is not a link of the studio`] };
  }
  const faults: string[] = [];
  for (const name of new Set(names)) {
    if (!FIELDS.includes(name)) faults.push(`its field ${quoted(name)} is unknown`);
    else if (fields.getAll(name).length > 1) faults.push(`its field ${name} occurs more than once, and the first is used`);
  }
  try {
    return { shown: read(fields, known, views, faults), faults };
  } catch (error) {
    if (!(error instanceof Unreadable)) throw error;
    return { shown: null, faults: [error.message] };
  }
}

/** The error of a link without a readable map. */
class Unreadable extends Error {}

/** The scene of a link that has a map; other problems are added to `faults`. */
function read(fields: URLSearchParams, known: Known, views: readonly string[], faults: string[]): { scene: Scene; view: string } {
  const { limits } = known;
  const { world, complete } = worldOf(fields, known, faults);
  const bare = !world.tools.length || (fields.get("t") ?? NO_TOOL) === NO_TOOL;
  const one = <Name extends string>(what: string, name: string, of: readonly string[], fresh: Name): Name => {
    const value = fields.get(name) ?? fresh;
    if (of.includes(value)) return value as Name;
    faults.push(`its ${what} ${quoted(value)} is unknown, and ${fresh} is used`);
    return fresh;
  };
  const number = (what: string, name: string, fresh: number, most: number, whole: boolean) =>
    numberOf(what, fields.get(name), fresh, most, whole, faults);

  let sensor = one<Sensor>("sensor", "s", Object.keys(SENSORS), FRESH.sensor);
  let thing = 0;
  if (!complete && (sensor === "tool" || fields.get("n") !== null)) {
    faults.push("the thing it observes may have been left out, and the first object is observed");
    sensor = FRESH.sensor;
  } else if (bare && sensor === "tool") {
    faults.push("it observes a tool without having one, and the object is observed");
    sensor = FRESH.sensor;
  } else {
    const among = sensor === "tool" ? world.tools : world.objects;
    thing = number("observed thing", "n", 0, among.length - 1, true);
  }
  const cells = (fields.get("c") ?? "").split(".").filter(Boolean);
  const there = (cell: string) => /^\d+$/.test(cell) && Number(cell) < world.height * world.width;
  const beyond = cells.find((cell) => !there(cell));
  if (beyond !== undefined) faults.push(`its chosen cell ${quoted(beyond)} is not on the map, and is left out`);
  return {
    scene: {
      world,
      bare,
      sensor,
      thing,
      cells: [...new Set(cells.filter(there).map(Number))],
      horizon: number("horizon", "h", FRESH.horizon, limits.horizon, true),
      kind: one<Kind>("kind of empowerment", "k", Object.keys(KIND_NAMES), FRESH.kind),
      discount: number("discount", "g", FRESH.discount, limits.discount, false),
      slack: number("slack", "l", FRESH.slack, limits.slack, true),
      actions: one<ActionSet>("set of actions", "x", Object.keys(ACTION_SETS), FRESH.actions),
      slip: number("slip", "p", FRESH.slip, limits.slip, false),
    },
    view: one("view", "v", views, FIRST_VIEW),
  };
}

/** A number from 0 to `most`: too large a number becomes `most`, anything else `fresh`. */
function numberOf(
  what: string, text: string | null, fresh: number, most: number, whole: boolean, faults: string[],
): number {
  if (text === null) return fresh;
  const value = /^\d+(\.\d+)?(e-?\d+)?$/i.test(text) ? Number(text) : NaN;
  const sound = Number.isNaN(value) || (whole && !Number.isInteger(value)) ? fresh : Math.min(value, most);
  if (sound !== value) {
    faults.push(`its ${what} ${quoted(text)} is not a ${whole ? "whole " : ""}number from 0 to ${most}, and ${sound} is used`);
  }
  return sound;
}

/** As in `m=rake@12*0.1,ball@30>44`. A name, such as a path, may contain any character. */
const toolCode = ({ kind, cell, slip }: Tool) =>
  `${encodeURIComponent(encodeURIComponent(kind))}@${cell}${slip ? `*${slip}` : ""}`;
const thingCode = ({ kind, cell, goal }: Thing) => `${kind}@${cell}${goal === null ? "" : `>${goal}`}`;

function worldCode(world: World): string {
  const [tool, thing] = [world.tools[0], world.objects[0]!];
  const places = [world.agent, tool?.cell ?? "-", thing.cell, thing.goal ?? "-"];
  return [`${world.height}x${world.width}`, bitsCode(world.walls), ...places].join(".");
}

/** The map of a link, and whether it has all of the link's things. */
function worldOf(
  fields: URLSearchParams, { tools, objects, limits }: Known, faults: string[],
): { world: World; complete: boolean } {
  const code = fields.get("w");
  if (code === null) throw new Unreadable("it has no map (its field w)");
  const [size = "", bits = "", ...places] = code.split(".");
  const [, height, width] = (/^(\d+)x(\d+)$/.exec(size) ?? []).map(Number);
  const damaged = new Unreadable(`its map ${quoted(code)} is damaged`);
  if (height === undefined || width === undefined) throw damaged;
  const [least, most] = limits.side;
  if (Math.min(height, width) < least || Math.max(height, width) > most) {
    throw new Unreadable(`its map has ${size.replace("x", " × ")} cells, and a map has ${least} to ${most} rows and columns`);
  }
  const walls = bitsOf(bits, height * width);
  if (walls === null || places.length !== 4) throw damaged;
  if (!places.every((place, k) => /^\d+$/.test(place) || (k === 1 && place === "-"))) throw damaged;
  const [agent, tool, cell, goal] = places.map(Number) as [number, number, number, number];

  const drawn = { tools: [] as Tool[], objects: [] as Thing[] };
  const slip = (text: string | null) => numberOf("tool's slip", text, 0, limits.tool_slip, false, faults);
  let complete = true;
  const leaveOut = (kind: string, what: string) => {
    faults.push(`its ${what} ${quoted(kind)} is unknown here, and is left out${kind.includes(":") ? " (start the studio with --tool)" : ""}`);
    complete = false;
  };
  const kind = fields.get("t");
  if (kind === null) faults.push("it does not name the tool in use (its field t)");
  if (!Number.isNaN(tool)) {
    // The link does not give the kind of a tool that the agent does not have.
    const own = kind === null || kind === NO_TOOL ? tools[0]! : kind;
    if (tools.includes(own)) drawn.tools.push({ kind: own, cell: tool, slip: slip(fields.get("f")) });
    else leaveOut(own, "tool");
  } else if (kind !== null && !tools.includes(kind)) leaveOut(kind, "tool");
  const first = fields.get("o") ?? FIRST_OBJECT;
  if (!objects.includes(first)) throw new Unreadable(`its object ${quoted(first)} is unknown here`);
  drawn.objects.push({ kind: first, cell, goal });
  for (const part of (fields.get("m") ?? "").split(",").filter(Boolean)) {
    const [, name, at, fails, to] = /^(.+)@(\d+)(?:\*([^>]*))?(?:>(\d+))?$/.exec(part) ?? [];
    const kind = decoded(name ?? "");
    if (!kind) throw new Unreadable(`its thing ${quoted(part)} is damaged`);
    if (objects.includes(kind) && fails === undefined) {
      drawn.objects.push({ kind, cell: Number(at), goal: to === undefined ? null : Number(to) });
    } else if (tools.includes(kind) && kind !== NO_TOOL && to === undefined) {
      drawn.tools.push({ kind, cell: Number(at), slip: slip(fails ?? null) });
    } else leaveOut(kind, "tool or object");
  }
  const count = Math.max(drawn.tools.length, drawn.objects.length);
  if (count > limits.things) throw new Unreadable(`its map has ${count} tools or objects, and a map has up to ${limits.things}`);
  const drop = fields.get("d") ?? "0";
  if (drop !== "0" && drop !== "1") faults.push(`its field d is ${quoted(drop)}, not 1, and tools cannot be dropped`);
  const world: World = { height, width, walls, agent, ...drawn, drop: drop === "1" };
  for (const [thing, at] of standing(world)) {
    const there = thingAt(world, at);
    if (walls[at] === undefined) throw new Unreadable(`${wordFor(thing, world)} of its map lies outside the map`);
    if (walls[at]) throw new Unreadable(`${wordFor(thing, world)} of its map is in a wall`);
    if (there?.what !== thing.what || there.of !== thing.of) {
      throw new Unreadable(`${wordFor(thing, world)} of its map shares a cell with ${wordFor(there!, world)}`);
    }
  }
  return { world, complete };
}

function wordFor({ what, of }: Standing, { tools, objects }: World): string {
  if (what === "agent") return "the agent";
  if (what === "goal") return `the bin of the ${objects[of]!.kind}`;
  return `the ${(what === "tool" ? tools : objects)[of]!.kind}`;
}

/** Text from an unknown source, truncated to fit on a line. */
function quoted(text: string): string {
  return `“${text.length > LONGEST ? `${text.slice(0, LONGEST)}…` : text}”`;
}

function decoded(text: string): string {
  try {
    return decodeURIComponent(text);
  } catch {
    return "";
  }
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
