/** The WebSocket to the server: numbered requests, and answers routed to their callers. */

import type { Answer, Hello, Messages, Shown } from "./protocol";

export type Status = "connecting" | "open" | "lost";

export interface Asked {
  readonly id: number;
  /** Ignores further answers. */
  forget(): void;
}

/** An answer; or that the connection was lost, and no further answers will come. */
export type Heard<Name extends keyof Messages> = Messages[Name]["answer"] & { lost?: boolean };

export interface Connection {
  /** Sends a request; `on` gets every answer to it, until it is forgotten or the connection is lost. */
  ask<Name extends keyof Messages>(
    what: Name,
    body: Omit<Messages[Name]["request"], "id" | "do">,
    on: (answer: Heard<Name>) => void,
  ): Asked;
  /** Sends a message about an earlier request, whose caller gets the answers. */
  tell(asked: Asked, what: "stop"): void;
}

const FIRST_WAIT = 400;
const LONGEST_WAIT = 5000;
const LOST = "the connection to the server was lost";

/** Connects to the page's own server, and reconnects whenever the connection is lost. */
export function connect(
  onHello: (hello: Hello) => void,
  onStatus: (status: Status) => void,
  onShow: (shown: Shown) => void,
): Connection {
  const listeners = new Map<number, (answer: never) => void>();
  let socket: WebSocket | null = null;
  let last = 0;
  let wait = FIRST_WAIT;

  function open(): void {
    onStatus("connecting");
    const address = new URL(`ws${location.search}`, location.href); // a proxy may serve the page at any path
    address.protocol = location.protocol === "https:" ? "wss:" : "ws:";
    socket = new WebSocket(address);
    socket.onmessage = (event) => receive(JSON.parse(String(event.data)));
    socket.onclose = () => {
      onStatus("lost");
      for (const id of [...listeners.keys()]) lose(id);
      setTimeout(open, wait);
      wait = Math.min(2 * wait, LONGEST_WAIT);
    };
  }

  function receive(message: Answer | { hello: Hello } | { show: Shown }): void {
    if ("show" in message) {
      onShow(message.show);
      return;
    }
    if ("hello" in message) {
      wait = FIRST_WAIT;
      onStatus("open");
      onHello(message.hello);
      return;
    }
    const answer = message;
    if (answer.id === null) return;
    const listener = listeners.get(answer.id) as ((answer: Answer) => void) | undefined;
    if (answer.overtaken || answer.error !== undefined) listeners.delete(answer.id);
    if (!answer.overtaken) listener?.(answer);
  }

  /** Every request gets an answer, even if the connection is lost. */
  function lose(id: number): void {
    const listener = listeners.get(id) as ((answer: Answer & { lost: true }) => void) | undefined;
    listeners.delete(id);
    listener?.({ id, error: LOST, lost: true });
  }

  function send(id: number, what: string, body: object): void {
    if (socket?.readyState !== WebSocket.OPEN) queueMicrotask(() => lose(id));
    else socket.send(JSON.stringify({ id, do: what, ...body }));
  }

  open();
  return {
    ask(what, body, on) {
      const id = ++last;
      listeners.set(id, on as (answer: never) => void);
      send(id, what, body);
      return { id, forget: () => listeners.delete(id) };
    },
    tell: (asked, what) => send(asked.id, what, {}),
  };
}
