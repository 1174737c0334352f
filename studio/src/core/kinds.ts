/** The kinds of empowerment, and the settings of each. */

import type { Kind, Scene as SceneMessage } from "./protocol";

export interface KindSettings {
  readonly kind: Kind;
  readonly discount: number;
  readonly slack: number;
}

export const KIND_NAMES: Record<Kind, string> = {
  "open-loop": "Open loop",
  effective: "Effective",
  "closed-loop": "Closed loop",
  "goal-directed": "Goal-directed",
};

/** What a kind measures. */
export function sentenceOn({ kind, discount, slack }: KindSettings): string {
  switch (kind) {
    case "open-loop":
      return "How many outcomes a plan made in advance can reach.";
    case "closed-loop":
      return "How many outcomes it can reach if it looks after every step.";
    case "effective":
      return `How much one action decides about ${steps(1 / (1 - discount))} later, if the rest is random.`;
    case "goal-directed":
      return slack
        ? `How many outcomes lie on paths to the goal that are at most ${steps(slack)} longer than the shortest.`
        : "How many outcomes lie on the shortest paths to the goal.";
  }
}

const steps = (count: number) => `${Number(count.toFixed(1))} ${count === 1 ? "step" : "steps"}`;

/** The hint below a landscape: only plans made in advance have futures to be marked. */
export function hintOf(kind: Kind, gap: number): string {
  if (kind === "open-loop") return "Point at a cell to see which futures are reachable from it.";
  const low = gap < 0.005 ? "" : ` Values may be up to ${gap.toFixed(2)} bits too low.`;
  return `Point at a cell to read its value.${low}`;
}

/** The kinds that are over all actions. */
export const OVER_ALL: readonly Kind[] = ["effective", "goal-directed"];

export const FRESH_KIND: KindSettings = { kind: "open-loop", discount: 0.9, slack: 2 };

/** The kind in the server's format: with none but its own settings. */
export function kindMessage({ kind, discount, slack }: KindSettings): Pick<SceneMessage, "kind" | "discount" | "slack"> {
  if (kind === "effective") return { kind, discount };
  return kind === "goal-directed" ? { kind, slack } : { kind };
}

/** The parts of a link; what is as in `FRESH_KIND` is left out. */
export function kindParts({ kind, discount, slack }: KindSettings): string[] {
  return [
    ...(kind === FRESH_KIND.kind ? [] : [`k=${kind}`]),
    ...(kind === "effective" && discount !== FRESH_KIND.discount ? [`g=${discount}`] : []),
    ...(kind === "goal-directed" && slack !== FRESH_KIND.slack ? [`l=${slack}`] : []),
  ];
}
