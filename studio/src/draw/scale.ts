/** The scale under a board: its colours, their two ends, and their unit. */

import { h } from "../core/elements";
import { colourOf, digitsOf, GRADIENT, inDigits, scaleOf } from "./colours";

export interface ScaleBar {
  readonly element: HTMLElement;
  /** Shows the scale, or hides it if there are no values. */
  show(ends: { least: number; most: number } | null): void;
}

export function createScaleBar(words: string): ScaleBar {
  const [least, most] = [h("span"), h("span")];
  const bar = h("span", { class: "scale-bar" });
  const element = h("div", { class: "scale" }, least, bar, most, h("span", {}, words));
  return {
    element,
    show(ends) {
      element.hidden = ends === null;
      if (ends === null) return;
      const digits = Math.max(digitsOf(ends.least, ends.most), 2);
      const inWords = (value: number) => inDigits(value, digits);
      const one = inWords(ends.least) === inWords(ends.most); // a single colour
      bar.style.background = one ? colourOf(ends.least, scaleOf(ends.least, ends.most)) : GRADIENT;
      most.hidden = one;
      least.textContent = inWords(ends.least);
      most.textContent = inWords(ends.most);
    },
  };
}
