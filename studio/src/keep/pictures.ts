/** A board or a chart as a picture of its own: what is on the screen, with its looks written out. */

const WIDTH = 1200; // pixels of a PNG, at least
const LOOKS = [
  "fill", "stroke", "stroke-width", "stroke-dasharray", "stroke-linejoin", "stroke-linecap", "paint-order",
  "opacity", "font-family", "font-size", "font-weight", "text-anchor", "dominant-baseline", "transform",
  "display", "rx", "clip-path", "font-variant-numeric",
];
const UNSEEN = ".cells, .cursor"; // what is there for pointers and readers only
const MARGIN = 0.02; // of the larger side, around a board, over which arrows may reach

/** The picture as SVG, readable without the page. */
export function svgOf(picture: SVGSVGElement): string {
  const copy = picture.cloneNode(true) as SVGSVGElement;
  const [from, to] = [picture, copy].map((one) => [...one.querySelectorAll<SVGElement>("*")]);
  from!.forEach((element, k) => write(element, to![k]!));
  write(picture, copy);
  copy.removeAttribute("style");
  for (const unseen of copy.querySelectorAll(UNSEEN)) unseen.remove();

  const box = picture.viewBox.baseVal;
  const margin = picture.matches(".board") ? MARGIN * Math.max(box.width, box.height) : 0;
  const [x, y, width, height] = [
    box.x - margin, box.y - margin, box.width + 2 * margin, box.height + 2 * margin,
  ].map((value) => Math.round(value)) as [number, number, number, number];
  for (const name of ["id", "class", "tabindex", "role", "aria-activedescendant"]) copy.removeAttribute(name);
  copy.setAttribute("xmlns", "http://www.w3.org/2000/svg");
  copy.setAttribute("viewBox", `${x} ${y} ${width} ${height}`);
  copy.setAttribute("width", String(width));
  copy.setAttribute("height", String(height));
  copy.insertAdjacentHTML(
    "afterbegin",
    `<defs>${drawingsIn(copy)}</defs><rect x="${x}" y="${y}" width="${width}" height="${height}" fill="${ground(picture)}"/>`,
  );
  return new XMLSerializer().serializeToString(copy);
}

/** The picture as pixels, large enough to print. */
export async function pngOf(picture: SVGSVGElement): Promise<Blob> {
  const image = new Image();
  image.src = `data:image/svg+xml;charset=utf-8,${encodeURIComponent(svgOf(picture))}`;
  await image.decode();
  const scale = Math.max(1, WIDTH / image.width);
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [Math.round(scale * image.width), Math.round(scale * image.height)];
  canvas.getContext("2d")!.drawImage(image, 0, 0, canvas.width, canvas.height);
  return new Promise((resolve, reject) =>
    canvas.toBlob((blob) => (blob ? resolve(blob) : reject(new Error("the picture is too large"))), "image/png"),
  );
}

/** Writes an element's looks, which style sheets determine, onto its copy. */
function write(element: SVGElement, copy: SVGElement): void {
  const looks = getComputedStyle(element);
  const written = LOOKS.map((name) => [name, looks.getPropertyValue(name)] as const)
    .filter(([name, value]) => value && value !== DEFAULTS[name])
    .map(([name, value]) => `${name}:${value}`);
  // What is drawn once and used often has its own looks.
  if (element.localName !== "use") copy.setAttribute("style", written.join(";"));
  copy.removeAttribute("class");
}

const DEFAULTS: Record<string, string> = {
  stroke: "none", "stroke-dasharray": "none", opacity: "1", transform: "none", display: "inline", rx: "auto",
  "clip-path": "none", "paint-order": "normal", "stroke-width": "1px", "stroke-linejoin": "miter", "stroke-linecap": "butt",
};

/** The library's drawings that a picture uses, which the page has once for all pictures. */
function drawingsIn(picture: SVGSVGElement): string {
  const names = [...picture.querySelectorAll("use")].map((use) => use.getAttribute("href")!.slice(1));
  return [...new Set(names)].map((name) => document.getElementById(name)?.outerHTML ?? "").join("");
}

/** The colour behind it. */
function ground(picture: Element): string {
  for (let at: Element | null = picture; at; at = at.parentElement) {
    const colour = getComputedStyle(at).backgroundColor;
    if (!/^rgba\(.*, 0\)$|^transparent$/.test(colour)) return colour;
  }
  return "#ffffff";
}
