/* The page Compare: two menus of entries, the pooled answer first, then the difference on every common board.
   The state is in the fragment of the address, as #?first=cloning&second=trpo, so that it works from a file, too. */
"use strict";

let index = null;
const loaded = {};
function compareIndex(document) { index = document; start(); }
function boardPairs(document) { loaded[document.board] = document; }

const fixed = (value, digits = 2) => {
  const text = value.toFixed(digits);
  return text.startsWith("-") ? (/[1-9]/.test(text) ? "\u2212" : "") + text.slice(1) : text;
};
const range = (low, high) => `${fixed(low)} to ${fixed(high)}`;
const pText = (p) => (p === null ? "\u2013" : p < 0.001 ? "< 0.001" : fixed(p, 3));

/* first − second on the core, in one sentence; [a, b, mean, low, high, p, verdict, runs] per pair. */
function verdict(pairs, first, second) {
  const found = (pairs || []).find(([a, b]) => (a === first && b === second) || (a === second && b === first));
  if (!found) return null;
  const sign = found[0] === first ? 1 : -1, [low, high] = sign > 0 ? [found[3], found[4]] : [-found[4], -found[3]];
  return { mean: sign * found[2], low, high, p: found[5], verdict: found[6], runs: found[7] };
}

/* first − second of a column of a board: [mean, low, high, p]; null where the scorer has none. */
function difference(board, first, second, at = 0) {
  const [i, j] = [board.names.indexOf(first), board.names.indexOf(second)];
  const found = i < 0 || j < 0 ? null : board.pairs[`${Math.min(i, j)},${Math.max(i, j)}`]?.[at];
  if (!found || i < j) return found || null;
  const [mean, low, high, p] = found;
  return [-mean, low === null ? null : -high, low === null ? null : -low, p];
}

const title = (name) => (index.titles[name].length > 40 ? `${[...index.titles[name]].slice(0, 39).join("")}\u2026` : index.titles[name]);

const make = (tag, properties = {}, ...children) => {
  const element = Object.assign(document.createElement(tag), properties);
  element.append(...children);
  return element;
};
const cell = (tag, text, className = "") => {
  const element = make(tag, { className }, text);
  if (tag === "th") element.scope = "row";
  return element;
};

function answer(first, second) {
  const list = make("div", { className: "answers" });
  for (const [metric, more, less] of [["final_performance", "keeps more", "keeps less"], ["forgetting", "forgets more", "forgets less"]]) {
    const found = verdict(index.core[metric], first, second);
    if (!found) continue;
    const what = found.verdict === "separated" ? (found.mean > 0 ? more : less)
      : found.verdict === "equivalent" ? `is equivalent in ${metric === "forgetting" ? "forgetting" : "what it keeps"}`
        : `is not separated in ${metric === "forgetting" ? "forgetting" : "what it keeps"}`;
    list.append(make("p", {}, make("strong", {}, title(first)), ` ${what}: ${fixed(found.mean)} (${range(found.low, found.high)}) `
      + `against ${title(second)}, over the core with ${found.runs} runs; p ${pText(found.p)}, adjusted for all pairs.`));
  }
  if (!list.children.length) list.append(make("p", {}, "There is no answer over the core: one of the two is not ranked on it. The boards below have both."));
  return list;
}

/* The difference as a disc with its interval, beside a line at 0. */
function bar([mean, low, high], reach) {
  const at = (value) => (100 + 92 * Math.max(-1, Math.min(1, value / reach))).toFixed(1);
  const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  svg.setAttribute("viewBox", "0 0 200 18");
  svg.setAttribute("class", "difference");
  svg.setAttribute("aria-hidden", "true");
  const add = (tag, facts) => {
    const element = document.createElementNS("http://www.w3.org/2000/svg", tag);
    for (const [name, value] of Object.entries(facts)) element.setAttribute(name, value);
    svg.append(element);
  };
  add("line", { class: "grid", x1: 100, x2: 100, y1: 0, y2: 18 });
  if (low !== null) add("line", { class: "interval", x1: at(low), x2: at(high), y1: 9, y2: 9 });
  add("circle", { class: "mean", cx: at(mean), cy: 9, r: 4.5 });
  return svg;
}

function table(boards, first, second) {
  const rows = boards.map((board) => {
    const data = loaded[board.id], at = data ? data.columns.indexOf("forgetting") : -1;
    return { board, kept: data && difference(data, first, second), lost: at < 0 ? null : difference(data, first, second, at) };
  });
  const reach = Math.max(0.1, ...rows.flatMap(({ kept }) => (kept ? kept.slice(0, 3).map(Math.abs) : [])));
  const numbers = (found) => (found ? [cell("td", fixed(found[0]), "num strong"),
    cell("td", found[1] === null ? "one run" : range(found[1], found[2]), "ends")] : [cell("td", "\u2013", "num"), cell("td", "", "ends")]);
  const lines = rows.map(({ board, kept, lost }) => make("tr", {},
    make("th", { scope: "row" }, make("a", { href: board.page }, board.group), make("span", { className: "tags" }, board.label)),
    make("td", {}, ...(kept ? [bar(kept, reach)] : [])), ...numbers(kept), ...numbers(lost)));
  const names = ["Board", "\u2190 second \u00b7 first better \u2192", "Score", "95 % interval", "Forgetting", "95 % interval"];
  const heads = names.map((name, at) => Object.assign(cell("th", name, at === 2 || at === 4 ? "num" : ""), { scope: "col" }));
  return make("table", { className: "plain" },
    make("caption", {}, "First minus second, on each board that both are on; \u2013 where the scorer has no difference"),
    make("thead", {}, make("tr", {}, ...heads)), make("tbody", {}, ...lines));
}

/* Both scores on each group of the core, for two that are on different boards of it. */
function scores(first, second) {
  const [a, b] = [index.groups[first] || {}, index.groups[second] || {}];
  const shown = (value) => cell("td", value[0] === null ? "\u2013" : fixed(value[0]) + (value[1] === null ? "" : ` (${range(value[1], value[2])})`), "num");
  const lines = Object.keys(a).filter((group) => b[group]).map((group) => make("tr", {}, cell("th", group), shown(a[group]), shown(b[group])));
  if (!lines.length) return make("p", {}, "The two have no group in common.");
  const heads = ["Group", title(first), title(second)].map((name, at) => Object.assign(cell("th", name, at ? "num" : ""), { scope: "col" }));
  return make("table", { className: "plain" },
    make("caption", {}, "The two are on no common board, because only one of them observes the task. Score at the end on each group of the core"),
    make("thead", {}, make("tr", {}, ...heads)), make("tbody", {}, ...lines));
}

function show(first, second) {
  const [place, region] = ["compared", "differences"].map((id) => document.getElementById(id));
  const boards = index.boards.filter((board) => board.entries.includes(first) && board.entries.includes(second));
  const render = () => {
    place.replaceChildren(answer(first, second));
    region.replaceChildren(boards.length ? table(boards, first, second) : scores(first, second));
  };
  if (first === second) {
    place.replaceChildren(make("p", {}, "Choose two different entries."));
    return region.replaceChildren();
  }
  for (const board of boards) {
    if (loaded[board.id] !== undefined) continue;
    loaded[board.id] = null;
    document.head.append(make("script", { src: board.pairs, onload: render }));
  }
  render();
}

function start() {
  const [first, second] = ["first", "second"].map((id) => document.getElementById(id));
  const names = Object.keys(index.titles).sort();
  if (names.length < 2) return;
  for (const select of [first, second]) for (const name of names) {
    select.add(new Option(title(name) === name ? name : `${title(name)} (${name})`, name));
  }
  const best = index.core.final_performance?.[0] || [names.find((name) => name !== "trpo"), names.includes("trpo") ? "trpo" : names[1]];
  const read = () => {
    const given = new URLSearchParams(location.hash.slice(location.hash.startsWith("#?") ? 2 : location.hash.length));
    first.value = names.includes(given.get("first")) ? given.get("first") : best[0];
    second.value = names.includes(given.get("second")) ? given.get("second") : best[1];
    show(first.value, second.value);
  };
  const changed = () => {
    history.replaceState(null, "", `#?${new URLSearchParams({ first: first.value, second: second.value })}`);
    show(first.value, second.value);
  };
  first.onchange = second.onchange = changed;
  addEventListener("hashchange", read);
  document.getElementById("compare").hidden = false;
  read();
}

if (typeof module !== "undefined") module.exports = { difference, fixed, verdict };
