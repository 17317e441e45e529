"""A SLURM of one node on loopback: real daemons, a configuration of their own, nothing installed.

Everything lies in one folder, SLURM_CONF names it, and every process that belongs to it is known
by that variable in its environment, so that none outlives the tests, however those end: a warden
of a process of its own ends what is left when its pipe closes.
"""

from __future__ import annotations

import os
import pwd
import shutil
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path

from tests.reliability.drivers import until

PROGRAMS = ("munged", "slurmctld", "slurmd", "sbatch", "squeue", "scancel", "sinfo")
START = 30.0  # s in which the daemons are ready, or something is wrong
ASKED = 0.2  # s between two clients that ask them, each a process
ROOT = Path(__file__).parent.parent.parent
SBIN = ("/usr/sbin", "/usr/local/sbin")  # where daemons are, which not everybody's PATH names

# A requeued job waits as long as a credential lives, and SLURM takes fewer than 5 s for 2 minutes.
CONFIGURATION = """\
ClusterName=loopback
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={controller_port}
SlurmUser={user}
SlurmdUser={user}
AuthType=auth/munge
AuthInfo=socket={folder}/munge/socket,cred_expire=5
CredType=cred/munge
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
ProctrackType=proctrack/pgid
TaskPlugin=task/none
SwitchType=switch/none
MpiDefault=none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
JobCompType=jobcomp/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SchedulerParameters=batch_sched_delay=0,sched_interval=1,bf_interval=1
SlurmctldTimeout=10
SlurmdTimeout=5
BatchStartTimeout=1
MessageTimeout=2
KillWait=5
EnforcePartLimits=ALL
ReturnToService=2
SlurmdParameters=config_overrides
NodeName={host} NodeAddr=127.0.0.1 Port={node_port} CPUs={cpus} RealMemory=4000 State=UNKNOWN
PartitionName=main Nodes=ALL Default=YES MaxTime=INFINITE State=UP
"""


class NoSlurm(Exception):
    """There is none here, and why."""


def program(name: str) -> str:
    """Path of a program.

    Raises:
        NoSlurm: If it is not installed.
    """
    path = os.pathsep.join([os.environ.get("PATH", ""), *SBIN])
    if found := shutil.which(name, path=path):
        return found
    raise NoSlurm(f"{name} is not installed (.ci/programs installs it)")


@contextmanager
def loopback_slurm(folder: Path, *, cpus: int) -> Iterator[LoopbackSlurm]:
    """A SLURM that runs while the block does.

    Args:
        folder: Empty, with a path short enough for a socket.
        cpus: How many the node pretends to have.

    Raises:
        NoSlurm: If its programs are missing or do not start.
    """
    slurm = LoopbackSlurm(folder=folder, cpus=cpus)
    mark = str(slurm.configuration)
    warden = [sys.executable, "-m", "tests.cluster.loopback_slurm", mark]
    with subprocess.Popen(
        warden, stdin=subprocess.PIPE, cwd=ROOT, start_new_session=True
    ) as process:
        try:
            slurm.start()
            yield slurm
        finally:
            kill_all(lambda: marked(mark))
            process.kill()  # what it is there for is done
            slurm.reap()


@dataclass(kw_only=True)
class LoopbackSlurm:
    """The daemons and their clients."""

    folder: Path
    cpus: int
    daemons: list[subprocess.Popen[bytes]] = field(default_factory=list)

    @property
    def configuration(self) -> Path:
        return self.folder / "slurm.conf"

    @property
    def environment(self) -> Mapping[str, str]:
        """Of the clients, and by them of the jobs."""
        others = ("SLURM_", "SBATCH_", "SQUEUE_")
        kept = {key: value for key, value in os.environ.items() if not key.startswith(others)}
        return {**kept, "SLURM_CONF": str(self.configuration)}

    def start(self) -> None:
        for name in PROGRAMS:
            program(name)
        for name in ("munge", "state", "spool"):
            (self.folder / name).mkdir(mode=0o700)
        controller_port, node_port = _free_ports()
        text = CONFIGURATION.format(
            host=self._node,
            user=pwd.getpwuid(os.geteuid()).pw_name,
            folder=self.folder,
            controller_port=controller_port,
            node_port=node_port,
            cpus=self.cpus,
        )
        self.configuration.write_text(text)
        self._munged()
        self._daemon("slurmctld", "-D", "-f", str(self.configuration))
        self.start_node()
        if not until(self._idle, START, period=ASKED):
            said = [file.read_text()[-500:] for file in sorted(self.folder.glob("*.out"))]
            raise NoSlurm(f"its daemons do not start here: {' '.join(said)}")

    def start_node(self) -> None:
        """Start slurmd, or start it again."""
        self._daemon("slurmd", "-D", "-f", str(self.configuration), "-N", self._node)

    def reap(self) -> None:
        """Take note of the end of the daemons, which were killed."""
        for daemon in self.daemons:
            daemon.wait(START)

    def run(self, *command: str, folder: Path | None = None) -> subprocess.CompletedProcess[str]:
        """What a client says."""
        return subprocess.run(
            command, env=self.environment, cwd=folder, capture_output=True, text=True,
            timeout=60.0, check=False,
        )  # fmt: skip

    def queue(self, *states: str) -> list[str]:
        """Jobs that have not ended, or those in some states, as `3_1 RUNNING`, one a task."""
        chosen = ["-t", ",".join(states)] if states else []
        end = time.monotonic() + START
        while True:
            done = self.run("squeue", "-h", "-r", "-o", "%i %T", *chosen)
            if done.returncode == 0:
                return done.stdout.splitlines()
            assert time.monotonic() < end, done.stderr  # the controller may be busy for a moment

    def states(self, job: str) -> list[str]:
        """How each task of a job has ended, in the order of their numbers."""
        done = self.run("squeue", "-h", "-r", "-t", "all", "-j", job, "-o", "%K %T")
        tasks = sorted(line.split() for line in done.stdout.splitlines())
        return [state for _, state in tasks]

    def wait_until_empty(self, seconds: float) -> None:
        """Wait until every job has ended."""
        assert until(lambda: not self.queue(), seconds, period=ASKED), self.queue()

    def kill_node(self) -> int:
        """SIGKILL for slurmd, every slurmstepd and every job, as if the node lost its power.

        Returns:
            How many jobs died.
        """
        jobs = len(self.queue("RUNNING"))
        kill_all(lambda: [pid for pid in marked(str(self.configuration)) if self._of_node(pid)])
        return jobs

    @property
    def _node(self) -> str:
        return socket.gethostname().partition(".")[0]

    def _of_node(self, pid: int) -> bool:
        """Whether a process runs on the node: slurmd, a slurmstepd or whatever a job started."""
        if pid == os.getpid():
            return False
        name = _read(pid, "cmdline")
        if b"slurmd\0" in name or b"slurmstepd" in name:
            return True
        return b"SLURM_JOB_ID=" in _read(pid, "environ")

    def _munged(self) -> None:
        munge = self.folder / "munge"
        (munge / "key").write_bytes(os.urandom(128))
        (munge / "key").chmod(0o600)
        names = {"socket": "socket", "pid-file": "pid", "log-file": "log", "seed-file": "seed"}
        places = [f"--{option}={munge / name}" for option, name in names.items()]
        self._daemon("munged", "--foreground", "--force", f"--key-file={munge / 'key'}", *places)
        if not until((munge / "socket").exists, START):
            raise NoSlurm("munged does not start here")

    def _daemon(self, name: str, *options: str) -> None:
        with (self.folder / f"{name}.out").open("ab") as out:
            process = subprocess.Popen(
                [program(name), *options], env=self.environment, stdin=subprocess.DEVNULL,
                stdout=out, stderr=out, start_new_session=True,
            )  # fmt: skip
        self.daemons.append(process)

    def _idle(self) -> bool:
        return self.run("sinfo", "-h", "-o", "%T", "-p", "main").stdout.strip() == "idle"


def marked(mark: str) -> list[int]:
    """Processes in whose environment SLURM_CONF is this."""
    wanted = f"SLURM_CONF={mark}".encode()
    pids = [int(path.name) for path in Path("/proc").iterdir() if path.name.isdigit()]
    return [pid for pid in pids if wanted in _read(pid, "environ").split(b"\0")]


def kill_all(found: Callable[[], list[int]]) -> None:
    """SIGKILL until nothing is found any more, for what is found may just have started more."""
    end = time.monotonic() + START
    while (pids := found()) and time.monotonic() < end:
        for pid in pids:
            with suppress(ProcessLookupError):
                os.kill(pid, signal.SIGKILL)
        time.sleep(0.02)


def _read(pid: int, name: str) -> bytes:
    """Of a process; nothing of one that has ended."""
    with suppress(OSError):
        return Path(f"/proc/{pid}/{name}").read_bytes()
    return b""


def _free_ports() -> tuple[int, int]:
    with socket.socket() as one, socket.socket() as two:
        for found in (one, two):
            found.bind(("127.0.0.1", 0))
        return one.getsockname()[1], two.getsockname()[1]


if __name__ == "__main__":
    assert Path(sys.argv[1]).name == "slurm.conf"
    sys.stdin.read()  # until whoever runs the tests closes it, or is gone
    kill_all(lambda: marked(sys.argv[1]))
