/** The control for what is measured: the kind of empowerment, and the settings of the chosen one. */

import { h } from "../core/elements";
import { KIND_NAMES, OVER_ALL, sentenceOn, type KindSettings } from "../core/kinds";
import type { Hello, Kind } from "../core/protocol";
import { field, select, slider } from "./widgets";

export interface KindControl {
  /** What is measured, and a sentence on it. */
  readonly element: HTMLElement;
  /** The settings of some kinds alone. */
  readonly settings: readonly HTMLElement[];
  /** Shows a kind, and of all controls those that belong to it. */
  show(chosen: KindSettings): void;
}

/**
 * @param prefix - of the ids.
 * @param others - the controls of the horizon and of the actions, which some kinds do not have.
 */
export function createKind(
  { limits }: Hello,
  prefix: string,
  others: { readonly horizon: HTMLElement; readonly actions: HTMLElement },
  onChange: (part: Partial<KindSettings>, gesture?: string) => void,
): KindControl {
  const kind = select<Kind>("What is measured", KIND_NAMES, (kind) => onChange({ kind }));
  const sentence = h("p", { class: "quiet kind-sentence", id: `${prefix}kind-sentence`, "aria-live": "polite" });
  kind.id = `${prefix}kind`;
  kind.setAttribute("aria-describedby", sentence.id);
  const discount = slider(
    "Discount",
    { id: `${prefix}discount`, least: 0, most: limits.discount, step: 0.05 },
    (value) => value.toFixed(2),
    (discount) => onChange({ discount }, "discount"),
  );
  const slack = slider(
    "Slack",
    { id: `${prefix}slack`, least: 0, most: limits.slack, step: 1 },
    String,
    (slack) => onChange({ slack }, "slack"),
  );
  const head = field("What is measured", kind);
  head.append(sentence);
  return {
    element: head,
    settings: [discount.element, slack.element],
    show(chosen) {
      kind.value = chosen.kind;
      sentence.textContent = sentenceOn(chosen);
      discount.show(chosen.discount);
      slack.show(chosen.slack);
      others.horizon.hidden = chosen.kind === "effective";
      others.actions.hidden = OVER_ALL.includes(chosen.kind);
      discount.element.hidden = chosen.kind !== "effective";
      slack.element.hidden = chosen.kind !== "goal-directed";
    },
  };
}
