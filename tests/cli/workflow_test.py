#!/usr/bin/python3
"""Runs scripts/workflow/ on this machine, and under a Slurm of one node that the test starts and ends.

usage: tests/cli/workflow_test.py REPOSITORY PROGRAMS [TEST...]"""

import getpass
import json
import os
import pathlib
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
import unittest

REPOSITORY, PROGRAMS = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve()
SNAKEFILE = REPOSITORY / "scripts/workflow/Snakefile"


def free_port():
    with socket.socket() as any_port:
        any_port.bind(("127.0.0.1", 0))
        return any_port.getsockname()[1]


class Slurm:
    """munged, slurmctld and slurmd of this test alone, in a folder of their own."""

    def __init__(self, folder):
        self.folder = folder
        self.children = []
        name = socket.gethostname().split(".")[0]
        self.conf = folder / "slurm.conf"
        for sub in ("state", "spool", "munge"):
            (folder / sub).mkdir(mode=0o755)
        key = folder / "munge/munge.key"
        key.write_bytes(os.urandom(128))
        key.chmod(0o600)
        self.socket = folder / "munge/munge.socket"
        self.conf.write_text(f"""ClusterName=cairn
SlurmctldHost={name}(127.0.0.1)
SlurmUser={getpass.getuser()}
SlurmdUser={getpass.getuser()}
SlurmctldPort={free_port()}
SlurmdPort={free_port()}
AuthType=auth/munge
AuthInfo=socket={self.socket}
CredType=cred/munge
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
MpiDefault=none
ReturnToService=2
SlurmdTimeout=10
MinJobAge=300
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
AccountingStorageType=accounting_storage/none
JobAcctGatherType=jobacct_gather/none
NodeName={name} NodeAddr=127.0.0.1 CPUs={os.cpu_count()} RealMemory=4096 State=UNKNOWN
PartitionName=main Nodes={name} Default=YES MaxTime=INFINITE State=UP
""")
        self.environment = dict(os.environ, SLURM_CONF=str(self.conf), USER=getpass.getuser())

    def start(self, *command):
        child = subprocess.Popen(command, env=self.environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.children.append(child)
        return child

    def start_node(self):
        return self.start("slurmd", "-D", "-f", str(self.conf))

    def start_all(self):
        self.start("munged", "--foreground", "--force", f"--key-file={self.folder}/munge/munge.key",
                   f"--socket={self.socket}", f"--pid-file={self.folder}/munge/munged.pid",
                   f"--log-file={self.folder}/munge/munged.log", f"--seed-file={self.folder}/munge/munged.seed")
        self.wait_for(self.socket.exists)
        self.start("slurmctld", "-D", "-f", str(self.conf))
        self.node = self.start_node()
        self.wait_for(lambda: "idle" in self.run("sinfo", "-h", "-o", "%T").stdout)

    def run(self, *command):
        return subprocess.run(command, env=self.environment, capture_output=True, text=True)

    @staticmethod
    def wait_for(condition, seconds=90):
        end = time.monotonic() + seconds
        while not condition():
            if time.monotonic() > end:
                raise TimeoutError("Slurm did not start")
            time.sleep(0.5)

    def end(self):
        for child in reversed(self.children):
            if child.poll() is None:
                child.terminate()
                try:
                    child.wait(10)
                except subprocess.TimeoutExpired:
                    child.kill()
                    child.wait()


@unittest.skipUnless(shutil.which("snakemake"), "snakemake is not installed")
class Workflow(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="cairn-workflow-"))
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)
        self.inputs = []
        for sample in sorted((REPOSITORY / "sample-dem").glob("*.tif")):
            self.inputs.append(self.folder / sample.name)
            shutil.copyfile(sample, self.inputs[-1])
        self.config = self.folder / "config.json"
        self.config.write_text(json.dumps({
            "inputs": [*map(str, self.inputs), "--tile-size", "257"],
            "pack": "out.cairn", "shards": 4, "threads": 1, "cairn": str(PROGRAMS / "cairn")}))

    def snakemake(self, *arguments, environment=None):
        command = ["snakemake", "-s", str(SNAKEFILE), "--configfile", str(self.config), *arguments]
        child = subprocess.Popen(command, cwd=self.folder, env=environment, text=True, stdout=subprocess.PIPE,
                                 stderr=subprocess.STDOUT)
        self.addCleanup(child.stdout.close)
        self.addCleanup(child.wait)
        self.addCleanup(child.kill)
        return child

    def finish(self, child):
        out, _ = child.communicate(timeout=600)
        self.assertEqual(child.returncode, 0, out)
        return out

    def check_pack(self):
        whole = self.folder / "whole.cairn"
        subprocess.run([PROGRAMS / "cairn", "bake", *self.inputs, "--tile-size", "257", "-o", whole, "--force"],
                       check=True, capture_output=True)
        self.assertEqual((self.folder / "out.cairn").read_bytes(), whole.read_bytes())
        report = json.loads((self.folder / "work/report.json").read_text())
        self.assertEqual(report["shards"], 4)
        self.assertEqual(report["pack_bytes"], whole.stat().st_size)

    def test_on_this_machine(self):
        self.finish(self.snakemake("--cores", "2"))
        self.check_pack()
        again = self.finish(self.snakemake("--cores", "2"))
        self.assertIn("Nothing to be done", again)
        # An input that was only touched: the plan says what it said, so no shard is made again.
        times = {part: part.stat().st_mtime_ns for part in (self.folder / "work").glob("*.part")}
        self.inputs[0].touch()
        self.finish(self.snakemake("--cores", "2"))
        self.assertEqual(times, {part: part.stat().st_mtime_ns for part in times})
        # One of other bytes: all is made again.
        with open(self.inputs[0], "ab") as changed:
            changed.write(b"more")
        self.finish(self.snakemake("--cores", "2"))
        self.check_pack()

    @unittest.skipUnless(shutil.which("slurmctld") and shutil.which("munged"), "slurm-wlm is not installed")
    def test_under_slurm(self):
        slurm = Slurm(self.folder)
        self.addCleanup(slurm.end)
        try:
            slurm.start_all()
        except TimeoutError:
            self.skipTest("Slurm does not start on this machine")
        run = ("--slurm", "--jobs", "8", "--latency-wait", "30", "--default-resources", "slurm_partition=main")
        child = self.snakemake(*run, environment=slurm.environment)
        # The node is full, since 4 shards wait for it at once; then its daemon dies and comes back, and a job that
        # runs is sent back to the queue.
        slurm.wait_for((self.folder / "work/plan.json").exists, 300)
        slurm.node.send_signal(signal.SIGKILL)
        slurm.node.wait()
        slurm.node = slurm.start_node()
        for job in slurm.run("squeue", "-h", "-t", "R", "-o", "%i").stdout.split():
            slurm.run("scontrol", "requeue", job)
        self.finish(child)
        self.check_pack()


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
