"""A live session of the six services that something can be done to, for tests/faults/run."""
import json, os, shutil, signal, subprocess, sys, threading, time

SERVICES = ["visual_odometry", "loop_detector", "dense_mapper", "lidar_mapper", "pose_graph", "fuser"]
# What a service says when it does its work.
VOICE = {"visual_odometry": "VISUAL_POSE", "lidar_mapper": "LIDAR_POSE", "pose_graph": "POSE"}
URL = "udpm://239.255.76.67:7667?ttl=0"


def own_network():
    """Starts this program again in a network that nobody else hears."""
    if os.environ.get("FS_OWN_NETWORK"):
        subprocess.run("ip link set lo up && ip link set lo multicast on && "
                       "ip route add 224.0.0.0/4 dev lo", shell=True, check=True)
        return
    os.environ["FS_OWN_NETWORK"] = "1"
    mounts = ["--mount"] if os.geteuid() == 0 else ["--map-root-user", "--user", "--mount"]
    os.execvp("unshare", ["unshare", "--net"] + mounts + [sys.executable] + sys.argv)


# As config/labs/three-machines.cfg; the log is played on the robot.
MACHINES = {"robot": [], "vision": SERVICES[:3], "mapping": SERVICES[3:]}


class OneMachine:
    def prefix(self, machine):
        return []

    def close(self):
        pass


class ThreeMachines:
    """tests/faults/machines.cpp: network namespaces joined by a switch."""

    def __init__(self, build, errors):
        self.process = subprocess.Popen([build + "/tests/fault_machines"], stdin=subprocess.PIPE,
                                        stdout=subprocess.PIPE, stderr=errors, text=True)
        line = self.process.stdout.readline()
        if not line:
            raise RuntimeError("no machines: network namespaces and /dev/net/tun need root")
        self.prefixes = json.loads(line)

    def prefix(self, machine):
        return self.prefixes[1 + list(MACHINES).index(machine) if machine else 0]

    def say(self, verb, machine):
        self.process.stdin.write(f"{verb} {1 + list(MACHINES).index(machine)}\n")
        self.process.stdin.flush()

    def close(self):
        self.process.stdin.close()
        self.process.wait(30)


class Observer:
    """tests/faults/observer.cpp: what is heard on the network, and what came of it."""

    def __init__(self, argv, environment, errors):
        self.process = subprocess.Popen(argv, env=environment, stdin=subprocess.PIPE,
                                        stdout=subprocess.PIPE, stderr=errors, text=True)
        self.lines, self.changed = [], threading.Condition()
        self.latest, self.last_of = {}, {}  # STATUS by process, and by process and pid
        threading.Thread(target=self.read, daemon=True).start()

    def read(self):
        for text in self.process.stdout:
            with self.changed:
                x = json.loads(text)
                self.lines.append(x)
                if "process" in x:
                    self.latest[x["process"]] = self.last_of[(x["process"], x["pid"])] = x
                self.changed.notify_all()

    def wait(self, fits, since=0, seconds=120.0):
        """The first line from number `since` on that fits; None when none comes."""
        end, i = time.monotonic() + seconds, since
        with self.changed:
            while True:
                while i < len(self.lines):
                    if fits(self.lines[i]):
                        return self.lines[i]
                    i += 1
                if time.monotonic() > end:
                    return None
                self.changed.wait(min(1.0, max(0.0, end - time.monotonic())))

    def say(self, text):
        self.process.stdin.write(text + "\n")
        self.process.stdin.flush()

    def statuses(self):
        """Newest STATUS by (process, pid)."""
        with self.changed:
            return dict(self.last_of)

    def newest(self, process):
        with self.changed:
            return self.latest.get(process)

    def quiet(self, seconds, at_most):
        """Until no tile and no GRAPH with news has come for so long."""
        end = time.monotonic() + at_most
        while time.monotonic() < end:
            with self.changed:
                talk = [x["at_s"] for x in self.lines[-4000:] if "channel" in x and "ok" not in x
                        and x["channel"] != "GRAPH"]
            busy = any(x["queue"] > 0 for x in self.current().values())
            if not busy and (not talk or time.monotonic() - talk[-1] > seconds):
                return
            time.sleep(0.2)

    def current(self):
        return {p: x for p in SERVICES if (x := self.newest(p))}

    def close(self):
        try:
            self.say("quit")
            self.process.wait(30)
        except (BrokenPipeError, subprocess.TimeoutExpired):
            self.process.kill()


class Trial:
    def __init__(self, arguments, name):
        self.a, self.name = arguments, name
        self.folder = os.path.join(arguments.out, name)
        shutil.rmtree(self.folder, ignore_errors=True)
        os.makedirs(self.folder + "/logs")
        self.journal = self.folder + "/journal"
        self.environment = {**os.environ, "LCM_DEFAULT_URL": URL, "FUSION_SLAM_JOURNAL": self.journal}
        self.log, self.moments, self.bin = arguments.log, [], arguments.build + "/bin"
        self.network, self.machines = OneMachine(), {"localhost": SERVICES}
        self.children, self.recovered_s, self.notes = [], [], []

    def start(self, argv, **more):
        child = subprocess.Popen(argv, env=more.pop("env", self.environment), **more)
        self.children.append(child)
        return child

    def up(self, seconds=120.0):
        self.config = self.folder + "/lab.cfg"
        with open(self.config, "w") as out:
            for machine, services in self.machines.items():
                for s in services:
                    out.write(f'cmd "{s}" {{ exec = "{s}"; deputy = "{machine}"; '
                              'auto_respawn = "true"; }\n')
        self.errors = open(self.folder + "/observer.log", "w")
        if len(self.machines) > 1:
            self.network = ThreeMachines(self.a.build, self.errors)
            self.environment["LCM_DEFAULT_URL"] = URL.replace("ttl=0", "ttl=1")
        self.quiet = {k: v for k, v in self.environment.items() if k != "LD_PRELOAD"}
        self.observer = Observer(self.network.prefix("") + [self.a.build + "/tests/fault_observer"],
                                 self.quiet, self.errors)
        for machine in self.machines:
            self.deputy = self.start_deputy(machine)
        if self.sheriff("up", self.config, "--timeout", str(seconds)).returncode != 0:
            raise RuntimeError(f"{self.name}: the services could not be started, see {self.folder}")
        for s in SERVICES:
            if not self.observer.wait(lambda x: x.get("process") == s and x["running"], 0, seconds):
                raise RuntimeError(f"{self.name}: {s} says no STATUS, see {self.folder}")

    def start_deputy(self, machine):
        return self.start(self.network.prefix(machine) + [
            self.a.build + "/bin/procman-deputy", "--name", machine, "--allow", self.bin,
            "--log-folder", self.folder + "/logs"], stdout=self.errors, stderr=self.errors)

    def sheriff(self, *argv):
        done = subprocess.run(self.network.prefix("") + [
            self.a.build + "/bin/procman-sheriff", *argv], env=self.quiet, capture_output=True,
            text=True)
        self.errors.write(done.stdout + done.stderr)
        return done

    def play(self):
        self.began = time.monotonic()
        self.player = self.start(
            self.network.prefix(list(self.machines)[0]) +
            ["lcm-logplayer", "--speed", str(self.a.speed), self.log], env=self.quiet,
            stdout=self.errors, stderr=self.errors)

    def at(self, seconds):
        """Sleeps until so many seconds of the log have been played."""
        time.sleep(max(0.0, self.began + seconds / self.a.speed - time.monotonic()))

    def pids(self, service):
        now = self.observer.newest(service)
        return now["pid"] if now else None

    def kill(self, services):
        old = {s: self.observer.newest(s) for s in services}
        since, began = len(self.observer.lines), time.monotonic()
        for s in services:
            try:
                os.kill(old[s]["pid"], signal.SIGKILL)
            except ProcessLookupError:
                self.notes.append(f"{s} had ended already")
        return old, since, began

    def await_start(self, killed, seconds):
        """Until each runs again, whether or not there is work for it."""
        old, since, _ = killed
        for s, before in old.items():
            if not self.observer.wait(lambda x: x.get("process") == s and x["running"] and
                                      x["pid"] != before["pid"], since, seconds):
                self.notes.append(f"{s} did not come back")

    def await_recovery(self, killed):
        """Until each is back at its work; seconds since the kill."""
        old, since, began = killed
        for s, before in old.items():
            back = self.observer.wait(lambda x: x.get("process") == s and x["running"] and
                                      x["pid"] != before["pid"], since)
            if back and s in VOICE:
                first = self.observer.lines.index(back, since)
                voice = self.observer.wait(lambda x: x.get("channel") == VOICE[s] and x["ok"], first, 20)
                back = voice or back
            elif back and s == "dense_mapper":  # as many keyframes as before
                had = number(before["text"])
                back = self.observer.wait(lambda x: x.get("process") == s and x["pid"] != before["pid"]
                                          and number(x["text"]) >= had, since) or None
            if not back:
                self.notes.append(f"{s} did not come back")
            else:
                self.recovered_s.append(back["at_s"] - began)

    def written(self):
        """The map as it is now goes to FOLDER/result; what the observer says of it."""
        since = len(self.observer.lines)
        self.observer.say("write " + self.folder + "/result")
        return self.observer.wait(lambda x: "written" in x, since, 600)

    def finish(self):
        """The input has ended: waits until all is said, and scores it."""
        self.player.wait()
        self.observer.quiet(1.5, 120)
        for _ in range(3):  # COMMAND is not repaired: someone may have lost one
            since = len(self.observer.lines)
            self.observer.say("finish")
            self.observer.wait(lambda x: x.get("process") == "pose_graph", since)
        self.observer.quiet(3.0, 180)
        written = self.written()
        if written["missing"]:
            self.notes.append("NOT IN THE GRAPH: " + ", ".join(written["missing"]))
        if written["twice"]:
            self.notes.append(f"{written['twice']} IDS GIVEN TWICE")
        statuses = self.observer.statuses()
        self.lost = sum(x["lost"] for (p, _), x in statuses.items() if p in SERVICES)
        with open(self.folder + "/lost.txt", "w") as out:
            for (process, pid), x in sorted(statuses.items()):
                for channel, n in x["lost_on"].items():
                    out.write(f"{process} {pid}: {n} of {channel}\n")
        revisions = [x["revision"] for x in self.observer.lines if x.get("channel") == "GRAPH"]
        if any(b < a for a, b in zip(revisions, revisions[1:])):
            self.notes.append("GRAPH's revision went back")
        self.score()

    def score(self):
        eval_, result = self.a.build + "/bin/eval", self.folder + "/result"

        def figure(argv, *path):
            out = self.folder + "/figure.json"
            done = subprocess.run([eval_] + argv + ["--json", out], capture_output=True, text=True)
            if done.returncode != 0:
                self.notes.append(done.stderr.strip().splitlines()[-1][:100] if done.stderr else "eval")
                return float("nan")
            value = json.load(open(out))
            for key in path:
                value = value[key]
            return value
        truth = result + "/groundtruth.tum"
        self.f1 = figure(["map", self.a.truth + "/map.yaml", result + "/map.yaml", "--align", truth,
                          result + "/trajectory.tum"], *F1_PATH)
        self.ape = figure(["ape", truth, result + "/trajectory.tum", "--align", "se3"], *APE_PATH)

    def down(self):
        self.observer.close()
        for child in reversed(self.children):
            if child.poll() is None:
                child.send_signal(signal.SIGINT)
        for child in self.children:
            try:
                child.wait(30)
            except subprocess.TimeoutExpired:
                child.kill()
                child.wait()
        self.network.close()
        self.errors.close()
        if not self.a.keep:
            shutil.rmtree(self.journal, ignore_errors=True)


F1_PATH, APE_PATH = ("f1",), ("statistics", "rmse")


def number(text):
    digits = "".join(c if c.isdigit() else " " for c in text).split()
    return int(digits[0]) if digits and text[:1].isdigit() else -1
