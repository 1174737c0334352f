/** The whole state in the link's fragment: `#w=10x10.AAA.28.66.77.35&t=picker&h=3`. */

import type { ActionSet, Sensor } from "./protocol";
import { ACTION_SETS, SENSORS, type Scene } from "./scene";
import { THINGS, thingAt, type World } from "./world";

export const FRESH: Omit<Scene, "world" | "tool"> = {
  sensor: "object",
  cells: [],
  horizon: 3,
  actions: "all",
  slip: 0,
};

/** What comes after the `#`; what is as in a fresh page is left out. */
export function toFragment(scene: Scene, view: string): string {
  const parts = [`w=${worldCode(scene.world)}`, `t=${encodeURIComponent(scene.tool)}`];
  if (scene.sensor !== FRESH.sensor) parts.push(`s=${scene.sensor}`);
  if (scene.sensor === "cells" && scene.cells.length) parts.push(`c=${scene.cells.join(".")}`);
  if (scene.horizon !== FRESH.horizon) parts.push(`h=${scene.horizon}`);
  if (scene.actions !== FRESH.actions) parts.push(`x=${scene.actions}`);
  if (scene.slip !== FRESH.slip) parts.push(`p=${scene.slip}`);
  if (view !== "design") parts.push(`v=${view}`);
  return parts.join("&");
}

/** The scene and the view that a fragment says, or null if it is none of ours. */
export function fromFragment(
  fragment: string,
  tools: readonly string[],
  sides: readonly [number, number],
): { scene: Scene; view: string } | null {
  const said = new URLSearchParams(fragment.replace(/^#/, ""));
  const world = worldOf(said.get("w") ?? "", sides);
  if (world === null) return null;
  const number = (name: string, fresh: number, most: number) => {
    const value = Number(said.get(name) ?? fresh);
    return Number.isFinite(value) ? Math.min(Math.max(value, 0), most) : fresh;
  };
  const one = <Name extends string>(name: string, known: object, fresh: Name): Name => {
    const value = said.get(name);
    return value !== null && Object.hasOwn(known, value) ? (value as Name) : fresh;
  };
  const wanted = said.get("t") ?? "none";
  const tool = tools.includes(wanted) && world.tool !== null ? wanted : "none";
  const sensor = one<Sensor>("s", SENSORS, FRESH.sensor);
  const count = world.height * world.width;
  return {
    scene: {
      world,
      tool,
      sensor: sensor === "tool" && tool === "none" ? FRESH.sensor : sensor,
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

function worldCode(world: World): string {
  const places = THINGS.map((thing) => world[thing] ?? "-");
  return [`${world.height}x${world.width}`, bitsCode(world.walls), ...places].join(".");
}

function worldOf(code: string, [least, most]: readonly [number, number]): World | null {
  const [size = "", bits = "", ...places] = code.split(".");
  const [height = 0, width = 0] = size.split("x").map(Number);
  const fits = (side: number) => Number.isInteger(side) && side >= least && side <= most;
  if (!fits(height) || !fits(width) || places.length !== THINGS.length) return null;
  const walls = bitsOf(bits, height * width);
  if (walls === null) return null;
  const [agent, tool, object, goal] = places.map((place) => (place === "-" ? null : Number(place)));
  const world = { height, width, walls, agent, tool, object, goal } as World;
  const sound = THINGS.every((thing) => {
    const cell = world[thing];
    if (cell === null) return thing === "tool";
    return walls[cell] === false && thingAt(world, cell) === thing;
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
