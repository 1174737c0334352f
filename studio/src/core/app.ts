/** What every view is given: the server's word, the line to it, the scene and its values. */

import type { Acted } from "./acted";
import type { Connection } from "./connection";
import type { Measuring } from "./measuring";
import type { Hello } from "./protocol";
import type { Store } from "./store";

export interface App {
  readonly hello: Hello;
  readonly connection: Connection;
  readonly store: Store;
  readonly measuring: Measuring;
  readonly acted: Acted;
}

/** One of the page's views; it hears when it is come to and left. */
export interface View {
  readonly element: HTMLElement;
  entered?(): void;
  left?(): void;
  /** The line to the server, which was lost, is there again. */
  again?(): void;
}
