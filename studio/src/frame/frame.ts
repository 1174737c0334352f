/** The frame around the views: name, tabs, definition, link, theme and help. */

import type { App, View } from "../core/app";
import type { Status } from "../core/connection";
import { h, set } from "../core/elements";
import { NOTHING, openKeep } from "../keep/dialog";
import { openHelp } from "./help";
import { createThemeSwitch } from "./theme";
import { createTour } from "./tour";
import { iconButton, notice } from "./widgets";

export interface Frame {
  readonly element: HTMLElement;
  view(): string;
  open(view: string): void;
  /** Shows the tour on a first visit. */
  offerTour(): void;
  showStatus(status: Status): void;
  /** A line below the tabs about the opened link; null removes it. */
  showLink(words: string | null): void;
}

/** The link to the current scene and view. */
export interface Link {
  /** Its address. */
  address(): string;
  /** Puts it in the address bar. */
  show(): void;
}

const IDEA = "Empowerment: how many distinct futures an agent can choose from.";
const STATUS: Record<Status, string> = {
  connecting: "connecting…",
  open: "",
  lost: "Connection lost; reconnecting…",
};

export function createFrame(
  app: App,
  views: Record<string, View>,
  onView: () => void,
  link: Link,
): Frame {
  const { hello, store } = app;
  const names = Object.keys(views);
  const tour = createTour(app, () => open("design"));
  const help = () => openHelp(hello, tour.begin);
  let current = "";
  const tabs = names.map((name) =>
    h(
      "button",
      {
        type: "button",
        role: "tab",
        id: `tab-${name}`,
        "aria-controls": `view-${name}`,
        onclick: () => open(name),
      },
      name[0]!.toUpperCase() + name.slice(1),
    ),
  );
  const panels = names.map((name) =>
    h(
      "div",
      { id: `view-${name}`, role: "tabpanel", "aria-labelledby": `tab-${name}`, hidden: true },
      views[name]!.element,
    ),
  );
  const line = h("p", { class: "status", role: "status" });
  const list = h("div", { class: "tabs", role: "tablist", "aria-label": "Views" }, ...tabs);
  list.addEventListener("keydown", (event) => {
    const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
    if (step === undefined) return;
    const next = names[(names.indexOf(current) + step + names.length) % names.length]!;
    open(next);
    tabs[names.indexOf(next)]!.focus();
    event.stopPropagation();
    event.preventDefault();
  });

  function open(name: string): void {
    const next = names.includes(name) ? name : names[0]!;
    if (next === current) return;
    views[current]?.left?.();
    current = next;
    names.forEach((other, k) => {
      set(tabs[k]!, "aria-selected", String(other === next));
      set(tabs[k]!, "tabindex", other === next ? 0 : -1);
      panels[k]!.hidden = other !== next;
    });
    views[next]!.entered?.();
    onView();
  }

  const keep = () => openKeep(app.connection, views[current]?.keeps?.() ?? NOTHING);

  async function share(): Promise<void> {
    try {
      await navigator.clipboard.writeText(link.address());
      notice("Link copied");
    } catch {
      link.show();
      notice("The link is in the address bar");
    }
  }

  addEventListener("keydown", (event) => {
    const target = event.target as Element;
    const typing = target.closest("textarea, dialog, input[type=number]") !== null;
    if ((event.ctrlKey || event.metaKey) && event.key.toLowerCase() === "z" && !typing) {
      if (event.shiftKey) store.redo();
      else store.undo();
      event.preventDefault();
    } else if (typing || event.ctrlKey || event.metaKey || event.altKey) return;
    else if (event.key === "?") help();
    else if (/^[1-4]$/.test(event.key) && !target.closest("input, select")) {
      open(names[Number(event.key) - 1]!);
    }
  });

  const words = h("span", {});
  const banner = h(
    "div",
    { class: "banner", id: "link-fault", role: "alert", hidden: true },
    words,
    iconButton("close", "Dismiss", () => (banner.hidden = true)),
  );
  // The page does not move while a finger or the mouse is drawing on it.
  let [pressed, outdated] = [false, false];
  addEventListener("pointerdown", () => (pressed = true), true);
  for (const end of ["pointerup", "pointercancel"]) {
    addEventListener(end, () => {
      pressed = false;
      setTimeout(() => outdated && (banner.hidden = true));
    }, true);
  }
  const element: HTMLElement = h(
    "div",
    { class: "frame" },
    h(
      "header",
      { class: "top" },
      h("h1", {}, "Habilis ", h("span", {}, "studio")),
      list,
      h("div", { class: "idea" }, h("p", {}, IDEA), line),
      h(
        "div",
        { class: "icons" },
        iconButton("keep", "Keep and share: pictures, films, values, code", keep, "keep"),
        iconButton("link", "Copy a link to this page", share, "share"),
        createThemeSwitch(),
        iconButton("help", "What is this? (?)", help, "help"),
      ),
    ),
    banner,
    tour.element,
    h("main", {}, ...panels),
  );
  return {
    element,
    view: () => current,
    open,
    offerTour: () => tour.offer(current),
    showStatus(status) {
      line.textContent = STATUS[status];
      line.hidden = status === "open";
    },
    showLink(message) {
      outdated = message === null;
      if (message !== null) words.textContent = message;
      if (!outdated || !pressed) banner.hidden = outdated;
    },
  };
}
