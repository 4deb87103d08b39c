"""Counts what ran in a build directory: prints 'PASSED FAILED'. A test program that left no results counts as failed."""
import json
import pathlib
import re
import sys

directory = pathlib.Path(sys.argv[1])
listed = set(re.findall(r"^\s*\d+/\d+ Test\s+#\d+: (\S+)", (directory / "test.log").read_text(), re.M))
failed_programs = set(re.findall(r"Test\s+#\d+: (\S+) \.+\s*\*\*\*", (directory / "test.log").read_text()))
passed = failed = 0
seen = set()
for file in (directory / "results").glob("*.json"):
    result = json.loads(file.read_text())
    seen.add(file.stem)
    passed += result["tests"] - result["failures"] - result.get("disabled", 0)
    failed += result["failures"]
for name in listed:
    if name not in seen or (name in failed_programs and failed == 0):
        failed += 1
if not listed:
    failed += 1
print(passed, failed)
