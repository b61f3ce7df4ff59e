#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""browser_check.py [--shots FOLDER] PAGE.html ...: opens pages in one headless Chromium as a reader would, moves what
can be moved by mouse and by key, prints them, and writes what was seen of each as a JSON list. Judges nothing.
FOLDER: for screenshots. Standard library only: WebDriver is JSON over HTTP."""
import argparse
import base64
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import time
import urllib.request

ELEMENT = "element-6066-11e4-a52e-4f735466cecf"  # WebDriver's name of an element reference
PICTURE = """const c = document.querySelector('.cloud canvas'), d = new Uint32Array(
  c.getContext('2d').getImageData(0, 0, c.width, c.height).data.buffer), counts = new Map();
let hash = 7;
for (const v of d) { hash = (Math.imul(hash, 31) + v) | 0; counts.set(v, (counts.get(v) || 0) + 1); }
const back = d[d.length - c.width];  // a corner of the picture
return {hash: hash, drawn: 1 - counts.get(back) / d.length, colors: counts.size};"""

# Words whose contrast with what lies behind them is less than WCAG's level AA asks for: 4.5, of large ones 3.
FAINT = """const channels = (text) => text.match(/[0-9.]+/g).map(Number);
const over = (c, behind) => { const a = c.length > 3 ? c[3] : 1; return [0, 1, 2].map((i) => a * c[i] + (1 - a) * behind[i]); };
const light = (c) => { const [r, g, b] = c.map((v) => v / 255).map((v) => v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4);
  return 0.2126 * r + 0.7152 * g + 0.0722 * b; };
const behind = (e) => e === null ? [255, 255, 255] : over(channels(getComputedStyle(e).backgroundColor), behind(e.parentElement));
document.querySelectorAll('details').forEach((d) => { d.open = true; });
const faint = [];
let n = 0;
for (const e of document.body.querySelectorAll('*')) {
  if (e.closest('svg, script, style') || !e.getClientRects().length) continue;
  const text = [...e.childNodes].filter((c) => c.nodeType === 3).map((c) => c.textContent.trim()).join('');
  if (!text) continue;
  ++n;
  const style = getComputedStyle(e), size = parseFloat(style.fontSize);
  const back = behind(e), front = over(channels(style.color), back);
  const [a, b] = [light(front), light(back)].sort((x, y) => y - x), ratio = (a + 0.05) / (b + 0.05);
  const large = size >= 24 || (size >= 18.66 && Number(style.fontWeight) >= 700);
  if (ratio < (large ? 3 : 4.5)) faint.push(`${ratio.toFixed(2)} ${e.tagName}.${e.className}: ${text.slice(0, 40)}`);
}
return {words: n, faint: faint, back: getComputedStyle(document.body).backgroundColor};"""
SILENT = """return [...document.querySelectorAll('img'), ...document.querySelectorAll('figure svg')].filter((e) =>
  ['', 'plot', null].includes(e.getAttribute('alt') || e.getAttribute('aria-label'))).map((e) => e.outerHTML.slice(0, 80));"""

# What scrolls sideways and cannot be reached by key, or says no name there.
KEYLESS = """return [...document.body.querySelectorAll('*')].filter((e) => e.scrollWidth > e.clientWidth + 1 &&
  ['auto', 'scroll'].includes(getComputedStyle(e).overflowX) &&
  !(e.tabIndex === 0 && e.hasAttribute('tabindex') && e.getAttribute('role') && e.getAttribute('aria-label')))
  .map((e) => e.outerHTML.slice(0, 80));"""
# Captions of tables that reach beyond the page.
CUT_CAPTIONS = """return [...document.querySelectorAll('caption')].filter((e) => {
  const box = e.getBoundingClientRect(); return box.left < 0 || box.right > innerWidth; })
  .map((e) => e.textContent.slice(0, 80));"""
# Letters of plots that are shown, and those below 9 px, each with its size on the screen.
SMALL = """const small = [];
let n = 0;
for (const e of document.querySelectorAll('svg text')) {
  if (!e.textContent.trim() || !e.getClientRects().length) continue;
  ++n;
  const to_screen = e.getScreenCTM();
  const size = parseFloat(getComputedStyle(e).fontSize) * Math.hypot(to_screen.c, to_screen.d);
  if (size < 9) small.push(`${size.toFixed(2)} px: ${e.textContent.trim().slice(0, 40)}`);
}
return {texts: n, small: small};"""
SLIDER = """const s = document.querySelector('.slider'); return {value: Number(s.querySelector('input').value),
  clip: getComputedStyle(s.querySelector('.over')).clipPath};"""
TAB, ENTER, LEFT, RIGHT, DOWN_KEY = "\ue004", "\ue007", "\ue012", "\ue014", "\ue015"
MOST_TABS = 200


class Browser:
    def __init__(self, profile):
        self.driver = subprocess.Popen(["chromedriver", "--port=0"], stdout=subprocess.PIPE,
                                       stderr=subprocess.DEVNULL, text=True)
        for line in self.driver.stdout:
            found = re.search(r"started successfully on port (\d+)", line)
            if found:
                break
        self.base = f"http://127.0.0.1:{found.group(1)}/session"
        arguments = ["--headless=new", "--disable-gpu", "--disable-dev-shm-usage", "--no-first-run",
                     "--disable-background-networking", "--disable-component-update", "--hide-scrollbars",
                     "--window-size=1160,1000", f"--user-data-dir={profile}"]
        if os.geteuid() == 0:
            arguments.append("--no-sandbox")  # root has no sandbox
        options = {"browserName": "chrome", "goog:chromeOptions": {"args": arguments},
                   "goog:loggingPrefs": {"browser": "ALL", "performance": "ALL"}}
        session = self.call("POST", "", {"capabilities": {"alwaysMatch": options}})
        self.base += "/" + session["sessionId"]

    def call(self, method, path, body=None):
        data = None if method == "GET" else json.dumps(body or {}).encode()
        request = urllib.request.Request(self.base + path, data, {"Content-Type": "application/json"}, method=method)
        try:
            with urllib.request.urlopen(request, timeout=60) as answer:
                return json.load(answer)["value"]
        except urllib.error.HTTPError as error:
            raise RuntimeError(f"{method} {path}: {error.read().decode()[:500]}") from None

    def script(self, text):
        return self.call("POST", "/execute/sync", {"script": text, "args": []})

    def find(self, css):
        return self.call("POST", "/element", {"using": "css selector", "value": css})

    def displayed(self, css):
        return self.call("GET", f"/element/{self.find(css)[ELEMENT]}/displayed")

    def pointer(self, css, actions):
        """Mouse actions; moves to places relative to the middle of an element."""
        element = self.find(css)
        for action in actions:
            if action["type"] == "pointerMove":
                action.setdefault("origin", element)
        self.call("POST", "/actions", {"actions": [
            {"type": "pointer", "id": "mouse", "parameters": {"pointerType": "mouse"}, "actions": actions}]})

    def keys(self, *keys):
        self.call("POST", "/actions", {"actions": [{"type": "key", "id": "keyboard", "actions": [
            {"type": kind, "value": key} for key in keys for kind in ("keyDown", "keyUp")]}]})

    def tab_to(self, css):
        """Presses Tab until the first element that fits has the keys; returns how it begins, or None: it never had."""
        for _ in range(MOST_TABS):
            self.keys(TAB)
            at = self.script(f"const e = document.activeElement; return e === document.querySelector({json.dumps(css)}) "
                             "? e.outerHTML.slice(0, 60) : null;")
            if at is not None:
                return at
        return None

    def settled(self, text):
        """A script's answer two frames later: what was asked for is drawn."""
        return self.call("POST", "/execute/async", {"args": [], "script":
            "const done = arguments[0], read = () => {" + text + "};"
            "requestAnimationFrame(() => requestAnimationFrame(() => { "
            "let seen; try { seen = read(); } catch (error) { seen = String(error); } done(seen); }));"})

    def devtools(self, command, **parameters):
        return self.call("POST", "/goog/cdp/execute", {"cmd": command, "params": parameters})

    def log(self, kind):
        return self.call("POST", "/se/log", {"type": kind})

    def close(self):
        try:
            self.call("DELETE", "")
        finally:
            self.driver.terminate()
            self.driver.wait(20)


def move(x, y, **more):
    return {"type": "pointerMove", "x": x, "y": y, "duration": 50, **more}


DOWN, UP = {"type": "pointerDown", "button": 0}, {"type": "pointerUp", "button": 0}


def slider(b):
    before = b.settled(SLIDER)
    width = b.script("return document.querySelector('.slider input').getBoundingClientRect().width;")
    b.pointer(".slider input", [move(0, 0), DOWN, move(int(0.3 * width), 0), UP])
    return {"before": before, "after": b.settled(SLIDER)}


def cloud(b, shot):
    b.script("document.querySelector('.cloud canvas').scrollIntoView({block: 'center', behavior: 'instant'});")
    seen = {"first": b.settled(PICTURE)}
    shot("cloud")
    b.pointer(".cloud canvas", [move(0, 0), DOWN, move(120, 40), UP])
    seen["turned"] = b.settled(PICTURE)
    shot("turned")
    element = b.find(".cloud canvas")
    b.call("POST", "/actions", {"actions": [{"type": "wheel", "id": "wheel", "actions": [
        {"type": "scroll", "x": 0, "y": 0, "deltaX": 0, "deltaY": 400, "origin": element}]}]})
    seen["farther"] = b.settled(PICTURE)
    b.pointer(".cloud canvas", [move(0, 0), DOWN, UP, DOWN, UP])
    seen["again"] = b.settled(PICTURE)
    return seen


def from_the_top(b):
    """The next Tab leads to what can be reached first."""
    b.script("const h = document.querySelector('h1'); h.tabIndex = -1; h.focus();")


def keyboard(b, has_cloud):
    """What keys alone reach and change of a report: the cloud, if any, a slider, a list that opens."""
    seen = {}
    if has_cloud:
        from_the_top(b)
        seen["cloud_at"] = b.tab_to(".cloud canvas")
        seen["cloud"] = {"first": b.settled(PICTURE)}
        for name, key in {"right": RIGHT, "down": DOWN_KEY, "farther": "-", "again": "0"}.items():
            b.keys(key)
            seen["cloud"][name] = b.settled(PICTURE)
    from_the_top(b)
    seen["slider_at"] = b.tab_to(".slider input")
    seen["slider"] = {"before": b.settled(SLIDER)}
    b.keys(*[LEFT] * 10)
    seen["slider"]["after"] = b.settled(SLIDER)
    from_the_top(b)
    seen["words_at"] = b.tab_to(".words summary")
    b.keys(ENTER)
    seen["words"] = b.settled("return document.querySelector('.words').open;")
    return seen


def scrolled_by_key(b, kind):
    """How far a key scrolls the first frame of this class that is narrower than what it holds; None without one."""
    wide = (f"[...document.querySelectorAll('.{kind}')].find((e) => e.scrollWidth > e.clientWidth + 1 && "
            "e.getClientRects().length)")
    if not b.script(f"const e = {wide}; if (e) e.id = 'wide-{kind}'; return Boolean(e);"):
        return None
    from_the_top(b)
    at = b.tab_to(f"#wide-{kind}")
    b.keys(*[RIGHT] * 3)
    b.settled("")
    until = time.monotonic() + 2
    scrolled = f"return document.getElementById('wide-{kind}').scrollLeft;"
    while (px := b.settled(scrolled)) == 0 and time.monotonic() < until:
        time.sleep(0.05)  # it glides there
    return {"at": at, "px": px}


def requests(b):
    """Addresses of everything asked for since the last call; of data: only the kind."""
    messages = [json.loads(entry["message"])["message"] for entry in b.log("performance")]
    urls = [m["params"]["request"]["url"] for m in messages if m["method"] == "Network.requestWillBeSent"]
    return sorted({url.split(",")[0] if url.startswith("data:") else url for url in urls})


def visible(b):
    return {"canvas": b.displayed(".cloud canvas"), "still": b.displayed(".cloud .still")}


def shot_from_the_top(b, shot, name):
    b.settled("window.scrollTo({top: 0, behavior: 'instant'});")
    shot(name)


def look_at(b, page, shot):
    """What is seen of a page; a report's slider and cloud are moved."""
    requests(b)  # of what was open before
    b.call("POST", "/url", {"url": page.resolve().as_uri()})
    seen = {"title": b.call("GET", "/title")}
    shot("top")
    seen["overflow_px"] = b.script("return document.documentElement.scrollWidth - innerWidth;")
    # a comparison has a slider, and a cloud unless its object is a measured one; a measurement has a cloud alone
    has_slider, has_cloud = (b.script(f"return document.querySelector('{css}') !== null;")
                             for css in (".slider input", ".cloud canvas"))
    has_cloud = has_cloud and has_slider
    seen["images"] = b.script("return document.querySelectorAll('svg').length;")
    if has_slider:
        seen["slider"] = slider(b)
    if has_cloud:
        seen["cloud"] = cloud(b, shot)
        seen["screen"] = visible(b)
    if has_slider:
        seen["keyboard"] = keyboard(b, has_cloud)
    seen["pictures_without_words"] = b.script(SILENT)
    seen["light"] = b.script(FAINT)
    b.devtools("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": "dark"}])
    seen["dark"] = b.script(FAINT)
    shot_from_the_top(b, shot, "dark")
    b.devtools("Emulation.setEmulatedMedia", features=[])
    b.devtools("Emulation.setDeviceMetricsOverride", width=400, height=800, deviceScaleFactor=1, mobile=False)
    seen["narrow_overflow_px"] = b.settled("return document.documentElement.scrollWidth - 400;")
    seen["captions_cut"] = b.script(CUT_CAPTIONS)
    seen["scrolled_without_keys"] = b.script(KEYLESS)
    seen["plots"] = b.script(SMALL)
    seen["scrolled_by_key"] = {kind: scrolled_by_key(b, kind) for kind in ("table", "drawing")}
    shot_from_the_top(b, shot, "narrow")
    b.devtools("Emulation.clearDeviceMetricsOverride")
    b.devtools("Emulation.setEmulatedMedia", media="print")
    if has_cloud:
        seen["print"] = visible(b)
    b.devtools("Emulation.setEmulatedMedia", media="")
    pdf = base64.b64decode(b.call("POST", "/print", {"background": True}))
    shot("page", pdf)
    seen["pdf"] = {"bytes": len(pdf), "pages": len(re.findall(rb"/Type\s*/Page\b", pdf))}
    seen["console"] = [f"{e['level']} {e['message']}" for e in b.log("browser")]
    b.devtools("Emulation.setScriptExecutionDisabled", value=True)
    b.call("POST", "/refresh")
    if has_cloud:
        seen["no_script"] = visible(b)
    b.devtools("Emulation.setScriptExecutionDisabled", value=False)
    seen["requests"] = requests(b)
    return seen


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--shots", type=pathlib.Path)
    parser.add_argument("pages", nargs="+", type=pathlib.Path)
    given = parser.parse_args()
    all_seen = []
    with tempfile.TemporaryDirectory() as profile:
        b = Browser(profile)
        try:
            b.call("POST", "/url", {"url": "about:blank"})
            for page in given.pages:
                start = time.monotonic()

                def shot(name, pdf=None):
                    if given.shots:
                        file = given.shots / f"{page.parent.name}_{page.stem}_{name}.{'pdf' if pdf else 'png'}"
                        file.write_bytes(pdf or base64.b64decode(b.call("GET", "/screenshot")))

                all_seen.append(look_at(b, page, shot))
                all_seen[-1]["seconds"] = time.monotonic() - start
        finally:
            b.close()
    json.dump(all_seen, sys.stdout, indent=1)


if __name__ == "__main__":
    main()
