// The island whose page is tested, and other programs beside it.
import { execFileSync, spawn } from "node:child_process";
import { existsSync } from "node:fs";
import { copyFile, readFile, rm, writeFile } from "node:fs/promises";
import { join } from "node:path";
import { fileURLToPath } from "node:url";

const address = "127.0.0.1:8642";
/** A folder with the page in place of the one in the program, for those who work on it. */
const files = process.env.RUBICON_PAGE_FILES;

const guarded = "127.0.0.1:8643";
const alone = "127.0.0.1:8644";
const example = "127.0.0.1:8645";
const unwritten = "127.0.0.1:8646";
const house = "127.0.0.1:8647";
const houseFile = fileURLToPath(new URL("house.yaml", import.meta.url));
const examples = fileURLToPath(new URL("../../examples", import.meta.url));
export const publisher = 70_000;

export class Island {
  #process = null;
  /** Programs of one test. */
  #others = [];
  #printed = "";

  constructor(programs, configuration, folder) {
    this.programs = programs;
    this.configuration = configuration;
    this.folder = folder;
    this.url = `http://${address}/`;
  }

  /** Starts the island and waits until its page answers. */
  async start() {
    const configuration = join(this.folder, "island.yaml");
    await copyFile(this.configuration, configuration);
    const words = [
      "run",
      configuration,
      "--set",
      `web={listen: "${address}"${files ? `, files: "${files}"` : ""}}`,
      "--tuple",
      "house.motto=carpe diem",
    ];
    this.#process = spawn(join(this.programs, "rubicon-proxy"), words, { cwd: this.folder, stdio: ["ignore", "pipe", "pipe"] });
    for (const stream of [this.#process.stdout, this.#process.stderr]) stream.on("data", (text) => (this.#printed += text));
    while (!(await answers(this.url))) {
      if (this.#process.exitCode !== null) throw new Error(`the island ended with ${this.#process.exitCode}:\n${this.#printed}`);
      await pause();
    }
  }

  #beside(program, words) {
    const child = spawn(join(this.programs, program), words, { cwd: this.folder, stdio: "ignore" });
    this.#others.push(child);
    return child;
  }

  /** Publishes a tuple of the owner `publisher`, which everybody may set. Two at a time need two owners. */
  publish(name, value, owner = publisher) {
    this.#beside("rubicon", ["publish", name, value, "--open", "--id", String(owner)]);
  }

  /** Another island with one device, and other networks. */
  async startNeighbour(others = "") {
    const configuration = join(this.folder, "neighbour.yaml");
    const device = "{name: Lawn mower, actuators: {switch-1: {behaviour: obey}}}";
    await writeFile(
      configuration,
      `island: {id: 6542, name: shed}\nnetworks: {dummy-shed: {type: dummy, simulate: {mower: ${device}}}${others}}\n`,
    );
    this.#beside("rubicon-proxy", ["run", configuration]);
  }

  /** An island that says that its history fails, with a page of its own; the address of the page. */
  async startUnwritten(reason) {
    const url = `http://${unwritten}/`;
    const configuration = join(this.folder, "unwritten.yaml");
    await writeFile(configuration, "island: {id: 6544, name: attic}\n");
    const web = `web={listen: "${unwritten}"${files ? `, files: "${files}"` : ""}}`;
    const status = `attic.history.status=${JSON.stringify({ state: "failing", reason })}`;
    this.#beside("rubicon-proxy", ["run", configuration, "--set", web, "--tuple", status]);
    while (!(await answers(url))) await pause();
    return url;
  }

  /** An island that plays a table: a value each second, but for five of twenty seconds, in which its sensor falls silent. */
  async startTape() {
    const table = join(this.folder, "tape.csv");
    const seconds = Array.from({ length: 900 }, (_, second) => second).filter((second) => second % 20 < 4 || second % 20 >= 9);
    await writeFile(table, `time,air\n${seconds.map((second) => `${second},${20 + second / 10}\n`).join("")}`);
    const configuration = join(this.folder, "tape.yaml");
    const tape = `{type: log, format: csv, file: tape.csv, time: {column: time, unit: s}, deadline: 2s, map: {room: {name: Tape room, columns: {air: {sensor: temperature-1}}}}}`;
    await writeFile(configuration, `island: {id: 6543, name: tape}\nnetworks: {log-tape: ${tape}}\n`);
    this.#beside("rubicon-proxy", ["run", configuration]);
  }

  /**
   * An island in a space of its own that keeps what people give it: the address of its page, and the value of one of its
   * tuples. `more` networks are texts of the command line.
   */
  async startHouse(...more) {
    const url = `http://${house}/`;
    const configuration = join(this.folder, "house.yaml");
    await copyFile(houseFile, configuration);
    await rm(join(this.folder, "house.state"), { force: true });
    const web = `web={listen: "${house}"${files ? `, files: "${files}"` : ""}}`;
    const sets = [web, "tuples={space: house}", ...more].flatMap((text) => ["--set", text]);
    this.#beside("rubicon-proxy", ["run", configuration, ...sets]);
    while (!(await answers(url))) await pause();
    const valueOf = async (key) => (await fetch(`${url}api/v1/tuples/6545/${key}`, { headers: { accept: "text/plain" } })).text();
    return { url, valueOf };
  }

  /** A ZigBee network without radio, and its network for `startHouse`; null where there is no broker. */
  async startZigbee(script) {
    const broker = ["/usr/sbin/mosquitto", "/usr/bin/mosquitto"].find(existsSync);
    if (!broker) return null;
    const configuration = join(this.folder, "mosquitto.conf");
    await writeFile(configuration, "listener 18831 127.0.0.1\nallow_anonymous true\npersistence false\n");
    this.#others.push(spawn(broker, ["-c", configuration], { stdio: "ignore" }));
    const file = join(this.folder, "zigbee.script");
    await writeFile(file, script);
    this.#beside("zigbee-simulator", [file, "--broker", "127.0.0.1:18831"]);
    return 'networks.zigbee={type: zigbee, broker: "127.0.0.1:18831"}';
  }

  /** The island of the examples with an hour of its history, in a space of its own; the address of its page. */
  async startExample() {
    const url = `http://${example}/`;
    const history = join(this.folder, "example.history");
    const recording = join(examples, "recordings/demo_hour.rec");
    execFileSync(join(this.programs, "rubicon"), ["history", history, "import", recording, "--end", "now"], { stdio: "ignore" });
    const file = join(examples, "home.yaml");
    const script = join(examples, "salad.script");
    this.#beside("salad-simulator", [file, "--bind", "127.0.0.1", "--script", script, "--log-level", "error"]);
    const web = `web={listen: "${example}"${files ? `, files: "${files}"` : ""}}`;
    const words = ["--set", web, "--set", "tuples={space: past}", "--set", `history={file: "${history}"}`];
    this.#beside("rubicon-proxy", ["run", file, ...words]);
    while (!(await answers(url))) await pause();
    return url;
  }

  /** Simulated motes, at the line of wsn-hall or another one. */
  startMotes(port = 19202) {
    this.#beside("motes-simulator", ["--motes", "3", "--obey", "--updates", "--wait", "--port", String(port)]);
  }

  /** Changes the file of the configuration. */
  async edit(change) {
    const configuration = join(this.folder, "island.yaml");
    await writeFile(configuration, change(await readFile(configuration, "utf8")));
  }

  /** A page of its own that wants a token; the tokens by role, and its address. */
  async startGuarded() {
    const file = join(this.folder, "web.tokens");
    const make = (role) =>
      execFileSync(join(this.programs, "rubicon"), ["token", `${role}-${Date.now()}`, "--role", role, "--file", file], {
        encoding: "utf8",
      }).trim();
    const tokens = { view: make("view"), command: make("command") };
    const url = `http://${guarded}/`;
    const start = async () => {
      const server = this.#beside("rubicon", ["web", "--listen", guarded, "--tokens", file, ...(files ? ["--files", files] : [])]);
      while (!(await answers(url))) await pause();
      return server;
    };
    let server = await start();
    /** Sessions end with the server that made them. */
    const endSessions = async () => {
      await end(server, "SIGTERM");
      server = await start();
    };
    return { tokens, url, endSessions };
  }

  /** A page of a space without islands; its address. */
  async startAlone() {
    const url = `http://${alone}/`;
    this.#beside("rubicon", ["web", "--space", "empty", "--listen", alone, ...(files ? ["--files", files] : [])]);
    while (!(await answers(url))) await pause();
    return url;
  }

  /** Kills what a test started beside the island. */
  async endOthers() {
    for (const child of this.#others.splice(0)) await end(child, "SIGKILL");
  }

  /** Kills the island as a power cut would. */
  async kill() {
    await this.#end("SIGKILL");
  }

  async stop() {
    await this.endOthers();
    await this.#end("SIGTERM");
  }

  async #end(signal) {
    const child = this.#process;
    this.#process = null;
    await end(child, signal);
  }
}

function pause() {
  return new Promise((done) => setTimeout(done, 50));
}

async function answers(url) {
  try {
    return (await fetch(url)).ok;
  } catch {
    return false;
  }
}

async function end(child, signal) {
  if (!child || child.exitCode !== null || child.signalCode !== null) return;
  const ended = new Promise((done) => child.once("exit", done));
  child.kill(signal);
  await ended;
}
