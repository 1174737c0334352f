/** What a training is asked to do, as the page lets one choose it. */

import type { App } from "../core/app";
import { h } from "../core/elements";
import { field, numberField, select } from "../frame/widgets";

export interface Settings {
  intrinsic: string;
  horizon: number;
  beta: number;
  runs: number;
  seed: number;
  algorithm: string;
  episodes: number;
}

const INTRINSIC: Record<string, string> = {
  none: "None",
  object: "Empowerment over the can",
  state: "Empowerment over everything",
  tool: "Empowerment over the tool",
  agent: "Empowerment over the agent",
  count: "Counts of visits",
  rnd: "Random network distillation",
};
const ALGORITHMS: Record<string, string> = {
  a2c: "A2C",
  ppo: "PPO",
  "q-learning": "Q-learning",
  "soft-value-iteration": "Soft value iteration",
};

export function createForm({ hello }: App): { element: HTMLElement; settings: () => Settings } {
  const limits = hello.limits.training;
  const intrinsic = select("Intrinsic reward", INTRINSIC, show);
  intrinsic.id = "intrinsic";
  intrinsic.value = "object";
  const algorithm = select("Algorithm", ALGORITHMS, () => undefined);
  algorithm.id = "algorithm";
  const horizon = numberField("Steps ahead", {
    id: "train-horizon", least: 1, most: hello.limits.horizon, step: 1, value: 3,
  });
  const beta = numberField("Weight β", { id: "beta", least: 0, most: 10, step: 0.01, value: 0.08 });
  const runs = numberField("Runs", { id: "runs", least: 1, most: limits.runs, step: 1, value: 5 });
  const seed = numberField("Seed", { id: "seed", least: 0, most: 2 ** 32 - 1, step: 1, value: 0 });
  const episodes = numberField("Episodes", {
    id: "episodes", least: 1, most: limits.episodes, step: 1, value: 2000,
  });

  function show(): void {
    const name = intrinsic.value;
    horizon.input.disabled = name === "none" || name === "count" || name === "rnd";
    beta.input.disabled = name === "none";
  }
  show();
  const value = ({ input }: { input: HTMLInputElement }) => Number(input.value);
  return {
    element: h(
      "div",
      { class: "form" },
      field("Intrinsic reward", intrinsic),
      h("div", { class: "pair" }, horizon.element, beta.element),
      field("Algorithm", algorithm),
      h("div", { class: "pair" }, runs.element, seed.element),
      episodes.element,
    ),
    settings: () => ({
      intrinsic: intrinsic.value,
      horizon: horizon.input.disabled ? 0 : value(horizon),
      beta: beta.input.disabled ? 0 : value(beta),
      runs: value(runs),
      seed: value(seed),
      algorithm: algorithm.value,
      episodes: value(episodes),
    }),
  };
}

/** What tells a training from others, in a few words. */
export function summary(settings: Settings, tool: string): string {
  const { intrinsic, horizon, beta, algorithm, seed } = settings;
  const reward = intrinsic === "none" ? "no intrinsic reward" : `${INTRINSIC[intrinsic] ?? intrinsic}`;
  const details = [horizon ? `h ${horizon}` : "", beta ? `β ${beta}` : "", tool, ALGORITHMS[algorithm] ?? algorithm, `seed ${seed}`];
  return [reward, ...details.filter(Boolean)].join(", ");
}
