#!/usr/bin/env python3
"""A sweep on a Slurm cluster of two nodes with its results in PostgreSQL. A node is killed while the sweep runs.

    run.py UGOKI

Starts munged, slurmctld, two slurmd and a PostgreSQL server in a temporary folder, all on this machine, and ends them. Prints one line for
each test: `ok ...`, `not ok ...` or `skip ...`. UGOKI is the program `ugoki`.
"""

import contextlib
import getpass
import os
import pathlib
import re
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time

RUNS = 400  # number of runs of the sweep, 0.05 s each; enough that both parts still run when the node is killed
PATIENCE = 240  # s: time limit of wait_until(); a requeued task waits for the time limits of slurm.conf below
NODES = ("one", "two")

failed = 0


@contextlib.contextmanager
def test(name):
    global failed
    try:
        yield
        print(f"ok {name}", flush=True)
    except Exception as error:  # every kind of failure becomes a line `not ok`
        failed += 1
        print(f"not ok {name}\n  {type(error).__name__}: {error}", flush=True)


def wait_until(what, condition, seconds=PATIENCE):
    """Returns the first true result of condition(); fails after `seconds`. `what` names the awaited event in the error."""
    end = time.monotonic() + seconds
    while True:
        result = condition()
        if result:
            return result
        if time.monotonic() > end:
            raise TimeoutError(f"{what}: not within {seconds} s")
        time.sleep(0.2)


def free_port():
    with socket.socket() as s:
        s.bind(("127.0.0.1", 0))
        return s.getsockname()[1]


class Cluster:
    """The daemons of Slurm and PostgreSQL, with all their files in one folder."""

    def __init__(self, folder):
        self.folder = folder
        self.daemons = {}
        self.environment = dict(os.environ, SLURM_CONF=str(folder / "slurm.conf"), LC_ALL="C.UTF-8")

    def start(self, name, command, **options):
        log = open(self.folder / f"{name}.log", "ab")
        self.daemons[name] = subprocess.Popen(command, stdout=log, stderr=log, stdin=subprocess.DEVNULL, env=self.environment,
                                              start_new_session=True, **options)

    def run(self, *command):
        done = subprocess.run(command, env=self.environment, cwd=self.folder, text=True, capture_output=True)
        if done.returncode != 0:
            raise RuntimeError(f"{' '.join(command)}: {done.stdout}{done.stderr}")
        return done.stdout

    def start_slurm(self):
        key = self.folder / "munge.key"
        key.write_bytes(os.urandom(64))
        key.chmod(0o400)
        self.start("munged", ["munged", "--foreground", "--force", f"--key-file={key}", f"--socket={self.folder}/munge.socket",
                              f"--pid-file={self.folder}/munge.pid", f"--seed-file={self.folder}/munge.seed", "--log-file=/dev/stderr"])
        host = socket.gethostname()
        nodes = "\n".join(f"NodeName={name} NodeHostname={host} NodeAddr=127.0.0.1 Port={free_port()} CPUs=1 State=UNKNOWN" for name in NODES)
        user = getpass.getuser()
        # Short time limits: a silent node is down after 10 s, and its task may run again 5 s later.
        (self.folder / "slurm.conf").write_text(f"""ClusterName=test
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={free_port()}
SlurmUser={user}
SlurmdUser={user}
AuthType=auth/munge
AuthInfo=socket={self.folder}/munge.socket,cred_expire=5
CredType=cred/munge
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SchedulerType=sched/builtin
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
MpiDefault=none
SlurmdParameters=config_overrides
SlurmdTimeout=10
JobRequeue=1
KillWait=2
StateSaveLocation={self.folder}/state
SlurmdSpoolDir={self.folder}/spool.%n
SlurmctldPidFile={self.folder}/slurmctld.pid
SlurmdPidFile={self.folder}/slurmd.%n.pid
{nodes}
PartitionName=all Nodes={",".join(NODES)} Default=YES State=UP MaxTime=60
""")
        (self.folder / "state").mkdir()
        wait_until("munged", (self.folder / "munge.socket").exists, 20)
        self.start("slurmctld", ["slurmctld", "-D"])
        for name in NODES:
            self.start(f"slurmd.{name}", ["slurmd", "-D", "-N", name])
        wait_until("both nodes are idle", lambda: self.states() == ["idle"] * len(NODES), 60)

    def states(self):
        done = subprocess.run(["sinfo", "--noheader", "--Node", "--format=%t"], env=self.environment, text=True, capture_output=True)
        return done.stdout.split()

    def processes_of(self, node):
        """Process ids of a node in the order to kill them: slurmd, slurmstepd, jobs. So no process reports the end of another."""
        jobs, steps = [], []
        for entry in pathlib.Path("/proc").iterdir():
            if not entry.name.isdigit():
                continue
            with contextlib.suppress(OSError):
                values = (entry / "environ").read_bytes().split(b"\0")
                if f"SLURM_CONF={self.folder}/slurm.conf".encode() not in values or f"SLURMD_NODENAME={node}".encode() not in values:
                    continue
                jobs.append(int(entry.name))
                parent = re.search(r"^PPid:\s*(\d+)", (entry / "status").read_text(), re.M)[1]
                if pathlib.Path("/proc", parent, "cmdline").read_bytes().startswith(b"slurmstepd"):
                    steps.append(int(parent))
        return [self.daemons[f"slurmd.{node}"].pid] + steps + jobs

    def kill_node(self, node):
        for pid in self.processes_of(node):
            with contextlib.suppress(ProcessLookupError):
                os.kill(pid, signal.SIGKILL)

    def start_postgres(self):
        """Starts a PostgreSQL server and returns its address."""
        versions = sorted(pathlib.Path("/usr/lib/postgresql").glob("*/bin/initdb"), key=lambda p: int(p.parts[4]))
        programs, data = versions[-1].parent, self.folder / "postgres"
        data.mkdir()
        as_user = []
        if os.geteuid() == 0:  # PostgreSQL refuses to run as root
            as_user = ["runuser", "-u", "postgres", "--"]
            shutil.chown(data, "postgres")
        self.run(*as_user, str(programs / "initdb"), "-D", f"{data}/data", "-A", "trust", "-U", "ugoki", "-E", "UTF8", "--locale=C.UTF-8")
        port = free_port()
        self.start("postgres", as_user + [str(programs / "postgres"), "-D", f"{data}/data", "-k", str(data), "-p", str(port), "-h", "127.0.0.1"])
        address = f"postgresql://ugoki@127.0.0.1:{port}/postgres"
        wait_until("PostgreSQL", lambda: subprocess.run(["psql", address, "-c", "select 1"], capture_output=True).returncode == 0, 60)
        return address

    def stop(self):
        for name, daemon in reversed(self.daemons.items()):
            if name.startswith("slurmd."):
                for pid in self.processes_of(name.removeprefix("slurmd.")):
                    with contextlib.suppress(ProcessLookupError):
                        os.kill(pid, signal.SIGKILL)
            daemon.send_signal(signal.SIGINT if name == "postgres" else signal.SIGTERM)
            with contextlib.suppress(subprocess.TimeoutExpired):
                daemon.wait(20)
            with contextlib.suppress(ProcessLookupError):
                os.killpg(daemon.pid, signal.SIGKILL)


def expect(condition, message):
    if not condition:
        raise AssertionError(message)


def check(cluster, ugoki):
    folder = cluster.folder
    address = cluster.start_postgres()
    sql = lambda text: cluster.run("psql", address, "--no-align", "--tuples-only", "--command", text).strip()
    project = str(folder / "park.ugoki")
    cluster.run(ugoki, "new", project)
    sweep = [ugoki, "bake", project, "--vary", f"push=0:400:{RUNS // 4}", "--vary", "push-angle=0,90,180,270", "--vary", "push-time=0.05",
             "--duration", "0.5"]
    shared = ["--table", address, "--name", "park_push"]
    part_of = lambda node: int(cluster.run("squeue", "--noheader", "--array", "--format=%K", f"--nodelist={node}", "--states=RUNNING").strip())

    with test("a sweep of Slurm with a killed node ends complete in PostgreSQL, and no run is computed twice"):
        cluster.start_slurm()
        cluster.run(*sweep, *shared, "--slurm", "2")
        count = lambda: int(sql("select count(*) from ugoki.sweep_park_push") if sql("select to_regclass('ugoki.sweep_park_push')") else 0)
        wait_until("the first tenth of the runs", lambda: count() >= RUNS // 10)
        part = part_of("two")
        expect(part in (0, 1), f"node two runs part {part}")
        cluster.kill_node("two")
        kept = int(sql(f"select count(*) from ugoki.sweep_park_push where number % 2 = {part}"))
        before = sql("select number, processor_s from ugoki.sweep_park_push order by number").splitlines()
        expect(0 < kept < RUNS // 2, f"the killed part had {kept} of {RUNS // 2} runs")
        wait_until("node two is down", lambda: any(s.startswith("down") for s in cluster.states()))
        wait_until("all jobs have ended", lambda: cluster.run("squeue", "--noheader") == "")
        after = sql("select number, processor_s from ugoki.sweep_park_push order by number").splitlines()
        expect(len(after) == RUNS, f"{len(after)} rows")
        expect(set(before) <= set(after), "a finished run was replaced")
        log = (folder / f"bake-park_push.{part}.log").read_text()
        again = re.search(r"of which (\d+) now", log)
        expect(again and int(again[1]) + kept == RUNS // 2, f"{kept} runs kept; the log of the requeued part: {log}")
        merged = (folder / "bake-park_push.merge.log").read_text()
        expect("of which 0 now" in merged, merged)
        print(f"# node two was killed after {len(before)} of {RUNS} runs; part {part} kept {kept} and computed {again[1]} after it was requeued")

    with test("the results of the cluster equal those of one process"):
        cluster.run(*sweep, "--table", str(folder / "alone.db"), "--csv", str(folder / "alone.csv"))
        lines = (folder / "alone.csv").read_text().splitlines()
        at = lines[0].split(",").index("state_hash")
        alone = [line.split(",")[0] + "|" + line.split(",")[at] for line in lines[1:]]
        expect(alone == sql("select number, state_hash from ugoki.sweep_park_push order by number").splitlines(), "the states differ")

    with test("a table in PostgreSQL is continued, plotted, and refused for another sweep"):
        expect("of which 0 now" in cluster.run(*sweep, *shared), "runs were repeated")
        cluster.run(ugoki, "bake", "plot", address, "--name", "park_push", "--x", "push", "--y", "tracking_rms_deg", "--by", "push-angle",
                    "--out", "plot.svg")
        expect((folder / "plot.svg").read_text().count("<circle") >= RUNS, "points are missing")
        other = subprocess.run(sweep + ["--seed", "5"] + shared, capture_output=True, text=True)
        expect(other.returncode == 1 and "another sweep" in other.stderr, other.stderr)
        nameless = subprocess.run(sweep + ["--table", address], capture_output=True, text=True)
        expect(nameless.returncode == 1 and "--name" in nameless.stderr, nameless.stderr)


def main():
    ugoki = str(pathlib.Path(sys.argv[1]).resolve())
    missing = [name for name in ("munged", "slurmctld", "slurmd", "sbatch", "psql") if not shutil.which(name)]
    if missing:
        print(f"skip a sweep on a Slurm cluster: not installed: {', '.join(missing)}")
        return 0
    folder = pathlib.Path(tempfile.mkdtemp(prefix="ugoki-cluster-"))
    folder.chmod(0o755)
    cluster = Cluster(folder)
    try:
        check(cluster, ugoki)
    finally:
        cluster.stop()
        if failed:
            for log in sorted(folder.glob("*.log")):
                print(f"--- {log.name}\n" + "\n".join(log.read_text(errors="replace").splitlines()[-25:]))
        shutil.rmtree(folder, ignore_errors=True)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
