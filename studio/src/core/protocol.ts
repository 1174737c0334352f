/** What the page and the server say to each other, as JSON over one WebSocket. */

export type Cell = [row: number, column: number];
export type Sensor = "state" | "object" | "tool" | "agent" | "cells";
export type ActionSet = "all" | "moves" | "tool";

/** A world and a question about it, as the server reads it. */
export interface SceneMessage {
  drawn: Drawn;
  /** "none" where the agent has none of those that are drawn. */
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

/** Where things are; of several tools, which is in hand and which was put down, -1 for none. */
export interface Placement {
  agent: Cell;
  tools: Cell[];
  objects: Cell[];
  held?: number;
  laid?: number;
}

/** A placement as the server says it, by the library's names. */
export type Words = Record<string, Cell | number>;

export type Drawing = [path: string, fill: string][];

/** What the server says first. */
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
    /** Characters. */
    message: number;
    training: TrainingLimits;
  };
  training: Offered;
  shapes: Record<string, Drawing>;
  run: RunAbout | null;
  /** The folder in which trainings are kept beyond the studio's end, if they are. */
  kept: string | null;
}

/** What a training may choose from, by name, in words. */
export interface Offered {
  intrinsic: Record<string, string>;
  algorithms: Record<string, string>;
  /** Intrinsic rewards that look no steps ahead. */
  without_horizon: string[];
  first: Settings;
}

/** What a training is asked to do. */
export interface Settings {
  intrinsic: string;
  horizon: number;
  beta: number;
  runs: number;
  seed: number;
  algorithm: string;
  episodes: number;
}

/** The most that a training may take. */
export interface TrainingLimits {
  runs: number;
  episodes: number;
  placements: number;
  at_once: number;
  waiting: number;
}

/** A trained run that the server can act out. */
export interface RunAbout {
  name: string;
  /** By which a training is asked for; none of the folder's own run. */
  asked?: string;
  runs: number;
  drawn: Drawn;
  config: Record<string, unknown>;
}

/** What any answer may have; nothing else is in it then. */
export interface Common {
  id: number;
  error?: string;
  progress?: number;
  overtaken?: boolean;
  /** Not from the server: the line to it was lost, and nothing more will come. */
  lost?: boolean;
}

export type Grid = (number | null)[][];

export interface Verdict {
  useful: boolean;
  /** Null where estimates leave it open. */
  better_than_none: boolean | null;
  /** As much as with none. */
  equal: boolean;
}

export interface LandscapeAnswer extends Common {
  landscape?: Grid;
  least?: number | null;
  most?: number | null;
  seconds?: number;
}

export interface MeasureAnswer extends LandscapeAnswer {
  /** Null where it takes too long; then `why` says so. */
  averages?: Record<string, number | null>;
  /** Half the widths of their 95 % intervals: 0 where they are exact. */
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
  /** That of the folder in which it trains. */
  name?: string;
  curve?: CurveData | null;
  /** Of all runs together. */
  steps?: number;
  episodes?: number;
  share?: number;
  steps_per_second?: number;
  best_return?: number;
  done?: { name: string; runs: number; converged_at: (number | null)[]; best_return: number };
}

export interface TrainingsAnswer extends Common {
  /** Of all that are listed, the latest first. */
  names?: string[];
  /** How many earlier ones are not. */
  left_out?: number;
  kept?: KeptTraining;
}

/** A training that the server has a folder of; what is wrong with it, or the rest. */
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

/** What the most probable actions come to. */
export interface Episode {
  placements: Words[];
  actions: number[];
  values: number[];
  return: number;
  finished: boolean;
  /** The best possible from where it began; null where there is no way to the goal. */
  best_return: number | null;
}
