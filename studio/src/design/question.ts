/** The question asked about the world: what is measured, sensor, horizon, actions, slip. */

import type { App } from "../core/app";
import { h } from "../core/elements";
import type { ActionSet } from "../core/protocol";
import { ACTION_SETS, SENSORS, toolsOf, type Scene, type Sensor } from "../core/scene";
import { capital } from "../core/words";
import { namesOf, type Thing, type Tool } from "../core/world";
import { createKind } from "../frame/kind";
import { field, offer, segmented, select, slider } from "../frame/widgets";

export function createQuestion({ hello, store }: App): HTMLElement {
  const { limits } = hello;
  const sensor = select("Sensor", choices(store.scene()), (chosen) => {
    const [sensor, thing] = chosen.split(" ") as [Sensor, string | undefined];
    store.change({ sensor, thing: Number(thing ?? 0) });
  });
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
  const sensorField = field("Sensor", sensor);
  sensorField.classList.add("in-line");
  const actionField = field("Actions", actions.element);
  const kind = createKind(
    hello, "", { horizon: horizon.element, actions: actionField }, (part, gesture) => store.change(part, gesture),
  );
  store.watch((scene) => {
    kind.show(scene);
    offer(sensor, choices(scene));
    const several = (scene.sensor === "object" || scene.sensor === "tool") && scene.thing > 0;
    sensor.value = several ? `${scene.sensor} ${scene.thing}` : scene.sensor;
    horizon.show(scene.horizon);
    actions.show(
      toolsOf(scene).length ? scene.actions : "all",
      toolsOf(scene).length ? [] : ["moves", "tool"],
    );
    slip.show(scene.slip);
  });
  return h(
    "div",
    { class: "question" },
    kind.element,
    horizon.element,
    ...kind.settings,
    slip.element,
    sensorField,
    actionField,
  );
}

/** The available sensors, with things by name. */
function choices(scene: Scene): Record<string, string> {
  const { world } = scene;
  const tools = toolsOf(scene);
  const named = (sensor: Sensor, things: readonly (Tool | Thing)[], only: string) =>
    namesOf(things).map((name, of) => [
      of ? `${sensor} ${of}` : sensor,
      things.length > 1 || sensor === "object" ? capital(name) : only,
    ]);
  return Object.fromEntries([
    ...named("object", world.objects, SENSORS.object),
    ["state", SENSORS.state],
    ...named("tool", tools, SENSORS.tool),
    ["agent", SENSORS.agent],
    ["cells", SENSORS.cells],
  ]);
}
