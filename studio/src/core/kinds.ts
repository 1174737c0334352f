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

export const KIND_SENTENCES: Record<Kind, string> = {
  "open-loop": "How many futures the agent can choose from, by a plan made in advance.",
  effective: "How much one action still changes later, if the agent then acts at random.",
  "closed-loop": "How many futures it can choose from if it looks after every step.",
  "goal-directed": "How many of its futures lead on to the goal.",
};

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
