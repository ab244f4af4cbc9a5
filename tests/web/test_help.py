# SPDX-License-Identifier: Apache-2.0
"""The Help in the page: the guide and what a technician needs beside it, in place, without a network, each link leading somewhere."""
import html.parser
import pathlib
import re
import unittest
import urllib.parse
import urllib.request

from page_test import PageTest

DOCS = pathlib.Path(__file__).resolve().parents[2] / "docs"
WIDTHS = (320, 390, 800, 1280)


class Fragment(html.parser.HTMLParser):
    """Names, links and words of a page of the Help."""

    def __init__(self, text):
        super().__init__()
        self.ids, self.links, self.words, self.tags = [], [], "", set()
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        self.tags.add(tag)
        for name, value in attributes:
            if name == "id":
                self.ids.append(value)
            if name == "href":
                self.links.append(value)
            assert name != "style" and not name.startswith("on"), (tag, name)

    def handle_data(self, data):
        self.words += data


class Help(PageTest):
    def fragment(self, name):
        with urllib.request.urlopen(f"{self.station.url}help-{name}.html", timeout=30) as answer:
            self.assertEqual(answer.headers["Content-Type"], "text/html; charset=utf-8")
            return Fragment(answer.read().decode())

    def pages(self):
        """All pages of the Help: name → Fragment."""
        links = self.fragment("guide").links
        names = {urllib.parse.parse_qs(link[1:])["help"][0] for link in links if link.startswith("#help=") and "&" not in link}
        return {name: self.fragment(name) for name in sorted(names)}

    def test_every_link_leads_to_a_page_and_a_heading_that_are_there(self):
        pages = self.pages()
        self.assertLessEqual({"guide", "operations", "campaigns", "safety", "report"}, set(pages))
        followed = 0
        for name, page in pages.items():
            self.assertEqual(len(page.ids), len(set(page.ids)), name)
            for link in page.links:
                if link.startswith("https://"):
                    continue
                parts = urllib.parse.parse_qs(link[1:], strict_parsing=True)
                with self.subTest(page=name, link=link):
                    self.assertIn(parts["help"][0], pages)
                    for heading in parts.get("at", []):
                        followed += 1
                        self.assertIn(f"at-{heading}", pages[parts["help"][0]].ids)
        self.assertGreater(followed, 100)
        self.assertIn("#help=file-formats", pages["guide"].links)

    def test_it_says_what_the_pages_of_docs_say(self):
        for name, page in self.pages().items():
            text = (DOCS / f"{name}.md").read_text(encoding="utf-8")
            for heading in re.findall(r"^#+ ([^`*\[\]\n]+)$", re.sub(r"^```.*?^```", "", text, flags=re.M | re.S), re.M):
                self.assertIn(heading, page.words, name)
            self.assertEqual("table" in page.tags, "\n| --- " in text, name)
            self.assertEqual("script" in page.tags, False)

    def test_it_opens_from_every_view_and_goes_from_page_to_page(self):
        self.open()
        for view in ("runs", "units", "station"):
            self.browser.run("location.hash = arguments[0]", view)
            self.browser.click("#to-help")
            self.see("#help-page article h3", "Guide")
            self.assertEqual(self.browser.run("return document.querySelector('[aria-current=page]').id"), "to-help")
        self.browser.wait("""const top = document.getElementById('at-from-the-browser').getBoundingClientRect().top;
            return top >= document.querySelector('header.top').getBoundingClientRect().bottom && top < innerHeight;""")
        self.browser.console()  # the scripted station has no data folder for those views to read
        self.browser.run("document.querySelector('#help-page nav a[href=\"#help=operations\"]').click()")
        self.see("#help-page article h3", "Operating a station")
        self.browser.click('#help-page article a[href="#help=operations&at=a-full-disk"]')
        self.browser.wait("return document.activeElement.id === 'at-a-full-disk'")
        top, head = self.browser.run("""return [document.activeElement.getBoundingClientRect().top,
                                                document.querySelector('header.top').getBoundingClientRect().bottom]""")
        self.assertGreaterEqual(top, head)
        self.assertLess(top, 600)
        self.browser.run("history.back()")
        self.browser.wait("return location.hash === '#help=operations'")
        resources = self.browser.run("return performance.getEntriesByType('resource').map(entry => entry.name)")
        self.assertEqual([name for name in resources if not name.startswith(self.station.url)], [])
        self.assertEqual(self.browser.console(), [])

    def test_alarms_stay_in_sight_over_it(self):
        self.station.set("/chamber/alarms", ["over-temperature"])
        self.browser.go(self.station.url + "#help=campaigns")
        self.see("#help-page article h3", "Campaigns")
        self.see("#alert-list", "over-temperature")

    def test_a_page_that_is_not_there_is_named(self):
        self.browser.go(self.station.url + "#help=nowhere")
        self.see("#help-failure", 'no page "nowhere"')

    def test_a_station_that_does_not_answer_is_said_in_words(self):
        self.browser.go(self.station.url + "#help=guide")
        self.see("#help-page article h3", "Guide")
        self.station.close()
        self.browser.run("location.hash = 'help=operations'")
        self.see("#help-failure", "The station does not answer")

    def test_it_fits_the_screen_and_its_pictures_load(self):
        self.browser.go(self.station.url + "#help=gap-workflow")
        self.browser.wait("return document.querySelectorAll('#help-page img').length === 3")
        self.browser.wait("return [...document.querySelectorAll('#help-page img')].every((image) => image.naturalWidth > 100)")
        for page in ("gap-workflow", "operations", "guide", "register-maps"):
            self.browser.go(f"{self.station.url}#help={page}")
            self.browser.wait("return document.querySelector('#help-page [aria-current]')?.hash === arguments[0]", f"#help={page}")
            for width in WIDTHS:
                self.browser.resize(width, 900)
                self.assertLessEqual(self.browser.run("return document.documentElement.scrollWidth"), width, page)
        for scheme in ("dark", "light"):
            self.browser.colours(scheme)
            self.assertEqual(self.browser.poor_contrast(), [])

    def test_a_search_finds_the_chapter_by_its_words_and_leads_there(self):
        self.browser.go(f"{self.station.url}#help")
        self.browser.wait("return document.querySelector('#help-page article')")
        self.browser.type("#help-find", "change a limit")
        self.browser.wait("return document.querySelector('#help-found li')")
        self.assertEqual(self.browser.text("#help-found li:first-child a"), "Change a limit")  # whose heading has the words, before those that mention them
        self.assertTrue(self.browser.run("return document.querySelector('#help-page').hidden"))
        self.browser.click("#help-found li:first-child a")
        self.browser.wait("return location.hash === '#help=guide&at=change-a-limit' && !document.querySelector('#help-page').hidden")
        self.assertEqual(self.browser.run("return document.activeElement.id"), "at-change-a-limit")
        self.browser.type("#help-find", "qwertz no such word")
        self.see("#help-found-count", "Nothing in the Help has all of these words.")
        self.assertEqual(self.browser.console(), [])


if __name__ == "__main__":
    unittest.main()
