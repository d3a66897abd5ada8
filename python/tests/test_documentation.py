"""What documentation shows does what it says."""

import doctest
import re
import subprocess
import sys
from pathlib import Path

from diffuse_contact import _batch

ROOT = Path(__file__).resolve().parents[2]


def test_docstrings():
    results = doctest.testmod(_batch)
    assert results.attempted > 0 and results.failed == 0


def test_the_program_of_the_guide():
    text = (ROOT / "docs" / "how-to" / "python.md").read_text(encoding="utf-8")
    programs = re.findall(r"```python\n(.*?)```", text, flags=re.DOTALL)
    assert len(programs) == 7
    for program in programs:
        exec(compile(program, "docs/how-to/python.md", "exec"), {})


def test_the_picture(tmp_path):
    picture = tmp_path / "surface.png"
    command = [sys.executable, ROOT / "python" / "examples" / "surface.py", picture]
    text = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    count, of, error = re.match(r"(\d+) of (\d+) points lie on the surface to (\S+)", text).groups()
    assert count == of == "4225" and float(error) < 1e-6
    assert 20_000 < picture.stat().st_size < 200_000
