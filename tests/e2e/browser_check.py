#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""browser_check.py REPORT.html [SHOTS]: opens a report in headless Chromium as a reader would, moves what can be
moved, prints it, and writes what was seen as JSON. Judges nothing. SHOTS: a folder for screenshots.
Standard library only: WebDriver is JSON over HTTP."""
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
  !(e.getAttribute('alt') || e.getAttribute('aria-label'))).map((e) => e.outerHTML.slice(0, 80));"""


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
    state = ("const s = document.querySelector('.slider'); return {value: Number(s.querySelector('input').value), "
             "clip: getComputedStyle(s.querySelector('.over')).clipPath};")
    before = b.settled(state)
    width = b.script("return document.querySelector('.slider input').getBoundingClientRect().width;")
    b.pointer(".slider input", [move(0, 0), DOWN, move(int(0.3 * width), 0), UP])
    return {"before": before, "after": b.settled(state)}


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


def main():
    page = pathlib.Path(sys.argv[1]).resolve().as_uri()
    shots = pathlib.Path(sys.argv[2]) if len(sys.argv) > 2 else None
    start = time.monotonic()
    seen = {}
    with tempfile.TemporaryDirectory() as profile:
        b = Browser(profile)

        def shot(name):
            if shots:
                (shots / f"{name}.png").write_bytes(base64.b64decode(b.call("GET", "/screenshot")))

        try:
            b.call("POST", "/url", {"url": "about:blank"})
            requests(b)  # of the page that a browser starts with
            b.call("POST", "/url", {"url": page})
            seen["title"] = b.call("GET", "/title")
            shot("top")
            seen["overflow_px"] = b.script("return document.documentElement.scrollWidth - innerWidth;")
            comparison = b.script("return document.querySelector('.slider') !== null;")
            seen["images"] = b.script("return document.querySelectorAll('svg').length;")
            if comparison:
                seen["slider"] = slider(b)
                seen["cloud"] = cloud(b, shot)
                seen["screen"] = visible(b)
            seen["pictures_without_words"] = b.script(SILENT)
            seen["light"] = b.script(FAINT)
            b.devtools("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": "dark"}])
            seen["dark"] = b.script(FAINT)
            shot_from_the_top(b, shot, "dark")
            b.devtools("Emulation.setEmulatedMedia", features=[])
            b.devtools("Emulation.setDeviceMetricsOverride", width=400, height=800, deviceScaleFactor=1, mobile=False)
            seen["narrow_overflow_px"] = b.settled("return document.documentElement.scrollWidth - 400;")
            shot_from_the_top(b, shot, "narrow")
            b.devtools("Emulation.clearDeviceMetricsOverride")
            b.devtools("Emulation.setEmulatedMedia", media="print")
            if comparison:
                seen["print"] = visible(b)
            b.devtools("Emulation.setEmulatedMedia", media="")
            pdf = base64.b64decode(b.call("POST", "/print", {"background": True}))
            if shots:
                (shots / "page.pdf").write_bytes(pdf)
            seen["pdf"] = {"bytes": len(pdf), "pages": len(re.findall(rb"/Type\s*/Page\b", pdf))}
            seen["console"] = [f"{e['level']} {e['message']}" for e in b.log("browser")]
            b.devtools("Emulation.setScriptExecutionDisabled", value=True)
            b.call("POST", "/refresh")
            if comparison:
                seen["no_script"] = visible(b)
            seen["requests"] = requests(b)
        finally:
            b.close()
    seen["seconds"] = time.monotonic() - start
    json.dump(seen, sys.stdout, indent=1)


if __name__ == "__main__":
    main()
