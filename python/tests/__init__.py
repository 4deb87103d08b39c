"""Tests of the Python package: cd python; python3 -W error -m tests

Real programs are looked for in RUBICON_PROGRAMS, else in build/dev/bin. They run in a private network."""
