// SPDX-License-Identifier: Apache-2.0
#include "station/report/style.h"

namespace soak::station {

std::string_view report_style() {
  return R"css(
:root {
  color-scheme: light dark;
  --back: #f2f5f6; --card: #ffffff; --line: #d5dde1; --text: #16222b; --soft: #53636f; --accent: #0b6b74;
  --good: #17693a; --good-back: #e0f3e6; --warn: #7a4b00; --warn-back: #fdeec9; --bad: #a3211c; --bad-back: #fbe3e1;
  --info-back: #dceff1; --grid: #e3e9ec; --pi95: #cfe6e9; --ci95: #8cc4cb;
  --c0: #0072b2; --c1: #c24f00; --c2: #00805c; --c3: #a8458a; --c4: #8a6d00; --c5: #5a4fcf; --c6: #b3203f; --c7: #3d7f8f;
}
@media screen and (prefers-color-scheme: dark) {
  :root {
    --back: #0f1519; --card: #182127; --line: #2d3a43; --text: #e7eef2; --soft: #a3b3bd; --accent: #4cc3cc;
    --good: #7ddca0; --good-back: #12331f; --warn: #f5c96b; --warn-back: #3a2c0c; --bad: #ff9d94; --bad-back: #42191a;
    --info-back: #12333a; --grid: #26323a; --pi95: #1b3b42; --ci95: #2c6570;
    --c0: #62b5f0; --c1: #ff9a52; --c2: #46cfa2; --c3: #e893cb; --c4: #e0c34a; --c5: #a9a1ff; --c6: #ff8799; --c7: #86c9d8;
  }
}
* { box-sizing: border-box; }
body {
  margin: 0; background: var(--back); color: var(--text);
  font: 15px/1.45 system-ui, "Segoe UI", Roboto, "Noto Sans", "DejaVu Sans", sans-serif;
  font-variant-numeric: tabular-nums;
}
h1, h2, h3, p, dl, dd, ul, figure { margin: 0; padding: 0; }
h1 { font-size: 1.6rem; line-height: 1.2; overflow-wrap: anywhere; }
h2 { font-size: 1.2rem; margin-bottom: .4rem; }
h3 { font-size: 1rem; margin: 1rem 0 .3rem; }
a { color: var(--accent); }
code { font-size: .85em; overflow-wrap: anywhere; }
.soft { color: var(--soft); }
main { max-width: 76rem; margin: 0 auto; padding: 1rem clamp(.75rem, 3vw, 2rem); display: grid; gap: 1rem; }
main > * { min-width: 0; }
section, header {
  padding: 1rem 1.2rem; background: var(--card); border: 1px solid var(--line); border-radius: .75rem; min-width: 0;
}
p + p { margin-top: .4rem; }
.brand { color: var(--accent); font-weight: 700; }
.simulated-bar {
  position: sticky; top: 0; z-index: 2; padding: .5rem 1rem; text-align: center; font-weight: 700; letter-spacing: .05em;
  background: var(--warn-back); color: var(--warn); border-bottom: 3px dashed var(--warn);
}
.watermark { display: none; }
.verdict { margin-top: .9rem; padding: .8rem 1rem; border-radius: .6rem; background: var(--info-back); font-size: 1.1rem; }
.verdict b { display: inline-block; margin-right: .7rem; padding: .05rem .7rem; border: 2px solid; border-radius: 1rem; letter-spacing: .05em; }
.verdict.pass { background: var(--good-back); color: var(--good); }
.verdict.marginal, .verdict.not_measured { background: var(--warn-back); color: var(--warn); }
.verdict.fail { background: var(--bad-back); color: var(--bad); }
.facts { display: flex; flex-wrap: wrap; gap: .4rem 1.8rem; margin-top: .7rem; }
.facts dt { color: var(--soft); font-size: .8125rem; }
.facts dd { font-weight: 600; overflow-wrap: anywhere; }
.warnings { list-style: none; display: grid; gap: .5rem; }
.warnings li { padding: .5rem .8rem; border-left: 4px solid var(--warn); background: var(--warn-back); border-radius: .3rem; }
.warnings .who { font-weight: 600; }
.warnings .do { display: block; color: var(--soft); }
nav ul { list-style: none; display: flex; flex-wrap: wrap; gap: .2rem 1.1rem; }
.wide { overflow-x: auto; margin: .6rem 0; }
table { border-collapse: collapse; font-size: .875rem; }
caption { text-align: left; font-weight: 600; padding-bottom: .2rem; }
th, td { padding: .18rem .9rem .18rem 0; text-align: left; vertical-align: top; }
th { font-weight: 600; }
thead th { color: var(--soft); font-weight: 400; vertical-align: bottom; border-bottom: 1px solid var(--line); }
tbody tr + tr { border-top: 1px solid var(--grid); }
td.n { white-space: nowrap; }
td.winner { font-weight: 700; color: var(--good); }
td.basis { min-width: 16rem; }
td.nowrap { white-space: nowrap; }
td.fail { color: var(--bad); font-weight: 700; }
td.pass { color: var(--good); font-weight: 600; }
td.marginal { color: var(--warn); font-weight: 600; }
.figures { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(100%, 25rem), 1fr)); gap: 1rem; margin: .6rem 0; }
.tables { align-content: flex-start; display: flex; flex-wrap: wrap; gap: 0 2.5rem; }
.tables > * { min-width: 0; max-width: 100%; }
figure svg { display: block; width: 100%; height: auto; }
figcaption { font-size: .8125rem; color: var(--soft); }
figcaption b { color: var(--text); }
.legend { list-style: none; display: flex; flex-wrap: wrap; gap: .1rem .9rem; }
.grid line { stroke: var(--grid); }
.grid text { fill: var(--soft); font-size: 12px; }
.band { stroke: none; }
.pi95 { --series: var(--pi95); }
.ci95 { --series: var(--ci95); }
.curve { --series: var(--text); }
.limit { --series: var(--bad); stroke-dasharray: 6 4; }
.fresh { --series: var(--text); }
.out { --series: var(--bad); }
.faint { --series: var(--soft); }
.c0 { --series: var(--c0); } .c1 { --series: var(--c1); } .c2 { --series: var(--c2); } .c3 { --series: var(--c3); }
.c4 { --series: var(--c4); } .c5 { --series: var(--c5); } .c6 { --series: var(--c6); } .c7 { --series: var(--c7); }
.band { fill: var(--series); }
.band.c0, .band.c1, .band.c2 { fill-opacity: .22; }
.line { fill: none; stroke: var(--series); stroke-width: 1.6; stroke-linejoin: round; }
.mark { fill: var(--series); fill-opacity: .8; }
.mark.faint { fill-opacity: .3; }
.mark.fresh { fill: none; stroke: var(--series); stroke-width: 1; }
.swatch { display: inline-block; width: 1rem; margin-right: .35rem; vertical-align: middle; background: none; }
.swatch.line { border-top: 3px solid var(--series); }
.swatch.line.limit { border-top-style: dashed; }
.swatch.band { height: .7rem; background: var(--series); }
.swatch.run { width: .6rem; height: .6rem; border-radius: 50%; background: var(--series); }
.swatch.square { width: .55rem; height: .55rem; border: 1px solid var(--series); }
.swatch.ring { width: .7rem; height: .7rem; border: 1px solid var(--series); border-radius: 50%; }
.swatch.none { display: none; }
footer { padding: 0 0 1.5rem; text-align: center; color: var(--soft); font-size: .8125rem; }
@media screen and (max-width: 40rem) { .grid text { font-size: 15px; } }
@page { size: A4; margin: 13mm 12mm; }
@media print {
  :root { color-scheme: light; font-size: 12.5px; }
  body { font-size: 9.5pt; background: none; }
  main { display: block; max-width: none; padding: 0; }
  section, header { border: 0; border-top: 1px solid var(--line); border-radius: 0; padding: .5rem 0; margin-bottom: .5rem; }
  nav { display: none; }
  .wide { overflow: visible; }
  table { font-size: 8pt; }
  th, td { padding-right: .5rem; }
  .figures { grid-template-columns: 1fr 1fr; }
  figure, tr, .warnings li, .facts div { break-inside: avoid; }
  h2, h3, caption { break-after: avoid; }
  .simulated-bar { position: static; }
  .watermark {
    display: block; position: fixed; inset: 40% 0 auto; text-align: center; font-size: 70pt; font-weight: 800;
    color: #7a4b00; opacity: .12; transform: rotate(-30deg); z-index: 3;
  }
  .verdict, .warnings li, .swatch, .simulated-bar { print-color-adjust: exact; -webkit-print-color-adjust: exact; }
}
)css";
}

}  // namespace soak::station
