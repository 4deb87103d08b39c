"""Runs all tests, or those that are named. With --results FILE it writes how many there were, for scripts/count_tests.py."""

import argparse
import json
import sys
import unittest
from pathlib import Path


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--results", type=Path)
    parser.add_argument("names", nargs="*")
    options = parser.parse_args()
    loader = unittest.TestLoader()
    folder = Path(__file__).parent
    tests = loader.loadTestsFromNames(options.names) if options.names else loader.discover(folder, top_level_dir=folder.parent)
    result = unittest.TextTestRunner(verbosity=1).run(tests)
    if options.results:
        options.results.parent.mkdir(parents=True, exist_ok=True)
        failed = len(result.failures) + len(result.errors)
        counts = {"tests": result.testsRun, "failures": failed, "disabled": len(result.skipped)}
        options.results.write_text(json.dumps(counts))
    return 0 if result.wasSuccessful() else 1


sys.exit(main())
