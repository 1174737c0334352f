/** Light or dark: the system's preference, until the user chooses. */

import { iconButton } from "./widgets";

const KEPT = "habilis-theme";

type Theme = "light" | "dark";

function system(): Theme {
  return matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light";
}

function kept(): Theme | null {
  try {
    const value = localStorage.getItem(KEPT);
    return value === "light" || value === "dark" ? value : null;
  } catch {
    return null; // storage is disabled
  }
}

/** The theme switch; it takes effect at once. */
export function createThemeSwitch(): HTMLElement {
  const holder = document.createElement("span");
  function show(): void {
    const theme = kept() ?? system();
    document.documentElement.dataset.theme = theme;
    const other = theme === "dark" ? "light" : "dark";
    const sign = other === "dark" ? "moon" : "sun";
    holder.replaceChildren(iconButton(sign, `Switch to ${other}`, () => choose(other), "theme"));
  }
  function choose(theme: Theme): void {
    try {
      localStorage.setItem(KEPT, theme);
    } catch {
      document.documentElement.dataset.theme = theme;
    }
    show();
    holder.querySelector("button")?.focus();
  }
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", show);
  show();
  return holder;
}
