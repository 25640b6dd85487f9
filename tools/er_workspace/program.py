"""Runs a module as `python -m` does; Ctrl-C ends it with one line, also while it is still being imported."""

import sys

INTERRUPTED = 130

if __name__ == "__main__":
    try:
        import os
        import runpy

        # as `python -m` has it: modules of this folder are not the program's
        sys.path[0] = os.getcwd()
        del sys.argv[0]
        runpy.run_module(sys.argv[0], run_name="__main__", alter_sys=True)
    except KeyboardInterrupt:
        sys.stderr.write("interrupted\n")
        sys.exit(INTERRUPTED)
