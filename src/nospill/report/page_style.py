"""The style sheet of the page: light, narrow screens first, and paper."""

from __future__ import annotations

STYLE = """
*{box-sizing:border-box}
body{margin:0;background:#fff;color:#1c1c1c;font:15px/1.45 system-ui,"Segoe UI",Roboto,"DejaVu Sans",sans-serif}
main{max-width:980px;margin:0 auto;padding:18px 16px 40px}
h1{font-size:26px;line-height:1.2;margin:0;overflow-wrap:anywhere}
h2{font-size:17px;margin:26px 0 8px;padding-bottom:3px;border-bottom:1px solid #ccc}
p{margin:4px 0}
.about{color:#444;overflow-wrap:anywhere}
.note{color:#444;font-size:13px;margin-top:6px}
.verdict{display:flex;gap:12px;align-items:flex-start;margin:10px 0;padding:10px 12px;border:2px solid;
border-left-width:9px}
.verdict strong{font-size:18px;letter-spacing:.03em}
.verdict p{color:#1c1c1c;overflow-wrap:anywhere}
.verdict.yes{color:#00704F;background:#EFF8F4}
.verdict.no{color:#9A4300;background:#FBF0E8}
.verdict.unknown{color:#555;background:#F5F5F5}
.sign{width:34px;height:34px;flex:none;margin-top:2px}
.tiles{display:grid;grid-template-columns:repeat(auto-fill,minmax(140px,1fr));gap:8px;
list-style:none;margin:14px 0;padding:0}
.tiles li{margin:0;border:1px solid #ddd;border-radius:4px;padding:7px 9px;font-size:12.5px;line-height:1.3;color:#333}
.tiles b{display:block;font-size:20px;color:#0072B2}
.tiles .fails{border-color:#9A4300}
.tiles .fails b{color:#9A4300}
.first{max-width:560px;margin:0 auto 14px}
details{margin-top:6px;font-size:13.5px}
summary{cursor:pointer}
.pair{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(100%,400px),1fr));gap:14px;align-items:start}
.flow{columns:2 380px;column-gap:14px}
.flow figure{margin-bottom:14px}
figure{margin:0;break-inside:avoid}
figure img{width:100%;height:auto;display:block}
figcaption{font-size:12.5px;color:#444}
.scroll{overflow-x:auto}
table{border-collapse:collapse;width:100%;font-size:13.5px}
th,td{text-align:left;vertical-align:top;padding:3px 10px 3px 0}
thead th{border-bottom:1px solid #444;white-space:nowrap}
tbody th{font-weight:normal}
tbody tr:nth-child(even){background:#F6F6F6}
.wide th,.wide td{white-space:nowrap}
.wide td.long{white-space:normal;min-width:18em}
.scene{margin:0 0 14px}
.facts th{width:26%;min-width:110px;color:#444}
.facts td{overflow-wrap:anywhere}
.small{font-size:12px}
.number{text-align:right;font-variant-numeric:tabular-nums}
.bar{width:120px;height:13px;display:block;margin-top:3px}
.fails th,.fails td{color:#9A4300;font-weight:bold}
ul{padding-left:20px;margin:6px 0}
li{margin:3px 0}
@media(max-width:600px){
.certificate th:nth-child(3),.certificate td:nth-child(3),.certificate th:nth-child(8),.certificate td:nth-child(8)
{display:none}
.wide:not(.certificate) thead{display:none}
.wide:not(.certificate) tr{display:block;padding:5px 0}
.wide:not(.certificate) th{display:block;font-weight:bold}
.wide:not(.certificate) td{display:inline-block;white-space:normal;padding-right:14px}
.wide:not(.certificate) td:empty{display:none}
.wide td.long{min-width:0}
.wide td[data-column]::before{content:attr(data-column) " ";color:#666}
.certificate td:nth-child(2){white-space:normal;overflow-wrap:anywhere}
.certificate{font-size:12px}
.certificate th,.certificate td{padding-right:6px}
}
@media print{
@page{size:A4;margin:14mm 12mm}
body{font-size:10.5pt}
main{max-width:none;padding:0}
h2{break-after:avoid}
tr,.verdict,.tiles li{margin:0;break-inside:avoid}
.scroll{overflow:visible}
.wide th,.wide td{white-space:normal}
table{font-size:8.5pt}
.small{font-size:7pt}
.pair{grid-template-columns:1fr 1fr}
}
"""
"""No address in it, and nothing that a browser would have to fetch."""
