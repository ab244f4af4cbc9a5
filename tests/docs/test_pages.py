# SPDX-License-Identifier: Apache-2.0
"""What the pages name is there: files, headings, each other, and a row for every long proof."""
import pathlib
import re
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("**/*.md"))]
LINK = re.compile(r"\]\(([^)\s]+)\)")


def text_of(page):
    """Without blocks of code."""
    return re.sub(r"^```.*?^```", "", page.read_text(encoding="utf-8"), flags=re.M | re.S)


def anchors_of(page):
    """The names that headings have as targets of links."""
    headings = re.findall(r"^#+ (.*)$", text_of(page), re.M)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


class Pages(unittest.TestCase):
    def test_links_lead_to_files_and_headings_that_are_there(self):
        for page in PAGES:
            for link in LINK.findall(text_of(page)):
                if re.match(r"[a-z]+:", link):
                    continue
                path, _, anchor = link.partition("#")
                target = (page.parent / path).resolve() if path else page
                with self.subTest(page=page.name, link=link):
                    self.assertTrue(target.exists())
                    if anchor and target.suffix == ".md":
                        self.assertIn(anchor, anchors_of(target))

    def test_source_files_that_the_pages_name_are_there(self):
        named = re.compile(r"`((?:anfis|base|calib|db|hal|nav|settings|station|tests|tools|web|bench)/[\w./-]+\.(?:cpp|h|py|mjs|toml))`")
        for page in PAGES:
            for path in named.findall(page.read_text(encoding="utf-8")):
                with self.subTest(page=page.name, path=path):
                    self.assertTrue((ROOT / path).exists())

    def test_the_entry_page_leads_to_every_page(self):
        entry = ROOT / "docs" / "README.md"
        linked = {(entry.parent / link.partition("#")[0]).resolve() for link in LINK.findall(text_of(entry))}
        for page in (ROOT / "docs").glob("*.md"):
            with self.subTest(page=page.name):
                self.assertTrue(page == entry or page.resolve() in linked)

    def test_every_long_proof_has_a_row(self):
        rows = re.findall(r"^\| `([\w-]+)` \|", (ROOT / "docs" / "proofs.md").read_text(encoding="utf-8"), re.M)
        proofs = {path.name for path in (ROOT / "tools" / "prove").iterdir() if path.is_file()}
        self.assertEqual(set(rows), proofs)


if __name__ == "__main__":
    unittest.main()
