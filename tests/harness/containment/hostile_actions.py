"""What hostile candidates of the tests do: statements that may stand anywhere in a candidate in Python.

None of them harms the machine, or a process that the candidate has not started, but for its own keeper.
"""

from typing import Final

PLACES: Final = ("import", "construction", "reset", "step", "deletion", "exit")
"""Where a candidate does what it does."""

CANDIDATE: Final = """
import atexit, builtins, ctypes, ctypes.util, faulthandler, gc, locale, mmap, multiprocessing, os, pickle, resource
import shutil, signal, socket, struct, subprocess, sys, tempfile, threading, time, warnings
import numpy as np
import drivegate
from drivegate import Command

MARK = {mark!r}
HEADER = struct.Struct("=8sqqqqq16s")

def descriptors():
    return [int(name) for name in os.listdir("/proc/self/fd")]

def connection():
    for number in descriptors():
        try:
            found = socket.socket(fileno=os.dup(number))
        except OSError:
            continue
        if found.family == socket.AF_UNIX and found.type == socket.SOCK_SEQPACKET:
            return found

def shared_places():
    for line in open("/proc/self/maps"):
        if "memfd:drivegate" in line:
            begin, end = (int(number, 16) for number in line.split()[0].split("-"))
            yield begin, end - begin

def scribble(value):
    for begin, size in shared_places():
        ctypes.memset(begin, value, size)

def for_ever():
    while True:
        pass

def in_a_thread(task):
    threading.Thread(target=task).start()

def write_into(number):
    try:
        os.set_blocking(number, False)
        os.write(number, b"garbage" * 99)
    except OSError:
        pass

def raise_in_handler(*_):
    raise InterruptedError("alarm")

def hostile():
{action}

if {place!r} == "import":
    hostile()
if {place!r} == "exit":
    atexit.register(hostile)

class Mine:
    def __init__(self):
        self.count = 0
        if {place!r} == "construction":
            hostile()

    def reset(self, nameplate):
        self.count = 0
        if {place!r} == "reset":
            hostile()

    def step(self, sense):
        self.count += 1
        if {place!r} == "step" and self.count == 5:
            hostile()
        return Command(*map(float, {early!r} if self.count < 200 else {late!r}))

    def __del__(self):
        if {place!r} == "deletion":
            hostile()
"""
"""The source of a candidate, with places for an action, and for the commands before and after some time."""

ACTIONS: Final[dict[str, str]] = {
    "nothing": "pass",
    # Errors of every kind.
    "a long message": "raise ValueError('x' * 10**7)",
    "control characters": "raise ValueError('\\x1b[31m<script>\\0\\ud800' * 99)",
    "a message that raises": "raise type('E', (Exception,), {'__str__': lambda self: 1 / 0})()",
    "a name that is none": "raise type('a\\nb' * 99, (Exception,), {})()",
    "sys.exit": "sys.exit(0)",
    "interrupt": "raise KeyboardInterrupt",
    "no memory": "raise MemoryError",
    "a refusal": "from drivegate_models.errors import InputError; raise InputError('no\\nsuch' * 9999)",
    "a fault that is none": "from drivegate.candidates.fault import CandidateFault; raise CandidateFault(None)",
    "a fault of the harness": "from drivegate_models.errors import HarnessFault; raise HarnessFault('mine')",
    "recursion": "hostile()",
    "an endless chain": "first, second = ValueError(), KeyError(); second.__cause__ = first; raise first from second",
    # Ends of its process.
    "os._exit 0": "os._exit(0)",
    "os._exit 119": "os._exit(119)",
    "abort": "os.abort()",
    "kill": "os.kill(os.getpid(), 9)",
    "stop": "os.kill(os.getpid(), signal.SIGSTOP)",
    "null": "ctypes.string_at(0)",
    "None overwritten": "ctypes.memset(id(None), 0xFF, 16)",
    "C library's exit": "ctypes.CDLL(None).exit(0)",
    # No end.
    "loop": "for_ever()",
    "sleep": "time.sleep(1e6)",
    "a thread that sleeps": "in_a_thread(lambda: time.sleep(1e6))",
    "a thread that loops": "in_a_thread(for_ever)",
    "an alarm": "signal.signal(signal.SIGALRM, raise_in_handler); signal.setitimer(signal.ITIMER_REAL, 1e-3, 1e-3)",
    "an alarm's default": "signal.setitimer(signal.ITIMER_REAL, 1e-3)",
    "signals ignored": "[signal.signal(n, signal.SIG_IGN) for n in (1, 2, 10, 13, 14, 15)]",
    "an end put off": "faulthandler.dump_traceback_later(0.05, exit=True)",
    # Further processes.
    "a copy that goes on": "os.fork()",
    "a copy that stays": "os.fork() or time.sleep(1e6)",
    "a daemon": "subprocess.Popen(['setsid', 'sleep', '54322'], env={'TMPDIR': MARK}, start_new_session=True)",
    "multiprocessing": "multiprocessing.get_context('fork').Process(target=for_ever, daemon=True).start()",
    "joblib": "import joblib; joblib.Parallel(n_jobs=2)(joblib.delayed(abs)(np.ones(300_000)) for _ in range(2))",
    "its keeper killed": "os.kill(os.getppid(), 9)",
    "its keeper interrupted": "os.kill(os.getppid(), signal.SIGTERM)",
    # What the system gives it.
    "all closed": "os.closerange(0, 256)",
    "its own closed": "os.closerange(3, 256)",
    "garbage everywhere": "for n in descriptors(): write_into(n)",
    "zeros instead": "zero = os.open('/dev/zero', os.O_RDWR)\nfor n in descriptors(): os.dup2(zero, n)",
    "folder": "os.chdir('/')",
    "a folder that is gone": "here = tempfile.mkdtemp(); os.chdir(here); os.rmdir(here)",
    "root": "os.chroot(tempfile.mkdtemp())",
    "environment": "os.environ.clear()",
    "no descriptors": "resource.setrlimit(resource.RLIMIT_NOFILE, (3, 3))",
    "no files": "resource.setrlimit(resource.RLIMIT_FSIZE, (0, 0))",
    "no memory left": "resource.setrlimit(resource.RLIMIT_AS, (2**20, 2**20))",
    "no time": "resource.setrlimit(resource.RLIMIT_CPU, (1, 1))",
    "ten gigabytes": "bytearray(10 * 2**30)",
    "memory bit by bit": "kept = []\nwhile True: kept.append(bytes(2**24))",
    "megabytes printed": "print('\\x1b[2J' * 10**6); sys.stderr.write('y' * 10**6)",
    "temporary files": "folder = tempfile.mkdtemp(); open(folder + '/left', 'w').close(); os.chmod(folder, 0)",
    "no temporary folder": "shutil.rmtree(tempfile.gettempdir())",
    "umask": "os.umask(0o777)",
    "shared memory": "open('/dev/shm/' + MARK, 'wb').write(bytes(4096))",
    "semaphores": "import _multiprocessing as m; m.SemLock(1, 1, 1, '/' + MARK, False)",
    "shared memory full": "open('/dev/shm/' + MARK, 'wb').write(bytes(2**21))\nfor _ in range(2000): os.sched_yield()",
    # What it shares with its judge.
    "ones in shared memory": "scribble(0xFF)",
    "zeros in shared memory": "scribble(0)",
    "small numbers in shared memory": "scribble(3)",
    "shared memory all the time": "in_a_thread(lambda: [(scribble(1), time.sleep(1e-3)) for _ in range(10**6)])",
    "a short packet": "connection().send(b'x')",
    "a long packet": "connection().send(b'\\xff' * 150_000)",
    "a forged reply": "connection().send(HEADER.pack(b'drivegat', 0, 0, 2**62, 0, 0, b''))",
    "a forged stop": "connection().send(HEADER.pack(b'drivegat', 0, 1, 2**62, 0, 2**62, b''))",
    "a forged fault": "connection().send(HEADER.pack(b'drivegat', 1, 0, 0, 0, 0, b'') + b'[' * 100_000)",
    "a forged refusal": "connection().send(HEADER.pack(b'drivegat', 2, 0, 0, 0, 0, b'') + b'\\x1b' * 99)",
    "a forged breakdown": "connection().send(HEADER.pack(b'drivegat', 3, 0, 0, 0, 0, b'') + b'mine')",
    "many packets": "for _ in range(10**4): write_into(connection().fileno())",
    "half a connection": "connection().shutdown(socket.SHUT_WR)",
    "a connection drained": "c = connection(); c.setblocking(True); in_a_thread(lambda: c.recv(9999))",
    # What its process is made of.
    "modules gone": "sys.modules.clear()",
    "builtins gone": "vars(builtins).clear()",
    "streams gone": "sys.stdout = sys.stderr = None",
    "numpy broken": "np.frombuffer = np.empty = np.zeros = np.ascontiguousarray = None",
    "floating point errors": "np.seterr(all='raise'); warnings.simplefilter('error')",
    "a tracer that raises": "sys.settrace(lambda *a: 1 / 0); sys.setprofile(lambda *a: 1 / 0)",
    "shallow stack": "sys.setrecursionlimit(30)",
    "Command replaced": "drivegate.Command = globals()['Command'] = lambda *numbers: numbers",
    "the command's size": "from drivegate.candidates.python.bridge import _Steps; _Steps.step = lambda *a: None",
    "drivegate's reply replaced": "import drivegate.containment.serving as s; s.packed = lambda reply: b'y' * 10**5",
    "collector": "gc.disable(); gc.freeze(); gc.callbacks.append(lambda *a: 1 / 0)",
    "a finaliser": "Mine.again = type('Again', (), {'__del__': lambda self: for_ever()})()",
}
"""What a candidate does, by a name for it."""

NATIVE_PLACES: Final = ("import", "version", "size", "reset", "step", "exit")
"""Where a candidate in C does what it does."""

NATIVE: Final = """
#define _GNU_SOURCE
#include <fenv.h>
#include <math.h>
#include <pthread.h>
#include <setjmp.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <drivegate.h>
enum {{ IMPORT, VERSION, SIZE, RESET, STEP, EXIT }};
static int count;
static jmp_buf nowhere;
static volatile int zero;
static void *for_ever(void *given) {{ for (;;) {{ zero = 0; }} return given; }}
static int deeper(int depth) {{ volatile char room[4096]; room[0] = 1; return deeper(depth + 1) + room[0]; }}
static void hostile(void *state, const drivegate_sense *sense, drivegate_command *command) {{
    char room[64];
    {action}
    (void)state, (void)sense, (void)command, (void)room, (void)for_ever, (void)deeper, (void)nowhere;
}}
static void at(int place, void *state, const drivegate_sense *sense, drivegate_command *command) {{
    if (place == {place}) {{ hostile(state ? state : malloc(64), sense, command); }}
}}
__attribute__((constructor)) static void loaded(void) {{ at(IMPORT, 0, 0, 0); }}
__attribute__((destructor)) static void unloaded(void) {{ at(EXIT, 0, 0, 0); }}
int64_t drivegate_abi_version(void) {{ at(VERSION, 0, 0, 0); return DRIVEGATE_ABI_VERSION; }}
int64_t drivegate_state_size(void) {{ at(SIZE, 0, 0, 0); return {size}; }}
int drivegate_reset(void *state, const drivegate_nameplate *nameplate) {{
    (void)nameplate; count = 0; at(RESET, state, 0, 0); return 0;
}}
void drivegate_step(void *state, const drivegate_sense *sense, drivegate_command *command) {{
    if (++count == 5) {{ at(STEP, state, sense, command); }}
    command->current_reference = 3.0;
    command->advance_angle = 0.5;
}}
"""
"""The source of a candidate in C, with places for an action and the size of its state."""

NATIVE_ACTIONS: Final[dict[str, str]] = {
    "exit": "exit(0);",
    "quick end": "_exit(0);",
    "abort": "abort();",
    "stop": "raise(SIGSTOP);",
    "copies": "fork();",
    "loop": "for_ever(0);",
    "a thread that loops": "pthread_t thread; pthread_create(&thread, 0, for_ever, 0);",
    "a jump to nowhere": "longjmp(nowhere, 1);",
    "deep recursion": "zero = deeper(0);",
    "its stack overwritten": "memset(room, 0xff, 4096);",
    "memory around its state": "memset((char *)state - 512, 0xff, 4096);",
    "memory far around its state": "memset((char *)state - 65536, 0x41, 131072);",
    "a state freed": "free(state);",
    "memory freed twice": "void *given = malloc(8); free(given); free(given);",
    "the Sense overwritten": "if (sense) memset((void *)sense, 0x41, 256);",
    "the Command overwritten": "if (command) memset(command, 0x41, 65536);",
    "the currents overwritten": "if (sense) memset((void *)sense->phase_currents, 0x7f, 4096);",
    "the size of the Command": "if (command) command->struct_size = -1;",
    "nothing answered": "return;",
    "rounding upward": "fesetround(FE_UPWARD);",
    "floating point traps": "feenableexcept(FE_ALL_EXCEPT);",
    "integer division": "zero = 1 / zero;",
    "all closed": "for (int n = 0; n < 256; n++) close(n);",
    "garbage everywhere": 'for (int n = 3; n < 256; n++) zero = (int)write(n, "garbage", 7);',
    "allocation": "for (;;) memset(malloc(1 << 24), 1, 1 << 24);",
}
"""What a candidate in C does, by a name for it."""
