# Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
"""Checks every link, anchor and image of a built book: `python3 .ci/check_book.py target/book`."""
import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

# Pages that mdBook derives from the others.
DERIVED = {"print.html", "toc.html", "404.html"}


class Page(HTMLParser):
    def __init__(self, path):
        super().__init__()
        self.links, self.anchors = [], set()
        self.feed(path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag, attributes):
        for name, value in attributes:
            if name in ("href", "src") and value:
                self.links.append(value)
            elif name == "id" or (tag == "a" and name == "name"):
                self.anchors.add(value)


def error(book, page, link, pages):
    parts = urlsplit(link)
    if parts.scheme or parts.netloc:
        return None
    target = (page.parent / unquote(parts.path)).resolve() if parts.path else page
    if not target.is_relative_to(book):
        return "leaves the book"
    if target.is_dir():
        target /= "index.html"
    if not target.is_file():
        return "no such file"
    # Links to the source of a page are not built.
    if target.suffix == ".md":
        return "is not a page of the book"
    anchor = unquote(parts.fragment)
    if anchor and target in pages and anchor not in pages[target].anchors:
        return "no such heading"
    return None


def main():
    book = Path(sys.argv[1]).resolve()
    pages = {path: Page(path) for path in book.rglob("*.html") if path.name not in DERIVED}
    count, wrong = 0, []
    for path, page in sorted(pages.items()):
        for link in page.links:
            count += 1
            if reason := error(book, path, link, pages):
                wrong.append(f"{path.relative_to(book)}: {link}: {reason}")
    print(*wrong, sep="\n", end="\n" if wrong else "")
    print(f"{len(pages)} pages, {count} links, {len(wrong)} wrong")
    return 1 if wrong or count < 1000 else 0


sys.exit(main())
