"""Programs that try to break out of the box, from inside, and what must become of each."""

from typing import NamedTuple


class Attack(NamedTuple):
    """A program, and a regular expression for what it ends with: its ``result``, or its exception."""

    name: str
    program: str
    outcome: str


MISSING, READ_ONLY, REFUSED = r"FileNotFoundError.*", r"OSError: \[Errno 30\].*", r"PermissionError.*"
NOT_WRITTEN, UNWRITABLE = f"{READ_ONLY}|{REFUSED}", f"{READ_ONLY}|{REFUSED}|{MISSING}"
EMPTY, ERRNO = r"\[\]", r"OSError: \[Errno {}\].*"
NO_MODULE = r"ModuleNotFoundError.*"


def call(name: str, number: int, *arguments: int, outcome: str = "1") -> Attack:
    """A system call as native code makes it; it fails with error 1, "Operation not permitted"."""
    words = "".join(f", ctypes.c_long({each})" for each in arguments)
    program = f"libc.syscall({number}{words}); result = ctypes.get_errno()"
    return Attack(f"system call {name}", program, outcome)


INSIDE = (
    Attack("rewrite core_pattern", "open('/proc/sys/kernel/core_pattern', 'w').write('|/tmp/x %p')", MISSING),
    Attack("use other open files", "result = [i for i in range(7, 256) if is_open(i)]", EMPTY),
    Attack("rewrite swappiness", "open('/proc/sys/vm/swappiness', 'w').write('1')", MISSING),
    Attack("press SysRq", "open('/proc/sysrq-trigger', 'w').write('b')", f"{READ_ONLY}|{MISSING}"),
    Attack("read the kernel's memory", "open('/proc/kcore', 'rb').read(9)", MISSING),
    Attack("read the environment of the parent", "open('/proc/1/environ').read()", MISSING),
    Attack("list processes", "result = os.listdir('/proc')", r"\['cpuinfo'\]"),
    Attack("change the processor", "open('/sys/devices/system/cpu/cpu1/online', 'w')", UNWRITABLE),
    Attack("find tokens", "result = [each for each in os.environ if re.search('TOKEN|SECRET', each)]", EMPTY),
    Attack("write /", "open('/x', 'w')", READ_ONLY),
    Attack("write its own file", "open(__file__, 'a')", READ_ONLY),
    Attack("write numpy", "open(numpy.__file__, 'a')", NOT_WRITTEN),
    Attack(
        "write the guest", "open('/packages/gym_extensions/baselines/isolated/guest.py', 'a')", NOT_WRITTEN
    ),
    Attack("write Python", "open(os.__file__, 'a')", NOT_WRITTEN),
    Attack("write a shared library", "open('/usr/lib/x86_64-linux-gnu/evil.so', 'w')", NOT_WRITTEN),
    Attack("write where MuJoCo was", "open('/packages/gymnasium/envs/mujoco/x', 'w')", NOT_WRITTEN),
    Attack("make a device", "os.mknod('/tmp/disk', 0o60600, os.makedev(8, 0))", REFUSED),
    Attack("read passwords", "open('/etc/shadow').read()", MISSING),
    Attack("list the users", "open('/etc/passwd').read()", MISSING),
    Attack("enter root's home", "os.listdir('/root')", MISSING),
    Attack("enter its user's home", "os.listdir('/home')", MISSING),
    Attack("read references", "from gym_extensions import references; references.__path__", "ImportError.*"),
    Attack("read submissions", "import gym_extensions.scoring", NO_MODULE),
    Attack("import experts", "import gym_extensions.references.experts", NO_MODULE),
    Attack("import the environments", "import gym_extensions.envs", NO_MODULE),
    Attack("import MuJoCo", "import mujoco", NO_MODULE),
    Attack(
        "find MuJoCo or a model",
        "result = [path for path in files_in('/packages', '/python', '/usr') if is_of_mujoco(path)]",
        EMPTY,
    ),
    Attack(
        "find a policy",
        "result = [path for path in files_in('/packages/gym_extensions', '/agent') if is_policy(path)]",
        EMPTY,
    ),
    Attack("read experts' states", "open('/packages/gym_extensions/catalog/states-1.npz', 'rb')", REFUSED),
    Attack(
        "find a program",
        "names = 'sh', 'gcc', 'bash', 'python3'\n"
        "result = [name for name in names if shutil.which(name, os.F_OK, '/bin:/usr/bin:/python/bin')]",
        EMPTY,
    ),
    Attack("TCP", "socket.create_connection(('1.1.1.1', 80), 1)", REFUSED),
    Attack("UDP", "socket.socket(socket.AF_INET, socket.SOCK_DGRAM)", REFUSED),
    Attack("a Unix socket", "socket.socket(socket.AF_UNIX)", REFUSED),
    Attack("netlink", "socket.socket(16, socket.SOCK_RAW)", REFUSED),
    Attack("a pair of sockets", "socket.socketpair()", REFUSED),
    Attack(
        "an address", "from urllib import request; request.urlopen('http://a.org', timeout=1)", "URLError.*"
    ),
    Attack("fork", "os.fork()", REFUSED),
    Attack("spawn", "os.posix_spawn('/python/bin/python', ['python'], {})", f"{REFUSED}|{MISSING}"),
    Attack("subprocess", "subprocess.run(['/python/bin/python', '-c', '1'])", REFUSED),
    Attack("exec", "os.execv('/python/bin/python', ['python', '-c', '1'])", REFUSED),
    Attack("a shell", "result = os.system('true') != 0", "True"),
    Attack(
        "worker processes",
        "import multiprocessing; multiprocessing.get_context('fork').Process(target=print).start()",
        REFUSED,
    ),
    Attack(
        "a thousand threads",
        "started = [threading.Thread(target=hold.wait, daemon=True) for _ in range(1000)]\n"
        "try: [each.start() for each in started]\n"
        "finally: hold.set()",
        "RuntimeError: can't start new thread",
    ),
    Attack("30 GB of memory", "bytearray(30 * 2**30)", "MemoryError"),
    Attack("30 GB shared", "mmap.mmap(-1, 30 * 2**30)", f"{ERRNO.format(12)}|MemoryError|ValueError.*"),
    Attack(
        "fill /tmp",
        "for i in range(99):\n    with open(f'/tmp/{i}', 'wb') as file: file.write(bytes(8 * 2**20))",
        ERRNO.format(28),
    ),
    Attack(
        "a large file", "os.truncate(os.open('/tmp/large', os.O_CREAT | os.O_RDWR), 2**40)", ERRNO.format(27)
    ),
    Attack(
        "raise a limit", "resource.setrlimit(resource.RLIMIT_CPU, (10**6, 10**6))", f"ValueError.*|{REFUSED}"
    ),
    Attack("become root", "os.setuid(0)", f"{REFUSED}|{ERRNO.format(22)}"),
    Attack("leave the root folder", "os.chroot('/tmp')", REFUSED),
    Attack("kill everybody", "os.kill(-1, 9)", "ProcessLookupError.*"),
    Attack("kill the first process", "os.kill(1, 9); os.kill(1, 0); result = 'alive'", "alive"),
    Attack("be dumped", "libc.prctl(4, 1, 0, 0, 0); result = libc.prctl(3, 0, 0, 0, 0)", "0"),
    Attack("type into a terminal", "libc.ioctl(0, 0x5412, b'x'); result = ctypes.get_errno()", "1"),
    call("ptrace", 101, 0, 1, 0, 0),
    call("process_vm_readv", 310, 1, 0, 0, 0, 0, 0),
    call("process_vm_writev", 311, 1, 0, 0, 0, 0, 0),
    call("pidfd_open", 434, 1, 0),
    call("unshare (a user namespace)", 272, 0x10000000),
    call("setns", 308, 0, 0),
    call("clone (a user namespace)", 56, 0x10000000 | 17, 0, 0, 0, 0),
    call("clone (a child)", 56, 17, 0, 0, 0, 0),
    call("clone3", 435, 0, 88, outcome="38"),
    call("a call of the future", 1000, outcome="38"),
    call("mount", 165, 0, 0, 0, 0, 0),
    call("pivot_root", 155, 0, 0),
    call("open_by_handle_at", 304, 0, 0, 0),
    call("bpf", 321, 0, 0, 0),
    call("io_uring_setup", 425, 1, 0),
    call("keyctl", 250, 0, 0, 0, 0, 0),
    call("add_key", 248, 0, 0, 0, 0, 0),
    call("perf_event_open", 298, 0, 0, -1, -1, 0),
    call("userfaultfd", 323, 0),
    call("memfd_create", 319, 0, 0),
    call("shmget", 29, 0, 4096, 0o1600),
    call("splice", 275, 0, 0, 0, 0, 0, 0),
    call("kexec_load", 246, 0, 0, 0, 0),
    call("init_module", 175, 0, 0, 0),
    call("settimeofday", 164, 0, 0),
    call("personality", 135, 0),
)
"""Attacks that leave the guest alive, so that all of them run in one box."""

PREAMBLE = """
import ctypes, json, mmap, os, re, resource, shutil, socket, subprocess, sys, threading
import numpy
libc = ctypes.CDLL(None, use_errno=True)


def files_in(*tops):
    return (f"{folder}/{name}" for top in tops for folder, _, names in os.walk(top) for name in names)


def is_of_mujoco(path):
    return "libmujoco" in path or (path.endswith(".xml") and b"<mujoco" in open(path, "rb").read())


def is_policy(path):
    return path.endswith((".npz", ".onnx")) and "/states-" not in path


def is_open(number):
    try:
        os.fstat(number)
    except OSError:
        return False
    return True

"""
ALL_INSIDE = (
    PREAMBLE
    + """
class Agent:
    def __init__(self, observation_space, action_space, seed):
        self.outcomes = {}
        for name, program in json.loads(PROGRAMS):
            own = {**globals(), "hold": threading.Event(), "result": "done"}
            try:
                exec(program, own)
                self.outcomes[name] = str(own["result"])
            except BaseException as error:
                self.outcomes[name] = f"{type(error).__name__}: {error}".rstrip(": ")
            finally:
                for file in os.listdir("/tmp"):
                    os.unlink(f"/tmp/{file}")

    def act(self, observations):
        return numpy.zeros((len(observations), 3))

    def learn(self, env, steps):
        pass

    def card(self):
        from gym_extensions.baselines import Card

        return Card("attacker", hyperparameters=self.outcomes)
"""
)
"""An agent that tries all of them when it is made, and states on its card what became of them."""

BODY = """
class Agent:
    def __init__(self, observation_space, action_space, seed):
        self.space = action_space
        self.make()

    def make(self):
        pass

    def act(self, observations):
        return numpy.zeros((len(observations), *self.space.shape))

    def learn(self, env, steps):
        env.reset()
        for _ in range(steps // env.num_envs):
            env.step(self.act(numpy.zeros(env.num_envs)))

"""
FRAMES = """
from gym_extensions.baselines import Card, Policy
from gym_extensions.baselines.isolated import frames

writer, ones = int(sys.argv[2]), numpy.ones(3)


def policy(offset=0, packs=None, **arrays):
    if packs:
        frames.packed = lambda _: ([("weight_0", *packs)], bytes(8))
    return Policy(action_offset=offset * ones, action_scale=ones, **arrays)

"""
METHODS = {
    "make": "make(self)",
    "act": "act(self, observations)",
    "learn": "learn(self, env, steps)",
    "policy": "policy(self)",
    "save": "save(self, path)",
    "card": "card(self)",
}


class Ending(NamedTuple):
    """What an agent does in one of its methods, words in the error of the world, and its code."""

    method: str
    """Empty for what the file does when it is imported."""
    name: str
    program: str
    words: str
    code: str = "agent-failed"


def in_method(method: str, *rows: tuple[str, ...]) -> tuple[Ending, ...]:
    return tuple(Ending(method, *row) for row in rows)


ENDED, BROKEN, OVER_BUDGET = "agent-ended", "agent-frames", ("its budget is 1000", "budget-exceeded")
THREAD = "threading.Thread(target=lambda: [0 for _ in iter(int, 1)])"
NO_SIGNAL = "import signal; signal.signal(signal.SIGXCPU, signal.SIG_IGN)"
STEP = "env.step(numpy.zeros((env.num_envs, 3)))"
MANY = "many = numpy.ones((9999, 11)); observed = dict(observation_mean=many, observation_scale=many)"
ENDINGS = (
    *in_method(
        "",
        ("does not import", "import no_such_package", "'no_such_package' (agent.py, line"),
        ("has a syntax error", "def (:", "SyntaxError"),
        ("has no such factory", "del Agent", "has no callable 'Agent'"),
        ("misspells its factory", "Agnet = Agent; del Agent", "Did you mean 'Agnet'?"),
        ("needs MuJoCo", "import mujoco", "and no simulator"),
        ("has a card that is not a method", "Agent.card = Card('x')", "def card(self)"),
    ),
    *in_method(
        "make",
        ("fails", "print('before the end'); 1 / 0", "ZeroDivisionError: division by zero (agent.py, line"),
        ("prints what a terminal obeys", r"print('\x1b[2Jred'); 1 / 0", r"| \x1b[2Jred"),
        ("ends Python", "sys.exit(7)", "SystemExit: 7"),
        ("ends its process", "print('bye', flush=True); os._exit(3)", "It printed last:\n  | bye", ENDED),
        ("crashes", "ctypes.string_at(0)", "status 139", ENDED),
        ("calls the kernel as x32", "libc.syscall(0x40000000 + 39)", "made a system call of x32", ENDED),
        ("loops", "while True: pass", "used up its 2 seconds of processor time", "agent-cpu"),
        ("loops in threads", f"for _ in range(3): {THREAD}.start()", "used up its 2 seconds", "agent-cpu"),
        ("loops and ignores the signal", f"{NO_SIGNAL}\n        while True: pass", "was killed", ENDED),
        ("sleeps", "import time; time.sleep(99)", "wait for 3 seconds", "agent-slow"),
        ("prints gigabytes", "while True: os.write(1, b'x' * 65536)", "1,048,576 bytes", "agent-output"),
        ("forks for ever", "while True: os.fork()", "PermissionError"),
        ("sends garbage", "os.write(writer, b'?' * 99)", "the unexpected byte b'?'", BROKEN),
        (
            "sends 4 GiB",
            "os.write(writer, frames.REPLY + frames.LENGTHS.pack(9, 2**32)); os.write(writer, bytes(99))",
            "a reply of 4,294,967,296 bytes; the limit is 0",
            BROKEN,
        ),
        ("sends a long text", r"os.write(writer, frames.ERROR + b'\xff' * 12)", "limit is 65,536", BROKEN),
        (
            "sends deep JSON",
            "text = b'[' * 60000; os.write(writer, frames.REPLY + frames.LENGTHS.pack(len(text), 0) + text)",
            "not JSON",
            BROKEN,
        ),
        ("closes its pipes", "os.closerange(0, 99)\n        while True: pass", "closed its pipes", ENDED),
    ),
    *in_method(
        "policy",
        (
            "returns too large a policy",
            f"{MANY}; return policy(weights=(many[:11, :3],), biases=(ones,), **observed)",
            "the limit is 1,000,000",
            BROKEN,
        ),
        ("returns a pickle as policy", "return object()", "Expected a Policy"),
        ("sends an array of objects", "return policy(packs=('|O', [1]))", "cannot be read", BROKEN),
        ("sends a huge shape", "return policy(packs=('<f8', [10**6, 10**6]))", "do not fit their", BROKEN),
        ("sends no policy", "return policy(packs=('<f8', [1]))", "is missing", "bad-policy"),
        (
            "returns another policy each time",
            "return policy(offset=numpy.random.default_rng().uniform())",
            "differ from act()",
            "policy-differs",
        ),
    ),
    *in_method(
        "save",
        ("writes no checkpoint", "pass\n    def load(self, path): pass", "save() did not write the file"),
        ("cannot load what it saved", "path.touch()\n    def load(self, path): 1 / 0", "load(): The agent"),
    ),
    *in_method(
        "card",
        (
            "states a strange card",
            "frames.json.dumps = lambda *_, **__: '{\"algorithm\": 1}'; return Card('x')",
            "cannot be read",
            "bad-card",
        ),
        (
            "states what is no JSON",
            "return Card('x', hyperparameters={'rates': {0.1}})",
            "card(): The agent raised",
        ),
    ),
    *in_method("act", ("returns wrong shapes in evaluation", "return numpy.zeros(7)", "shape (1, 3)")),
    *in_method(
        "learn",
        (
            "returns NaN in training",
            "env.reset(); env.step(numpy.full((env.num_envs, 3), numpy.nan))",
            "The agent returned nan as an action",
            "bad-actions",
        ),
        ("returns wrong shapes in training", "env.reset(); env.step(numpy.zeros(7))", "the shape (7,)"),
        ("returns text in training", "env.reset(); env.step('left')", "the shape () and the dtype <U4"),
        (
            "fails while it trains",
            f"env.reset(); [{STEP} for _ in range(20)]; raise ValueError('too late')",
            "learn(), stage 1, after 20 of 1,000 steps: The agent raised ValueError: too late (agent.py",
        ),
        ("takes ten times the steps", f"env.reset(); [{STEP} for _ in range(10 * steps)]", *OVER_BUDGET),
        ("hides steps behind resets", f"while True: env.reset(); {STEP}", *OVER_BUDGET),
        ("resets for ever", "while True: env.reset()", "reset 1,101 environments", "too-many-resets"),
        ("asks for the stage unasked", "env.stage", "observes.boundaries"),
    ),
)
"""Agents that end with an error; each has a box of its own."""


def agent_file(ending: Ending) -> str:
    """The file of an agent that does this."""
    if not ending.method:
        return f"{PREAMBLE}{FRAMES}{BODY}\n\n{ending.program}\n"
    return f"{PREAMBLE}{FRAMES}{BODY}    def {METHODS[ending.method]}:\n        {ending.program}\n"
