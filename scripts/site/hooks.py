# SPDX-License-Identifier: Apache-2.0
"""What mkdocs has to be told so that a page reads as the Markdown of code-hosting sites, for which the documents are written."""
import os
import re

ITEM = re.compile(r"(\s*)([-*]|\d+\.) ")


def anchor_of(heading, _separator):
    """The anchor that tests/house/docs_test.py asks links for."""
    return re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")


def on_config(config):
    config["mdx_configs"].setdefault("toc", {})["slugify"] = anchor_of
    return config


def on_page_markdown(markdown, **_):
    """mkdocs wants empty lines before lists, tables and items that follow a paragraph of their own, four spaces before what
    belongs to an item, and code there indented instead of fenced."""
    lines, fence, in_list, loose = [], None, False, False
    for line in markdown.split("\n"):
        text, indent = line.strip(), len(line) - len(line.lstrip())
        last = lines[-1] if lines else ""
        if text.startswith("```") and fence in (None, indent):
            fence = indent if fence is None else None
            line = "" if indent else line
            loose = True
        elif fence:
            line = " " * 8 + line[fence:]
        elif fence is None:
            item = ITEM.match(line)
            starts_table = text.startswith("|") and not last.startswith("|")
            if last.strip() and (starts_table or (item and (loose or not in_list))):
                lines.append("")
            in_list = bool(item) or (in_list and (indent > 0 or not text))
            loose = not text or (loose and not item)
            if in_list and indent >= 3 and not item:
                line = " " + line
        lines.append(line)
    return "\n".join(lines)


def on_page_content(html, **_):
    """Tables that are wider than the window are moved in it, not the page."""
    return html.replace("<table>", '<div class="wide"><table>').replace("</table>", "</table></div>")


def on_post_build(config):
    """The index as a script, too: pages that are opened as files may load scripts alone."""
    folder = os.path.join(config["site_dir"], "search")
    with open(os.path.join(folder, "search_index.json"), encoding="utf-8") as file:
        index = file.read()
    with open(os.path.join(folder, "search_index.js"), "w", encoding="utf-8") as file:
        file.write(f"const searchIndex = {index};\n")
