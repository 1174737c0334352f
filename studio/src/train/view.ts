/** Train: the library's trainer on the current world, with live learning curves. */

import type { App, View } from "../core/app";
import { h } from "../core/elements";
import { createChart } from "../draw/chart";
import { button, card } from "../frame/widgets";
import { message } from "../core/scene";
import { NOTHING, type Keeps } from "../keep/dialog";
import { pointsOf } from "../keep/files";
import { createForm } from "./form";
import { createTrainings, type Training } from "./trainings";

const PACE = 2000; // milliseconds between updates of trainings of other pages

export function createTrain(app: App, openRun: () => void): View {
  const form = createForm(app);
  const chart = createChart("Learning curves", "curves");
  const list = h("ul", { class: "trainings", id: "trainings" });
  const earlier = h("p", { class: "quiet", id: "earlier", role: "status" });
  const trainings = createTrainings(app, draw);
  let active = false;
  let due = 0;

  const start = button("Start", () => trainings.begin(form.settings()), {
    id: "start", kind: "primary", sign: "play",
  });
  const stop = button("Stop", trainings.stop, { id: "stop", sign: "stop" });

  function draw(): void {
    const going = trainings.running();
    start.disabled = going !== null;
    stop.disabled = going === null || going.stopped;
    const drawn = trainings.all().filter(({ line }) => line !== null);
    const best = drawn.find((training) => training.best !== null)?.best ?? null;
    chart.draw({
      lines: drawn
        .filter(({ curve }) => curve !== null)
        .map(({ curve, label, line }) => ({
          label,
          x: curve!.x, y: curve!.mean, low: curve!.low, high: curve!.high,
          kind: line!,
        })),
      xLabel: "episodes (moving average over 100)",
      yLabel: "return",
      level: best === null ? null : { y: best, label: "best possible" },
      squeezed: true,
      ...(best === null ? {} : { yMost: 0 }),
      empty: going ? "Waiting for the first episodes…" : "Choose a reward and press Start.",
    });
    list.replaceChildren(...trainings.all().toReversed().map(rowOf));
    earlier.textContent = trainings.fault() || wordsOnOthers(trainings.leftOut(), app.hello.kept);
    earlier.className = trainings.fault() ? "fault" : "quiet";
    earlier.hidden = earlier.textContent === "";
    if (active && !due && trainings.all().some(({ elsewhere }) => elsewhere)) {
      due = window.setTimeout(() => {
        due = 0;
        if (active) trainings.list();
      }, PACE);
    }
  }

  function rowOf(training: Training): HTMLElement {
    const { label, line, error, done, share, name, curve, own } = training;
    const check = h("input", {
      type: "checkbox",
      checked: line !== null,
      disabled: curve === null && (error !== null || (!own && !done)),
      "aria-label": `Draw: ${label}`,
      onchange: () => trainings.toggle(training),
    });
    const bar = h("span", { class: "track" }, h("span", { class: "bar" }));
    bar.style.setProperty("--share", String(share));
    const dismiss = button("Dismiss", () => trainings.dismiss(training), { kind: "small" });
    dismiss.setAttribute("aria-label", `Dismiss: ${label}`);
    return h(
      "li",
      { class: `training ${line === null ? "" : `k${line}`}` },
      check,
      h("span", { class: "swatch", "aria-hidden": "true" }),
      h("span", { class: "name" }, label, app.hello.kept === null || label === name ? null : h("small", {}, name)),
      h("span", { class: error ? "fault" : "quiet" }, error ?? wordsOn(training)),
      done
        ? button("Watch", () => (trainings.watch(training), openRun()), { kind: "small" })
        : error !== null ? dismiss : own ? bar : null,
    );
  }

  draw();
  trainings.resume();
  const element = h(
    "div",
    { class: "view train" },
    card(
      "Settings",
      "side",
      h("div", { class: "card-head" }, h("h2", {}, "Train")),
      form.element,
      h("div", { class: "buttons" }, start, stop),
      h("p", { class: "quiet" }, "Trains in the world as drawn, from its start."),
      h("p", { class: "quiet", id: "kept" }, whereKept(app.hello.kept)),
    ),
    card(
      "Curves",
      "curves",
      h("div", { class: "card-head" }, h("h2", {}, "Learning curves"), h("span", { class: "quiet" }, "mean over runs, shaded: 95 % interval")),
      chart.element,
      list,
      earlier,
    ),
  );
  function keeps(): Keeps {
    const lines = chart.lines();
    const drawn = trainings.all().filter(({ line }) => line !== null);
    const { name } = drawn.find((training) => training.name !== null && training.done) ?? { name: null };
    return {
      ...NOTHING,
      pictures: lines.length ? [{ name: "Learning curves", picture: chart.picture }] : [],
      tables: lines.length ? [{ name: "Learning curves", rows: pointsOf(lines, "episode", "return") }] : [],
      code: {
        scene: message(app.store.scene()),
        view: "training",
        ...(name === null ? { settings: form.settings() } : { name }),
      },
    };
  }

  return {
    element,
    keeps,
    entered() {
      active = true;
      trainings.list();
      draw();
    },
    left() {
      active = false;
    },
    again() {
      trainings.resume();
      if (active) trainings.list();
    },
  };
}

function wordsOnOthers(count: number, folder: string | null): string {
  if (!count) return "";
  const which = count === 1 ? "One earlier training is" : `${count.toLocaleString("en-GB")} earlier trainings are`;
  return `${which} not listed${folder === null ? "" : `; use habilis watch with its folder in ${folder}`}.`;
}

function whereKept(folder: string | null): string {
  if (folder === null) return "Kept until the studio ends; start habilis studio --out DIR to keep trainings.";
  return `Kept in ${folder}, each in a folder named as below.`;
}

function wordsOn({ own, done, stopped, elsewhere, steps, episodes, curve, runs, converged: at }: Training): string {
  const last = curve?.mean.at(-1);
  const now = last === undefined ? "" : `return ${last.toFixed(1).replace("-", "−")}`;
  const count = (value: number) => Math.round(value).toLocaleString("en-GB");
  const so = `${count(episodes / runs)} episodes`;
  if (elsewhere) return "still training";
  if (!own && !done) return "";
  if (!done && stopped) return "stopping…";
  if (!done) return steps ? [now, so, `${count(steps)} steps`].filter(Boolean).join(" · ") : "starting…";
  const converged = (at ?? []).filter((one) => one !== null);
  const mean = converged.reduce((sum, one) => sum + one, 0) / converged.length;
  const end = converged.length
    ? `${converged.length} of ${runs} converged, after ${count(mean)} episodes`
    : stopped || at === null ? (episodes ? `stopped after ${so}` : "stopped early") : `none of ${runs} converged`;
  return [now, end].filter(Boolean).join(" · ");
}
