/** Shared by all views: the server's greeting, the connection, the scene and its values. */

import type { Keeps } from "../keep/dialog";
import type { Watched } from "./watched";
import type { Connection } from "./connection";
import type { Measuring } from "./measuring";
import type { Hello } from "./protocol";
import type { Store } from "./store";

export interface App {
  readonly hello: Hello;
  readonly connection: Connection;
  readonly store: Store;
  readonly measuring: Measuring;
  readonly watched: Watched;
}

/** One of the page's views, notified when it is entered and left. */
export interface View {
  readonly element: HTMLElement;
  entered?(): void;
  left?(): void;
  /** What is on the screen, to be kept as files. */
  keeps?(): Keeps;
  /** The connection to the server is back. */
  again?(): void;
}
