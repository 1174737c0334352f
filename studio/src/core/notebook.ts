/** The world that an embedded page shares with its notebook: edits go there, and its worlds come here. */

import type { Connection } from "./connection";
import type { Hello, Shown } from "./protocol";
import { fitted, message } from "./scene";
import type { Store } from "./store";
import { worldOf } from "./world";

export interface Notebook {
  /** Shows a world of the notebook. */
  show(shown: Shown): void;
}

/** Shares the store's world, if the page is in a notebook. */
export function createNotebook({ shown: first }: Hello, connection: Connection, store: Store): Notebook {
  let number = first?.number ?? 0;
  let [due, showing] = [false, false];

  function send(): void {
    due = false;
    connection.ask("edit", { scene: { ...message(store.scene()) }, shown: number }, () => undefined).forget();
  }

  if (first !== null) {
    document.documentElement.dataset.embedded = "";
    store.watch(({ world, bare }, before) => {
      if (before === null || showing || (world === before.world && bare === before.bare)) return;
      if (!due) requestAnimationFrame(send);
      due = true;
    });
  }
  return {
    show({ drawn, number: next }) {
      if (next <= number && JSON.stringify(message(store.scene()).drawn) === JSON.stringify(drawn)) return;
      number = next;
      showing = true;
      const world = worldOf(drawn);
      store.change(fitted({ ...store.scene(), world, bare: !world.tools.length, cells: [], thing: 0 }));
      showing = false;
    },
  };
}
