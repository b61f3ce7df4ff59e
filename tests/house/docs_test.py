#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks that what the documents and comments point to exists.

docs_test.py ROOT         fails where a relative link of a page leads nowhere, where a page names a file of the project
                          that does not exist, and where a page or a comment cites a section that its page lacks;
docs_test.py --self-test  plants each of these faults in a scratch tree and proves that it is seen.
"""
import os
import re
import sys
import tempfile

PAGES = ("docs", "README.md", "CONTRIBUTING.md", "CHANGELOG.md", "datasets/README.md")
FOLDERS = ("bench", "calib", "capture", "cli", "cmake", "compare", "cosim", "datasets", "docs", "measure", "python", "render",
           "report", "scripts", "study", "tests", "tradeoff", "twin")
TESTS = ("accuracy", "e2e", "hard")  # groups of tests in tests/
SOURCES = re.compile(r"(\.(cpp|hpp|h|comp|glsl|py|sh|cmake|toml|yml)|CMakeLists\.txt|\.clang-tidy)$")
CODE = re.compile(r"^```.*?^```", re.MULTILINE | re.DOTALL)
LINK = re.compile(r"\]\(([^)\s]+)\)")
TICKED = re.compile(r"`([^`\n]+)`")
# docs/PAGE.md, "Section": the comment's line may end after the comma.
CITED = re.compile(r"((?:docs/)?[\w/]*[A-Za-z_]+\.md)`?,(?:\s|//[/<]*|#)+\"([^\"]+)\"")


def text_of(path):
    with open(path, encoding="utf-8") as f:
        return f.read()


def headings(path):
    return [m[1].strip() for m in re.finditer(r"^#+ (.*)$", CODE.sub("", text_of(path)), re.MULTILINE)]


def anchors(path):
    """The anchors of a page's headings, as GitHub makes them."""
    return {re.sub(r"[^\w\- ]", "", h.lower()).replace(" ", "-") for h in headings(path)}


def files_below(root, start):
    if os.path.isfile(os.path.join(root, start)):
        yield start
    for folder, folders, names in os.walk(os.path.join(root, start)):
        folders[:] = [f for f in folders if f != "bad_files"]  # wrong on purpose
        for name in names:
            yield os.path.relpath(os.path.join(folder, name), root)


def find_page(root, name, beside):
    """A page named in text: from the project's root, beside the page that names it, or in docs/."""
    for folder in ("", os.path.dirname(beside), "docs"):
        path = os.path.normpath(os.path.join(root, folder, name))
        if os.path.isfile(path):
            return path
    return None


def link_faults(root, page, text):
    for target in LINK.findall(CODE.sub("", text)):
        if re.match(r"[a-z]+:", target):
            continue
        name, _, anchor = target.partition("#")
        path = os.path.normpath(os.path.join(root, os.path.dirname(page), name)) if name else os.path.join(root, page)
        if not os.path.exists(path):
            yield f"{page}: the link to {target} leads nowhere"
        elif anchor and anchor not in anchors(path):
            yield f"{page}: {target}: the page has no such heading"


def is_test(root, name):
    """Is `name` the name of a test in CTest, ROOM/NAME or ROOM/LABEL/NAME, which NAME_test.cpp in that room holds?"""
    room, test = name.split("/")[0], name.split("/")[-1] + "_test.cpp"
    return any(os.path.basename(f) == test for start in (room, "tests/" + room) for f in files_below(root, start))


def named_file_faults(root, page, text):
    for token in TICKED.findall(CODE.sub("", text)):
        if re.fullmatch(r"[A-Z_]+\.md", token):
            if not find_page(root, token, page):
                yield f"{page}: names the page {token}, which does not exist"
        elif re.fullmatch(rf"({'|'.join(FOLDERS + TESTS)})/[\w./-]*", token):
            if not os.path.exists(os.path.join(root, token)) and not is_test(root, token):
                yield f"{page}: names {token}, which does not exist"


def pages_of(path):
    """The page, and those it is the index of: METRICS.md of what it links to in metrics/."""
    folder = os.path.splitext(os.path.basename(path))[0].lower()
    linked = re.findall(rf"\]\(({folder}/\w+\.md)", text_of(path))
    return [path, *sorted({os.path.join(os.path.dirname(path), page) for page in linked})]


def citation_faults(root, source, text):
    for name, section in CITED.findall(text):
        section = " ".join(re.sub(r"\n\s*(///?<?|#)?", " ", section).split())
        path = find_page(root, name, source)
        if not path:
            yield f"{source}: cites {name}, which does not exist"
        elif not any(h.replace("`", "").startswith(section) for page in pages_of(path) for h in headings(page)):
            yield f"{source}: {name} has no section \"{section}\""


def missing_page_faults(root, source, text):
    for name in re.findall(r"\bdocs/[\w/]+\.md", text):
        if not os.path.isfile(os.path.join(root, name)):
            yield f"{source}: cites {name}, which does not exist"


def faults(root):
    pages = [f for start in PAGES for f in files_below(root, start) if f.endswith(".md")]
    sources = [f for start in (*FOLDERS, ".clang-tidy", "CMakeLists.txt") for f in files_below(root, start)
               if SOURCES.search(f) and os.path.basename(f) != os.path.basename(__file__)]
    if not pages:
        return [f"no page under {root}"]
    found = []
    for page in pages:
        text = text_of(os.path.join(root, page))
        found += [*link_faults(root, page, text), *named_file_faults(root, page, text),
                  *citation_faults(root, page, CODE.sub("", text))]
    for source in sources:
        text = text_of(os.path.join(root, source))
        found += [*citation_faults(root, source, text), *missing_page_faults(root, source, text)]
    return sorted(set(found))


def self_test():
    good = {"README.md": "[a](docs/A.md#some-part-x) `docs/A.md` `twin/lens.hpp` `A.md`, \"Some part\"",
            "docs/A.md": "# A\n## Some part (`x`)\n[of this page](a/more.md)",
            "docs/a/more.md": "## More of it",
            "twin/lens.hpp": "// As in docs/A.md,\n// \"Some part\", and docs/A.md, \"More\"."}
    planted = {"README.md": ("[a](docs/B.md)", "[a](docs/A.md#other)", "`twin/gone.hpp`", "`B.md`", "`A.md`, \"Other\""),
               "twin/lens.hpp": ("// docs/B.md", "// docs/A.md,\n/// \"Other\"")}

    def run(files):
        with tempfile.TemporaryDirectory() as root:
            for name, text in files.items():
                os.makedirs(os.path.dirname(os.path.join(root, name)), exist_ok=True)
                with open(os.path.join(root, name), "w", encoding="utf-8") as f:
                    f.write(text)
            return faults(root)

    wrong = [f"a sound tree: {fault}" for fault in run(good)]
    for name, texts in planted.items():
        wrong += [f"not seen in {name}: {text}" for text in texts if len(run(good | {name: text})) != 1]
    return wrong


def main():
    found = self_test() if sys.argv[1] == "--self-test" else faults(sys.argv[1])
    print("\n".join(found) or "every link, file name and citation leads somewhere")
    sys.exit(1 if found else 0)


main()
