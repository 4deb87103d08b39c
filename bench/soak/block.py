"""The programs of a city block: 20 islands on all wires, six types of networks, brokers, simulators."""
import os, pathlib, shutil, signal, struct, subprocess, sys, time

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
ROOMS = 80  #: simulated rooms of an island, each a device
DIMMERS = 8  #: of them with a dimmer that is commanded
PAGE = 18600  #: port of the page of island N: PAGE + N
SITES, ZIGBEE = 18801, 18802  #: ports of the two brokers

#: Islands by the wires that they are on. 119 and 120 are on two.
WIRES = {"host": range(101, 108), "dds": range(108, 112), "peis": range(112, 115), "mqtt": range(115, 119), "carriers": (119, 120)}
#: Islands that are seen at the broker of the sites, too: by the one that carries them there.
CARRIED = {103: (101, 102), 119: (108,), 120: (112,)}
#: Are killed, stopped and reloaded; the others run from the beginning to the end, and must not grow.
MORTAL = (102, 105, 107, 109, 111, 113, 116, 118)
#: Those of them whose wall clock steps.
STEPPED = (107, 118)
GUEST = 117  #: its page wants tokens


def wire_of(island):
    return next(wire for wire, islands in WIRES.items() if island in islands)


def between(sender, owner):
    """Names of what is between a sender and an owner and may be killed or stopped."""
    at_the_broker = sender != owner and {"mqtt", "carriers"} & {wire_of(sender), wire_of(owner)}
    return [str(owner)] + (["broker-sites"] if at_the_broker else [])


def tuples_of(island):
    """The section `tuples` of an island."""
    dds, peis = "interfaces: [lo], domain: 7", "peis: {network: block}"
    mqtt = f"mqtt: {{broker: {{host: 127.0.0.1, port: {SITES}}}, trust_broker: yes, lease: 13s}}"
    carry = f"carry: {list(CARRIED.get(island, ()))}"
    return {103: f"{{engine: mqtt, {mqtt}, {carry}}}", 119: f"{{host: no, engine: [dds, mqtt], {dds}, {mqtt}, {carry}}}",
            120: f"{{host: no, engine: [peis, mqtt], interfaces: [lo], {peis}, {mqtt}, {carry}}}"}.get(island) or {
            "host": "{}", "dds": f"{{host: no, engine: dds, {dds}}}", "peis": f"{{host: no, engine: peis, interfaces: [lo], {peis}}}",
            "mqtt": f"{{host: no, engine: mqtt, {mqtt}}}"}[wire_of(island)]


def rooms(name="dummy-rooms", count=ROOMS):
    plain = "sensors: {temperature-1: {wave: random, low: 19, high: 23}, light-1: {wave: sine, low: 5, high: 400, period: 30s}}"
    return f"""  {name}:
    type: dummy
    simulate:
      "room-{{1..{count}}}": {{name: "Room {{n}}", {plain}}}
      "hall-{{1..{DIMMERS}}}": {{name: "Hall {{n}}", {plain}, actuators: {{dimmer-1: {{behaviour: obey, delay: 50ms}}}}}}
"""


def knx_groups(folder):
    """The line of the KNX simulator, and the groups of an island there."""
    line, groups = [], []
    for one in range(1, 51):
        line += [f"group 1/1/{one} 1.001 off state 1/2/{one}", f"group 1/3/{one} 9.001 21 every {5 + one % 20}s noise 0.2"]
        groups += [f"1/1/{one}: {{dpt: 1.001, kind: actuator, state: 1/2/{one}}}", f"1/3/{one}: {{dpt: 9.001}}"]
    (folder / "knx.script").write_text("\n".join(line) + "\n")
    return ", ".join(groups)


def in_a_network_of_its_own():
    """Starts the program of the caller once more, in a network namespace with loopback alone."""
    if os.environ.get("RUBICON_BENCH_INSIDE") != "yes":
        as_root = [] if os.geteuid() == 0 else ["--map-root-user"]
        os.execvpe("unshare", ["unshare", "--net", *as_root, "sh", "-c", 'ip link set lo up && exec "$0" "$@"', sys.executable, *sys.argv],
                   {**os.environ, "RUBICON_BENCH_INSIDE": "yes"})


class Group:
    """A control group of version 2, or of version 1, that holds a process to `share` of a core and `memory` bytes. The processor is given
    and taken away in each `period` of microseconds. Root."""

    def __init__(self, share, memory, period=100_000):
        root = pathlib.Path("/sys/fs/cgroup")
        self.two = (root / "cgroup.controllers").exists()
        name = f"rubicon-held-{os.getpid()}"
        self.cpu = root / name if self.two else root / "cpu" / name
        self.memory = self.cpu if self.two else root / "memory" / name
        for folder in {self.cpu, self.memory}:
            folder.mkdir()
        if self.two:
            (self.cpu / "cpu.max").write_text(f"{int(share * period)} {period}")
            (self.cpu / "cpu.weight").write_text("2000")  # it gets its share beside other programs
            (self.memory / "memory.max").write_text(str(memory))
        else:
            (self.cpu / "cpu.cfs_period_us").write_text(str(period))
            (self.cpu / "cpu.cfs_quota_us").write_text(str(int(share * period)))
            (self.cpu / "cpu.shares").write_text("20480")
            (self.memory / "memory.limit_in_bytes").write_text(str(memory))

    def enter(self):
        """In the process that is held, before it becomes the program."""
        for folder in {self.cpu, self.memory}:
            (folder / "cgroup.procs").write_text(str(os.getpid()))

    def throttled(self):
        """Periods, and those in which the processor was taken away."""
        rows = dict(line.split() for line in (self.cpu / "cpu.stat").read_text().splitlines())
        return int(rows["nr_periods"]), int(rows["nr_throttled"])

    def peak(self):
        return int((self.memory / ("memory.peak" if self.two else "memory.max_usage_in_bytes")).read_text())

    def remove(self):
        for folder in {self.cpu, self.memory}:
            folder.rmdir()


#: Signals that a program ends by because of a fault of its own.
CRASHES = {signal.SIGABRT, signal.SIGBUS, signal.SIGFPE, signal.SIGILL, signal.SIGSEGV}


class Program:
    """A program that can be killed and started again. Its messages go to a file of its own."""

    def __init__(self, name, words, folder, environment):
        self.name, self.words, self.folder, self.environment = name, [str(word) for word in words], folder, environment
        self.process, self.starts, self.told_to_end = None, 0, False
        self.crashes = []  #: ends that nobody asked for, and signals of a fault

    def start(self):
        """Does nothing if it runs: who killed it and who stopped it both start it again."""
        if self.running():
            return
        self.note_end()
        with open(self.folder / f"{self.name}.log", "ab") as log:
            self.process = subprocess.Popen(self.words, stdin=subprocess.DEVNULL, stdout=log, stderr=log, cwd=self.folder,
                                            env=self.environment, process_group=0)
        self.starts, self.told_to_end = self.starts + 1, False

    def note_end(self):
        code = self.process.poll() if self.process else None
        if code is not None and (-code in CRASHES or not self.told_to_end):
            self.crashes.append(f"{self.name} ended with {code}")

    def running(self):
        return self.process is not None and self.process.poll() is None

    def send(self, number):
        if self.running():
            self.process.send_signal(number)

    def tell_to_end(self, number):
        self.told_to_end |= self.running()
        self.send(number)

    def end(self, number=signal.SIGTERM, wait=10):
        """Returns whether it ended within `wait` seconds."""
        if self.process is None:
            return True
        self.tell_to_end(number)
        try:
            self.process.wait(wait)
            return True
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
            return False

    def memory(self):
        """Resident memory in bytes, that of no file, and descriptors."""
        with open(f"/proc/{self.process.pid}/statm", encoding="ascii") as file:
            resident, of_files = map(int, file.read().split()[1:3])
        page = os.sysconf("SC_PAGE_SIZE")
        return resident * page, (resident - of_files) * page, len(os.listdir(f"/proc/{self.process.pid}/fd"))

    def processor(self):
        """Seconds of processor time since it was started."""
        with open(f"/proc/{self.process.pid}/stat", encoding="ascii") as file:
            words = file.read().rpartition(")")[2].split()
        return (int(words[11]) + int(words[12])) / os.sysconf("SC_CLK_TCK")


class Block:
    """All of it, in a folder. The caller is in a network namespace of its own, with loopback up."""

    def __init__(self, folder, programs):
        self.folder, self.programs = folder, programs
        self.meeting = folder / "meet"
        self.meeting.mkdir(mode=0o700)
        self.environment = {**os.environ, "RUBICON_FOLDER": str(self.meeting), "HOME": str(folder)}
        self.services = {}
        self.islands = {}
        self._build()

    def _add(self, name, *words, environment=None):
        self.services[name] = Program(name, words, self.folder, environment or self.environment)

    def _build(self):
        mosquitto = shutil.which("mosquitto") or "/usr/sbin/mosquitto"
        for name, port in (("broker-sites", SITES), ("broker-zigbee", ZIGBEE)):
            text = f"listener {port} 127.0.0.1\nallow_anonymous true\npersistence false\nlog_type error\n"
            (self.folder / f"{name}.conf").write_text(text)
            self._add(name, mosquitto, "-c", self.folder / f"{name}.conf")
        self.groups = knx_groups(self.folder)
        self._add("motes", self.programs / "motes-simulator", "--motes", 20, "--sinks", 2, "--same-ids", "--obey", "--updates", "--wait", "--port", 19202)
        for name, port in (("knx-1", 13671), ("knx-2", 13672)):
            self._add(name, self.programs / "knx-simulator", self.folder / "knx.script", "--listen", port, "--log-level", "error")
        for one in ("a", "b"):
            self._add(f"zigbee-{one}", self.programs / "zigbee-simulator", "--devices", 60, "--every", "10s", "--base", f"zigbee-{one}",
                      "--broker", f"127.0.0.1:{ZIGBEE}", "--log-level", "error")
        shutil.copy(ROOT / "examples/salad.yaml", self.folder / "salad.yaml")
        shutil.copy(ROOT / "examples/salad.properties", self.folder / "salad.properties")
        self._add("salad", self.programs / "salad-simulator", self.folder / "salad.yaml", "--bind", "127.0.0.1", "--noise", 5, "--log-level", "error")
        self._build_clock()
        for island in (one for islands in WIRES.values() for one in islands):
            self.write(island)
            environment = dict(self.environment)
            if island in STEPPED:
                environment.update(LD_PRELOAD=str(self.folder / "clock.so"), SOAK_CLOCK=str(self.folder / "clock"))
            words = (self.programs / "rubicon-proxy", "run", self.folder / f"{island}.yaml", "--log-level", "warning")
            self.islands[island] = Program(str(island), words, self.folder, environment)

    def _build_clock(self):
        (self.folder / "clock").write_bytes(struct.pack("d", 0))
        source = pathlib.Path(__file__).with_name("clock.c")
        subprocess.run(["cc", "-O1", "-shared", "-fPIC", "-o", self.folder / "clock.so", source, "-ldl"], check=True)

    def step_clock(self, seconds):
        with open(self.folder / "clock", "r+b") as file:
            file.write(struct.pack("d", seconds))

    def networks(self, island):
        found = [rooms()]
        if island in (101, 108):
            found.append(f"  knx-line: {{type: knx, host: 127.0.0.1, port: {13671 if island == 101 else 13672}, groups: {{{self.groups}}}}}\n")
        if island in (102, 109):
            port = 19202 if island == 102 else 19203
            found.append(f"  wsn-flat: {{type: wsn, source: 'network@127.0.0.1:{port}', board: EM1000, sampling: read-updates, actuators: assumed}}\n")
        if island in (103, 115):
            base = "zigbee-a" if island == 103 else "zigbee-b"
            found.append(f"  zigbee: {{type: zigbee, broker: '127.0.0.1:{ZIGBEE}', base: {base}}}\n")
        if island == 104:
            found.append("  salad: {type: salad, silence: 1min, properties: salad.properties}\n")
        if island in (105, 116):
            columns = "kitchen: {columns: {kitchen_temperature: {sensor: temperature-1}}}, hall: {columns: {hall_motion: {sensor: motion-1}}}"
            file = ROOT / "examples/recordings/flat_day.csv"
            found.append(f"  log-flat: {{type: log, format: csv, file: '{file}', comment: '#', time: {{column: time, unit: iso}}, speed: 100, "
                         f"loop: yes, map: {{{columns}}}}}\n")
        return "".join(found)

    def write(self, island, more=""):
        """The configuration of an island; `more` = further networks."""
        text = f"island: {{id: {island}, name: block-{island}}}\ntuples: {tuples_of(island)}\n"
        text += f"state: {{file: {island}.state}}\nhistory: {{file: {island}.history, patterns: ['proxy.dummy-rooms.hall-1.**']}}\n" if island % 2 else \
                f"state: {{file: {island}.state}}\n"
        tokens = f", tokens: {{file: {island}.tokens}}" if island == GUEST else ""
        text += f"web: {{listen: '127.0.0.1:{PAGE + island}'{tokens}}}\n"
        if island == 106:
            text += f"bridges: {{ha: {{type: mqtt, broker: '127.0.0.1:{ZIGBEE}', discovery: homeassistant, commands: yes}}}}\n"
        if island == 110:
            text += "bridges: {robots: {type: ros2, commands: yes}}\n"
        if island == GUEST:
            (self.folder / f"{island}.tokens").touch(mode=0o600)
        part = self.folder / f"{island}.part"
        part.write_text(text + "networks:\n" + self.networks(island) + more)
        part.replace(self.folder / f"{island}.yaml")

    def check(self):
        """The first configuration with an error, or nothing."""
        for island in self.islands:
            done = subprocess.run([self.programs / "rubicon-proxy", "check", self.folder / f"{island}.yaml"], capture_output=True, text=True,
                                  env=self.environment, cwd=self.folder, check=False)
            if done.returncode != 0:
                return done.stdout + done.stderr
        return ""

    def start(self):
        for program in self.services.values():
            program.start()
        time.sleep(1)
        for program in self.islands.values():
            program.start()

    def stop(self):
        """Names of programs that did not end by themselves."""
        for program in self.islands.values():
            program.send(signal.SIGCONT)
            program.tell_to_end(signal.SIGTERM)
        late = [one.name for one in self.islands.values() if not one.end()]
        for program in self.services.values():
            program.end()
        return late

    def crashes(self):
        """What ended by itself, or by a fault of its own."""
        programs = [*self.islands.values(), *self.services.values()]
        for program in programs:
            program.note_end()
        return [one for program in programs for one in program.crashes]
