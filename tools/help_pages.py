# SPDX-License-Identifier: Apache-2.0
"""Turns pages of docs/ into the Help of the station's page.

help_pages.py FOLDER PAGE.md... writes FOLDER/help-NAME.html for each page: the list of all pages, in the order given, and
the text. Links between the pages become addresses of the station's page (#help=NAME&at=HEADING); a link to anything that
the Help does not hold keeps its text only. docs/decisions/0034-help.md
"""
import argparse
import collections
import html
import pathlib
import re

from markdown_it import MarkdownIt

# Under the headings of the station's page, h1 and h2.
LOWER_BY = 2


def slug(heading):
    """The name of a heading as the target of a link: that of the pages' own links."""
    return re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")


def text_of(inline):
    """What a heading says, without its marks."""
    return "".join(part.content for part in inline.children if part.type in ("text", "code_inline"))


def address(page, heading=""):
    return f"#help={page}" + (f"&at={heading}" if heading else "")


class Help:
    def __init__(self, paths):
        self.reader = MarkdownIt("commonmark", {"html": False}).enable("table")
        self.pages = {path.stem: self.reader.parse(path.read_text(encoding="utf-8")) for path in paths}
        self.titles = {name: text_of(tokens[1]) for name, tokens in self.pages.items()}

    def fragment(self, page):
        headings = self.name_headings(page)
        for token in self.pages[page]:
            token.attrs.pop("style", None)  # how columns are aligned: the page's policy forbids it
            if token.type == "inline":
                self.turn_links(page, token.children)
        text = self.reader.renderer.render(self.pages[page], self.reader.options, {})
        return f"{self.contents(page, headings)}<article>\n{text}</article>\n"

    def name_headings(self, page):
        """Gives the headings their names, and returns those of the chapters: [(name, text)]."""
        chapters, met = [], collections.Counter()
        tokens = self.pages[page]
        for begin, inline, end in zip(tokens, tokens[1:], tokens[2:]):
            if begin.type != "heading_open":
                continue
            name = slug(text_of(inline))
            met[name] += 1
            if met[name] > 1:
                name += f"-{met[name] - 1}"
            if begin.tag == "h2":
                chapters.append((name, text_of(inline)))
            begin.attrs.update({"id": f"at-{name}", "tabindex": "-1"})
            begin.tag = end.tag = f"h{int(begin.tag[1]) + LOWER_BY}"
        return chapters

    def turn_links(self, page, parts):
        kept = []
        for part, following in zip(parts, [*parts[1:], None]):
            if part.type == "image":
                part.attrs["src"] = pathlib.PurePosixPath(part.attrs["src"]).name
            if part.type == "link_open":
                target = self.target_of(page, part.attrs["href"])
                kept.append(target is not None)
                part.attrs = {"href": target} if target else {}
                if target and following.content in (f"{name}.md" for name in self.titles):
                    following.content = self.titles[following.content.removesuffix(".md")]
            if part.type in ("link_open", "link_close") and not kept[-1]:
                part.tag = "span"
            if part.type == "link_close":
                kept.pop()

    def target_of(self, page, link):
        """The address in the Help; None where it does not hold what the link leads to."""
        if re.match(r"https?:", link):
            return link
        path, _, heading = link.partition("#")
        name = path.removesuffix(".md") if path else page
        return address(name, heading) if name in self.pages else None

    def contents(self, page, chapters):
        items = []
        for name, title in self.titles.items():
            here = ' aria-current="page"' if name == page else ""
            below = "".join(f'<li><a href="{html.escape(address(page, at))}">{html.escape(text)}</a></li>\n' for at, text in chapters)
            below = f"\n<ul>\n{below}</ul>\n" if name == page and chapters else ""
            items.append(f'<li><a href="{address(name)}"{here}>{html.escape(title)}</a>{below}</li>\n')
        return f'<nav aria-label="Pages of the help">\n<ul>\n{"".join(items)}</ul>\n</nav>\n'


def main():
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("pages", type=pathlib.Path, nargs="+")
    arguments = parser.parse_args()
    arguments.folder.mkdir(parents=True, exist_ok=True)
    pages = Help(arguments.pages)
    for page in list(pages.pages):
        (arguments.folder / f"help-{page}.html").write_text(pages.fragment(page), encoding="utf-8")


if __name__ == "__main__":
    main()
