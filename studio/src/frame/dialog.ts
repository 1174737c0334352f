/** A dialog over the page; Escape and a click outside close it. */

import { h, type Child } from "../core/elements";
import { iconButton } from "./widgets";

export function openDialog(title: string, ...children: Child[]): () => void {
  const dialog = h("dialog", { "aria-label": title });
  const close = () => dialog.close();
  dialog.append(
    h("div", { class: "dialog-head" }, h("h2", {}, title), iconButton("close", "Close", close)),
    ...children.filter((child) => child !== null),
  );
  let beside = false; // where the press began: selecting text beyond the edge does not close the dialog
  dialog.addEventListener("pointerdown", (event) => (beside = event.target === dialog));
  dialog.addEventListener("click", (event) => beside && event.target === dialog && close());
  dialog.addEventListener("close", () => dialog.remove());
  document.body.append(dialog);
  dialog.showModal();
  return close;
}
