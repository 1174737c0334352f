/** The trainings of this page, updated as results arrive, and those kept by the server. */

import type { App } from "../core/app";
import type { Asked, Heard } from "../core/connection";
import type {
  CurveAnswer, Drawn, FirstSettings as Settings, KeptTraining, LearningCurve,
} from "../core/protocol";
import { message, NO_TOOL } from "../core/scene";
import { worldOf } from "../core/world";
import { DISMISSED, UNDER_WAY } from "./remembered";
import { summary } from "./form";

export interface Training {
  /** Whether this page started it. */
  readonly own: boolean;
  label: string;
  runs: number;
  drawn: Drawn | null;
  config: Record<string, unknown>;
  /** The name of its folder. */
  name: string | null;
  curve: LearningCurve | null;
  share: number;
  steps: number;
  episodes: number;
  best: number | null;
  /** Each run's episodes to convergence; null while it trains, or if it did not finish. */
  converged: (number | null)[] | null;
  /** Whether it can be watched, and no further answers will come. */
  done: boolean;
  stopped: boolean;
  /** Whether it is training for another page. */
  elsewhere: boolean;
  error: string | null;
  /** Its line in the chart, if it is drawn. */
  line: 0 | 1 | null;
}

export interface Trainings {
  all(): readonly Training[];
  running(): Training | null;
  /** The number of older ones that are not listed. */
  leftOut(): number;
  /** The error, if the kept ones cannot be listed. */
  fault(): string;
  begin(settings: Settings): void;
  stop(): void;
  toggle(training: Training): void;
  /** Makes this the run to watch. */
  watch(training: Training): void;
  /** Takes one that failed off the list; what it has kept stays where it is. */
  dismiss(training: Training): void;
  /** Goes on with the training of this page that was under way before it was loaded again. */
  resume(): void;
  /** Requests the list of kept trainings. */
  list(): void;
}

const NOTHING = {
  runs: 0, drawn: null, config: {}, name: null, curve: null, share: 0, steps: 0, episodes: 0, best: null,
  converged: null, done: false, stopped: false, elsewhere: false, error: null, line: null,
} as const;

export function createTrainings(app: App, onChange: () => void): Trainings {
  const { connection, store, watched } = app;
  let trainings: Training[] = [];
  let asked: Asked | null = null;
  let listing: Asked | null = null;
  let reading: Training | null = null; // whose curve is asked for
  let leftOut = 0;
  let fault = "";
  let due = false;

  /** Redraws once for many answers. */
  function soon(): void {
    if (due) return;
    due = true;
    requestAnimationFrame(() => {
      due = false;
      onChange();
    });
  }

  const running = () => trainings.find(({ own, done, error }) => own && !done && error === null) ?? null;

  /** Gives it a line; if two are drawn, the older one is removed. */
  function draw(training: Training): void {
    const drawn = trainings.filter(({ line }) => line !== null);
    if (drawn.length === 2) drawn[0]!.line = null;
    const taken = trainings.find(({ line }) => line !== null)?.line;
    training.line = taken === 0 ? 1 : 0;
  }

  function watch({ label, name, done, runs, drawn, config }: Training): void {
    if (!done || name === null || drawn === null || watched.current()?.asked === name) return;
    watched.show({ name: label, asked: name, runs, drawn, config });
  }

  function take(training: Training, answer: CurveAnswer): void {
    training.curve = answer.curve ?? training.curve;
    training.steps = answer.steps ?? training.steps;
    training.episodes = answer.episodes ?? training.episodes;
    training.best = answer.best_return ?? training.best;
  }

  function begin(settings: Settings): void {
    const scene = message(store.scene());
    const drawn = scene.tool === NO_TOOL ? { ...scene.drawn, tools: [] } : scene.drawn;
    const training: Training = {
      ...NOTHING,
      own: true,
      label: summary(app.hello.training, settings, worldOf(drawn)),
      runs: settings.runs, drawn, config: { ...settings },
    };
    trainings.push(training);
    draw(training);
    asked = connection.ask("train", { scene, settings }, (answer) => hear(training, answer));
    onChange();
  }

  /** Takes in a part of the answer about a training of this page. */
  function hear(training: Training, answer: Heard<"train">): void {
    training.name = answer.name ?? training.name;
    if (answer.name !== undefined) UNDER_WAY.set(answer.name);
    take(training, answer);
    training.share = answer.share ?? answer.progress ?? training.share;
    if (answer.error !== undefined) {
      training.error = answer.error;
      if (training.curve === null) training.line = null;
      if (!answer.lost) UNDER_WAY.set(null);
      list(); // part of it may be kept
    }
    if (answer.done) {
      [training.done, training.converged] = [true, answer.done.converged_at];
      UNDER_WAY.set(null);
      asked?.forget();
      watch(training);
    }
    onChange();
  }

  function resume(): void {
    const name = UNDER_WAY.get();
    if (name === null || running() !== null) return;
    let training = trainings.find((one) => one.name === name);
    asked = connection.ask("follow", { name }, (answer) => {
      if (training === undefined && answer.error !== undefined) {
        if (!answer.lost) UNDER_WAY.set(null); // it has ended, and is listed
        list();
        return;
      }
      if (training === undefined) {
        training = { ...NOTHING, own: true, name, label: name };
        trainings.push(training);
        draw(training);
        list(); // for its settings
      } else if (answer.error === undefined) training.error = null;
      hear(training, answer);
    });
  }

  function list(): void {
    listing?.forget();
    listing = connection.ask("trainings", {}, (answer) => {
      if (answer.lost) return;
      fault = answer.error ?? "";
      if (answer.names) arrange(answer.names, answer.left_out ?? 0);
      if (answer.kept) add(answer.kept);
      soon();
    });
  }

  /** Sorts as the server does, the newest last. */
  function arrange(names: readonly string[], others: number): void {
    leftOut = others;
    const age = ({ name }: Training) => (name === null ? -1 : names.indexOf(name));
    trainings = trainings
      .filter((training) => training.own || age(training) >= 0)
      .filter(({ name }) => name === null || !DISMISSED.has(name))
      .sort((one, other) => age(other) - age(one));
    for (const name of names.toReversed()) {
      if (DISMISSED.has(name) || trainings.some((training) => training.name === name)) continue;
      const later = trainings.findIndex((training) => age(training) < names.indexOf(name));
      trainings.splice(later < 0 ? trainings.length : later, 0, {
        ...NOTHING, own: false, name, label: "…",
      });
    }
  }

  function add({ name, under_way, error, runs, drawn, config, converged_at, best_return }: KeptTraining): void {
    const training = trainings.find((one) => one.name === name);
    if (training === undefined) return;
    if (training.own && training.drawn === null && config && drawn && runs) {
      const label = summary(app.hello.training, config as unknown as Settings, worldOf(drawn));
      Object.assign(training, { label, runs, drawn, config });
    }
    if (training.own) {
      // The connection was lost; whatever was kept can be watched.
      if (training.error !== null && !under_way && error === undefined) training.done = true;
      return;
    }
    if (training.elsewhere && !under_way) training.curve = null; // it has progressed since
    training.elsewhere = under_way;
    training.label = name;
    training.error = under_way ? null : (error ?? null);
    training.done = error === undefined;
    if (!drawn || !config || !runs) return;
    training.label = summary(app.hello.training, config as unknown as Settings, worldOf(drawn));
    Object.assign(training, { runs, drawn, config, converged: converged_at ?? null, best: best_return ?? null });
    read();
  }

  /** Requests the curves of the drawn ones, one after the other. */
  function read(): void {
    const next = trainings.find(({ own, line, curve, error }) => !own && line !== null && curve === null && error === null);
    if (next === undefined || reading !== null) return;
    reading = next;
    const asked = connection.ask("curve", { name: next.name! }, (answer) => {
      asked.forget();
      reading = null;
      if (answer.lost) return;
      take(next, answer);
      if (next.curve === null) {
        next.line = null;
        next.error = answer.error ?? "there is no curve yet: one of its runs has not finished an episode";
      }
      soon();
      read();
    });
  }

  return {
    all: () => trainings,
    running,
    leftOut: () => leftOut,
    fault: () => fault,
    begin,
    resume,
    dismiss(training) {
      trainings = trainings.filter((one) => one !== training);
      if (training.name !== null) DISMISSED.add(training.name);
      onChange();
    },
    watch,
    list,
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
      read();
      onChange();
    },
  };
}
