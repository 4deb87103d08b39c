import type { Want } from "./feed";

/** Open branches of one owner that are asked for; a connection has 256 subscriptions. */
const mostBranches = 100;

function wholeOf(pattern: string): Want {
  return { pattern, full: true, min: 500 };
}

/**
 * What the tree needs of an owner. A large island is never asked for everything: its own tuples, those of its networks, and what is
 * below the devices that are open; the devices are known by their descriptions. Points have six parts.
 */
export function wantsOf(owner: string, open: Iterable<string>, large: boolean): Want[] {
  if (!large) return [wholeOf(`${owner}:**`)];
  const own = ["*", "*.*", "*.*.*", "*.*.*.*", "*.*.*.*.*"].map((keys) => wholeOf(`${owner}:${keys}`));
  const devices = [...open].filter((path) => isDevice(path, owner)).slice(-mostBranches);
  return [...own, ...devices.map((path) => wholeOf(`${path}.**`))];
}

/** `6541:proxy.wsn-1.7` */
function isDevice(path: string, owner: string): boolean {
  const [prefix = "", network = "", device, more] = path.split(".");
  return (
    prefix.startsWith(`${owner}:`) &&
    device !== undefined &&
    device !== "property" &&
    more === undefined &&
    network !== "inbox" &&
    network !== "recorder"
  );
}
