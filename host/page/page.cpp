// SPDX-License-Identifier: MIT
// Frame and style sheet of all pages.
#include "host/page/page.hpp"

#include "host/page/page_text.hpp"

namespace glint {
namespace {

constexpr std::string_view kStyle = R"css(
:root{color-scheme:light dark;--ground:#f6f7f9;--card:#fff;--ink:#1c2530;--soft:#5d6b7a;--rule:#dfe4ea;
--grid:#e3e8ee;--accent:#1769c2;--wash:#1769c226;--warn:#c2410c;--camera:#3d4a58}
@media(prefers-color-scheme:dark){:root{--ground:#12161b;--card:#1a2027;--ink:#e6ebf0;--soft:#97a5b4;
--rule:#2c353f;--grid:#2a333d;--accent:#62aef7;--wash:#62aef730;--warn:#fb923c;--camera:#b9c5d1}}
*{box-sizing:border-box}
body{margin:0;background:var(--ground);color:var(--ink);
font:15px/1.5 system-ui,-apple-system,"Segoe UI",Roboto,"Noto Sans","DejaVu Sans",sans-serif}
main{max-width:1240px;margin:0 auto;padding:32px 24px 48px}
h1{font-size:26px;font-weight:650;letter-spacing:-.01em;margin:0}
h2{font-size:15px;font-weight:650;margin:0 0 2px}
.soft{color:var(--soft)}p{margin:2px 0 0}
.heads{display:grid;grid-template-columns:repeat(auto-fit,minmax(180px,1fr));gap:14px;margin:24px 0 14px}
.card{background:var(--card);border:1px solid var(--rule);border-radius:10px;padding:16px 18px;min-width:0}
.heads .value{font-size:20px;font-weight:650;letter-spacing:-.02em;font-variant-numeric:tabular-nums;line-height:1.25}
.small{font-size:12.5px;color:var(--soft)}
.two{display:grid;grid-template-columns:1fr 1fr;gap:14px;margin-top:14px}
table{border-collapse:collapse;width:100%;font-variant-numeric:tabular-nums}
.rows{columns:2;column-gap:40px}
.row{display:flex;justify-content:space-between;gap:16px;padding:5px 0;border-bottom:1px solid var(--rule);
break-inside:avoid}
.row b{font-weight:550;text-align:right}.row .small{display:block;font-weight:400}
svg{display:block;width:100%;height:auto;overflow:hidden}
svg text{font-size:12px;fill:var(--soft);font-variant-numeric:tabular-nums}
.mid{text-anchor:middle}.end{text-anchor:end}.start{text-anchor:start}
svg .unit{font-size:12.5px;fill:var(--ink)}svg .strong{fill:var(--ink);font-weight:600}
.grid{stroke:var(--grid);stroke-width:1;fill:none}.axis,.tick{stroke:var(--soft);stroke-width:1;fill:none}
.bar{fill:var(--accent)}.area{fill:var(--wash)}.curve{fill:none;stroke:var(--accent);stroke-width:2}
.mark{stroke:var(--warn);stroke-width:1.2;stroke-dasharray:3 3}
.nominal{stroke:var(--soft);stroke-width:1.2;stroke-dasharray:5 4}
.camera{fill:none;stroke:var(--camera);stroke-width:1.2;stroke-linejoin:round}
.lens{fill:var(--wash);stroke:var(--camera);stroke-width:1.6;stroke-linejoin:round}
svg .name{fill:var(--ink);font-weight:600;paint-order:stroke;stroke:var(--card);stroke-width:3px}
.keys{display:flex;flex-wrap:wrap;gap:4px 14px;margin-top:10px}
.keys span{white-space:nowrap;font-size:12.5px;color:var(--soft)}
.keys i{display:inline-block;width:10px;height:10px;border-radius:5px;margin-right:5px}
@media(max-width:900px){.two{grid-template-columns:1fr}.rows{columns:1}}
@media print{body{background:#fff}.card{break-inside:avoid}}
)css";

}  // namespace

std::string page_html(const std::string& title, std::string_view style, std::string_view body,
                      std::string_view script) {
  std::string page =
      "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">"
      "<meta name=\"viewport\" content=\"width=device-width,initial-scale=1\"><title>";
  page.append(escape_html(title)).append("</title><style>").append(kStyle).append(style);
  page.append("</style></head><body><main>").append(body).append("</main>");
  if (!script.empty()) page.append("<script>").append(script).append("</script>");
  return page.append("</body></html>\n");
}

}  // namespace glint
