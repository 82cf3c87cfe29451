#!/usr/bin/python3
"""Runs scripts/workflow/ on this machine, and under a Slurm of one node that the test starts and ends.

usage: tests/cli/workflow_test.py REPOSITORY PROGRAMS [TEST...]"""

import contextlib
import copy
import ctypes
import getpass
import json
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
import unittest

REPOSITORY, PROGRAMS = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve()
WORKFLOW = REPOSITORY / "scripts/workflow"
PR_SET_CHILD_SUBREAPER = 36


def free_port():
    with socket.socket() as any_port:
        any_port.bind(("127.0.0.1", 0))
        return any_port.getsockname()[1]


def wait_for(what, condition, seconds=120):
    end = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > end:
            raise TimeoutError(f"expected {what} within {seconds} s, found it not so")
        time.sleep(0.3)


def descendants(*ancestors):
    """The processes that these started, directly or not, as {pid: name of the program}."""
    processes = {}
    for stat in pathlib.Path("/proc").glob("[0-9]*/stat"):
        try:
            name, _, fields = stat.read_text().partition("(")[2].rpartition(")")
        except OSError:  # ended meanwhile
            continue
        processes[int(stat.parent.name)] = (name, int(fields.split()[1]))
    found, generation = {}, set(ancestors)
    while generation:
        generation = {pid for pid, (_, parent) in processes.items() if parent in generation}
        found.update((pid, processes[pid][0]) for pid in generation)
    return found


def kill_all(pids, sign=signal.SIGKILL):
    for pid in pids:
        try:
            os.kill(pid, sign)
        except ProcessLookupError:
            pass


def end_descendants(started):
    for sign in (signal.SIGTERM, signal.SIGKILL):
        end = time.monotonic() + 5
        kill_all(descendants(os.getpid()), sign)
        while descendants(os.getpid()) and time.monotonic() < end:
            for child in started:
                child.poll()
            for pid in descendants(os.getpid()).keys() - {child.pid for child in started}:
                with contextlib.suppress(ChildProcessError):  # it is a child's child
                    os.waitpid(pid, os.WNOHANG)
            time.sleep(0.1)


class Slurm:
    """munged, slurmctld and slurmd of this test alone, in a folder of their own, with a node of two cores."""

    def __init__(self, folder, started):
        self.folder = folder
        self.started = started
        name = socket.gethostname().split(".")[0]
        self.conf = folder / "slurm.conf"
        for sub in ("state", "spool", "munge"):
            (folder / sub).mkdir(mode=0o755)
        key = folder / "munge/munge.key"
        key.write_bytes(os.urandom(128))
        key.chmod(0o600)
        self.socket = folder / "munge/munge.socket"
        # A requeued job waits as long as credentials live.
        self.conf.write_text(f"""ClusterName=cairn
SlurmctldHost={name}(127.0.0.1)
SlurmUser={getpass.getuser()}
SlurmdUser={getpass.getuser()}
SlurmctldPort={free_port()}
SlurmdPort={free_port()}
AuthType=auth/munge
AuthInfo=socket={self.socket},cred_expire=10
CredType=cred/munge
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SchedulerParameters=sched_interval=2,bf_interval=2
SlurmdParameters=config_overrides
MpiDefault=none
ReturnToService=2
SlurmdTimeout=15
MinJobAge=600
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
AccountingStorageType=accounting_storage/none
JobAcctGatherType=jobacct_gather/none
NodeName={name} NodeAddr=127.0.0.1 CPUs=2 RealMemory=4096 State=UNKNOWN
PartitionName=main Nodes={name} Default=YES MaxTime=INFINITE State=UP
""")
        self.environment = dict(os.environ, SLURM_CONF=str(self.conf), USER=getpass.getuser())

    def start(self, *command):
        self.started.append(subprocess.Popen(command, env=self.environment, stdout=subprocess.DEVNULL,
                                             stderr=subprocess.DEVNULL))
        return self.started[-1]

    def start_node(self):
        self.node = self.start("slurmd", "-D", "-f", str(self.conf))

    def kill_node(self, *steps):
        kill_all([self.node.pid, *steps, *descendants(*steps)])
        self.node.wait()

    def start_all(self):
        self.start("munged", "--foreground", "--force", f"--key-file={self.folder}/munge/munge.key",
                   f"--socket={self.socket}", f"--pid-file={self.folder}/munge/munged.pid",
                   f"--log-file={self.folder}/munge/munged.log", f"--seed-file={self.folder}/munge/munged.seed")
        wait_for("munged's socket", self.socket.exists, 30)
        self.start("slurmctld", "-D", "-f", str(self.conf))
        self.start_node()
        wait_for("an idle node", lambda: "idle" in self.run("sinfo", "-h", "-o", "%T"), 60)

    def run(self, *command):
        return subprocess.run(command, env=self.environment, capture_output=True, text=True).stdout

    def jobs(self, state):
        return self.run("squeue", "-h", "-t", state, "-o", "%i").split()

    def restarts(self, job):
        fields = dict(field.partition("=")[::2] for field in self.run("scontrol", "show", "job", job).split())
        return int(fields.get("Restarts", 0))


@unittest.skipUnless(shutil.which("snakemake"), "SKIPPED: snakemake is not installed")
class Workflow(unittest.TestCase):
    SHARDS = 3

    @classmethod
    def setUpClass(cls):
        # What outlives its parent becomes a child of the test, which can end it.
        ctypes.CDLL(None).prctl(PR_SET_CHILD_SUBREAPER, 1, 0, 0, 0)

    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="cairn-workflow-"))
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)
        self.started = []
        self.addCleanup(end_descendants, self.started)
        samples = sorted((REPOSITORY / "sample-dem").glob("*.tif"))
        self.use([pathlib.Path(shutil.copyfile(sample, self.folder / sample.name)) for sample in samples])

    def use(self, inputs):
        self.inputs = inputs
        self.config = self.folder / "config.json"
        self.config.write_text(json.dumps({
            "inputs": [*map(str, inputs), "--tile-size", "257"], "pack": "out.cairn", "shards": self.SHARDS,
            "threads": 1, "memory_mib": 512, "cairn": str(self.watched_cairn())}))

    def watched_cairn(self):
        """cairn, but shards are noted in `calls`, do not begin while `hold` is there, and die where `kill` names them."""
        program = self.folder / "cairn"
        program.write_text(f"""#!/bin/sh
if [ "$1 $2" = "bake --plan" ]; then
  echo "$5" >> {self.folder}/calls
  while [ -e {self.folder}/hold ]; do sleep 0.2; done
  if [ -e {self.folder}/kill.$5 ]; then rm {self.folder}/kill.$5; kill -9 $$; fi
fi
exec {PROGRAMS}/cairn "$@"
""")
        program.chmod(0o755)
        return program

    def calls(self):
        path = self.folder / "calls"
        return path.read_text().split() if path.exists() else []

    def snakemake(self, *arguments, environment=None):
        command = ["snakemake", "-s", str(WORKFLOW / "Snakefile"), "--configfile", str(self.config), *arguments]
        self.log = open(self.folder / "snakemake.log", "a+")
        self.addCleanup(self.log.close)
        self.started.append(subprocess.Popen(command, cwd=self.folder, env=environment, stdout=self.log,
                                             stderr=subprocess.STDOUT))
        return self.started[-1]

    def finish(self, child):
        code = child.wait(timeout=400)
        self.log.seek(0)
        out = self.log.read()
        self.log.truncate(0)
        self.assertEqual(code, 0, out)
        return out

    def here(self):
        return self.finish(self.snakemake("--cores", "2"))

    def check_pack(self):
        whole = self.folder / "whole.cairn"
        subprocess.run([PROGRAMS / "cairn", "bake", *self.inputs, "--tile-size", "257", "-o", whole, "--force"],
                       check=True, capture_output=True)
        self.assertEqual((self.folder / "out.cairn").read_bytes(), whole.read_bytes())
        report = json.loads((self.folder / "work/report.json").read_text())
        self.assertEqual(report["shards"], self.SHARDS)
        self.assertEqual(report["pack_bytes"], whole.stat().st_size)

    def flat_cell(self, lon, metres):
        path = self.folder / f"N40E{lon:03}.hgt"
        path.write_bytes(metres.to_bytes(2, "big") * 1201**2)
        return path

    def part_times(self):
        return {part: part.stat().st_mtime_ns for part in (self.folder / "work").glob("*.part")}

    def test_on_this_machine(self):
        (self.folder / "kill.1").touch()
        self.assertIn("Trying to restart job", self.here())
        self.assertEqual(sorted(self.calls()), ["0", "1", "1", "2"])
        self.check_pack()
        self.assertIn("Nothing to be done", self.here())
        # An input that was only touched: the plan says what it said, so no shard is made again.
        times = self.part_times()
        self.inputs[0].touch()
        self.here()
        self.assertEqual(times, self.part_times())
        # One of other bytes, which all shards read.
        with open(self.inputs[0], "ab") as changed:
            changed.write(b"more")
        self.here()
        self.check_pack()

    def test_shards_stay_that_do_not_read_what_changed(self):
        self.use([self.flat_cell(lon, 7) for lon in (20, 23, 26)])
        self.here()
        self.check_pack()
        times = self.part_times()
        self.flat_cell(26, 8)
        self.here()
        self.check_pack()
        self.assertEqual([part.name for part, time in self.part_times().items() if time != times[part]], ["2.part"])

    def test_under_slurm(self):
        if not (shutil.which("slurmctld") and shutil.which("slurmd") and shutil.which("munged")):
            self.skipTest("SKIPPED: slurm-wlm and munge are not installed")
        slurm = Slurm(self.folder, self.started)
        try:
            slurm.start_all()
        except TimeoutError as error:
            print("SKIPPED: Slurm does not start on this machine:", error, file=sys.stderr)
            self.skipTest(f"SKIPPED: {error}")
        (self.folder / "hold").touch()
        child = self.snakemake("--profile", str(WORKFLOW / "slurm"), "--jobs", "8", environment=slurm.environment)

        def wait(what, condition):
            wait_for(what, lambda: child.poll() is not None or condition())
            self.assertIsNone(child.poll(), f"{what}: the workflow ended")

        # The node is full: one shard waits for a core.
        wait("two shards that run", lambda: len(self.calls()) == 2)
        wait("a shard that waits", lambda: len(slurm.jobs("PD")) == 1)
        self.assertIn("alloc", slurm.run("sinfo", "-h", "-o", "%T"))
        # One that runs is sent back to the queue: the third takes its place.
        requeued, staying = slurm.jobs("R")
        slurm.run("scontrol", "requeue", requeued)
        wait("the third shard", lambda: len(set(self.calls())) == 3)
        # The node's daemon is killed and comes back: the shards go on.
        slurm.kill_node()
        slurm.start_node()
        wait("the node", lambda: "alloc" in slurm.run("sinfo", "-h", "-o", "%T"))
        self.assertEqual(slurm.restarts(staying), 0)
        # The node dies with all that runs on it: its shards are queued again.
        steps = [pid for pid, name in descendants(os.getpid()).items() if name == "slurmstepd"]
        self.assertGreaterEqual(len(steps), 2)
        slurm.kill_node(*steps)
        wait("the shards to be queued again", lambda: slurm.restarts(staying) == 1)
        slurm.start_node()
        (self.folder / "hold").unlink()
        self.finish(child)
        self.assertEqual(slurm.restarts(requeued), 1)
        self.assertGreaterEqual(len(self.calls()), 5)
        self.check_pack()


class Manifests(unittest.TestCase):
    """The manifests for Kubernetes, held against what its API requires of their kinds."""

    # https://kubernetes.io/docs/reference/kubernetes-api/: of each kind, the version and what has to be there.
    KINDS = {"Namespace": ("v1", []), "ResourceQuota": ("v1", [("spec", "hard")]), "LimitRange": ("v1", [("spec", "limits")])}
    QUANTITY = re.compile(r"[0-9]+(\.[0-9]+)?(m|k|Ki|M|Mi|G|Gi|T|Ti)?")
    NAME = re.compile(r"[a-z0-9]([-a-z0-9]{0,61}[a-z0-9])?")
    FACTORS = {"m": 1e-3, "k": 1e3, "Ki": 2**10, "M": 1e6, "Mi": 2**20, "G": 1e9, "Gi": 2**30, "T": 1e12, "Ti": 2**40}

    def setUp(self):
        try:
            import yaml
        except ImportError:
            self.skipTest("SKIPPED: python3-yaml is not installed")
        self.profile = yaml.safe_load((WORKFLOW / "kubernetes/config.yaml").read_text())
        self.manifests = list(yaml.safe_load_all((WORKFLOW / "kubernetes/namespace.yaml").read_text()))

    def amount(self, quantity):
        number = re.match(r"[0-9.]+", str(quantity)).group()
        return float(number) * self.FACTORS.get(str(quantity)[len(number):], 1)

    def faults(self, manifests, profile):
        found = []
        for manifest in manifests:
            kind, name = manifest.get("kind"), manifest.get("metadata", {}).get("name", "")
            if kind not in self.KINDS:
                found.append(f"{kind}: no kind that is known")
                continue
            version, required = self.KINDS[kind]
            if manifest.get("apiVersion") != version:
                found.append(f"{kind}: version {manifest.get('apiVersion')}")
            if not self.NAME.fullmatch(name):
                found.append(f"{kind}: name {name}")
            if set(manifest) - {"apiVersion", "kind", "metadata", "spec"}:
                found.append(f"{kind}: members {sorted(manifest)}")
            namespace = name if kind == "Namespace" else manifest["metadata"].get("namespace")
            if namespace != profile["kubernetes"]:
                found.append(f"{kind}: namespace {namespace}, of the profile {profile['kubernetes']}")
            for path in required:
                value = manifest
                for member in path:
                    value = (value or {}).get(member)
                if not value:
                    found.append(f"{kind}: no {'.'.join(path)}")
        hard = next((m["spec"]["hard"] for m in manifests if m.get("kind") == "ResourceQuota" and m.get("spec")), {})
        limits = [limit for m in manifests if m.get("kind") == "LimitRange" and m.get("spec") for limit in m["spec"]["limits"]]
        quantities = [*hard.values(), *(q for limit in limits for part in ("default", "defaultRequest") for q in limit[part].values())]
        bad = [q for q in quantities if not self.QUANTITY.fullmatch(str(q))]
        if bad:
            return [*found, f"quantities {bad}"]
        for limit in limits:
            if limit["type"] not in ("Container", "Pod", "PersistentVolumeClaim"):
                found.append(f"limit of a {limit['type']}")
            for resource, request in limit["defaultRequest"].items():
                if self.amount(request) > self.amount(limit["default"][resource]):
                    found.append(f"{resource}: request above its limit")
                quota = hard.get(f"requests.{resource}")
                if quota is not None and self.amount(request) * profile["jobs"] > self.amount(quota):
                    found.append(f"{resource}: {profile['jobs']} jobs do not fit the quota of {quota}")
        if profile["jobs"] > self.amount(hard.get("pods", 0)):
            found.append(f"pods: fewer than {profile['jobs']} jobs")
        return found

    def test_they_are_what_the_api_requires(self):
        self.assertEqual(self.faults(self.manifests, self.profile), [])

    def test_faults_are_found(self):
        for fault in (lambda m: m[0].update(kind="Namespaces"), lambda m: m[0].update(apiVersion="v2"),
                      lambda m: m[0]["metadata"].update(name="Cairn!"), lambda m: m[1]["metadata"].pop("namespace"),
                      lambda m: m[1].pop("spec"), lambda m: m[1]["spec"]["hard"].update(pods="10"),
                      lambda m: m[1]["spec"]["hard"].update({"requests.memory": "3Gi"}), lambda m: m[2].update(specs={}),
                      lambda m: m[2]["spec"]["limits"][0]["defaultRequest"].update(cpu="two"),
                      lambda m: m[2]["spec"]["limits"][0]["defaultRequest"].update(memory="9Gi")):
            manifests = copy.deepcopy(self.manifests)
            fault(manifests)
            self.assertNotEqual(self.faults(manifests, self.profile), [])

    @unittest.skipUnless(shutil.which("snakemake"), "SKIPPED: snakemake is not installed")
    def test_snakemake_knows_every_option_of_the_profiles(self):
        import yaml
        known = subprocess.run(["snakemake", "--help"], capture_output=True, text=True, check=True).stdout
        for profile in ("kubernetes", "slurm"):
            for option in yaml.safe_load((WORKFLOW / profile / "config.yaml").read_text()):
                self.assertRegex(known, rf"--{option}\b", profile)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
