"""The package itself: types, what it imports, and its documentation."""

import inspect
import subprocess
import sys
import unittest

import rubicon
import rubicon.sync

from .island import ROOT


class Package(unittest.TestCase):
    def test_its_types_are_strict(self):
        try:
            import mypy  # noqa: F401
        except ImportError:
            self.skipTest("mypy is not installed")
        done = subprocess.run([sys.executable, "-m", "mypy", "--cache-dir", "/dev/null"], cwd=ROOT / "python",
                              capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stdout)

    def test_pandas_comes_only_when_asked_for(self):
        code = "import sys, rubicon; print([one for one in ('pandas', 'numpy', 'websockets', 'ssl') if one in sys.modules])"
        done = subprocess.run([sys.executable, "-W", "error", "-c", code], cwd=ROOT / "python", check=True,
                              capture_output=True, text=True)
        self.assertIn(done.stdout.strip(), ("[]", "['ssl']"), "asyncio imports ssl")

    def test_whatever_is_public_is_documented(self):
        for name in rubicon.__all__:
            self.assertTrue(inspect.getdoc(getattr(rubicon, name)), name)
        for name, call in inspect.getmembers(rubicon.Space, inspect.isfunction):
            if not name.startswith("_"):
                self.assertTrue(inspect.getdoc(call) or name == "open", name)

    def test_lines_and_files_fit(self):
        for file in (ROOT / "python").rglob("*.py"):
            for number, line in enumerate(file.read_text().splitlines(), 1):
                self.assertLessEqual(len(line), 130, f"{file}:{number}")
            self.assertLessEqual(number, 500, file)


if __name__ == "__main__":
    unittest.main()
