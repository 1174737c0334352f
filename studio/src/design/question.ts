/** The question asked about the world: what is sensed, how far ahead, with which actions. */

import type { App } from "../core/app";
import { h } from "../core/elements";
import type { ActionSet, Sensor } from "../core/protocol";
import { ACTION_SETS, SENSORS } from "../core/scene";
import { field, segmented, select, slider } from "../frame/widgets";

export function createQuestion({ hello, store }: App): HTMLElement {
  const { limits } = hello;
  const sensor = select<Sensor>("What is sensed", SENSORS, (sensor) => store.change({ sensor }));
  sensor.id = "sensor";
  const horizon = slider(
    "Steps ahead",
    { id: "horizon", least: 0, most: limits.horizon, step: 1 },
    String,
    (horizon) => store.change({ horizon }, "horizon"),
  );
  const actions = segmented<ActionSet>(
    "Actions",
    { all: [ACTION_SETS.all], moves: [ACTION_SETS.moves], tool: [ACTION_SETS.tool] },
    (actions) => store.change({ actions }),
  );
  const slip = slider(
    "Slip",
    { id: "slip", least: 0, most: limits.slip, step: 0.05 },
    (value) => `${Math.round(100 * value)} %`,
    (slip) => store.change({ slip }, "slip"),
  );
  store.watch((scene) => {
    sensor.value = scene.sensor;
    sensor.options[Object.keys(SENSORS).indexOf("tool")]!.disabled = scene.tool === "none";
    horizon.show(scene.horizon);
    actions.show(
      scene.tool === "none" ? "all" : scene.actions,
      scene.tool === "none" ? ["moves", "tool"] : [],
    );
    slip.show(scene.slip);
  });
  return h(
    "div",
    { class: "question" },
    horizon.element,
    field("What is sensed", sensor),
    field("Actions", actions.element),
    slip.element,
  );
}
