// SPDX-License-Identifier: Apache-2.0
#include "report/page_template.hpp"

namespace fringetwin::report {

const char* const kFigureTemplate =
    R"html(<figure>{{{body}}}<figcaption>{{caption}}{{#formula}}<code class="formula">{{formula}}</code>{{/formula}}{{#command}}<code class="command">$ {{command}}</code>{{/command}}</figcaption></figure>
)html";

const char* const kPageTemplate = R"html(<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="generator" content="fringetwin">
<meta http-equiv="Content-Security-Policy" content="default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src 'unsafe-inline'">
<title>{{title}}</title>
<style>
:root { color-scheme: light; --ink: #1d2329; --soft: #57626c; --line: #d9dee3; --paper: #ffffff; --wash: #f5f7f9;
  --accent: #0b5c8a; --pass: #1a7f4b; --fail: #b3261e; --warn: #8a5a00; --code: #39424a; --command: #5b6670;
  --note: #eef5fa; --warning: #fff8e5; --badge: #ffffff; --sheet: transparent; }
@media screen and (prefers-color-scheme: dark) {
  :root { color-scheme: dark; --ink: #e4e8ec; --soft: #a3aeb8; --line: #3a434c; --paper: #15191d; --wash: #1f252b;
    --accent: #6db7e3; --pass: #5cc98f; --fail: #ff8a80; --warn: #e8b64c; --code: #c3ccd4; --command: #a3aeb8;
    --note: #1a2a36; --warning: #332a12; --badge: #15191d; --sheet: #ffffff; }
}
* { box-sizing: border-box; }
html { scroll-behavior: smooth; }
body { margin: 0; color: var(--ink); background: var(--paper); line-height: 1.5; font-size: 15px;
  font-family: "Helvetica Neue", Helvetica, Arial, "Liberation Sans", "DejaVu Sans", sans-serif; }
.page { max-width: 1120px; margin: 0 auto; padding: 0 28px 60px; }
header { padding: 34px 0 16px; border-bottom: 3px solid var(--ink); }
h1 { font-size: 28px; line-height: 1.2; margin: 0; font-weight: 650; letter-spacing: -0.01em; }
.answer { font-size: 17px; margin: 8px 0 0; }
.next code { overflow-wrap: anywhere; }
.subtitle { color: var(--soft); margin: 6px 0 0; }
.verdict { font-weight: 700; letter-spacing: .08em; text-transform: uppercase; font-size: 17px; padding: 9px 20px;
  border-radius: 5px; color: var(--badge); width: fit-content; margin-top: 12px; }
.verdict.pass { background: var(--pass); } .verdict.fail { background: var(--fail); }
.verdict.none { background: var(--soft); }
h2 { font-size: 20px; margin: 44px 0 12px; padding-bottom: 5px; border-bottom: 1px solid var(--line); font-weight: 650; }
h3 { font-size: 16px; margin: 26px 0 8px; font-weight: 650; }
p { margin: 8px 0; max-width: 80ch; }
.note { border-left: 4px solid var(--accent); background: var(--note); padding: 10px 16px; margin: 18px 0; }
.warnings { border-left: 4px solid #e0a100; background: var(--warning); padding: 10px 16px; margin: 18px 0; }
.warnings ul { margin: 4px 0; padding-left: 20px; }
.note p, .warnings p { margin: 0; max-width: none; }
nav { margin: 18px 0 0; padding: 10px 16px; background: var(--wash); border-radius: 5px; font-size: 14px; }
nav a { color: var(--accent); text-decoration: none; margin-right: 20px; white-space: nowrap; display: inline-block; }
nav a:hover { text-decoration: underline; }
.table { overflow-x: auto; margin: 12px 0 18px; }
table { border-collapse: collapse; font-size: 14px; font-variant-numeric: tabular-nums; min-width: 50%; }
caption { text-align: left; color: var(--soft); padding: 0 0 6px; font-size: 14px; position: sticky; left: 0; }
th, td { padding: 5px 14px 5px 0; border-bottom: 1px solid var(--line); vertical-align: baseline; }
th { font-weight: 650; border-bottom: 1.5px solid var(--ink); border-top: 1.5px solid var(--ink); vertical-align: bottom; }
th:first-child, td:first-child { padding-left: 6px; } th:last-child, td:last-child { padding-right: 6px; }
.l { text-align: left; } .r { text-align: right; white-space: nowrap; }
.unit { display: block; font-weight: 400; color: var(--soft); font-size: 12px; }
td a { color: var(--accent); } tr.fault td { color: var(--warn); }
tr.group td { font-weight: 650; background: var(--wash); }
td.share { width: 40%; min-width: 180px; } td.share span { display: block; height: 11px; print-color-adjust: exact;
  -webkit-print-color-adjust: exact; }
td.share .part { background: #7fb2d0; } td.share .whole { background: var(--accent); } td.share .beyond { background: var(--fail); }
tr.total td { border-top: 1.5px solid var(--ink); font-weight: 650; }
tr.pass td:last-child { color: var(--pass); font-weight: 650; } tr.fail td:last-child { color: var(--fail); font-weight: 650; }
figure { margin: 16px 0 26px; break-inside: avoid; }
figcaption { color: var(--soft); font-size: 13px; margin-top: 6px; max-width: 110ch; }
figcaption code { display: block; margin-top: 3px; }
code { font: 12px/1.45 "DejaVu Sans Mono", Menlo, Consolas, monospace; color: var(--code); overflow-wrap: anywhere; }
pre { font: 12px/1.45 "DejaVu Sans Mono", Menlo, Consolas, monospace; white-space: pre-wrap; overflow-wrap: anywhere; }
code.command { color: var(--command); }
figure svg { width: 100%; height: auto; display: block; background: var(--sheet); }
abbr { text-decoration: underline dotted var(--soft); text-underline-offset: 3px; cursor: help; }
.verdict abbr { text-decoration-color: currentColor; }
:focus-visible { outline: 2px solid var(--accent); outline-offset: 1px; }
.words dt { font-weight: 650; margin-top: 6px; } .words dd { margin: 0 0 0 18px; max-width: 80ch; }
.maps { display: flex; flex-wrap: wrap; gap: 18px; }
.map { flex: 1 1 320px; min-width: 0; max-width: 720px; }
.map .map { max-width: none; }
.wide { flex: 2 1 480px; min-width: 0; align-self: center; }
.map img { width: 100%; height: auto; display: block; border: 1px solid var(--line); image-rendering: auto; }
.map h4 { margin: 0 0 4px; font-size: 13px; font-weight: 650; }
.bar { margin-top: 7px; font-size: 12px; color: var(--soft); }
.ramp { height: 11px; border: 1px solid #9aa4ad; print-color-adjust: exact; -webkit-print-color-adjust: exact; }
.ticks { display: flex; justify-content: space-between; font-variant-numeric: tabular-nums; }
.barunit { text-align: center; margin-top: -1px; }
.scale { display: flex; align-items: center; gap: 8px; font-size: 12px; color: var(--soft); margin-top: 4px; }
.scale span { height: 6px; border: 1.5px solid var(--ink); border-top: 0; }
.cloud canvas, .cloud .hint { display: none; }
.cloud.live canvas { display: block; width: 100%; height: auto; border: 1px solid var(--line); cursor: grab; touch-action: pan-y; background: var(--sheet); }
.cloud.live .hint { display: block; font-size: 12px; color: var(--soft); margin: 4px 0 0; } .cloud.live .still { display: none; }
.slider { flex: 1 1 320px; min-width: 0; max-width: 720px; }
.stack { position: relative; border: 1px solid var(--line); overflow: hidden; }
.stack img { width: 100%; height: auto; display: block; }
.stack .over { position: absolute; inset: 0; clip-path: inset(0 0 0 var(--cut)); }
.stack .cut { position: absolute; top: 0; bottom: 0; left: var(--cut); width: 2px; margin-left: -1px; background: #ffb000; }
.tag { position: absolute; top: 8px; background: rgba(0,0,0,.62); color: #fff; font-size: 12px; padding: 2px 8px; border-radius: 3px; }
.tag-left { left: 8px; } .tag-right { right: 8px; }
.slider input { width: 100%; margin: 6px 0 0; accent-color: var(--accent); }
.missing { color: var(--warn); font-style: italic; }
footer { margin-top: 56px; padding-top: 12px; border-top: 1.5px solid var(--ink); font-size: 13px; color: var(--soft); }
footer table { font-size: 12px; } footer td { overflow-wrap: anywhere; }
footer details { margin-top: 8px; } summary { cursor: pointer; }
@media screen and (max-width: 880px) {
  .drawing { overflow-x: auto; } .drawing svg { width: max(100%, var(--least)); } .map:has(> .drawing) { flex-basis: 450px; }
}
@media (max-width: 560px) {
  .page { padding: 0 14px 40px; } header { padding-top: 20px; } h1 { font-size: 22px; overflow-wrap: anywhere; }
  .answer, .verdict { font-size: 15px; } .verdict { padding: 7px 12px; letter-spacing: .04em; }
  caption { max-width: calc(100vw - 28px); } .map, .slider, .wide { flex-basis: 100%; } td, th { padding-right: 10px; } td.share { min-width: 90px; }
  nav a { margin-right: 14px; padding: 3px 0; }
  .cards thead, .cards td:empty { display: none; } .cards table { min-width: 100%; }
  .cards table, .cards caption, .cards tbody, .cards tr, .cards td { display: block; } .cards tr { padding: 8px 0; border-bottom: 1px solid var(--line); }
  .cards td { border: 0; padding: 1px 6px; text-align: left; white-space: normal; overflow-wrap: anywhere; }
  .cards td[data-head]::before { content: attr(data-head) ": "; color: var(--soft); }
}
@media print {
  @page { size: A4; margin: 14mm 13mm; }
  body { font-size: 10.5pt; } .page { max-width: none; padding: 0; }
  nav, .slider input, .stack .cut { display: none; }
  h2, h3 { break-after: avoid; } tr, figure { break-inside: avoid; }
  .verdict, .note, .warnings, tr.group td { print-color-adjust: exact; -webkit-print-color-adjust: exact; }
  .cloud.live canvas, .cloud.live .hint { display: none; } .cloud.live .still { display: block; }
  .slider { max-width: none; flex-basis: 100%; }
  .stack { display: flex; border: 0; gap: 8px; } .stack img { width: calc(50% - 4px); }
  .stack .over { position: static; clip-path: none; }
  .tag-right { right: auto; left: calc(50% + 12px); }
}
</style>
</head>
<body>
<div class="page">
<header><h1>{{title}}</h1>{{#answer}}<p class="answer">{{answer}}</p>{{/answer}}{{#verdict}}<div class="verdict {{verdict_class}}">{{{verdict}}}</div>{{/verdict}}<p class="subtitle">{{subtitle}}</p></header>
<nav aria-label="Contents">{{#sections}}<a href="#{{id}}">{{title}}</a>{{/sections}}<a href="#provenance">Provenance</a></nav>
{{{summary}}}
{{#note}}<div class="note"><p>{{note}}</p></div>
{{/note}}{{#has_warnings}}<div class="warnings"><p><strong>Warnings</strong></p><ul>{{#warnings}}<li>{{text}}</li>{{/warnings}}</ul></div>
{{/has_warnings}}{{#sections}}<section id="{{id}}"><h2>{{title}}</h2>
{{{body}}}</section>
{{/sections}}<footer id="provenance">{{{footer}}}</footer>
</div>
{{#script}}<script>
{{{script}}}
</script>
{{/script}}</body>
</html>
)html";

}  // namespace fringetwin::report
