"""An interrupt while modules load ends a node in order, whatever a library does with KeyboardInterrupt."""

import subprocess
import sys

import pytest

INTERRUPTED = """
import os, signal, sys

class Interrupting:
    '''The import of a module, during which the signal comes.'''

    def find_spec(self, name, path, target=None):
        if name == "scipy.special":
            {what}

sys.meta_path.insert(0, Interrupting())
from wheelset_track_sim.cli import main
sys.exit(main({arguments}))
"""
PASSED_ON = "exec('os.kill(os.getpid(), signal.SIGINT)')"
SWALLOWED = f"exec('''try:\n  {PASSED_ON}\nexcept KeyboardInterrupt: pass''')"


@pytest.mark.parametrize("what", [PASSED_ON, SWALLOWED], ids=["passed on", "swallowed"])
@pytest.mark.parametrize("arguments", [["node"], ["replay", "none.mcap"]])
def test_an_interrupt_while_modules_load(arguments, what):
    code = INTERRUPTED.format(what=what, arguments=arguments)
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=100)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
