"""What a guest may ask of the kernel: limits of its process, and system calls that are refused.

The guest limits itself before it reads the agent's file, and cannot take it back. It stays one process, so
that the limits of the kernel, which count per process, hold for all of it.
"""

from __future__ import annotations

import ctypes
import errno
import math
import struct
import sys
from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from gym_extensions.catalog.groups import TaskGroup

MEBIBYTE = 2**20
TRPO_MICROSECONDS = {"Hopper": 110, "HalfCheetah": 70, "Walker2d": 156, "Humanoid": 447}
"""Processor time of the agent trpo per training step, with simulation and evaluation: medians of its
submitted runs. Other bodies count as the slowest."""
LIBRARIES = 4096 * MEBIBYTE
"""Address space for the code of libraries, beyond that for data: torch with CUDA maps gigabytes."""


@dataclass(frozen=True)
class Limits:
    """Limits of a guest.

    Args:
        cpu_seconds: processor time of all its threads.
        wait_seconds: how long the world waits for it, all together; 4 × ``cpu_seconds`` + 60 if 0.
        memory: bytes of its data. Its files in ``/tmp`` come on top, with at most ``files``.
        files: bytes of all its files, and of what it saves.
        threads: most threads.
        output: most bytes that it prints.
        policy: most bytes of its policy.
    """

    cpu_seconds: int = 3600
    wait_seconds: int = 0
    memory: int = 4096 * MEBIBYTE
    files: int = 256 * MEBIBYTE
    threads: int = 64
    output: int = 64 * MEBIBYTE
    policy: int = 256 * MEBIBYTE

    @classmethod
    def of(cls, jobs: Iterable[tuple[TaskGroup, int]]) -> Limits:
        """The limits for jobs with these groups and training steps: five times the processor time of trpo.

        A minute more is for the start. The longest job counts.
        """
        slowest = max(TRPO_MICROSECONDS.values())
        costs = [
            steps * max(TRPO_MICROSECONDS.get(task.base, slowest) for task in group.tasks)
            for group, steps in jobs
        ]
        return cls(cpu_seconds=60 + math.ceil(5 * max(costs) / 1e6))

    @property
    def longest_wait(self) -> int:
        return self.wait_seconds or 4 * self.cpu_seconds + 60


def confine(limits: Limits) -> None:
    """Limits this process, which has one thread and no child, for the rest of its life."""
    import resource

    bounds = {"CPU": limits.cpu_seconds, "DATA": limits.memory, "AS": limits.memory + LIBRARIES, "CORE": 0}
    bounds |= {"FSIZE": limits.files, "NPROC": limits.threads, "NOFILE": 256, "MEMLOCK": 0}
    for name, value in bounds.items():
        # The kernel ends the process with SIGXCPU, and, if it ignores that, two seconds later.
        resource.setrlimit(getattr(resource, f"RLIMIT_{name}"), (value, value + 2 * (name == "CPU")))
    program = seccomp_program()
    code = ctypes.create_string_buffer(b"".join(struct.pack("=HBBI", *each) for each in program))
    filters = struct.pack("@HP", len(program), ctypes.addressof(code))  # a struct sock_fprog
    prctl = ctypes.CDLL(None, use_errno=True).prctl
    # Never dumped: a core pattern that begins with "|" gives the memory to a program of the host's root.
    for call in ((PR_SET_DUMPABLE, 0), (PR_SET_NO_NEW_PRIVS, 1), (PR_SET_SECCOMP, 2, filters)):
        if prctl(*call, *[0] * (5 - len(call))) != 0:
            sys.exit(f"prctl({call[0]}) failed: {errno.errorcode.get(ctypes.get_errno())}")


PR_SET_DUMPABLE, PR_SET_SECCOMP, PR_SET_NO_NEW_PRIVS = 4, 22, 38
REFUSED = {
    "other programs, and other processes": """execve 59 execveat 322 fork 57 vfork 58 ptrace 101 kcmp 312
        process_vm_readv 310 process_vm_writev 311 pidfd_open 434 pidfd_getfd 438 process_madvise 440
        process_mrelease 448""",
    "namespaces and file systems": """unshare 272 setns 308 mount 165 umount2 166 pivot_root 155 chroot 161
        open_tree 428 move_mount 429 fsopen 430 fsconfig 431 fsmount 432 fspick 433 mount_setattr 442
        name_to_handle_at 303 open_by_handle_at 304 quotactl 179 quotactl_fd 443 fanotify_init 300
        sysfs 139 ustat 136 acct 163""",
    "the network, and sockets of all kinds": "socket 41 socketpair 53",
    "memory that the limits do not count": """memfd_create 319 memfd_secret 447 shmget 29 shmat 30
        shmctl 31 semget 64 msgget 68 mq_open 240""",
    "parts of the kernel that had holes and that no agent needs": """bpf 321 io_uring_setup 425
        io_uring_enter 426 io_uring_register 427 add_key 248 request_key 249 keyctl 250
        perf_event_open 298 userfaultfd 323 splice 275 tee 276 vmsplice 278 remap_file_pages 216
        modify_ldt 154 personality 135 migrate_pages 256 move_pages 279 lookup_dcookie 212""",
    "the machine": """init_module 175 finit_module 313 delete_module 176 kexec_load 246
        kexec_file_load 320 reboot 169 swapon 167 swapoff 168 syslog 103 settimeofday 164
        clock_settime 227 adjtimex 159 clock_adjtime 305 sethostname 170 setdomainname 171 iopl 172
        ioperm 173 vhangup 153""",
}
"""System calls that fail with EPERM, with their numbers on x86-64, by what they are for."""
ARGUMENTS = {16: (1, (0x5412, 0x541C)), 157: (0, (PR_SET_DUMPABLE,))}
"""Calls that are refused for some values of one argument, by number: its index, and the values. TIOCSTI and
TIOCLINUX of ioctl write into a terminal; prctl would allow dumps again."""
CLONE, CLONE_THREAD, CLONE3, NEWEST = 56, 0x10000, 435, 450
"""A thread is a clone with this flag. The flags of clone3 lie in memory, where no filter sees them: libraries
go back to clone if it is missing. Calls above ``NEWEST`` are missing, too: nobody has judged them."""
X86_64, X32 = 0xC000003E, 0x40000000
LOAD, EQUAL, AT_LEAST, BIT_SET, RETURN = 0x20, 0x15, 0x35, 0x45, 0x06
KILL, ALLOW, FAIL = 0x80000000, 0x7FFF0000, 0x00050000
NUMBER, ARCHITECTURE, FIRST_ARGUMENT = 0, 4, 16
"""Offsets in what a filter sees: the call, the architecture, and arguments of 8 bytes each."""
Instruction = tuple[int, int, int, int]
"""What to do, how many instructions to skip if it is true and if it is false, and a number."""


def seccomp_program() -> list[Instruction]:
    """The filter of system calls: instructions of the kernel's BPF, from top to bottom."""

    def refuse(test: int, value: int, answer: int) -> tuple[Instruction, Instruction]:
        return (test, 0, 1, value), (RETURN, 0, 0, answer)

    program: list[Instruction] = [(LOAD, 0, 0, ARCHITECTURE), (EQUAL, 1, 0, X86_64), (RETURN, 0, 0, KILL)]
    program += (LOAD, 0, 0, NUMBER), *refuse(AT_LEAST, X32, KILL)
    program += *refuse(AT_LEAST, NEWEST + 1, FAIL | errno.ENOSYS), *refuse(EQUAL, CLONE3, FAIL | errno.ENOSYS)
    for number in (int(word) for calls in REFUSED.values() for word in calls.split()[1::2]):
        program += refuse(EQUAL, number, FAIL | errno.EPERM)
    for number, (index, values) in ARGUMENTS.items():
        body = [step for value in values for step in refuse(EQUAL, value, FAIL | errno.EPERM)]
        program += (EQUAL, 0, len(body) + 2, number), (LOAD, 0, 0, FIRST_ARGUMENT + 8 * index), *body
        program.append((RETURN, 0, 0, ALLOW))
    program += (EQUAL, 0, 3, CLONE), (LOAD, 0, 0, FIRST_ARGUMENT), (BIT_SET, 1, 0, CLONE_THREAD)
    return [*program, (RETURN, 0, 0, FAIL | errno.EPERM), (RETURN, 0, 0, ALLOW)]
