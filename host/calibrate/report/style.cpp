// SPDX-License-Identifier: MIT
// What a calibration's report adds to the style of all pages.
#include "host/calibrate/report/style.hpp"

namespace glint {

constexpr std::string_view kCalibrationStyle = R"css(
:root{--excellent:#15803d;--good:#1769c2;--poor:#b45309;--refuse:#b91c1c}
@media(prefers-color-scheme:dark){:root{--excellent:#4ade80;--good:#62aef7;--poor:#fbbf24;--refuse:#f87171}}
.excellent{--level:var(--excellent)}.good{--level:var(--good)}.poor{--level:var(--poor)}.refuse{--level:var(--refuse)}
.verdict{margin-top:24px;border-left:6px solid var(--level)}
.verdict .word{font-size:44px;font-weight:700;letter-spacing:-.03em;line-height:1.15;color:var(--level)}
.verdict .rule{margin-top:4px;font-size:14px;color:var(--soft)}
.pill{display:inline-block;border-radius:9px;padding:0 9px;font-size:12.5px;font-weight:600;white-space:nowrap;
color:var(--level);border:1.5px solid var(--level)}
.scroll{overflow-x:auto}
th,td{padding:5px 10px 5px 0;border-bottom:1px solid var(--rule);text-align:left;vertical-align:top}
th{font-weight:500;color:var(--soft);font-size:12.5px;white-space:nowrap}
td.n,th.n{text-align:right;padding:5px 0 5px 14px}td.n{white-space:nowrap}
td.whole{white-space:nowrap}tr:last-child td{border-bottom:0}
.verdict table{margin-top:14px}.verdict td b{font-weight:550}
h2.part{font-size:19px;margin:34px 0 0}
.three{display:grid;grid-template-columns:1.25fr 1fr 1fr;gap:4px 22px;margin-top:10px}
.three h3{font-size:12.5px;font-weight:550;color:var(--soft);margin:0 0 4px}
.figures{display:flex;flex-wrap:wrap;gap:2px 22px;font-size:13.5px;font-variant-numeric:tabular-nums}
.figures b{font-weight:600}
ul{margin:6px 0 0;padding-left:20px}
.heat{shape-rendering:crispEdges}.cell{stroke:var(--grid);stroke-width:1}.frame{stroke:var(--soft);stroke-width:1}
.arrow{stroke:#0d1117;stroke-width:1.7;fill:none;stroke-linecap:round;stroke-linejoin:round;opacity:.85}
.halo{stroke:#fff;stroke-width:3.4;fill:none;stroke-linecap:round;stroke-linejoin:round;opacity:.5}
.key{stroke:var(--ink);stroke-width:1.7;fill:none;stroke-linecap:round;stroke-linejoin:round}
.samples{stroke:var(--accent);stroke-width:2.6;stroke-linecap:round;opacity:.5;fill:none}
.field{fill:var(--wash);stroke:var(--camera);stroke-width:1;stroke-opacity:.35;stroke-linejoin:round}
.eye{fill:var(--camera);stroke:var(--card);stroke-width:2}
.link{stroke:var(--accent);opacity:.55;stroke-linecap:round}
.outline{fill:none;stroke:var(--warn);stroke-width:1.8;stroke-linejoin:round}
svg .count{font-size:15px;fill:var(--ink)}svg .bad{font-size:15px;fill:var(--refuse);font-weight:600}
svg .name{stroke-width:4px}
@media(max-width:900px){.three{grid-template-columns:1fr}}
)css";

}  // namespace glint
