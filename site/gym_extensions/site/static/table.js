/* Sorts, searches and filters the table of a board; its state is in the address. Without it, the page is complete as it is. */
"use strict";

const { make, number, sorted } = page;
const FILTERS = { level: "Level", label: "Task label", algorithm: "Algorithm" };
const FULL_RUNS = 5;
const SCREEN = 50; // Rows per frame: laying out a thousand takes longer than sorting them.
const plain = (text) => text.replace(/\s+/g, " ").trim();

/* Columns of the table, and rows with their values. */

function readTable(table) {
  const columns = [...table.tHead.rows[0].cells].map((head, index) => ({
    head, index, key: head.dataset.key, isNumber: head.dataset.kind === "number",
    title: plain(head.firstChild?.textContent || ""),
  }));
  const rows = [...table.tBodies[0].rows].map((element) => {
    const values = {};
    for (const { key, index, isNumber } of columns) {
      const text = element.cells[index].textContent;
      values[key] = isNumber ? number(text) : plain(text);
    }
    const name = element.querySelector("th i").textContent;
    const find = `${element.cells[0].textContent} ${values.algorithm}`.toLowerCase();
    return { element, values, name, title: plain(element.querySelector("th a").textContent), find };
  });
  return { columns, rows };
}

/* The state, and which rows it shows in which order. */

const readState = (hash) => {
  const value = page.read(hash), filters = Object.fromEntries(Object.keys(FILTERS).map((key) => [key, value(key)]));
  return { q: value("q"), sort: value("sort"), up: value("up") === "1", runs: value("runs"), filters,
    hide: page.names(value("hide")), ticked: page.names(value("compare")).slice(-2), all: value("all") === "1" };
};

const writeState = ({ q, sort, up, runs, filters, hide, ticked, all }) =>
  page.write({ q, sort, up: Number(up), runs, ...filters, hide: hide.join(","), compare: ticked.join(","), all: Number(all) });

function shownRows(rows, state, columns) {
  const words = state.q.toLowerCase().split(/\s+/).filter(Boolean);
  const kept = rows.filter((row) =>
    words.every((word) => row.find.includes(word)) &&
    (!state.runs || row.values.runs >= Number(state.runs)) &&
    Object.entries(state.filters).every(([key, value]) => !value || row.values[key] === value));
  return columns.some((column) => column.key === state.sort) ? sorted(kept, state.sort, state.up) : kept;
}

/* What the state names and the table does not have. */
function unknown(rows, state, columns) {
  const keys = [state.sort, ...state.hide].filter((key) => key && !columns.some((column) => column.key === key));
  const filters = Object.entries(state.filters).filter(([key, value]) => value && !rows.some((row) => row.values[key] === value));
  const names = state.ticked.filter((name) => !rows.some((row) => row.name === name));
  if (state.runs && state.runs !== String(FULL_RUNS)) filters.push(["runs", state.runs]);
  return [...keys, ...filters.map(([, value]) => value), ...names];
}

/* The page. */

function start(table) {
  const { columns, rows } = readTable(table);
  const body = table.tBodies[0];
  const optional = columns.filter((column) => column.key !== "submission");
  let state = readState(location.hash);
  let shown = [], placed = 0, frame = 0;
  const place = (count) => {
    body.append(...shown.slice(placed, placed + count).map((row) => row.element));
    placed = Math.min(placed + count, shown.length);
  };
  const next = (act) => { frame = requestAnimationFrame(() => { frame = requestAnimationFrame(act); }); }; // once painted
  const grow = () => { if (state.all && placed < shown.length) next(() => { place(SCREEN); grow(); }); };

  const search = make("input", { type: "search", autocomplete: "off" });
  const runs = make("select", {}, new Option("any", ""), new Option(`at least ${FULL_RUNS}`, String(FULL_RUNS)));
  const selects = {};
  for (const key of Object.keys(FILTERS)) {
    const values = [...new Set(rows.map((row) => row.values[key]))].filter(Boolean).sort();
    if (values.length > 1) selects[key] = make("select", {}, new Option("any", ""), ...values.map((v) => new Option(v, v)));
  }
  const labelled = (text, control) => make("label", {}, `${text} `, control);
  const status = make("p", { className: "status", role: "status" });
  const compare = make("button", { type: "button" }, "Compare two ticked");
  const reset = make("button", { type: "button" }, "Reset");
  const boxes = optional.map((column) => {
    const box = make("input", { type: "checkbox" });
    box.onchange = () => {
      state.hide = optional.filter((_, at) => !boxes[at].checked).map((item) => item.key);
      update();
    };
    return box;
  });
  const chooser = make("details", { className: "columns" }, make("summary", {}, "Columns"),
    ...optional.map((column, at) => make("label", {}, boxes[at], ` ${column.title}`)));
  const more = make("button", { type: "button", className: "more", onclick: () => { state.all = true; update(); } });
  const tools = make("div", { className: "tools" }, labelled("Search", search), labelled("Runs", runs),
    ...Object.entries(selects).map(([key, select]) => labelled(FILTERS[key], select)), chooser, compare, reset);
  const region = table.closest(".scroll");
  region.before(tools, status);
  region.after(more);

  for (const column of columns) {
    const button = make("button", { type: "button", className: "sort", ariaLabel: `Sort by ${column.title}` });
    button.onclick = () => {
      state.up = state.sort === column.key ? !state.up : !column.isNumber || "lower" in column.head.dataset;
      state.sort = column.key;
      update();
    };
    column.head.append(" ", button);
    column.button = button;
  }
  for (const row of rows) {
    row.box = make("input", { type: "checkbox", className: "tick", ariaLabel: `Compare ${row.title} (${row.name})` });
    row.box.onchange = () => {
      const others = state.ticked.filter((name) => name !== row.name);
      state.ticked = row.box.checked ? [...others, row.name].slice(-2) : others;
      update();
    };
    row.element.cells[0].classList.add("ticked");
    row.element.cells[0].prepend(row.box, " ");
  }
  search.oninput = () => { state.q = search.value; update(); };
  runs.onchange = () => { state.runs = runs.value; update(); };
  for (const [key, select] of Object.entries(selects)) select.onchange = () => { state.filters[key] = select.value; update(); };
  compare.onclick = () => {
    const [first, second] = state.ticked;
    location.href = `${table.dataset.compare}#?${new URLSearchParams({ first, second })}`;
  };
  reset.onclick = () => { state = readState(""); update(); };
  addEventListener("hashchange", () => {
    if (location.hash.startsWith("#?") || !location.hash) { state = readState(location.hash); apply(); }
  });

  addEventListener("beforeprint", () => place(shown.length));
  addEventListener("afterprint", () => { placed = 0; apply(); });

  function update() {
    history.replaceState(null, "", writeState(state));
    apply();
  }

  function apply() {
    const list = shownRows(rows, state, columns);
    cancelAnimationFrame(frame);
    if (!placed || list.length !== shown.length || list.some((row, at) => row !== shown[at])) {
      shown = list;
      body.replaceChildren();
      placed = 0;
      place(SCREEN);
    }
    grow();
    more.hidden = state.all || shown.length <= SCREEN;
    more.textContent = `Show all ${shown.length} rows`;
    for (const row of rows) row.box.checked = state.ticked.includes(row.name);
    for (const column of columns) {
      const active = column.key === state.sort;
      column.button.textContent = active ? (state.up ? "\u2191" : "\u2193") : "\u21c5";
      if (active) column.head.setAttribute("aria-sort", state.up ? "ascending" : "descending");
      else column.head.removeAttribute("aria-sort");
      const hidden = state.hide.includes(column.key);
      if (column.head.hidden !== hidden) {
        column.head.hidden = hidden;
        for (const row of rows) row.element.cells[column.index].hidden = hidden;
        for (const row of table.querySelectorAll(".computed tr")) if (row.cells[column.index]?.colSpan === 1) row.cells[column.index].hidden = hidden;
      }
    }
    search.value = state.q;
    runs.value = state.runs;
    for (const [key, select] of Object.entries(selects)) select.value = state.filters[key];
    optional.forEach((column, at) => { boxes[at].checked = !state.hide.includes(column.key); });
    const total = `${rows.length} ${rows.length === 1 ? "submission" : "submissions"}`;
    const matching = shown.length === rows.length ? total : `${shown.length} of ${total}`;
    const lost = unknown(rows, state, columns), said = lost.length ? `. This table has no ${lost.join(", ")}.` : "";
    status.textContent = (more.hidden ? matching : `${matching}; the first ${SCREEN} are below`) + said;
    compare.disabled = state.ticked.length !== 2;
  }

  apply();
}

for (const table of document.querySelectorAll("table[data-table]")) start(table);
