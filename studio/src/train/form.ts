/** The form with the settings of a training. */

import type { App } from "../core/app";
import { h } from "../core/elements";
import type { FirstSettings as Settings, Offered } from "../core/protocol";
import { NO_TOOL, toolsOf, type Scene } from "../core/scene";
import { namesOf, several, type World } from "../core/world";
import { field, numberField, offer, select } from "../frame/widgets";

const NONE = "none"; // no intrinsic reward

export function createForm({ hello, store }: App): { element: HTMLElement; settings: () => Settings } {
  const limits = hello.limits.training;
  const { first, ...offered } = hello.training;
  const choicesIn = (scene: Scene) => intrinsics(hello.training, { ...scene.world, tools: toolsOf(scene) });
  const intrinsic = select("Intrinsic reward", choicesIn(store.scene()), show);
  intrinsic.id = "intrinsic";
  intrinsic.value = first.intrinsic;
  store.watch((scene) => {
    const choices = choicesIn(scene);
    const chosen = intrinsic.value;
    offer(intrinsic, choices);
    intrinsic.value = chosen in choices ? chosen : Object.keys(choices)[1]!;
  });
  const algorithm = select("Algorithm", offered.algorithms, () => undefined);
  algorithm.id = "algorithm";
  algorithm.value = first.algorithm;
  const horizon = numberField("Steps ahead", {
    id: "train-horizon", least: 1, most: hello.limits.horizon, step: 1, value: first.horizon,
  });
  const beta = numberField("Weight β", { id: "beta", least: 0, step: 0.01, value: first.beta });
  const runs = numberField("Runs", { id: "runs", least: 1, most: limits.runs, step: 1, value: first.runs });
  const seed = numberField("Seed", { id: "seed", least: 0, most: limits.seed, step: 1, value: first.seed });
  const episodes = numberField("Episodes", {
    id: "episodes", least: 1, most: limits.episodes, step: 1, value: first.episodes,
  });

  function show(): void {
    horizon.input.disabled = offered.without_horizon.includes(intrinsic.value);
    beta.input.disabled = intrinsic.value === NONE;
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

/** The intrinsic rewards available in a world: with several objects, over each and over all. */
function intrinsics({ intrinsic }: Offered, world: World): Record<string, string> {
  if (!several(world)) return intrinsic;
  const over = (sensor: string, names: string[]) =>
    names.map((name) => [`${sensor}:${name}`, `Empowerment over the ${name}`] as const);
  const objects = over("object", namesOf(world.objects));
  const all = objects.map(([sensor]) => sensor);
  const { none, object, tool, ...others } = intrinsic;
  return Object.fromEntries([
    ["none", none!],
    ...objects,
    ...(all.length > 1 ? [[all.join("+"), "Sum over all objects"], [all.join("*"), "Product over all objects"]] : []),
    ...over("tool", namesOf(world.tools)),
    ...Object.entries(others),
  ]) as Record<string, string>;
}

/** A short label of a training; the world has the tools that were used. */
export function summary(offered: Offered, settings: Settings, world: World): string {
  const { horizon, beta, seed, algorithm } = settings;
  const named = intrinsics(offered, world)[settings.intrinsic] ?? settings.intrinsic;
  const reward = settings.intrinsic === NONE ? "no intrinsic reward" : named;
  const tool = world.tools.length > 1 ? "several tools" : (world.tools[0]?.kind ?? NO_TOOL);
  const details = [horizon ? `h ${horizon}` : "", beta ? `β ${beta}` : "", tool];
  return [reward, ...details, offered.algorithms[algorithm] ?? algorithm, `seed ${seed}`].filter(Boolean).join(", ");
}
