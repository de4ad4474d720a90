// SPDX-License-Identifier: MIT
// Style sheet and script of a report.
#include "host/output/report_page.hpp"

namespace glint {

constexpr std::string_view kReportStyle = R"css(
.scenes{display:grid;grid-template-columns:760fr 520fr;gap:14px;margin-top:14px}
.track{fill:none;stroke-width:1.5;stroke-linecap:round;stroke-linejoin:round;opacity:.85}
.now{stroke:var(--card);stroke-width:1}
#turn.live{cursor:grab;touch-action:none}#turn.live:active{cursor:grabbing}
.live-only{display:none}.js .live-only{display:inline}
@media(max-width:900px){.scenes{grid-template-columns:1fr}}
)css";

constexpr std::string_view kReportScript = R"js(
(function(){
  const svg=document.getElementById('turn');
  if(!svg||!window.PointerEvent)return;
  document.documentElement.classList.add('js');
  svg.classList.add('live');
  const start=svg.dataset.view.split(' ').map(Number);
  const box=svg.viewBox.baseVal;
  let [azimuth,elevation,scale,cx,cy,cz]=start;
  const items=[...svg.querySelectorAll('[data-p]')].map(node=>({node,
    shift:(node.dataset.o||'0 0').split(' ').map(Number),
    pieces:node.dataset.p.split(';').map(piece=>piece.split(' ').map(Number))}));
  function draw(){
    const ca=Math.cos(azimuth),sa=Math.sin(azimuth),ce=Math.cos(elevation),se=Math.sin(elevation);
    const see=(p,i)=>{const x=p[i]-cx,y=p[i+1]-cy,z=p[i+2]-cz;
      return [box.width/2+(x*ca+y*sa)*scale,box.height/2-(z*ce+(y*ca-x*sa)*se)*scale]};
    for(const {node,shift,pieces} of items){
      if(node.tagName==='path'){
        let d='';
        for(const p of pieces){
          for(let i=0;i<p.length;i+=3){const s=see(p,i);d+=(i?'L':'M')+s[0].toFixed(1)+' '+s[1].toFixed(1)}
          if(p.length===3)d+='h0';
        }
        node.setAttribute('d',d);
      }else{
        const s=see(pieces[0],0),text=node.tagName==='text';
        node.setAttribute(text?'x':'cx',s[0]+shift[0]);
        node.setAttribute(text?'y':'cy',s[1]+shift[1]);
      }
    }
  }
  let from=null;
  svg.addEventListener('pointerdown',e=>{from=[e.clientX,e.clientY,azimuth,elevation];svg.setPointerCapture(e.pointerId)});
  svg.addEventListener('pointermove',e=>{
    if(!from)return;
    azimuth=from[2]-(e.clientX-from[0])*.008;
    elevation=Math.max(-Math.PI/2,Math.min(Math.PI/2,from[3]+(e.clientY-from[1])*.008));
    requestAnimationFrame(draw);
  });
  for(const end of ['pointerup','pointercancel'])svg.addEventListener(end,()=>{from=null});
  svg.addEventListener('wheel',e=>{e.preventDefault();
    scale=Math.max(start[2]/4,Math.min(start[2]*40,scale*Math.exp(-e.deltaY*.001)));requestAnimationFrame(draw)},{passive:false});
  svg.addEventListener('dblclick',()=>{[azimuth,elevation,scale]=start;draw()});
})();
)js";

}  // namespace glint
