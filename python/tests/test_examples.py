"""Each example of examples/python and docs/python.md, against an island like the demo."""

import json
import re
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

from .island import PROGRAMS, PYTHONPATH, ROOT, Island, needs_island

EXAMPLES = ROOT / "examples/python"
DEMO = (ROOT / "examples/home.yaml").read_text().replace("file: recordings/", f"file: {ROOT}/examples/recordings/")


def installed(*names):
    import importlib.util

    return all(importlib.util.find_spec(name) for name in names)


@needs_island
class Examples(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = Path(tempfile.mkdtemp(prefix="rubicon-python-"))
        recording = ROOT / "examples/recordings/demo_hour.rec"
        subprocess.run([str(PROGRAMS / "rubicon"), "history", "demo.history", "import", str(recording), "--end", "now"],
                       cwd=folder, check=True, capture_output=True)
        text = re.sub(r"\n  salad:.*", "\n", DEMO, flags=re.S)
        cls.island = Island("history={file: demo.history}", text=text, folder=folder)

    @classmethod
    def tearDownClass(cls):
        cls.island.end()

    def run_program(self, *words, code=0):
        environment = {**self.island.environment, "PYTHONPATH": PYTHONPATH}
        done = subprocess.run([sys.executable, *words], cwd=self.island.folder, env=environment, text=True, timeout=120,
                              capture_output=True)
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        return done.stdout

    def run_example(self, name, *words, code=0):
        return self.run_program("-W", "error", str(EXAMPLES / name), *words, code=code)

    def test_list(self):
        self.assertRegex(self.run_example("list.py"), r"6541 home: 9 devices.*\n(.*\n)*proxy.log-flat.kitchen  Kitchen air")
        self.assertIn("light-1", self.run_example("list.py", "living"))

    def test_watch(self):
        lines = self.run_example("watch.py", "living.*", "3").splitlines()
        self.assertEqual(len(lines), 3)
        self.assertRegex(lines[0], r"^\d\d:\d\d:\d\d  living\.")

    def test_command(self):
        self.assertEqual(self.run_example("command.py", "living.lamp-1", "on"), "confirmed \n")
        self.assertIn("refused", self.run_example("command.py", "living.lamp-1", "purple", code=1))
        self.run_example("command.py", "livng.lamp-1", "on", code=1)

    @unittest.skipUnless(installed("pandas", "matplotlib"), "pandas or matplotlib is not installed")
    def test_history(self):
        self.assertIn("mean", self.run_program(str(EXAMPLES / "history.py")))
        self.assertTrue((self.island.folder / "temperatures.png").read_bytes().startswith(b"\x89PNG"))
        rows = (self.island.folder / "temperatures.csv").read_text().splitlines()
        self.assertGreater(len(rows), 55)

    @unittest.skipUnless(installed("rubicon._native"), "the native module is not built")
    def test_component(self):
        self.assertIn("warmest: ", self.run_example("component.py", "1"))

    def test_the_notebook_has_no_outputs(self):
        for cell in json.loads((EXAMPLES / "notebook.ipynb").read_text())["cells"]:
            self.assertFalse(cell.get("outputs"))

    @unittest.skipUnless(installed("nbclient", "ipykernel", "pandas", "matplotlib"), "nbclient is not installed")
    def test_the_notebook(self):
        code = ("import nbformat, nbclient, sys\nnotebook = nbformat.read(sys.argv[1], 4)\n"
                "nbclient.NotebookClient(notebook, timeout=100).execute()\n"
                "kinds = [kind for cell in notebook.cells for one in cell.get('outputs', ()) for kind in one.get('data', ())]\n"
                "print(kinds.count('text/html'), kinds.count('image/png'))")
        self.assertEqual(self.run_program("-c", code, str(EXAMPLES / "notebook.ipynb")), "2 1\n")

    @unittest.skipUnless(installed("pandas"), "pandas is not installed")
    def test_the_measurements_run(self):
        figures = json.loads(self.run_program("-W", "error", str(ROOT / "bench/python/rubicon-bench-python"), "--rounds", "3",
                                              "--runs", "1", "--programs", str(PROGRAMS)))
        self.assertGreater(figures["updates_per_s"], 0)
        self.assertGreater(figures["million_points_to_frame_s"], 0)
        self.assertEqual(installed("rubicon._native"), "native_updates_per_s" in figures)

    def test_the_page(self):
        """What stands in docs/python.md as a program runs."""
        blocks = re.findall(r"```python\n(.*?)```", (ROOT / "docs/python.md").read_text(), re.S)
        self.assertGreater(len(blocks), 4)
        for block in blocks:
            if "join(" in block and not installed("rubicon._native"):
                continue
            if "history(" in block and not installed("pandas"):
                continue
            with self.subTest(block):
                if re.search(r"^(async for|async with|.*await )", block, re.M) and "async def main" not in block:
                    body = "".join(f"    {line}\n" for line in block.splitlines())
                    block = f"import rubicon, rubicon.sync\nasync def main():\n{body}\nrubicon.run(main())\n"
                self.run_program("-c", block)


if __name__ == "__main__":
    unittest.main()
