/** Files made by the page, which the browser saves. */

import { h } from "../core/elements";
import type { Grid } from "../core/protocol";
import type { Line } from "../draw/chart";

export function saveFile(name: string, content: Blob): void {
  const link = h("a", { download: name });
  link.href = URL.createObjectURL(content);
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000); // some browsers begin to read it later
}

/** Rows as comma-separated values. */
export function csvOf(rows: readonly (readonly (string | number | null)[])[]): Blob {
  const field = (value: string | number | null) => {
    const text = value === null ? "" : String(value);
    return /[",\r\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
  };
  const lines = rows.map((row) => row.map(field).join(","));
  return new Blob([lines.join("\n"), "\n"], { type: "text/csv" });
}

/** A file from the base64 text of a message. */
export function blobOf(base64: string, type: string): Blob {
  return new Blob([Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0))], { type });
}

/** The values of cells as rows: row, column, value. */
export function rowsOf(grid: Grid, unit: string): (string | number | null)[][] {
  const rows = grid.flatMap((values, row) => values.map((value, column) => [row, column, value]));
  return [["row", "column", unit], ...rows];
}

/** Lines of a chart as rows: which line, its point, and the interval there. */
export function pointsOf(lines: readonly Line[], xLabel: string, yLabel: string): (string | number | null)[][] {
  const rows = lines.flatMap(({ label, x, y, low, high }) =>
    x.map((at, k) => [label, at, y[k]!, low?.[k] ?? null, high?.[k] ?? null]),
  );
  return [["line", xLabel, yLabel, "low", "high"], ...rows];
}
