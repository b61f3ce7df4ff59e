#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The static site of the documents is whole, loads nothing from the network, and can be searched without a server.

site_test.py --source . --out DIR   builds it in DIR (scripts/site.sh) and checks it: files, links, what pages load, the search
                                    index; with Chromium also that the search answers, that no page is wider than a phone, and
                                    the contrast of words
site_test.py --self-test            plants each fault of its files in a scratch site and proves that it is seen
Exit code 77: mkdocs is missing. No tolerances: all of it is there or not, but for the width, see WIDTH_PX.
"""
import argparse
import html.parser
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

BESIDE_DOCS = ("README.md", "CONTRIBUTING.md", "CHANGELOG.md", "datasets/README.md")
WIDTH_PX = 400  # of a small phone; what is wider is moved in its own frame, not the page
FENCED = re.compile(r"^ *```.*?^ *```", re.M | re.S)
LOADED = {("link", "href"), ("script", "src"), ("img", "src"), ("form", "action"), ("source", "src"), ("iframe", "src")}


class Page(html.parser.HTMLParser):
    """Links, anchors and text of a page, and what its body is made of; text without code."""

    def __init__(self, text):
        super().__init__()
        self.links, self.ids, self.prose, self.code, self.made = [], set(), "", 0, None
        self.listed, self.in_list = set(), False
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.code += tag in ("pre", "code", "script")
        self.in_list = self.in_list or tag == "nav"
        if tag == "main":
            self.made = dict.fromkeys(("li", "tr", "pre", "img"), 0)
        elif self.made and tag in self.made:
            self.made[tag] += 1
        for name, value in attrs:
            if name == "id":
                self.ids.add(value)
            if (tag, name) in LOADED | {("a", "href")}:
                self.links.append(((tag, name), value or ""))
                if self.in_list:
                    self.listed.add(os.path.normpath((value or "").partition("#")[0]))

    def handle_endtag(self, tag):
        self.code -= tag in ("pre", "code", "script")
        self.in_list = self.in_list and tag != "nav"

    def handle_data(self, data):
        self.prose += "`" if self.code else data


def html_of(source):
    return "index.html" if source == "README.md" else re.sub(r"README\.md$", "index.html", source).replace(".md", ".html")


def pages_of(source):
    docs = sorted(str(path.relative_to(source)) for path in (source / "docs").rglob("*.md"))
    return [page for page in (*BESIDE_DOCS, *docs) if (source / page).is_file()]


def link_faults(site, name, page, ids):
    for (tag, attribute), target in page.links:
        if target.startswith("data:"):
            continue
        if re.match(r"(\w+:)?//", target):
            if (tag, attribute) in LOADED:
                yield f"{name}: loads {target} from the network"
            continue
        path, _, anchor = target.partition("#")
        file = os.path.normpath(os.path.join(os.path.dirname(name), path)) if path else name
        if not (site / file).is_file():
            yield f"{name}: the link to {target} leads nowhere"
        elif anchor and anchor not in ids.get(file, ()):
            yield f"{name}: {target}: the page has no such place"


def made_of(text):
    """How many items, rows, blocks of code and pictures a page of Markdown has."""
    blocks = re.findall(FENCED, text)
    prose = re.sub(FENCED, "", text)
    return {"li": len(re.findall(r"^ *(?:[-*]|\d+\.) ", prose, re.M)), "tr": len(re.findall(r"^\|(?!-).*\|$", prose, re.M)),
            "pre": len(blocks), "img": len(re.findall(r"!\[", prose))}


def text_faults(name, page, text):
    if page.made != made_of(text):
        yield f"{name}: made of {page.made}, written {made_of(text)}"
    for line in page.prose.split("\n"):
        if re.match(r"\s*([-*] |\|.*\|$|```|#+ )", line):
            yield f"{name}: Markdown that was not understood: {line.strip()[:60]}"


def network_faults(site):
    for path in [*site.rglob("*.css"), *site.rglob("*.js")]:
        code = re.sub(r"^\s*//.*$", "", path.read_text("utf-8"), flags=re.M)
        if path.name != "search_index.js" and re.search(r"//\w|@import", code):
            yield f"{path.name} names an address"


def search_faults(site, sources, source):
    script = (site / "search/search_index.js").read_text("utf-8")
    places = {}
    for doc in json.loads(re.fullmatch(r"const searchIndex = (.*);\n", script, re.DOTALL)[1])["docs"]:
        page = places.setdefault(doc["location"].split("#")[0], [])
        page.append(doc["title"] + " " + doc["text"])
    for name in sources:
        text = re.sub(FENCED, "", (source / name).read_text("utf-8"))
        headings = [heading.replace("`", "") for heading in re.findall(r"^#+ (.*)$", text, re.M)]
        indexed = re.sub(r"\s+", " ", " ".join(places.get(html_of(name), [])).replace("`", ""))
        missing = [heading for heading in headings if heading not in indexed]
        if missing or not headings:
            yield f"{name}: the search does not know {missing or 'it'}"


def faults(site, source):
    sources = pages_of(source)
    pages = {str(path.relative_to(site)): Page(path.read_text("utf-8")) for path in site.rglob("*.html")}
    ids = {name: page.ids for name, page in pages.items()}
    found = [f"{name} is no page of the site" for name in sources if html_of(name) not in pages]
    found += [f"{name} is not in the list of pages" for name in sources if html_of(name) not in pages["index.html"].listed]
    for name, page in pages.items():
        found += link_faults(site, name, page, ids)
    for name in sources:
        if html_of(name) in pages:
            found += text_faults(name, pages[html_of(name)], (source / name).read_text("utf-8"))
    return sorted(set([*found, *network_faults(site), *search_faults(site, sources, source)]))


def browser_faults(site):
    """What a reader sees who opened the site as files."""
    sys.dont_write_bytecode = True  # into the sources
    sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
    from browser_check import FAINT, Browser, requests  # pylint: disable=import-outside-toplevel
    with tempfile.TemporaryDirectory() as profile:
        browser = Browser(profile)
        try:
            browser.call("POST", "/url", {"url": "about:blank"})
            requests(browser)  # of the page that a browser starts with
            browser.devtools("Emulation.setDeviceMetricsOverride", width=WIDTH_PX, height=800, deviceScaleFactor=1, mobile=False)
            for path in sorted(site.rglob("*.html")):
                browser.call("POST", "/url", {"url": path.as_uri()})
                beyond = browser.settled(f"return document.documentElement.scrollWidth - {WIDTH_PX};")
                if beyond > 0:
                    yield f"{path.name} is {beyond} px wider than {WIDTH_PX} px"
            for question, wanted in (("phase_origin_px gray", "formats/twin.html"), ("quxzwort", None)):
                browser.call("POST", "/url", {"url": f"{(site / 'index.html').as_uri()}"})
                browser.script(f"document.querySelector('header input').value = '{question}';")
                browser.script("document.querySelector('form').submit();")
                links = browser.settled("return [...document.querySelectorAll('#results a')].map((a) => a.href);")
                if not any(wanted in link for link in links) if wanted else links:
                    yield f"the search for \"{question}\" answers {links[:5]}"
                for scheme in ("light", "dark"):
                    browser.devtools("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": scheme}])
                    yield from (f"{scheme}: hard to read: {words}" for words in browser.settled(FAINT)["faint"])
            yield from (f"asks for {url}" for url in requests(browser) if not url.startswith(("file:", "data:")))
            yield from (f"the browser says {entry['message']}" for entry in browser.log("browser"))
        finally:
            browser.close()


def build_faults(command, seconds):
    """Builds the site; returns what is wrong with that."""
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=seconds, check=False)
    except subprocess.TimeoutExpired:
        return [f"the site was not built within {seconds} s"]
    return [done.stdout + done.stderr] if done.returncode else []


def seen_by_browser(look, site):
    """The faults that a browser sees, or one that says that it does not answer."""
    try:
        return list(look(site))
    except OSError as error:  # a timeout, or no connection
        return [f"the browser does not answer ({error})"]


def silent_browser(_site):
    raise TimeoutError("timed out")


def self_test():
    sources = {"README.md": "# One\n[two](docs/PHYSICS.md#part)\n", "docs/PHYSICS.md": "# Two\n## Part\n- one\n"}
    index = {"docs": [{"location": "index.html", "title": "One", "text": "two"},
                      {"location": "docs/PHYSICS.html", "title": "Two", "text": "Part"}]}
    start = '<link href="site.css"><nav><a href="docs/PHYSICS.html#part">two</a><a href="index.html">One</a></nav><main></main>'
    good = {"index.html": start, "site.css": "a { color: red; }",
            "docs/PHYSICS.html": '<h2 id="part">Part</h2><main><li>one</main>',
            "search/search_index.js": f"const searchIndex = {json.dumps(index)};\n"}
    planted = {"a link to nowhere": {"index.html": start + '<a href="docs/THREE.html">'},
               "an anchor to nowhere": {"index.html": start + '<a href="docs/PHYSICS.html#whole">'},
               "a script of the network": {"index.html": start + '<script src="https://cdn.example/a.js"></script>'},
               "a font of the network": {"site.css": "@font-face { src: url(https://fonts.example/a.woff2); }"},
               "a list that is text": {"docs/PHYSICS.html": '<h2 id="part">Part</h2><main><p>- one</p></main>'},
               "a page that the list lacks": {"index.html": start.replace("docs/PHYSICS.html#part", "") + '<a href="docs/PHYSICS.html">'},
               "a heading that is not found": {"search/search_index.js": good["search/search_index.js"].replace("Part", "")},
               "a page that is missing": {"docs/PHYSICS.html": None}}
    wrong = [f"a timeout is {found}" for found in (build_faults(["sleep", "60"], 1), seen_by_browser(silent_browser, None)) if len(found) != 1]
    for name, change in {"nothing": {}, **planted}.items():
        with tempfile.TemporaryDirectory() as scratch:
            for root, files in (("source", sources), ("site", good | change)):
                for file, text in files.items():
                    if text is not None:
                        path = pathlib.Path(scratch, root, file)
                        path.parent.mkdir(parents=True, exist_ok=True)
                        path.write_text(text, "utf-8")
            found = faults(pathlib.Path(scratch, "site"), pathlib.Path(scratch, "source"))
            if bool(found) == (name == "nothing"):
                wrong.append(f"planted: {name}; seen: {found}")
    return wrong


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--self-test", action="store_true")
    parser.add_argument("--source", type=pathlib.Path)
    parser.add_argument("--out", type=pathlib.Path)
    chosen = parser.parse_args()
    if chosen.self_test:
        found = self_test()
    elif not shutil.which("mkdocs"):
        print("skipped: mkdocs is not installed")
        sys.exit(77)
    else:
        site, source = chosen.out.resolve(), chosen.source.resolve()
        found = build_faults([source / "scripts/site.sh", site], 120) or faults(site, source)
        if not found and shutil.which("chromedriver"):
            found = seen_by_browser(browser_faults, site)
    print("\n".join(found) or "the site is whole")
    sys.exit(1 if found else 0)


main()
