/** A world and the question asked about it: the content of a link to the page. */

import { kindMessage, OVER_ALL, type KindSettings } from "./kinds";
import type { ActionSet, Cell, Placement, Scene as SceneMessage, Sensor as AnySensor } from "./protocol";
import { drawnOf, namesOf, type Tool, type World } from "./world";

/** Sensors of maps. */
export type Sensor = Exclude<AnySensor, "factor">;

export interface Scene extends KindSettings {
  readonly world: World;
  /** Whether the agent uses no tool, even if one is on the map. */
  readonly bare: boolean;
  readonly sensor: Sensor;
  /** Which of several objects, or tools, is observed. */
  readonly thing: number;
  /** The cells in which the sensor "cells" observes the object. */
  readonly cells: readonly number[];
  readonly horizon: number;
  readonly actions: ActionSet;
  readonly slip: number;
}

export const SENSORS: Record<Sensor, string> = {
  object: "Can",
  state: "Everything",
  tool: "Tool",
  agent: "Agent",
  cells: "Chosen cells",
};

export const ACTION_SETS: Record<ActionSet, string> = {
  all: "All",
  moves: "Moves",
  tool: "Tool",
};

export const NO_TOOL = "none";

export function cellOf(world: Pick<World, "width">, index: number): Cell {
  return [Math.floor(index / world.width), index % world.width];
}

export function indexOf(world: World, [row, column]: Cell): number {
  return row * world.width + column;
}

/** The tools that the agent can use. */
export function toolsOf({ world, bare }: Scene): readonly Tool[] {
  return bare ? [] : world.tools;
}

/** The kind of its only tool, or "none"; null if there are several. */
export function toolOf(scene: Scene): string | null {
  const [first, ...others] = toolsOf(scene);
  return others.length ? null : (first?.kind ?? NO_TOOL);
}

/** The name of the object that the question is about; the first object if it is about all. */
export function objectOf({ world, sensor, thing }: Scene): string {
  return namesOf(world.objects)[sensor === "tool" ? 0 : thing] ?? namesOf(world.objects)[0]!;
}

/** The scene with a question that its world can answer. */
export function fitted(scene: Scene): Scene {
  const among = scene.sensor === "tool" ? toolsOf(scene) : scene.world.objects;
  const sensor = scene.sensor === "tool" && !among.length ? "object" : scene.sensor;
  return { ...scene, sensor, thing: sensor === scene.sensor && scene.thing < among.length ? scene.thing : 0 };
}

/** The scene in the server's format. */
export function message(scene: Scene): SceneMessage & Required<Pick<SceneMessage, "drawn" | "horizon" | "slip">> {
  const { world, bare, sensor, thing, cells, horizon, actions, slip } = scene;
  return {
    drawn: drawnOf(world),
    ...(bare ? { tool: NO_TOOL } : {}),
    sensor,
    thing,
    cells: sensor === "cells" ? cells.map((cell) => cellOf(world, cell)) : [],
    horizon,
    ...kindMessage(scene),
    actions: toolsOf(scene).length && !OVER_ALL.includes(scene.kind) ? actions : "all",
    slip,
  };
}

/** The placement on the map. */
export function startOf(scene: Scene): Placement {
  const { world } = scene;
  return {
    agent: cellOf(world, world.agent),
    tools: toolsOf(scene).map(({ cell }) => cellOf(world, cell)),
    objects: world.objects.map(({ cell }) => cellOf(world, cell)),
  };
}
