#!/usr/bin/env python3
"""A preprocessor of mdBook: the pages are written to be read in the repository, too.

* Blocks of `math` become what MathJax reads.
* Links to files outside docs/ become their names: the book does not hold these files.
* ARCHITECTURE.md, which the book includes, names pages from the root of the repository.
"""

import json
import posixpath
import re
import sys

MATH = re.compile(r"^```math\n(.*?)^```$", re.MULTILINE | re.DOTALL)
FENCED = re.compile(r"(^```.*?^```$)", re.MULTILINE | re.DOTALL)
LINK = re.compile(r"\[([^\]]+)\]\(([^)\s]+)\)")


def named(path, match):
    """A link as it is, or as the name of the file if that is not in the book."""
    words, target = match[1], match[2].removeprefix("docs/")
    if re.match(r"[a-z]+:", target) or target.startswith("#"):
        return match[0]
    place = posixpath.normpath(posixpath.join(posixpath.dirname(path), target))
    if not place.startswith("../"):
        return f"[{words}]({target})"
    place = place.removeprefix("../")
    return f"`{place}`" if posixpath.basename(place).startswith(words) or words == place else f"{words} (`{place}`)"


def converted(path, text):
    """A page as the book has it."""
    text = MATH.sub(lambda match: "\\\\[ " + re.sub(r"\s*\n\s*", " ", escaped(match[1])) + " \\\\]", text)
    pieces = FENCED.split(text)
    pieces[::2] = [LINK.sub(lambda match: named(path, match), piece) for piece in pieces[::2]]
    return "".join(pieces)


def escaped(formula):
    """Markdown takes backslashes, underscores and asterisks for its own."""
    return re.sub(r"([\\_*])", r"\\\1", formula)


def convert(items):
    """All chapters below."""
    for item in items:
        chapter = item.get("Chapter") if isinstance(item, dict) else None
        if chapter:
            chapter["content"] = converted(chapter.get("path") or "", chapter["content"])
            convert(chapter["sub_items"])


if __name__ == "__main__":
    if sys.argv[1:2] == ["supports"]:
        sys.exit(0)
    _, book = json.load(sys.stdin)
    convert(book.get("sections") or book.get("items") or [])
    json.dump(book, sys.stdout)
