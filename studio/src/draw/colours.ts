/** The colour map: viridis without its dark end, as in the library's pictures. */

const STOPS = [
  0x414487, 0x3b528b, 0x355f8d, 0x2f6c8e, 0x2a788e, 0x25848e, 0x21918c, 0x1e9c89, 0x22a884,
  0x2fb47c, 0x44bf70, 0x5ec962, 0x7ad151, 0x9bd93c, 0xbddf26, 0xdfe318, 0xfde725,
];
const HALFWAY = 0.179; // the luminance at which black and white have equal contrast

export interface Scale {
  readonly low: number;
  readonly high: number;
  /** Decimals of its values. */
  readonly digits: number;
}

/** The two ends of a colour scale; a single value becomes its lower end. */
export function scaleOf(least: number, most: number): Scale {
  return { low: least, high: most > least ? most : least + 1, digits: digitsOf(least, most) };
}

/** The decimals that tell the values of a scale apart: more on a shorter one. */
export function digitsOf(least: number, most: number): 1 | 2 | 3 {
  const length = most - least;
  if (length >= 1 || length < 1e-9) return 1;
  return length >= 0.1 ? 2 : 3;
}

export function inDigits(value: number, digits: number): string {
  return value.toFixed(digits).replace("-", "−");
}

export function colourOf(value: number, { low, high }: Scale): string {
  const [red, green, blue] = parts(value, low, high);
  return `rgb(${Math.round(red)},${Math.round(green)},${Math.round(blue)})`;
}

/** Black or white, whichever has the higher contrast (as WCAG 2 defines it). */
export function inkOn(value: number, { low, high }: Scale): string {
  const linear = parts(value, low, high).map((part) => {
    const share = part / 255;
    return share <= 0.04045 ? share / 12.92 : ((share + 0.055) / 1.055) ** 2.4;
  });
  const light = 0.2126 * linear[0]! + 0.7152 * linear[1]! + 0.0722 * linear[2]!;
  return light > HALFWAY ? "#000" : "#fff";
}

/** The scale as the background of an element, from left to right. */
export const GRADIENT = `linear-gradient(90deg, ${STOPS.map(
  (stop) => `#${stop.toString(16).padStart(6, "0")}`,
).join(", ")})`;

function parts(value: number, low: number, high: number): [number, number, number] {
  const place = Math.min(Math.max((value - low) / (high - low), 0), 1) * (STOPS.length - 1);
  const below = Math.min(Math.floor(place), STOPS.length - 2);
  const share = place - below;
  const [from, to] = [STOPS[below]!, STOPS[below + 1]!];
  const mixed = (shift: number) =>
    ((from >> shift) & 255) * (1 - share) + ((to >> shift) & 255) * share;
  return [mixed(16), mixed(8), mixed(0)];
}
