"""What tests/faults/run does to a session: each fault a function of a trial, called when all is up."""
import os, random, shutil, signal, subprocess, time

from trial import MACHINES, SERVICES, VOICE


def undisturbed(t, moment):
    t.play()


def kill_one(service):
    def fault(t, moment):
        t.play()
        for m in t.moments or [moment]:  # not before it has recovered from the last
            t.at(m)
            t.await_recovery(t.kill([service]))
    return fault


def kill_each(t, moment):
    """Each of the six in one run, one after the other."""
    t.play()
    for i, service in enumerate(SERVICES):
        t.at((i + 1) * t.a.seconds / (len(SERVICES) + 1))
        t.await_recovery(t.kill([service]))


def kill_all(t, moment):
    t.play()
    t.at(moment)
    t.await_recovery(t.kill(SERVICES))


def kill_deputy(t, moment):
    """Its commands die with it; a new one is started and ordered, as systemd and a sheriff do."""
    t.play()
    t.at(moment)
    old = {s: t.observer.newest(s) for s in SERVICES}
    since, began = len(t.observer.lines), time.monotonic()
    t.deputy.kill()
    t.deputy.wait()
    t.deputy = t.start_deputy("localhost")
    t.sheriff("up", t.config, "--timeout", "120")
    t.await_recovery((old, since, began))


def power_cut(t, moment):
    """All killed, and each journal loses a seeded number of its last bytes."""
    t.play()
    t.at(moment)
    t.deputy.send_signal(signal.SIGSTOP)  # nobody is started again yet
    killed = t.kill(SERVICES)
    time.sleep(0.5)
    chance = random.Random(t.a.seed)
    for name in sorted(os.listdir(t.journal)):
        path = t.journal + "/" + name
        os.truncate(path, max(0, os.path.getsize(path) - chance.randrange(1, 200)))
    t.deputy.send_signal(signal.SIGCONT)
    t.await_recovery(killed)


def loss(percent):
    def fault(t, moment):
        t.play()
    fault.environment = lambda t: {"LD_PRELOAD": t.a.build + "/tests/lossy.so",
                                   "FS_LOSS_PERCENT": str(percent), "FS_LOSS_SEED": str(t.a.seed)}
    return fault


def cut(t, moment):
    """All hear nobody for a while, the mapping services and the camera's alike."""
    t.play()
    t.at(moment)
    with open(t.folder + "/cut", "w"):
        pass
    t.at(moment + t.a.cut_s)
    os.remove(t.folder + "/cut")
    since, began = len(t.observer.lines), time.monotonic()
    back = t.observer.wait(lambda x: x.get("channel") == "POSE" and x["ok"], since)
    if back:
        t.recovered_s.append(back["at_s"] - began)


cut.environment = lambda t: {"LD_PRELOAD": t.a.build + "/tests/lossy.so",
                             "FS_CUT_FILE": t.folder + "/cut"}


def cut_link(t, moment):
    """The machine with the sensors and the trackers goes on; the others hear nobody for 30 s."""
    t.a.cut_s, before = 30.0, t.a.cut_s
    cut(t, 0.1 * t.a.seconds)
    t.a.cut_s = before


cut_link.environment = lambda t: {**cut.environment(t), "FS_CUT_NAMES":
                                  "loop_detector,dense_mapper,pose_graph,fuser"}


def freeze(service):
    def fault(t, moment):
        t.play()
        t.at(moment)
        pid = t.pids(service)
        os.kill(pid, signal.SIGSTOP)
        t.at(moment + t.a.freeze_s)
        since, began = len(t.observer.lines), time.monotonic()
        os.kill(pid, signal.SIGCONT)
        back = t.observer.wait(lambda x: x.get("process") == service and x["pid"] == pid, since)
        if back:
            t.recovered_s.append(back["at_s"] - began)
        else:
            t.notes.append(f"{service} did not come back")
    return fault


def full_disk(t, moment):
    t.play()


def small_disk(t):
    """The journals' folder is a file system of 300 KB."""
    os.makedirs(t.journal)
    subprocess.run(["mount", "-t", "tmpfs", "-o", "size=300k", "tmpfs", t.journal], check=True)


full_disk.before = small_disk


def silent(sensor):
    """A log beside LOG that `simulate --sensor-silent` made."""
    def fault(t, moment):
        t.log = os.path.join(os.path.dirname(t.a.log), f"silent-{sensor}.lcm")
        t.play()
    return fault


def shifted(log, out, after_s, jump_s):
    """A copy of a log whose measurements say another time from after_s on. A time that comes twice
    has no truth: nobody could say which of the two is meant."""
    with open(log, "rb") as file, open(out, "wb") as copy:
        first = began = None
        while len(head := file.read(28)) == 28:
            n_channel, n_data = (int.from_bytes(head[i:i + 4], "big") for i in (20, 24))
            at = int.from_bytes(head[12:20], "big")
            first = at if first is None else first
            channel, data = file.read(n_channel), bytearray(file.read(n_data))
            if at - first >= after_s * 1e6:
                def move(i):
                    said = int.from_bytes(data[i:i + 8], "big") + int(jump_s * 1e6)
                    data[i:i + 8] = said.to_bytes(8, "big")
                move(8)
                if channel == b"CAMERA":  # images_t: each image has a stamp of its own
                    n = int.from_bytes(data[16:20], "big")
                    i = 20 + 2 * n
                    for _ in range(n):
                        move(i)
                        i += 28 + int.from_bytes(data[i + 24:i + 28], "big")
                        if int.from_bytes(data[i:i + 4], "big") != 0:
                            raise RuntimeError("CAMERA with metadata: not this program's logs")
                        i += 4
            said = int.from_bytes(data[8:16], "big") if channel == b"GROUND_TRUTH" else None
            if said is not None:
                began = said if began is None else began
                twice = after_s + min(0.0, jump_s) <= (said - began) * 1e-6 <= after_s
                if twice and jump_s < 0:
                    continue
            copy.write(head + channel + data)


def clock(jump_s):
    """The machine's clock jumps: all stamps, and what the services take for now."""
    def fault(t, moment):
        t.log = t.folder + "/jump.lcm"
        shifted(t.a.log, t.log, moment, jump_s)
        t.play()
        t.at(moment)
        with open(t.folder + "/clock", "w") as file:
            file.write(str(jump_s))
    fault.environment = lambda t: {"LD_PRELOAD": t.a.build + "/tests/lossy.so",
                                   "FS_CLOCK_FILE": t.folder + "/clock"}
    return fault


def second_pose_graph(t, moment):
    t.play()
    t.at(moment)
    second = subprocess.run([t.a.build + "/bin/pose_graph"], env={
        k: v for k, v in t.environment.items() if k != "FUSION_SLAM_JOURNAL"},
        capture_output=True, text=True, timeout=120)
    said = second.stderr.strip().splitlines()
    t.notes.append(f"refused, exit code {second.returncode}: {said[-1][:90] if said else ''}")
    if second.returncode != 1:
        t.notes.append("NOT REFUSED")


def two_sheriffs(t, moment):
    """A second one orders that everything stop, again and again, while the first gives its orders."""
    first = t.start([t.a.build + "/bin/procman-sheriff", "up", t.config, "--watch"], env=t.quiet,
                    stdout=subprocess.DEVNULL, stderr=t.errors)
    t.play()
    t.at(moment)
    second = t.sheriff("restart", t.config, "--timeout", "5")
    t.notes.append(f"the second sheriff's restart: exit code {second.returncode}")
    first.send_signal(signal.SIGINT)


def upgrade(t, moment):
    """A new program takes the old one's place, and the service is restarted; the others run on."""
    t.play()
    t.at(moment)
    before = {s: t.observer.newest(s) for s in SERVICES}
    since, began = len(t.observer.lines), time.monotonic()
    shutil.copy2(t.bin + "/lidar_mapper", t.bin + "/new")
    os.replace(t.bin + "/new", t.bin + "/lidar_mapper")
    t.sheriff("status")
    t.sheriff("restart", t.config, "lidar_mapper")
    t.await_recovery(({"lidar_mapper": before["lidar_mapper"]}, since, began))
    t.sheriff("status")
    if any(t.pids(s) != before[s]["pid"] for s in SERVICES if s != "lidar_mapper"):
        t.notes.append("OTHERS WERE RESTARTED, TOO")


def own_programs(t):
    t.bin = t.folder + "/bin"
    os.makedirs(t.bin)
    for s in SERVICES:
        shutil.copy2(t.a.build + "/bin/" + s, t.bin)


upgrade.before = own_programs


def three_machines(victim):
    """Three machines; the victim's cable is out for 30 s."""
    def fault(t, moment):
        t.play()
        if not victim:
            t.at(0.5 * t.a.seconds)
            with open(t.folder + "/status.txt", "w") as out:
                out.write(t.sheriff("status").stdout)
            return
        t.at(0.1 * t.a.seconds)
        t.network.say("cut", victim)
        t.at(0.1 * t.a.seconds + 30.0)
        since, began = len(t.observer.lines), time.monotonic()
        t.network.say("join", victim)
        service = MACHINES[victim][0]
        back = t.observer.wait(lambda x: x.get("channel") == VOICE[service] and x["ok"], since)
        if back:
            t.recovered_s.append(back["at_s"] - began)
        else:
            t.notes.append(f"{service} did not come back")
    fault.before = lambda t: setattr(t, "machines", MACHINES)
    return fault


FAULTS = {"undisturbed": undisturbed}
FAULTS.update({"kill-" + s: kill_one(s) for s in SERVICES})
FAULTS.update({"kill-each": kill_each, "kill-all": kill_all, "kill-deputy": kill_deputy,
               "power-cut": power_cut, "loss-1": loss(1), "loss-5": loss(5), "loss-20": loss(20),
               "cut": cut, "cut-link": cut_link})
FAULTS.update({"freeze-" + s: freeze(s) for s in SERVICES})
FAULTS.update({"silent-" + s: silent(s) for s in ("lidar", "camera", "odometry")})
FAULTS.update({"clock-forward": clock(10), "clock-back": clock(-10)})
FAULTS.update({"machines": three_machines(None), "cut-vision": three_machines("vision"),
               "cut-mapping": three_machines("mapping"), "upgrade": upgrade})
FAULTS.update({"full-disk": full_disk, "second-pose-graph": second_pose_graph,
               "two-sheriffs": two_sheriffs})
