/* worker: the connection, off the page's thread: a page that is busy drawing does not keep the socket waiting. Hands
 * over each frame's octets without a copy, and the connection's state. */
import { Connection } from "../../client/src/index.js";
import type { FromWorker, ToWorker } from "./source.js";

const scope = self as unknown as { onmessage: (e: MessageEvent<ToWorker>) => void; postMessage(m: FromWorker, move?: Transferable[]): void };
let connection: Connection | null = null;

scope.onmessage = ({ data }) => {
  switch (data.op) {
    case "connect":
      connection?.close();
      connection = new Connection({
        url: data.url, token: data.token,
        onFrame: (_, buffer) => scope.postMessage({ op: "frame", buffer }, [buffer]),
        onState: (state, why) => scope.postMessage({ op: "state", state, why }),
      });
      break;
    case "send": connection?.send(data.message); break;
    case "seen": connection?.seen(BigInt(data.number)); break;
  }
};
