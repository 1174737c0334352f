/** Average object empowerment with each tool, side by side, and a verdict. */

import type { App } from "../core/app";
import { h } from "../core/elements";
import type { Measured } from "../core/measuring";
import type { Verdict } from "../core/protocol";
import { NO_TOOL, objectOf, toolOf, toolsOf } from "../core/scene";
import { nameOf } from "../core/words";
import { drawingOf, icon } from "../draw/shapes";

export function createAverages({ hello, store, measuring }: App): HTMLElement {
  const rows = new Map(
    hello.tools.map((tool) => {
      const bar = h("span", { class: "bar" });
      const bits = h("span", { class: "bits" }, "–");
      const picture = tool === NO_TOOL ? h("span", { class: "no-icon" }) : icon(drawingOf(tool), 22);
      const name = h("span", { class: "name" }, nameOf(tool));
      const track = h("span", { class: "track" }, bar);
      const row = h("li", { "data-tool": tool }, picture, name, track, bits);
      return [tool, { row, bar, bits }] as const;
    }),
  );
  const verdict = h("p", { class: "verdict", id: "verdict", "aria-live": "polite" });
  const waiting = h("p", { class: "quiet" });

  function show({ averages, within, verdicts, compared, error, why }: Measured): void {
    const scene = store.scene();
    const tool = toolOf(scene);
    const here = new Set(toolsOf(scene).map(({ kind }) => kind));
    const object = objectOf(scene);
    const most = Math.max(...Object.values(averages).map((bits) => bits ?? 0), 1e-9);
    for (const [name, { row, bar, bits }] of rows) {
      const value = averages[name];
      const about = within[name] ?? 0;
      bits.textContent = value === undefined || value === null ? "–" : inWords(value, about);
      row.title = about ? `95 % interval: ${(value! - about).toFixed(2)} to ${(value! + about).toFixed(2)}` : "";
      bar.style.setProperty("--share", String(Math.max((value ?? 0) / most, 0)));
      row.classList.toggle("chosen", here.has(name) || name === tool);
      row.dataset.fresh = String(compared.includes(name));
    }
    const estimated = Object.values(within).some((about) => about > 0);
    const plain = scene.kind === "open-loop" ? "Mean bits" : `Mean open-loop bits, ${scene.horizon} steps ahead,`;
    waiting.textContent = `${plain} over the ${object}${estimated ? ", sampled" : ""}${tool === null ? ", each tool alone" : ""}.`;
    const message = error ? [] : why !== null ? [why] : tool === null ? [] : sentence(tool, object, averages, verdicts[tool]);
    verdict.replaceChildren(...message);
    const of = why !== null || error !== null || tool === null || tool === NO_TOOL ? [] : [tool, NO_TOOL];
    verdict.dataset.fresh = String(of.every((name) => compared.includes(name)));
    verdict.dataset.kind = kindOf(why === null && tool !== null ? verdicts[tool] : undefined);
  }

  measuring.watch(show);
  store.watch(() => show(measuring.latest()));
  return h(
    "div",
    { class: "averages" },
    h("h3", {}, "Comparison of tools"),
    waiting,
    h("ul", { class: "bars" }, ...[...rows.values()].map(({ row }) => row)),
    verdict,
  );
}

/** A value; estimates are marked. */
function inWords(bits: number, about: number): string {
  return about > 0.005 ? `≈ ${bits.toFixed(2)}` : bits.toFixed(2);
}

/** A difference; one too small for two digits is not shown as 0. */
function inBits(apart: number): string {
  return apart < 0.005 ? "less than 0.01 bits" : `${apart.toFixed(2)} bits`;
}

function kindOf(verdict: Verdict | undefined): string {
  if (!verdict || verdict.equal) return "none";
  if (!verdict.useful) return "useless";
  if (verdict.better_than_none === null) return "none";
  return verdict.better_than_none ? "useful" : "encumbers";
}

function sentence(
  tool: string,
  object: string,
  averages: Record<string, number | null>,
  verdict: Verdict | undefined,
): (Node | string)[] {
  const name = nameOf(tool).toLowerCase();
  const [own, bare] = [averages[tool], averages[NO_TOOL]];
  if (tool === NO_TOOL) return ["Choose a tool to see whether it helps."];
  if (!verdict || own == null || bare == null) return [];
  if (verdict.equal) {
    const why = verdict.useful
      ? "it gives as much empowerment as bare hands"
      : `the agent cannot affect the ${object}, with it or with bare hands`;
    return [h("strong", {}, `The ${name} makes no difference`), `: ${why}.`];
  }
  if (!verdict.useful) {
    return [h("strong", {}, `The ${name} is useless here`), `: with it, the agent cannot affect the ${object}.`];
  }
  if (verdict.better_than_none === null) {
    return [h("strong", {}, "Undecided"), ": about as much as with bare hands."];
  }
  const apart = inBits(Math.abs(own - bare));
  if (verdict.better_than_none) {
    return [h("strong", {}, `The ${name} helps`), `: ${apart} more than with bare hands.`];
  }
  return [h("strong", {}, `The ${name} encumbers`), `: ${apart} less than with bare hands.`];
}
