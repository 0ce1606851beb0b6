"""Programs that try to break out of the box, from inside, and what must become of each."""

from typing import NamedTuple


class Attack(NamedTuple):
    """A program, and a regular expression for what it ends with: its ``result``, or its exception."""

    name: str
    program: str
    outcome: str


MISSING, READ_ONLY, REFUSED = r"FileNotFoundError.*", r"OSError: \[Errno 30\].*", r"PermissionError.*"
NOT_WRITTEN = f"{READ_ONLY}|{REFUSED}"
NO_MODULE = r"ModuleNotFoundError.*"


def call(name: str, number: int, *arguments: int, outcome: str = "1") -> Attack:
    """A system call as native code makes it; it fails with error 1, "Operation not permitted"."""
    words = "".join(f", ctypes.c_long({each})" for each in arguments)
    program = f"libc.syscall({number}{words}); result = ctypes.get_errno()"
    return Attack(f"system call {name}", program, outcome)


INSIDE = (
    Attack("rewrite core_pattern", "open('/proc/sys/kernel/core_pattern', 'w').write('|/tmp/x %p')", MISSING),
    Attack("use other open files", "result = [i for i in range(7, 256) if is_open(i)]", r"\[\]"),
    Attack("rewrite swappiness", "open('/proc/sys/vm/swappiness', 'w').write('1')", MISSING),
    Attack("press SysRq", "open('/proc/sysrq-trigger', 'w').write('b')", f"{READ_ONLY}|{MISSING}"),
    Attack("read the kernel's memory", "open('/proc/kcore', 'rb').read(9)", MISSING),
    Attack("read the environment of the parent", "open('/proc/1/environ').read()", MISSING),
    Attack("list processes", "result = os.listdir('/proc')", r"\['cpuinfo'\]"),
    Attack(
        "change the processor", "open('/sys/devices/system/cpu/cpu1/online', 'w')", f"{NOT_WRITTEN}|{MISSING}"
    ),
    Attack(
        "find tokens",
        "result = [name for name in os.environ if 'TOKEN' in name or 'SECRET' in name]",
        r"\[\]",
    ),
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
    Attack(
        "read submissions",
        ("from gym_extensions import references; references.__path__; import gym_extensions.scoring"),
        "ModuleNotFoundError.*|ImportError.*",
    ),
    Attack("import experts", "import gym_extensions.references.experts", NO_MODULE),
    Attack("import the environments", "import gym_extensions.envs", NO_MODULE),
    Attack("import MuJoCo", "import mujoco", NO_MODULE),
    Attack(
        "find MuJoCo or a model",
        (
            "result = [f'{folder}/{name}' for top in ('/packages', '/python', '/usr') for "
            "folder, _, names in os.walk(top) for name in names if is_of_mujoco(folder, name)]"
        ),
        r"\[\]",
    ),
    Attack(
        "find a policy",
        (
            "result = sum(name.endswith(('.npz', '.onnx')) for top in "
            "('/packages/gym_extensions', '/agent') for _, _, names in os.walk(top) for name in "
            "names if not name.startswith('states-'))"
        ),
        "0",
    ),
    Attack(
        "read observations of experts",
        "open('/packages/gym_extensions/catalog/states-1.npz', 'rb')",
        "PermissionError.*",
    ),
    Attack(
        "find a program",
        (
            "result = sum(os.path.exists(f'{top}/{name}') for top in ('/bin', '/usr/bin', "
            "'/python/bin') for name in ('sh', 'gcc', 'bash', 'python3'))"
        ),
        "0",
    ),
    Attack("TCP", "socket.create_connection(('1.1.1.1', 80), 1)", REFUSED),
    Attack("UDP", "socket.socket(socket.AF_INET, socket.SOCK_DGRAM)", REFUSED),
    Attack("a Unix socket", "socket.socket(socket.AF_UNIX)", REFUSED),
    Attack("netlink", "socket.socket(16, socket.SOCK_RAW)", REFUSED),
    Attack("a pair of sockets", "socket.socketpair()", REFUSED),
    Attack(
        "an address",
        "import urllib.request; urllib.request.urlopen('http://example.org', timeout=1)",
        "URLError.*",
    ),
    Attack("fork", "os.fork()", REFUSED),
    Attack("spawn", "os.posix_spawn('/python/bin/python', ['python'], {})", f"{REFUSED}|{MISSING}"),
    Attack("subprocess", "subprocess.run(['/python/bin/python', '-c', '1'])", REFUSED),
    Attack("exec", "os.execv('/python/bin/python', ['python', '-c', '1'])", REFUSED),
    Attack("a shell", "result = os.system('true') != 0", "True"),
    Attack(
        "worker processes",
        ("import multiprocessing; multiprocessing.get_context('fork').Process(target=print).start()"),
        REFUSED,
    ),
    Attack(
        "a thousand threads",
        (
            "started = []\n"
            "try:\n"
            "    for _ in range(1000):\n"
            "        started.append(threading.Thread(target=hold.wait, daemon=True)); "
            "started[-1].start()\n"
            "finally:\n    hold.set()\n    [each.join() for each in started[:-1]]"
        ),
        "RuntimeError: can't start new thread",
    ),
    Attack("30 GB of memory", "bytearray(30 * 2**30)", "MemoryError"),
    Attack(
        "30 GB of shared memory",
        "mmap.mmap(-1, 30 * 2**30)",
        r"OSError: \[Errno 12\].*|MemoryError|ValueError.*",
    ),
    Attack(
        "fill /tmp",
        ("for i in range(99):\n    with open(f'/tmp/{i}', 'wb') as file: file.write(bytes(8 * 2**20))"),
        r"OSError: \[Errno 28\].*",
    ),
    Attack(
        "a large file",
        "os.truncate(os.open('/tmp/large', os.O_CREAT | os.O_RDWR), 2**40)",
        r"OSError: \[Errno 27\].*",
    ),
    Attack(
        "raise a limit",
        "resource.setrlimit(resource.RLIMIT_CPU, (10**6, 10**6))",
        "ValueError: not allowed.*|PermissionError.*",
    ),
    Attack("become root", "os.setuid(0)", r"PermissionError.*|OSError: \[Errno 22\].*"),
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
import ctypes, json, mmap, os, re, resource, socket, subprocess, sys, threading
import numpy
libc = ctypes.CDLL(None, use_errno=True)


def is_of_mujoco(folder, name):
    if "libmujoco" in name:
        return True
    return name.endswith(".xml") and b"<mujoco" in open(f"{folder}/{name}", "rb").read()


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
FRAMES = "from gym_extensions.baselines.isolated import frames; writer = int(sys.argv[2])\n"


class Ending(NamedTuple):
    """What an agent does in one of its methods, the code of the error of the world, and words in it."""

    name: str
    method: str
    program: str
    code: str
    words: str


ENDINGS = (
    Ending(
        "does not import",
        "",
        "import no_such_package",
        "agent-failed",
        "ModuleNotFoundError: No module named 'no_such_package' (agent.py, line",
    ),
    Ending("has a syntax error", "", "def (:", "agent-failed", "SyntaxError"),
    Ending("has no such factory", "", "del Agent", "agent-failed", "no attribute 'Agent'"),
    Ending("needs MuJoCo", "", "import mujoco", "agent-failed", "No module named 'mujoco'"),
    Ending(
        "fails",
        "make(self)",
        "print('before the end'); 1 / 0",
        "agent-failed",
        "ZeroDivisionError: division by zero (agent.py, line",
    ),
    Ending(
        "prints what a terminal obeys",
        "make(self)",
        r"print('\x1b[2Jred'); 1 / 0",
        "agent-failed",
        r"| \x1b[2Jred",
    ),
    Ending("ends Python", "make(self)", "sys.exit(7)", "agent-failed", "SystemExit: 7"),
    Ending(
        "ends its process",
        "make(self)",
        "print('bye', flush=True); os._exit(3)",
        "agent-ended",
        "ended with status 3. It printed last:\n  | bye",
    ),
    Ending("crashes", "make(self)", "ctypes.string_at(0)", "agent-ended", "status 139"),
    Ending(
        "calls the kernel as x32",
        "make(self)",
        "libc.syscall(0x40000000 + 39)",
        "agent-ended",
        "made a system call of x32",
    ),
    Ending("loops", "make(self)", "while True: pass", "agent-cpu", "used up its 2 seconds of processor time"),
    Ending(
        "loops in threads",
        "make(self)",
        "for _ in range(3): threading.Thread(target=lambda: [0 for _ in iter(int, 1)]).start()",
        "agent-cpu",
        "used up its 2 seconds",
    ),
    Ending(
        "loops and ignores the signal",
        "make(self)",
        "import signal; signal.signal(signal.SIGXCPU, signal.SIG_IGN)\n        while True: pass",
        "agent-ended",
        "was killed",
    ),
    Ending("sleeps", "make(self)", "import time; time.sleep(99)", "agent-slow", "wait for 3 seconds"),
    Ending(
        "prints gigabytes",
        "make(self)",
        "while True: os.write(1, b'x' * 65536)",
        "agent-output",
        "printed more than 1,048,576 bytes",
    ),
    Ending("forks for ever", "make(self)", "while True: os.fork()", "agent-failed", "PermissionError"),
    Ending(
        "sends garbage",
        "make(self)",
        "os.write(writer, b'?' * 99)",
        "agent-frames",
        "the unexpected byte b'?'",
    ),
    Ending(
        "sends 4 GiB",
        "make(self)",
        ("os.write(writer, frames.REPLY + frames.LENGTHS.pack(9, 2**32)); os.write(writer, bytes(99))"),
        "agent-frames",
        "a reply of 4,294,967,296 bytes; the limit is 0",
    ),
    Ending(
        "sends a long text",
        "make(self)",
        r"os.write(writer, frames.ERROR + b'\xff' * 12)",
        "agent-frames",
        "a text of 4,294,967,295 bytes; the limit is 65,536",
    ),
    Ending(
        "sends deep JSON",
        "make(self)",
        ("text = b'[' * 60000; os.write(writer, frames.REPLY + frames.LENGTHS.pack(len(text), 0) + text)"),
        "agent-frames",
        "not JSON",
    ),
    Ending(
        "closes its pipes",
        "make(self)",
        "os.closerange(0, 99)\n        while True: pass",
        "agent-ended",
        "closed its pipes",
    ),
    Ending(
        "returns too large a policy",
        "policy(self)",
        (
            "return Policy(action_offset=numpy.zeros(3), action_scale=numpy.ones(3), "
            "weights=(numpy.zeros((11, 3)),) * 1, biases=(numpy.zeros(3),), "
            "observation_mean=numpy.zeros((9999, 11)), observation_scale=numpy.ones((9999, 11)))"
        ),
        "agent-frames",
        "the limit is 1,000,000",
    ),
    Ending(
        "returns a pickle as policy", "policy(self)", "return object()", "agent-failed", "Expected a Policy"
    ),
    Ending(
        "sends an array of objects",
        "policy(self)",
        (
            "frames.packed = lambda _: ([('weight_0', '|O', [1])], bytes(8)); return "
            "Policy(action_offset=numpy.zeros(3), action_scale=numpy.ones(3))"
        ),
        "agent-frames",
        "arrays that cannot be read",
    ),
    Ending(
        "sends a huge shape",
        "policy(self)",
        (
            "frames.packed = lambda _: ([('weight_0', '<f8', [10**6, 10**6])], bytes(8)); return "
            "Policy(action_offset=numpy.zeros(3), action_scale=numpy.ones(3))"
        ),
        "agent-frames",
        "do not fit their bytes",
    ),
    Ending(
        "sends no policy",
        "policy(self)",
        (
            "frames.packed = lambda _: ([('weight_0', '<f8', [1])], bytes(8)); return "
            "Policy(action_offset=numpy.zeros(3), action_scale=numpy.ones(3))"
        ),
        "bad-policy",
        "is missing",
    ),
    Ending(
        "returns another policy each time",
        "policy(self)",
        (
            "return Policy(action_offset=numpy.random.default_rng().uniform(-1, 1, 3), "
            "action_scale=numpy.ones(3))"
        ),
        "policy-differs",
        "differ from act()",
    ),
    Ending(
        "writes no checkpoint",
        "save(self, path)",
        "pass\n    def load(self, path): pass",
        "agent-failed",
        "save() did not write the file",
    ),
    Ending(
        "cannot load what it saved",
        "save(self, path)",
        "path.touch()\n    def load(self, path): 1 / 0",
        "agent-failed",
        "load(): The agent raised BenchError",
    ),
    Ending(
        "states a strange card",
        "card(self)",
        "frames.json.dumps = lambda *_, **__: '{\"algorithm\": 1}'; return Card('x')",
        "bad-card",
        "cannot be read",
    ),
    Ending(
        "returns NaN in training",
        "learn(self, env, steps)",
        "env.reset(); env.step(numpy.full((env.num_envs, 3), numpy.nan))",
        "bad-actions",
        "The agent returned nan as an action",
    ),
    Ending(
        "returns wrong shapes in training",
        "learn(self, env, steps)",
        "env.reset(); env.step(numpy.zeros(7))",
        "agent-failed",
        "numbers of shape (1, 3), one row per environment; they have the shape (7,)",
    ),
    Ending(
        "returns text in training",
        "learn(self, env, steps)",
        "env.reset(); env.step('left')",
        "agent-failed",
        "they have the shape () and the dtype <U4",
    ),
    Ending(
        "returns wrong shapes in evaluation",
        "act(self, observations)",
        "return numpy.zeros(7)",
        "agent-failed",
        "act(): The agent raised ValueError: Actions are numbers of shape (1, 3)",
    ),
    Ending(
        "fails while it trains",
        "learn(self, env, steps)",
        (
            "env.reset(); [env.step(numpy.zeros((env.num_envs, 3))) for _ in range(20)]; raise "
            "ValueError('too late')"
        ),
        "agent-failed",
        ("learn(), stage 1, after 20 of 1,000 steps: The agent raised ValueError: too late (agent.py, line"),
    ),
    Ending(
        "takes ten times the steps",
        "learn(self, env, steps)",
        "env.reset(); [env.step(numpy.zeros((env.num_envs, 3))) for _ in range(10 * steps)]",
        "budget-exceeded",
        "its budget is 1000",
    ),
    Ending(
        "hides steps behind resets",
        "learn(self, env, steps)",
        "while True: env.reset(); env.step(numpy.zeros((env.num_envs, 3)))",
        "budget-exceeded",
        "its budget is 1000",
    ),
    Ending(
        "resets for ever",
        "learn(self, env, steps)",
        "while True: env.reset()",
        "too-many-resets",
        "The agent reset 1,101 environments",
    ),
    Ending(
        "asks for the stage unasked",
        "learn(self, env, steps)",
        "env.stage",
        "agent-failed",
        "observes.boundaries",
    ),
)
"""Agents that end with an error; each has a box of its own."""


def agent_file(ending: Ending) -> str:
    """The file of an agent that does this."""
    imports = f"{PREAMBLE}{FRAMES}from gym_extensions.baselines import Card, Policy\n{BODY}"
    if not ending.method:
        return f"{imports}\n\n{ending.program}\n"
    return f"{imports}    def {ending.method}:\n        {ending.program}\n"
