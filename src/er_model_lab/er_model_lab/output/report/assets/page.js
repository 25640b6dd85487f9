"use strict";
// Replaces the still pictures by plots to zoom into. Where the browser is too old, or anything fails, they stay.
(() => {
  const MOST_POINTS = 4000;
  const NARROW = 700;
  const CONFIG = {
    responsive: true, displaylogo: false, toImageButtonOptions: { format: "svg" },
    modeBarButtons: [["toImage"], ["zoom2d", "pan2d", "zoomIn2d", "zoomOut2d", "resetScale2d"]],
    // measurements never leave this page: no button that uploads, and no place to upload to
    plotlyServerURL: "",
  };

  async function inflate(id) {
    const text = document.getElementById(id).textContent.trim();
    const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
    return new Response(stream).text();
  }

  function unpack({ low, step, rises }) {
    const out = new Float64Array(rises.length);
    let whole = 0;
    rises.forEach((rise, i) => {
      whole += rise ?? 0;
      out[i] = rise === null ? NaN : low + step * whole;
    });
    return out;
  }

  // rows of the range in view: all of them, or the lowest and highest of equal stretches
  function visible(x, y, range) {
    let first = 0;
    let last = x.length - 1;
    while (first < last && !(x[first] >= range[0])) first += 1;
    while (last > first && !(x[last] <= range[1])) last -= 1;
    first = Math.max(first - 1, 0);
    last = Math.min(last + 1, x.length - 1);
    const width = Math.ceil((last - first + 1) / (MOST_POINTS / 2));
    const rows = [];
    if (width < 2) {
      for (let i = first; i <= last; i += 1) rows.push(i);
      return rows;
    }
    for (let start = first; start <= last; start += width) {
      let low = start;
      let high = start;
      let gap = -1;
      for (let i = start; i < Math.min(start + width, last + 1); i += 1) {
        if (Number.isNaN(y[i])) gap = i;
        else {
          if (!(y[i] >= y[low])) low = i;
          if (!(y[i] <= y[high])) high = i;
        }
      }
      rows.push(...new Set([low, high, ...(gap < 0 ? [] : [gap])].sort((a, b) => a - b)));
    }
    return rows;
  }

  function thinned(plot, range) {
    return plot.long.map(({ trace, x, y }) => {
      const rows = visible(plot.curves[x], plot.curves[y], range);
      const pick = (values) => rows.map((i) => (Number.isNaN(values[i]) ? null : values[i]));
      return { trace, x: pick(plot.curves[x]), y: pick(plot.curves[y]) };
    });
  }

  function follow(plot, host) {
    host.on("plotly_relayout", (change) => {
      if (!Object.keys(change).some((key) => key.startsWith("xaxis"))) return;
      const axis = host.layout.xaxis;
      const found = thinned(plot, axis.autorange ? plot.whole : axis.range);
      Plotly.restyle(host, { x: found.map((c) => c.x), y: found.map((c) => c.y) }, found.map((c) => c.trace));
    });
  }

  function addTools(plot, host, tools) {
    const start = [...plot.layout.xaxis.range];
    const show = (range) => {
      const change = { "xaxis.range": range };
      Object.keys(host.layout).filter((k) => k.startsWith("yaxis")).forEach((k) => { change[`${k}.autorange`] = true; });
      return Plotly.relayout(host, change);
    };
    const step = (by) => () => {
      const [low, high] = host.layout.xaxis.range;
      const room = by < 0 ? plot.whole[0] - low : plot.whole[1] - high;
      const shift = by < 0 ? Math.max(by * (high - low), Math.min(room, 0)) : Math.min(by * (high - low), Math.max(room, 0));
      return show([low + shift, high + shift]);
    };
    const buttons = [
      ["worst 5 s", () => show([...start])], ["\u2190", step(-0.8)], ["\u2192", step(0.8)], ["all", () => show([...plot.whole])],
    ];
    buttons.forEach(([name, act]) => {
      const button = document.createElement("button");
      button.type = "button";
      button.textContent = name;
      button.addEventListener("click", act);
      tools.append(button);
    });
    tools.hidden = false;
  }

  // on a narrow screen the legend takes more rows, and gets room for them
  function makeRoom(plot, width) {
    const names = [...plot.data, ...plot.layout.shapes].filter((item) => item.showlegend).map((item) => item.name.length);
    const rows = Math.ceil(names.reduce((sum, length) => sum + 7 * length + 50, 0) / Math.max(width - (width < NARROW ? 80 : 180), 100));
    const extra = 20 * Math.max(rows - 1, 0);
    plot.layout.margin.t += extra;
    plot.layout.height += extra;
  }

  // names below bars are turned where they would run into one another
  function turnNames(layout, width) {
    Object.entries(layout).filter(([key, axis]) => key.startsWith("xaxis") && axis.ticktext).forEach(([, axis]) => {
      const room = (width - 80) * (axis.domain[1] - axis.domain[0]) / axis.ticktext.length;
      const longest = Math.max(...axis.ticktext.flatMap((text) => text.split("<br>")).map((line) => line.length));
      if (6.5 * longest > room) axis.tickangle = -60;
    });
  }

  async function draw(plot) {
    const figure = document.querySelector(`figure[data-plot="${plot.name}"]`);
    const host = figure.querySelector(".live");
    plot.curves = plot.packed.map(unpack);
    const range = plot.layout.xaxis.range ?? plot.whole;
    thinned(plot, range).forEach(({ trace, x, y }) => Object.assign(plot.data[trace], { x, y }));
    figure.classList.add("is-live");
    makeRoom(plot, host.clientWidth);
    if (host.clientWidth < NARROW) turnNames(plot.layout, host.clientWidth);
    host.style.height = `${plot.layout.height}px`;
    try {
      const config = { ...CONFIG, displayModeBar: host.clientWidth >= NARROW };
      await Plotly.newPlot(host, plot.data, plot.layout, config);
    } catch (error) {
      figure.classList.remove("is-live");
      throw error;
    }
    if (plot.long.length) follow(plot, host);
    if (plot.whole) addTools(plot, host, figure.querySelector(".tools"));
  }

  async function start() {
    if (!document.getElementById("er-plots") || !("DecompressionStream" in window)) return;
    const library = document.createElement("script");
    library.textContent = await inflate("er-library");
    document.head.append(library);
    const plots = JSON.parse(await inflate("er-plots"));
    for (const plot of plots) {
      await draw(plot);
      // the page stays usable while the next plot waits
      await new Promise((done) => { setTimeout(done, 0); });
    }
    document.body.dataset.plots = "ready";
  }

  // on paper nothing can be opened; the cards that are closed are of effects that do not matter
  window.addEventListener("beforeprint", () => document.querySelectorAll("details:not(.card)").forEach((d) => { d.open = true; }));
  // a link to a card opens it
  window.addEventListener("hashchange", () => {
    const card = document.getElementById(window.location.hash.slice(1));
    if (card instanceof HTMLDetailsElement) card.open = true;
  });
  start().catch((error) => console.warn("the plots could not be made live:", error));
})();
