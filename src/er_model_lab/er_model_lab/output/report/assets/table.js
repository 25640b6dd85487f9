"use strict";
// Tables that are turned in pages. Their rows lie in the page, or in files beside it that are read when they are looked
// at: scripts, because a page that is opened as a file may read nothing else.
(() => {
  const KEPT = 8;
  const arriving = new Map();
  window.erRows = (file, packed) => arriving.get(file)(packed);

  async function unpack(packed) {
    const bytes = Uint8Array.from(atob(packed), (c) => c.charCodeAt(0));
    return new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"))).json();
  }

  function read(file) {
    return new Promise((done, failed) => {
      arriving.set(file, done);
      const script = document.createElement("script");
      script.onload = () => script.remove();
      script.onerror = () => failed(new Error(`${file} cannot be read`));
      script.src = file;
      document.head.append(script);
    }).then(unpack).finally(() => arriving.delete(file));
  }

  // rows by their files: the last ones looked at stay
  function shelf({ rows, files }) {
    const kept = new Map();
    return (k) => {
      if (rows) return rows;
      const found = kept.get(k) ?? read(files[k]);
      kept.delete(k);
      kept.set(k, found);
      found.catch(() => kept.delete(k));
      if (kept.size > KEPT) kept.delete(kept.keys().next().value);
      return found;
    };
  }

  function turn(box) {
    const { head, size, chunk, count, rows, files } = JSON.parse(box.querySelector("script").textContent);
    const taken = shelf({ rows, files });
    const [find, from, back, on, where, table] = ["[type=search]", "[type=number]", ".back", ".on", "output", "table"]
      .map((name) => box.querySelector(name));
    let first = 0;
    let found = null; // places of the rows that hold what is looked for; null: all
    let asked = 0; // what was asked for last: an older answer is dropped
    const total = () => (found ? found.length : count);
    const cell = (line, kind, text) => {
      const made = document.createElement(kind);
      made.textContent = text;
      made.className = "text";
      if (kind === "th") made.scope = line.parentNode === table.tHead ? "col" : "row";
      line.append(made);
    };
    head.forEach((name) => cell(table.tHead.rows[0], "th", name));

    async function show(now, searched = 1) {
      first = Math.max(0, Math.min(first, total() - 1));
      first -= first % size;
      const last = Math.min(first + size, total());
      const seen = [];
      for (let k = first; k < last; k += 1) {
        const place = found ? found[k] : k;
        const near = await taken(Math.floor(place / chunk));
        seen.push(near[place % chunk]);
      }
      if (now !== asked) return;
      const body = table.tBodies[0];
      body.replaceChildren();
      seen.forEach((row) => {
        const line = body.insertRow();
        row.forEach((text, k) => cell(line, k ? "td" : "th", text));
      });
      const rest = searched < 1 ? `, ${Math.floor(100 * searched)} % searched` : "";
      where.textContent = (last ? `${first + 1} to ${last} of ${total()}` : "none") + rest;
      [from.value, from.max, back.disabled, on.disabled] = [last ? first + 1 : "", total(), first === 0, last >= total()];
    }

    async function search(now) {
      const wanted = find.value.toLowerCase();
      found = wanted ? [] : null;
      first = 0;
      const parts = Math.ceil(count / chunk);
      for (let k = 0, drawn = -1; wanted && k < parts; k += 1) {
        const near = await taken(k);
        if (now !== asked) return;
        near.forEach((row, i) => {
          if (row.some((text) => text.toLowerCase().includes(wanted))) found.push(k * chunk + i);
        });
        if (k + 1 < parts && (drawn < size || k % 10 === 0)) {
          drawn = found.length;
          await show(now, (k + 1) / parts);
        }
      }
      await show(now);
    }

    const ask = (act) => {
      asked += 1;
      act(asked).catch((error) => { where.textContent = error.message; });
    };
    const go = (to) => { first = to; ask(show); };
    find.addEventListener("input", () => ask(search));
    from.addEventListener("change", () => go((Number(from.value) || 1) - 1));
    back.addEventListener("click", () => go(first - size));
    on.addEventListener("click", () => go(first + size));
    table.addEventListener("keydown", (event) => {
      const to = { ArrowLeft: first - size, ArrowRight: first + size, Home: 0, End: total() - 1 }[event.key];
      if (to === undefined) return;
      event.preventDefault();
      go(to);
    });
    ask(show);
  }

  document.querySelectorAll(".paged").forEach(turn);
})();
