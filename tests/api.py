#!/usr/bin/env python3
"""Lists the public interface of the library from its documentation: `make check` compares
the list with tests/api.txt, so that no change of it goes unseen.

    make api && cp target/api.txt tests/api.txt

The list is of rustc 1.95, whose pages it is read from; another version may lay them out
otherwise.
"""

import html
import pathlib
import re
import sys

DECLARATION = re.compile(r'<pre class="rust item-decl"><code>(.*?)</code></pre>', re.S)
MEMBER = re.compile(r'<h[34] class="code-header">(.*?)</h[34]>', re.S)
TRAITS = 'id="trait-implementations"'
# What the compiler and the standard library implement for every type.
OTHERS = re.compile(r'id="(synthetic|blanket)-implementations"')


def text(code):
    """A piece of a page as one line of Rust."""
    # Bounds and attributes that rustdoc shows beside the code.
    code = re.sub(r'<(a|span)[^>]*class="(?:src|since|tooltip)[^>]*>.*?</\1>', "", code, flags=re.S)
    line = " ".join(html.unescape(re.sub(r"<[^>]*>", "", code)).split())
    return re.sub(r"Show \d+ \w+ ", "", line).replace("]pub", "] pub")


def of_page(page):
    """The declaration of an item, its members, and the traits it implements."""
    page = OTHERS.split(page)[0]
    own, _, traits = page.partition(TRAITS)
    yield from (text(code) for code in DECLARATION.findall(own))
    # Variants and fields stand in the declaration.
    yield from (line for line in map(text, MEMBER.findall(own)) if line.startswith(("pub ", "impl", "fn ")))
    # The methods of a trait that is implemented are known.
    yield from (line for line in map(text, MEMBER.findall(traits)) if line.startswith("impl"))


def main():
    folder = pathlib.Path(sys.argv[1])
    for path in sorted(folder.rglob("*.html")):
        name = path.relative_to(folder)
        if path.name in ("all.html", "index.html") or "macro" in path.name:
            continue
        lines = list(of_page(path.read_text(encoding="utf-8")))
        if lines:
            print("::".join(name.with_suffix("").parts))
            print("".join(f"    {line}\n" for line in lines), end="")


main()
