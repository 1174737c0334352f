/** The question asked about the board, and its controls. */

import type { App } from "../core/app";
import { h } from "../core/elements";
import { FRESH_KIND, kindMessage, OVER_ALL, type KindSettings } from "../core/kinds";
import type { BoardAbout, Scene } from "../core/protocol";
import { capital } from "../core/words";
import { createKind } from "../frame/kind";
import { field, select, slider } from "../frame/widgets";

/** The board and the question; `messageOf` has it in the server's format. */
export type Asked = Scene & KindSettings & Required<Pick<Scene, "board" | "sensor" | "thing" | "horizon" | "slip">>;

export interface Question {
  readonly element: HTMLElement;
  /** The question that is asked first. */
  readonly first: Asked;
  scene(): Asked;
  /** The board and the question in the server's format. */
  message(): Scene;
  /** Asks another question, such as a link's. */
  show(next: Asked): void;
  /** The observed thing in words. */
  sensed(): string;
  watch(watcher: () => void): void;
}

const EVERYTHING = "state";
const FIRST_HORIZON = 3;

export function createQuestion({ hello }: App, board: BoardAbout): Question {
  const watchers: (() => void)[] = [];
  const first: Asked = {
    board: board.name, sensor: EVERYTHING, thing: 0, horizon: FIRST_HORIZON, slip: 0, ...FRESH_KIND,
  };
  let scene = first;
  function change(part: Partial<Asked>): void {
    scene = { ...scene, ...part };
    kind.show(scene);
    for (const watcher of watchers) watcher();
  }

  const names = Object.fromEntries(board.factors.map((name, of) => [`factor ${of}`, wordsFor(name)]));
  const sensor = select<string>("Sensor", { [EVERYTHING]: "Everything", ...names }, (chosen) =>
    change(chosen === EVERYTHING ? { sensor: EVERYTHING, thing: 0 } : { sensor: "factor", thing: Number(chosen.split(" ")[1]) }),
  );
  sensor.id = "board-sensor";
  const horizon = slider(
    "Steps ahead",
    { id: "board-horizon", least: 0, most: hello.limits.horizon, step: 1 },
    String,
    (horizon) => change({ horizon }),
  );
  horizon.show(scene.horizon);
  const slip = slider(
    "Slip",
    { id: "board-slip", least: 0, most: hello.limits.slip, step: 0.05 },
    (value) => `${Math.round(100 * value)} %`,
    (slip) => change({ slip }),
  );
  slip.show(0);

  const boxes = board.actions.map(() => h("input", { type: "checkbox", checked: true }));
  for (const box of boxes) {
    box.addEventListener("change", () => {
      if (!boxes.some(({ checked }) => checked)) box.checked = true; // at least one
      change({ only: boxes.flatMap(({ checked }, action) => (checked ? [action] : [])) });
    });
  }
  const actions = h(
    "div",
    { class: "action-set", role: "group", "aria-label": "Actions", id: "board-actions" },
    ...boxes.map((box, action) => h("label", {}, box, h("span", {}, board.actions[action]!))),
  );
  const sensorField = field("Sensor", sensor);
  sensorField.classList.add("in-line");
  const actionField = field("Actions", actions);
  const kind = createKind(hello, "board-", { horizon: horizon.element, actions: actionField }, (part) => change(part));
  kind.show(scene);
  return {
    element: h(
      "div",
      { class: "question" },
      kind.element,
      horizon.element,
      ...kind.settings,
      slip.element,
      sensorField,
      actionField,
    ),
    first,
    scene: () => scene,
    message: () => messageOf(scene),
    show(next) {
      scene = next;
      sensor.value = next.sensor === EVERYTHING ? EVERYTHING : `factor ${next.thing}`;
      kind.show(next);
      horizon.show(next.horizon);
      slip.show(next.slip);
      boxes.forEach((box, action) => (box.checked = next.only?.includes(action) ?? true));
      for (const watcher of watchers) watcher();
    },
    sensed: () => (scene.sensor === EVERYTHING ? "state" : wordsFor(board.factors[scene.thing]!).toLowerCase()),
    watch: (watcher) => watchers.push(watcher),
  };
}

/** With the settings of its kind alone. */
function messageOf({ kind, discount, slack, only, ...rest }: Asked): Scene {
  const all = only === undefined || OVER_ALL.includes(kind);
  return { ...rest, ...(all ? {} : { only }), ...kindMessage({ kind, discount, slack }) };
}

/** A factor in words: "object:m0" is the movable m0. */
function wordsFor(factor: string): string {
  return capital(factor.replace(/^object:/, ""));
}
