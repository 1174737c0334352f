/** The trainings of this visit: begun, followed as they stream in, stopped, compared. */

import type { App } from "../core/app";
import type { Asked } from "../core/connection";
import type { CurveData, SceneMessage, Settings, TrainAnswer } from "../core/protocol";
import { message, NO_TOOL } from "../core/scene";
import { summary } from "./form";

export interface Training {
  readonly id: number;
  readonly label: string;
  readonly settings: Settings;
  readonly scene: SceneMessage;
  /** That of its folder. */
  name: string | null;
  curve: CurveData | null;
  share: number;
  steps: number;
  episodes: number;
  best: number | null;
  done: TrainAnswer["done"] | null;
  stopped: boolean;
  error: string | null;
  /** Which of the chart's two lines it is, if it is drawn. */
  line: 0 | 1 | null;
}

export interface Trainings {
  all(): readonly Training[];
  running(): Training | null;
  begin(settings: Settings): void;
  stop(): void;
  toggle(training: Training): void;
  /** Makes this the run that is acted out. */
  watch(training: Training): void;
}

export function createTrainings(app: App, onChange: () => void): Trainings {
  const { connection, store, acted } = app;
  const trainings: Training[] = [];
  let asked: Asked | null = null;

  const running = () => trainings.find(({ done, error }) => !done && error === null) ?? null;

  /** Gives it a line; with two drawn, the older of them leaves. */
  function draw(training: Training): void {
    const drawn = trainings.filter(({ line }) => line !== null);
    if (drawn.length === 2) drawn[0]!.line = null;
    const taken = trainings.find(({ line }) => line !== null)?.line;
    training.line = taken === 0 ? 1 : 0;
  }

  function watch({ label, done, settings, scene }: Training): void {
    if (!done || acted.current()?.asked === done.name) return;
    const { runs } = settings;
    const drawn = scene.tool === NO_TOOL ? { ...scene.drawn, tools: [] } : scene.drawn;
    acted.show({ name: label, asked: done.name, runs, drawn, config: { ...settings } });
  }

  function begin(settings: Settings): void {
    const scene = message(store.scene());
    const training: Training = {
      id: trainings.length + 1,
      label: summary(app.hello.training, settings, store.scene()),
      settings, scene, name: null,
      curve: null, share: 0, steps: 0, episodes: 0, best: null, done: null, stopped: false,
      error: null, line: null,
    };
    trainings.push(training);
    draw(training);
    asked = connection.ask<TrainAnswer>("train", { scene, settings }, (answer) => {
      if (answer.error !== undefined) training.error = answer.error;
      training.name = answer.name ?? training.name;
      if (answer.curve) training.curve = answer.curve;
      if (answer.error !== undefined && training.curve === null) training.line = null;
      training.share = answer.share ?? answer.progress ?? training.share;
      training.steps = answer.steps ?? training.steps;
      training.episodes = answer.episodes ?? training.episodes;
      training.best = answer.best_return ?? training.best;
      if (answer.done) {
        training.done = answer.done;
        asked?.forget();
        watch(training);
      }
      onChange();
    });
    onChange();
  }

  return {
    all: () => trainings,
    running,
    begin,
    watch,
    stop() {
      const going = running();
      if (asked === null || going === null) return;
      going.stopped = true;
      connection.tell(asked, "stop");
      onChange();
    },
    toggle(training) {
      if (training.line === null) draw(training);
      else training.line = null;
      onChange();
    },
  };
}
