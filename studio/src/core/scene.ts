/** A world and the question asked about it: all that a link to the page says. */

import type { ActionSet, Cell, Placement, SceneMessage, Sensor } from "./protocol";
import { mapText, type World } from "./world";

export interface Scene {
  readonly world: World;
  /** A tool's name, or "none". */
  readonly tool: string;
  readonly sensor: Sensor;
  /** The cells that the sensor "cells" can see the can in. */
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

/** Marks the tool's place whichever tool it is: the scene says that by name. */
const ANY_TOOL = "P";

export function cellOf(world: World, index: number): Cell {
  return [Math.floor(index / world.width), index % world.width];
}

export function indexOf(world: World, [row, column]: Cell): number {
  return row * world.width + column;
}

/** The scene as the server reads it. */
export function message(scene: Scene): SceneMessage {
  const { world, tool, sensor, cells, horizon, actions, slip } = scene;
  return {
    map: mapText(world, ANY_TOOL),
    tool,
    sensor,
    cells: sensor === "cells" ? cells.map((cell) => cellOf(world, cell)) : [],
    horizon,
    actions: tool === "none" ? "all" : actions,
    slip,
  };
}

/** Where the map has its things. */
export function startOf(scene: Scene): Placement {
  const { world, tool } = scene;
  return {
    agent: cellOf(world, world.agent),
    tool: tool === "none" || world.tool === null ? null : cellOf(world, world.tool),
    object: cellOf(world, world.object),
  };
}
