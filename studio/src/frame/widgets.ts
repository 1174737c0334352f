/** The controls shared by all views. */

import { h, set, type Child } from "../core/elements";

export interface Choice<Name extends string> {
  readonly element: HTMLElement;
  show(chosen: Name, off?: readonly string[]): void;
}

/** A choice of a few options, side by side. */
export function segmented<Name extends string>(
  label: string,
  options: Record<Name, Child[]>,
  onChoice: (chosen: Name) => void,
): Choice<Name> {
  const group = `choice-${label.toLowerCase().replaceAll(/\W+/g, "-")}`;
  const inputs = new Map<string, HTMLInputElement>();
  const parts = (Object.entries(options) as [Name, Child[]][]).map(([name, content]) => {
    const input = h("input", { type: "radio", name: group, value: name });
    input.addEventListener("change", () => onChoice(name));
    inputs.set(name, input);
    return h("label", { class: "segment" }, input, h("span", {}, ...content));
  });
  const element = h("div", { class: "segmented", role: "radiogroup", "aria-label": label }, ...parts);
  return {
    element,
    show(chosen, off = []) {
      for (const [name, input] of inputs) {
        input.checked = name === chosen;
        input.disabled = off.includes(name);
      }
    },
  };
}

/** An on-off switch. */
export function toggle(
  label: string,
  id: string,
  onChange: () => void,
): { element: HTMLElement; on: () => boolean; turn: () => void } {
  const input = h("input", { type: "checkbox", role: "switch", id, onchange: onChange });
  return {
    element: h("label", { class: "button toggle" }, input, h("span", {}, label)),
    on: () => input.checked,
    turn() {
      input.checked = !input.checked;
      onChange();
    },
  };
}

/** One of several by name. */
export function select<Name extends string>(
  label: string,
  options: Record<Name, string>,
  onChoice: (chosen: Name) => void,
): HTMLSelectElement {
  const element = h("select", { "aria-label": label });
  offer(element, options);
  element.addEventListener("change", () => onChoice(element.value as Name));
  return element;
}

/** Lets one choose among these, where they are others than before. */
export function offer(element: HTMLSelectElement, options: Record<string, string>): void {
  const offered = JSON.stringify(options);
  if (element.dataset.offered === offered) return;
  element.dataset.offered = offered;
  element.replaceChildren(
    ...Object.entries(options).map(([value, text]) => h("option", { value }, text)),
  );
}

export interface Slider {
  readonly element: HTMLElement;
  readonly input: HTMLInputElement;
  show(value: number): void;
}

/** A number from a range, with its value in words. */
export function slider(
  label: string,
  range: { id: string; least: number; most: number; step: number },
  words: (value: number) => string,
  onInput: (value: number) => void,
): Slider {
  const { id, least, most, step } = range;
  const input = h("input", { type: "range", id, min: least, max: most, step });
  const output = h("output", { for: id });
  const show = (value: number) => {
    input.value = String(value);
    const end = Number(input.max); // it may have been moved
    input.style.setProperty("--share", String((value - least) / (end - least)));
    set(input, "aria-valuetext", words(value));
    output.textContent = words(value);
  };
  input.addEventListener("input", () => {
    show(Number(input.value));
    onInput(Number(input.value));
  });
  const head = h("div", { class: "field-head" }, h("label", { for: id }, label), output);
  return { element: h("div", { class: "field" }, head, input), input, show };
}

export function field(label: string, control: HTMLElement): HTMLElement {
  const head = h("div", { class: "field-head" }, h("span", { class: "field-name" }, label));
  return h("div", { class: "field" }, head, control);
}

/** A whole or other number with its label above. */
export function numberField(
  label: string,
  range: { id: string; least: number; most?: number; step: number; value: number },
): { element: HTMLElement; input: HTMLInputElement } {
  const { id, least, most, step, value } = range;
  const input = h("input", { type: "number", id, min: least, max: most, step, value });
  const element = h("div", { class: "field" }, h("label", { for: id }, label), input);
  return { element, input };
}

const ICONS: Record<string, string> = {
  undo: "M9 7 4 12l5 5M4 12h10a6 6 0 0 1 0 12h-3",
  redo: "m15 7 5 5-5 5M20 12H10a6 6 0 0 0 0 12h3",
  text: "M5 6h14M5 11h14M5 16h9",
  eraser: "m7 20-3-3 11-11 6 6-8 8zM4 20h17",
  link: "M10 14a4 4 0 0 0 6 0l3-3a4 4 0 0 0-6-6l-1 1M14 10a4 4 0 0 0-6 0l-3 3a4 4 0 0 0 6 6l1-1",
  keep: "M12 4v11M7 11l5 5 5-5M5 20h14",
  sun: "M12 8a4 4 0 1 0 0 8 4 4 0 0 0 0-8M12 2v2M12 20v2M2 12h2M20 12h2M5 5l1.5 1.5M17.5 17.5 19 19M5 19l1.5-1.5M17.5 6.5 19 5",
  moon: "M20 14A8.5 8.5 0 0 1 10 4a8.5 8.5 0 1 0 10 10",
  help: "M9 9a3 3 0 1 1 4.5 2.6c-1 .6-1.5 1.2-1.5 2.4M12 17.5v.5",
  play: "M8 5v14l11-7z",
  pause: "M8 5v14M16 5v14",
  stop: "M7 7h10v10H7z",
  reset: "M5 12a7 7 0 1 0 2.5-5.4M5 4v4h4",
  bin: "M5 7h14M10 7V5h4v2M7 7l1 13h8l1-13",
  close: "M6 6l12 12M18 6 6 18",
};

export function glyph(name: string): HTMLElement {
  const span = h("span", { class: "glyph", "aria-hidden": "true" });
  const shift = name === "undo" || name === "redo" ? "0 3 24 24" : "0 0 24 24";
  span.innerHTML = `<svg viewBox="${shift}"><path d="${ICONS[name] ?? ""}"/></svg>`;
  return span;
}

/** A button with an icon only; its action is the label and the tooltip. */
export function iconButton(
  name: string,
  label: string,
  onClick: () => void,
  id?: string,
): HTMLButtonElement {
  return h(
    "button",
    { type: "button", class: "icon-button", "aria-label": label, title: label, onclick: onClick, id },
    glyph(name),
  );
}

export function button(
  label: string,
  onClick: () => void,
  { id, kind = "", sign }: { id?: string; kind?: string; sign?: string } = {},
): HTMLButtonElement {
  return h(
    "button",
    { type: "button", class: `button ${kind}`, onclick: onClick, id },
    sign ? glyph(sign) : null,
    h("span", { class: "button-name" }, label),
  );
}

/** Changes the label and icon of a button, such as to "Pause" during playback. */
export function rename(element: HTMLButtonElement, label: string, sign: string): void {
  if (element.querySelector(".button-name")?.textContent === label) return;
  element.replaceChildren(glyph(sign), h("span", { class: "button-name" }, label));
}

export function card(name: string, kind: string, ...children: Child[]): HTMLElement {
  return h("section", { class: `card ${kind}`, "aria-label": name }, ...children);
}

/** A few words at the foot of the page that go by themselves. */
export function notice(words: string): void {
  const old = document.querySelector(".notice");
  old?.remove();
  const element = h("div", { class: "notice", role: "status" }, words);
  document.body.append(element);
  setTimeout(() => element.remove(), 3500);
}

/** Copies a text; where the browser does not let the page, as without HTTPS on another machine, selects what shows it. */
export async function copyText(text: string, shown: HTMLElement): Promise<void> {
  try {
    await navigator.clipboard.writeText(text);
    notice("Copied");
  } catch {
    if (shown instanceof HTMLTextAreaElement) shown.select();
    else getSelection()?.selectAllChildren(shown);
    notice("Selected, but not copied: press Ctrl+C");
  }
}
