"""How the worksheet looks, on a screen and on paper."""

STYLE = """
:root { --ink: #1d1f24; --soft: #5d626d; --line: #d6d9df; --paper: #fff; --tint: #f4f5f7; }
@media screen and (prefers-color-scheme: dark) {
  :root { --ink: #e8eaee; --soft: #a4aab5; --line: #3a3f48; --paper: #17191d; --tint: #20242a; } }
* { box-sizing: border-box; }
body { margin: 0; background: var(--paper); color: var(--ink);
  font: 15px/1.45 system-ui, "Segoe UI", "DejaVu Sans", sans-serif; }
main { max-width: 1080px; margin: 0 auto; padding: 24px 20px 60px; }
h1 { font-size: 26px; margin: 0 0 4px; } h2 { font-size: 19px; margin: 34px 0 8px; text-transform: none; }
h3 { font-size: 15px; margin: 14px 0 4px; } .lead, footer, small { color: var(--soft); }
h2::first-letter { text-transform: uppercase; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; width: 100%; margin: 8px 0 14px; font-size: 13.5px; }
th { text-align: left; color: var(--soft); font-weight: 600; border-bottom: 1.5px solid var(--line); }
th, td { padding: 3px 10px 3px 0; vertical-align: top; } td { border-bottom: 1px solid var(--line); }
.n { text-align: right; white-space: nowrap; }
ul.todo { list-style: none; padding: 0; margin: 6px 0; }
ul.todo li { padding: 2px 0 2px 24px; text-indent: -24px; }
ul.todo li::before { content: "\\2610"; display: inline-block; width: 24px; text-indent: 0; }
.two { display: grid; grid-template-columns: 1.15fr 1fr; gap: 26px; align-items: start; }
.shown img { width: 100%; display: block; background: #fff; border-radius: 6px; margin-bottom: 12px; }
svg { width: 100%; height: auto; background: #fff; border-radius: 6px; margin: 8px 0; }
svg text { font: 11px system-ui, "DejaVu Sans", sans-serif; fill: #333; }
code { font-size: .9em; }
@media (max-width: 720px) { .two { grid-template-columns: 1fr; } main { padding: 14px 12px 40px; } }
@media print {
  @page { size: A4; margin: 13mm; }
  body { font-size: 10.5px; } main { max-width: none; padding: 0; }
  h1 { font-size: 20px; } h2 { font-size: 14.5px; margin-top: 16px; }
  h3 { font-size: 11.5px; margin-top: 8px; }
  table { font-size: 9.5px; } th, td { padding: 1.5px 7px 1.5px 0; } tr, li, svg, img { break-inside: avoid; }
  thead { display: table-header-group; } h2, h3 { break-after: avoid; }
  .sheet { break-before: page; } .wide { overflow: visible; }
  .sheet .shown img { max-height: 118mm; width: auto; max-width: 100%; margin: 0 auto 6px; } }
"""
