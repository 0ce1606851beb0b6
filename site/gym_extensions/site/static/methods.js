// The table of methods: sorts its lists, switches what the cells show, orders by some groups only, and opens Compare.
// The state is in the address. Without it, the page is complete.
"use strict";
(() => {
  const FIRST = 100; // rows that are shown of many
  const SIDES = ["first", "second", "third", "fourth"]; // of the page Compare

  const { fixed, make, number, sorted } = page;
  const read = (hash) => {
    const value = page.read(hash);
    return { cells: value("cells"), list: value("list"), groups: page.names(value("groups")), sort: value("sort"), up: value("up") === "1",
      ticked: page.names(value("compare")).slice(0, SIDES.length), all: value("all") === "1" };
  };
  const write = ({ cells, list, groups, sort, up, ticked, all }) =>
    page.write({ cells, list, groups: groups.join(","), sort, up: Number(up), compare: ticked.join(","), all: Number(all) });
  // The mean of the values at some places; null if one of them is missing.
  const meanAt = (values, places) => {
    const found = places.map((at) => values[at]);
    return found.length && found.every((value) => value !== null) ? found.reduce((a, b) => a + b) / found.length : null;
  };
  if (typeof module !== "undefined") module.exports = { meanAt };
  if (typeof document === "undefined") return;

  // The page Play in place of the drawings. It loads the simulator; its menus have the method, the run and the stage.
  const offer = document.getElementById("simulate");
  if (offer) {
    const button = offer.querySelector("button"), section = offer.closest(".forgetting"), choices = [...section.querySelectorAll("input")];
    const address = () => choices.find((input) => input.checked).value.replace("#", "?in-page#");
    const live = make("iframe", { title: offer.dataset.title });
    button.addEventListener("click", () => {
      if (location.protocol === "file:") {
        offer.querySelector("span").textContent = "It needs a web server: run “python -m http.server” in the folder of the site.";
        return;
      }
      live.src = address();
      section.classList.add("live");
      offer.remove();
      section.querySelector("#stage").before(live);
      live.focus();
    });
    for (const input of choices) input.addEventListener("change", () => { if (live.isConnected) live.contentWindow.location.replace(address()); });
    offer.hidden = false;
  }

  const table = document.getElementById("core-table");
  if (!table) return;
  const labelled = (text, control) => make("label", {}, control, ` ${text}`);
  const metrics = table.dataset.metrics.split(" "), keys = metrics.map((name) => name.toLowerCase()); // the first is what cells show
  const groups = table.dataset.groups.split(" "), allPlaces = groups.map((_, at) => at);
  const heads = [...table.tHead.rows[0].cells], at = (key) => heads.findIndex((head) => head.dataset.key === key);
  let state = read(location.hash), chosen = allPlaces;

  function rowOf(element) {
    const cells = [...element.cells], shift = heads.length - cells.length; // a row without a score has one cell for two columns
    const cell = (key) => cells[at(key) - (at(key) > 2 ? shift : 0)];
    const numbers = element.dataset.cells.split(";").map((part) => part.split(" ").map((text) => (text === "-" ? null : Number(text) / 1000)));
    const shown = groups.map((_, place) => cell(`g${place}`)), link = element.querySelector("th a");
    const values = { name: link.textContent.toLowerCase(), rank: number(cell("rank").textContent), kept: shift ? null : number(cell("kept").textContent),
      forgotten: number(cell("forgotten").textContent), minutes: number(cell("minutes").textContent),
      tuning: number(cell("tuning").dataset.v), level: cell("level").textContent.trim() };
    const box = make("input", { type: "checkbox", className: "tick", ariaLabel: `Compare ${link.textContent} (${element.dataset.name})` });
    box.addEventListener("change", () => {
      const others = state.ticked.filter((name) => name !== element.dataset.name);
      update({ ticked: box.checked ? [...others, element.dataset.name].slice(-SIDES.length) : others });
    });
    element.cells[0].append(" ", make("label", { className: "pick" }, box));
    // A number opens what is behind it: the first text of its cell becomes a link, as on all pages.
    element.dataset.number = link.getAttribute("href").replace(/\.html$/, "/core.js");
    const opener = (text, name) => {
      const made = make("a", { className: "n", href: link.href }, text);
      made.dataset.of = name;
      return made;
    };
    for (const key of ["kept", "forgotten", "minutes", "tuning"]) {
      const text = key === "kept" && shift ? null : cell(key).querySelector("b") || cell(key).firstChild;
      if (text && /\d/.test(text.textContent)) text.replaceWith(opener(text.cloneNode(true), metrics[0]));
    }
    shown.forEach((each, place) => { if (!each.firstElementChild && each.textContent.trim() !== "\u2013") each.replaceChildren(opener(each.textContent, groups[place])); });
    const texts = shown.map(({ className, innerHTML }) => [className, innerHTML]);
    const rank = cell("rank"), kept = shift ? null : cell("kept"), first = { rank: rank.firstChild.data, html: kept?.innerHTML, kept: values.kept };
    return { element, name: element.dataset.name, numbers, shown, texts, opener, values, box, rank, kept, first };
  }
  const lists = [...table.tBodies].filter((body) => body.dataset.list).map((body) => ({
    body, key: body.dataset.list, rows: [...body.rows].filter((row) => row.dataset.name).map(rowOf),
  }));
  const longest = Math.max(...lists.map(({ rows }) => rows.length));

  const radios = (name, title, options) => {
    const inputs = Object.entries(options).map(([value, text]) => {
      const input = make("input", { type: "radio", name, value });
      input.addEventListener("change", () => update({ [name]: value }));
      return [input, labelled(text, input)];
    });
    const group = make("div", { className: "methods", role: "radiogroup", ariaLabel: title }, make("strong", {}, title), ...inputs.map(([, label]) => label));
    return [inputs.map(([input]) => input), group];
  };
  const [cellInputs, cellSet] = radios("cells", "Cells", Object.fromEntries(metrics.map((name, i) => [i ? keys[i] : "", name])));
  const [listInputs, listSet] = radios("list", "Lists", { "": "both", 0: "without task label", 1: "with it" });
  const boxes = groups.map((group) => {
    const box = make("input", { type: "checkbox" });
    box.addEventListener("change", () => {
      const names = groups.filter((_, place) => boxes[place].checked);
      update({ groups: names.length === groups.length ? [] : names });
    });
    return box;
  });
  const chooser = make("details", { className: "columns" }, make("summary", {}, "Choose groups"),
    ...groups.map((group, place) => labelled(group, boxes[place])));
  const compare = make("button", { type: "button" });
  compare.addEventListener("click", () => { location.href = `${table.dataset.compare}#?${new URLSearchParams(state.ticked.map((name, i) => [SIDES[i], name]))}`; });
  const status = make("p", { className: "status", role: "status" });
  const more = make("button", { type: "button", className: "more" });
  more.addEventListener("click", () => update({ all: true }));
  const region = table.closest(".scroll");
  region.before(make("div", { className: "tools" }, cellSet, listSet, chooser, compare), status);
  region.after(more);
  table.caption.append(" Numbers of methods open.");

  for (const head of heads) {
    const key = head.dataset.key === "drawn" ? "kept" : head.dataset.key;
    head.querySelector(".head").addEventListener("click", () => {
      const shown = /^g\d/.test(key) ? state.cells : key, low = ["rank", "name", "forgotten", "minutes", "tuning"].includes(shown); // what is best first
      update({ sort: key, up: state.sort === key ? !state.up : low });
    });
  }

  // What rows are sorted by: the metric that the cells show, and the mean over the chosen groups.
  const metricOf = () => Math.max(keys.indexOf(state.cells), 0);
  function evaluate(row) {
    const values = row.numbers[metricOf()];
    allPlaces.forEach((place) => { row.values[`g${place}`] = values[place]; });
    row.values.kept = chosen.length < allPlaces.length || !row.kept ? meanAt(row.numbers[0], chosen) : row.first.kept;
  }

  // A cell shows a metric of its group; only kept has a test, and so a frame or hatching.
  function paint(row) {
    const metric = metricOf(), cold = keys[metric] === "forgotten" ? 1 : -1; // what is lost is orange
    row.shown.forEach((cell, place) => {
      const value = row.numbers[metric][place], [kind, html] = row.texts[place], isOther = metric && row.numbers[0][place] !== null;
      cell.className = isOther ? `cell ${value * cold > 0 ? "cold" : ""} h${Math.min(10, Math.round(10 * Math.abs(value)))}` : kind;
      if (isOther) cell.replaceChildren(value === null ? "\u2013" : row.opener(fixed(value), groups[place]));
      else cell.innerHTML = html;
      cell.classList.toggle("left-out", !chosen.includes(place));
    });
    const isPart = chosen.length < allPlaces.length, { kept } = row.values;
    row.rank.firstChild.data = isPart ? "\u2013" : row.first.rank;
    if (row.kept) row.kept.innerHTML = isPart ? `<b>${kept === null ? "\u2013" : fixed(kept)}</b>` : row.first.html;
    row.box.checked = state.ticked.includes(row.name);
  }

  function apply() {
    const known = state.groups.filter((name) => groups.includes(name)), lost = state.groups.filter((name) => !groups.includes(name));
    for (const [name, values] of Object.entries({ cells: keys, list: lists.map((list) => list.key), sort: heads.map((head) => head.dataset.key) })) {
      if (!state[name] || values.includes(state[name])) continue;
      lost.push(state[name]);
      state[name] = "";
    }
    chosen = known.length ? allPlaces.filter((place) => known.includes(groups[place])) : allPlaces;
    boxes.forEach((box, place) => { box.checked = chosen.includes(place); });
    const key = state.sort || (chosen === allPlaces ? "" : "kept");
    for (const { body, key: label, rows } of lists) {
      body.hidden = state.list !== "" && state.list !== label;
      rows.forEach(evaluate);
      const order = key ? sorted(rows, key, state.up) : rows, shown = state.all ? order : order.slice(0, FIRST);
      shown.forEach(paint);
      body.replaceChildren(body.rows[0], ...shown.map(({ element }) => element));
    }
    for (const head of heads) {
      if (head.dataset.key === key && key) head.setAttribute("aria-sort", state.up ? "ascending" : "descending");
      else head.removeAttribute("aria-sort");
    }
    for (const input of cellInputs) input.checked = input.value === (keys.indexOf(state.cells) > 0 ? state.cells : "");
    for (const input of listInputs) input.checked = input.value === state.list;
    more.hidden = state.all || longest <= FIRST;
    more.textContent = `Show all ${longest} rows of a list`;
    const unknown = [...lost, ...state.ticked.filter((name) => !lists.some(({ rows }) => rows.some((row) => row.name === name)))];
    status.textContent = [unknown.length ? `This table has no ${unknown.join(", ")}.` : "",
      known.length ? `Kept is the mean over ${known.length} of ${groups.length} groups, not tested; drawings and other columns are over all.` : "",
      metricOf() ? "What cells show now has no test on a group: no frames, no hatching." : ""].filter(Boolean).join(" ");
    compare.disabled = state.ticked.length < 2;
    compare.textContent = state.ticked.length < 2 ? "Tick two to four to compare" : `Compare ${state.ticked.length}`;
  }

  function update(change) {
    state = { ...state, ...change };
    history.replaceState(null, "", write(state));
    apply();
  }

  // A link to commands opens them.
  function open() {
    const target = document.querySelector(":target"), details = target?.closest("details");
    if (details) { details.open = true; target.scrollIntoView({ block: "nearest" }); }
  }
  addEventListener("hashchange", () => { if (location.hash.startsWith("#?") || !location.hash) { state = read(location.hash); apply(); } else open(); });
  apply();
  open();
})();
