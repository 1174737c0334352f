/** The messages between page and server, as JSON over one WebSocket. */

export type Cell = [row: number, column: number];
export type Sensor = "state" | "object" | "tool" | "agent" | "cells";
export type ActionSet = "all" | "moves" | "tool";

/** A world and a question about it, as the server reads it. */
export interface SceneMessage {
  drawn: Drawn;
  /** "none" if the agent has none of the drawn tools. */
  tool?: string;
  sensor: Sensor;
  thing: number;
  cells: Cell[];
  horizon: number;
  actions: ActionSet;
  slip: number;
}

/** A map: walls as rows of text, and its things. */
export interface Drawn {
  ground: string;
  agent: Cell;
  tools: { kind: string; cell: Cell; slip: number }[];
  objects: { kind: string; cell: Cell; goal: Cell | null }[];
  drop: boolean;
}

/** Where things are; with several tools, which is in hand and which was dropped, -1 for none. */
export interface Placement {
  agent: Cell;
  tools: Cell[];
  objects: Cell[];
  held?: number;
  laid?: number;
}

/** A placement in the server's format, by the library's names. */
export type Words = Record<string, Cell | number>;

export type Drawing = [path: string, fill: string][];

/** The server's greeting. */
export interface Hello {
  version: string;
  worlds: Record<string, Drawn>;
  tools: string[];
  objects: string[];
  actions: string[];
  limits: {
    side: [number, number];
    things: number;
    horizon: number;
    slip: number;
    /** Of a tool's failures. */
    tool_slip: number;
    /** Characters. */
    message: number;
    training: TrainingLimits;
  };
  training: Offered;
  shapes: Record<string, Drawing>;
  run: RunAbout | null;
  /** The folder in which trainings outlive the studio, if there is one. */
  kept: string | null;
}

/** The choices of a training: labels by name. */
export interface Offered {
  intrinsic: Record<string, string>;
  algorithms: Record<string, string>;
  /** Intrinsic rewards without a horizon. */
  without_horizon: string[];
  first: Settings;
}

/** The settings of a training. */
export interface Settings {
  intrinsic: string;
  horizon: number;
  beta: number;
  runs: number;
  seed: number;
  algorithm: string;
  episodes: number;
}

/** The upper limits of a training. */
export interface TrainingLimits {
  runs: number;
  seed: number;
  episodes: number;
  placements: number;
  at_once: number;
  waiting: number;
}

/** A trained run that the server can replay. */
export interface RunAbout {
  name: string;
  /** The name to request a training by; absent for the folder's own run. */
  asked?: string;
  runs: number;
  drawn: Drawn;
  config: Record<string, unknown>;
}

/** The fields that any answer may have, each alone. */
export interface Common {
  id: number;
  error?: string;
  progress?: number;
  overtaken?: boolean;
  /** Set by the page: the connection was lost, and no further answers will come. */
  lost?: boolean;
}

export type Grid = (number | null)[][];

export interface Verdict {
  useful: boolean;
  /** Null if the estimates leave it open. */
  better_than_none: boolean | null;
  /** The same as with none. */
  equal: boolean;
}

export interface LandscapeAnswer extends Common {
  landscape?: Grid;
  least?: number | null;
  most?: number | null;
  seconds?: number;
}

export interface MeasureAnswer extends LandscapeAnswer {
  /** Null if it takes too long; `why` has the reason. */
  averages?: Record<string, number | null>;
  /** Half the widths of their 95 % intervals; 0 if exact. */
  within?: Record<string, number>;
  why?: string;
  verdicts?: Record<string, Verdict>;
}

export interface FuturesAnswer extends Common {
  bits?: number;
  things?: [row: number, column: number, probability: number][];
  count?: number;
}

export interface SolveAnswer extends Common {
  steps?: number | null;
  actions?: number[];
}

export interface ReadAnswer extends Common {
  drawn?: Drawn;
  text?: string;
}

export interface StepAnswer extends Common {
  placement?: Words;
  bits?: number;
  equipped?: boolean;
  attached?: boolean;
  reward?: number;
  ended?: boolean;
}

/** The statistic of some runs and its interval, point by point. */
export interface CurveData {
  x: number[];
  low: number[];
  high: number[];
  mean: number[];
  runs: number;
}

export interface TrainAnswer extends Common {
  /** The name of its folder. */
  name?: string;
  curve?: CurveData | null;
  /** Over all runs. */
  steps?: number;
  episodes?: number;
  share?: number;
  steps_per_second?: number;
  best_return?: number;
  done?: { name: string; runs: number; converged_at: (number | null)[]; best_return: number };
}

export interface TrainingsAnswer extends Common {
  /** The listed trainings, newest first. */
  names?: string[];
  /** The number of older ones that are not listed. */
  left_out?: number;
  kept?: KeptTraining;
}

/** A training with a folder on the server: either its error, or the other fields. */
export interface KeptTraining {
  name: string;
  under_way: boolean;
  error?: string;
  runs?: number;
  config?: Record<string, unknown>;
  drawn?: Drawn;
  ended?: boolean;
  converged_at?: (number | null)[] | null;
  best_return?: number | null;
}

export interface RunAnswer extends Common {
  drawn?: Drawn;
  policy?: { episode: number[][]; cells: (number[] | null)[][] };
  values?: Grid;
  episode?: Episode;
  curve?: CurveData | null;
  best_return?: number;
}

/** An episode of the greedy policy. */
export interface Episode {
  placements: Words[];
  actions: number[];
  values: number[];
  return: number;
  finished: boolean;
  /** The best possible from its start; null if the goal is unreachable. */
  best_return: number | null;
}
