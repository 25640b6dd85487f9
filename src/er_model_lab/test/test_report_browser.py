"""The page in a browser, where there is one: the plots come alive, zooming shows every sample, nothing is fetched."""

from __future__ import annotations

import html
import json
import re
import shutil
import subprocess
from pathlib import Path

import pytest
from er_model_lab.output.report import page as page_module
from er_model_lab.output.report.page import write_report
from report_views import view

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
BROWSER = next((path for name in BROWSERS if (path := shutil.which(name))), None)
PROBE = """<script>
const seen = { refused: [], errors: [] };
document.addEventListener("securitypolicyviolation", (e) => seen.refused.push(e.blockedURI));
window.addEventListener("error", (e) => seen.errors.push(e.message));
const pause = (ms) => new Promise((done) => setTimeout(done, ms));
(async () => {
  while (document.body.dataset.plots !== "ready") await pause(50);
  const host = document.querySelector("#figure-time_series .live");
  const points = () => ({ n: host.data[0].x.length, range: [...host.layout.xaxis.range],
    top: Math.max(...host.data[0].y.filter((v) => v !== null)) });
  seen.start = points();
  [...document.querySelectorAll("#figure-time_series .tools button")].at(-1).click();
  await pause(500);
  seen.all = points();
  await Plotly.relayout(host, { "xaxis.range[0]": 10, "xaxis.range[1]": 12 });
  await pause(500);
  seen.zoomed = points();
  seen.live = document.querySelectorAll("figure.is-live").length;
  seen.fetched = performance.getEntriesByType("resource").map((e) => e.name);
  seen.buttons = [...document.querySelectorAll(".modebar-btn")].map((b) => b.dataset.title);
  const out = document.createElement("pre");
  out.id = "probe";
  out.textContent = JSON.stringify(seen);
  document.body.append(out);
})();
</script></body>"""


@pytest.mark.skipif(BROWSER is None, reason="no Chromium or Chrome on this machine")
def test_the_plots_come_alive_and_nothing_is_fetched(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(page_module, "still", lambda _: (b"\x89PNG", b"<svg/>"))
    monkeypatch.setattr(page_module, "picture", lambda *_: "data:,")
    v = view(seconds=60.0)
    page = write_report(v, tmp_path)
    probe = tmp_path / "probe.html"
    probe.write_text(page.read_text(encoding="utf-8").replace("</body>", PROBE), encoding="utf-8")
    command = [
        str(BROWSER),
        "--headless=new",
        "--no-sandbox",
        "--disable-gpu",
        f"--user-data-dir={tmp_path / 'profile'}",
    ]
    command += ["--virtual-time-budget=30000", "--dump-dom", probe.as_uri()]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)
    found = re.search(r'<pre id="probe">(.*?)</pre>', done.stdout, re.DOTALL)
    assert found, done.stderr[-500:]
    seen = json.loads(html.unescape(found.group(1)))
    assert seen["refused"] == seen["errors"] == seen["fetched"] == []
    assert seen["live"] == len([f for f in page_module.figures(v) if f.interactive])
    assert not any("loud" in title or "hare" in title for title in seen["buttons"])
    low, high = seen["start"]["range"]
    assert high - low == pytest.approx(5.0, abs=0.05)
    assert seen["start"]["n"] == pytest.approx(1001, abs=3), (
        "every sample of the first five seconds"
    )
    assert seen["zoomed"]["n"] == pytest.approx(401, abs=3), "every sample of the two seconds"
    assert 2000 < seen["all"]["n"] <= 4100, "thinned when all is in view"
    peak = max(float(r.measured.max()) for r in v.records)
    assert seen["all"]["top"] == pytest.approx(peak, abs=0.02), "and the peak is still there"
