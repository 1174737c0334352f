/** The library's drawings of things, defined once and used wherever one is shown. */

import type { Drawing } from "../core/protocol";
import { escaped, svg } from "../core/elements";

const PREFIX = "shape-";
const known = new Set<string>();
let sheet: SVGSVGElement | null = null;

/** Stores the server's drawings, each in a unit cell. */
export function keepShapes(shapes: Record<string, Drawing>): void {
  sheet?.remove();
  sheet = svg("svg", { width: 0, height: 0, "aria-hidden": "true", class: "shapes" });
  const defs = svg("defs");
  defs.innerHTML = Object.entries(shapes)
    .map(([name, drawing]) => {
      const paths = drawing.map(([path, fill]) => `<path d="${path}" fill="${escaped(fill)}"/>`);
      return `<g id="${idOf(name)}">${paths.join("")}</g>`;
    })
    .join("");
  for (const name of Object.keys(shapes)) known.add(name);
  sheet.append(defs);
  document.body.append(sheet);
}

/** A tool's own drawing, or the default one. */
export function drawingOf(tool: string): string {
  return known.has(tool) ? tool : "tool";
}

/** A reference to a drawing; `size` is the size of its cell in the surrounding units. */
export function use(name: string, x: number, y: number, size: number): string {
  return `<use href="#${idOf(name)}" transform="translate(${x} ${y}) scale(${size})"/>`;
}

/** A thing as an icon in text. */
export function icon(name: string, size = 22): SVGSVGElement {
  const picture = svg("svg", {
    viewBox: "0 0 1 1",
    width: size,
    height: size,
    class: "icon",
    "aria-hidden": "true",
  });
  picture.innerHTML = use(name, 0, 0, 1);
  return picture;
}

function idOf(name: string): string {
  return PREFIX + encodeURIComponent(name).replaceAll("%", "_");
}
