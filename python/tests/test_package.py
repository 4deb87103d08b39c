"""The package itself: types, what it imports, and its documentation."""

import ast
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

    def test_lines_and_functions_fit(self):
        """As the rules of tests/structure for C++; that of the length of files is there."""
        files = [file for folder in ("python", "examples/python") for file in (ROOT / folder).rglob("*.py")]
        for file in (*files, *(ROOT / "bench/python").glob("rubicon-*")):
            text = file.read_text()
            for number, line in enumerate(text.splitlines(), 1):
                self.assertLessEqual(len(line), 130, f"{file}:{number}")
            for node in ast.walk(ast.parse(text)):
                if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)):
                    self.assertLessEqual(node.end_lineno - node.lineno, 40, f"{file}: {node.name}")


if __name__ == "__main__":
    unittest.main()
