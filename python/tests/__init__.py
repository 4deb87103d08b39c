"""Tests of the Python package: python3 -W error -m unittest discover -t python python/tests

Real programs are looked for in RUBICON_PROGRAMS, else in build/dev/bin. They run in a private network."""
