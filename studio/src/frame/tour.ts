/** The one-minute tour: four things to do on the map, and what they do to the bits. */

import type { App } from "../core/app";
import { h } from "../core/elements";
import type { Grid } from "../core/protocol";
import { toolOf, type Scene } from "../core/scene";
import { button } from "./widgets";

const KEPT = "habilis-tour";
const OFF = ["tour", "embedded"]; // fields of an address that has no tour on the first visit
const VISIBLE = 0.005; // bits that two values have to differ by

interface Step {
  readonly words: string;
  /** What it is about on the page. */
  readonly target: string;
  /** Whether the user has done it; the last step has nothing to do. */
  done?(now: Scene, before: Scene): boolean;
}

const STEPS: readonly Step[] = [
  {
    words: "Draw a wall: drag over empty cells of the map.",
    target: "#world-board",
    done: ({ world }, { world: old }) =>
      world.walls.length === old.walls.length && world.walls.some((wall, cell) => wall !== old.walls[cell]),
  },
  {
    words: "Drag the can to another cell of the map.",
    target: "#world-board",
    done: ({ world }, { world: old }) => world.objects[0]!.cell !== old.objects[0]!.cell,
  },
  {
    words: "Change the tool: choose another one below the map.",
    target: ".design .tools",
    done: (now, before) => toolOf(now) !== toolOf(before),
  },
  {
    words: "See the bits move: let the agent look further ahead, or less far.",
    target: "#horizon",
    done: (now, before) => now.horizon !== before.horizon,
  },
  {
    words: "Point at a cell of the landscape to see the futures behind its number. Then play, and train. To see this tour again, press “?”.",
    target: "#landscape-board",
  },
];

export interface Tour {
  readonly element: HTMLElement;
  /** Begins on a first visit, unless the address asks for none. */
  offer(view: string): void;
  begin(): void;
}

export function createTour({ store, measuring }: App, openDesign: () => void): Tour {
  let at = -1; // the step, if it is under way
  let done = false; // and whether the user has done it
  let start: Grid | null = null; // the values before
  let pressed = false;
  let marked: Element | null = null;

  const count = h("span", { class: "quiet tour-count" });
  const words = h("p", { class: "tour-words" });
  const outcome = h("p", { class: "tour-outcome" });
  const next = button("Next", () => advance(""), { id: "tour-next", kind: "primary small" });
  const skip = button("Skip the tour", end, { id: "tour-skip", kind: "small" });
  const element = h(
    "section",
    { class: "tour", id: "tour", "aria-label": "Tour", hidden: true },
    count,
    h("div", { "aria-live": "polite" }, words, outcome),
    h("div", { class: "buttons" }, skip, next),
  );
  element.addEventListener("keydown", (event) => event.key === "Escape" && end());

  function show(step: number): void {
    at = step;
    done = false;
    const { words: text, target } = STEPS[step]!;
    const last = step === STEPS.length - 1;
    start = measuring.latest().landscape;
    count.textContent = `${step + 1} of ${STEPS.length}`;
    words.textContent = text;
    next.querySelector(".button-name")!.textContent = last ? "Done" : "Next";
    skip.hidden = last;
    element.hidden = false;
    mark(document.querySelector(target));
  }

  function mark(target: Element | null): void {
    marked?.classList.remove("tour-target");
    marked = target;
    marked?.classList.add("tour-target");
  }

  function advance(result: string): void {
    if (at < 0) return;
    outcome.textContent = result;
    if (at === STEPS.length - 1) end();
    else show(at + 1);
  }

  function end(): void {
    at = -1;
    element.hidden = true;
    mark(null);
    remember();
  }

  /** Advances once the values of the changed scene are there, but not below a pressed pointer. */
  function check(): void {
    const { pending, landscape, error, scene } = measuring.latest();
    if (at < 0 || !done || pressed || pending) return;
    if (error !== null) advance("");
    else if (landscape !== null && scene === store.scene()) advance(wordsOn(start, landscape));
  }

  store.watch((now, before) => {
    if (at >= 0 && before !== null && STEPS[at]!.done?.(now, before)) done = true;
  });
  measuring.watch(check);
  addEventListener("pointerdown", () => (pressed = true), true);
  for (const up of ["pointerup", "pointercancel"]) {
    addEventListener(up, () => {
      pressed = false;
      setTimeout(check);
    }, true);
  }

  function begin(): void {
    openDesign();
    outcome.textContent = "Each number of the landscape counts the futures that the agent can choose from there, in bits.";
    show(0);
  }

  return {
    element,
    begin,
    offer(view) {
      const fields = new URLSearchParams(location.search);
      if (view === "design" && !OFF.some((name) => fields.has(name)) && isFirst()) begin();
    },
  };
}

/** The change of the values in words. */
function wordsOn(before: Grid | null, after: Grid): string {
  const changed = after.flatMap((row, r) =>
    row.filter((bits, c) => Math.abs((bits ?? 0) - (before?.[r]?.[c] ?? 0)) > VISIBLE),
  ).length;
  const most = Math.max(...after.flat().map((bits) => bits ?? 0)).toFixed(2);
  const cells = changed === 1 ? "one cell" : `${changed} cells`;
  return changed
    ? `The bits changed in ${cells}; the most is now ${most}.`
    : `The bits are as before: none of the futures counted here depends on it. The most is ${most}.`;
}

function isFirst(): boolean {
  try {
    return localStorage.getItem(KEPT) === null;
  } catch {
    return false; // storage is disabled, and it would be shown every time
  }
}

function remember(): void {
  try {
    localStorage.setItem(KEPT, "seen");
  } catch {
    // storage is disabled
  }
}
