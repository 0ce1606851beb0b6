/* The page Compare: menus of two to four submissions. The first is compared with each other one: over the core, then on every
   common group. The state is in the address. */
"use strict";

const { fixed, make } = page;
let index = null;
const loaded = {}; // differences by board: false while they are loaded, undefined where that failed
function compareIndex(document) { index = document; start(); }
function boardPairs(document) { loaded[document.board] = document; }

const range = (low, high) => `${fixed(low)} to ${fixed(high)}`;

/* first − second on the core, in one sentence; [a, b, mean, low, high, p, verdict, runs, remark or false] per pair. */
function verdict(pairs, first, second) {
  const found = (pairs || []).find(([a, b]) => (a === first && b === second) || (a === second && b === first));
  if (!found) return null;
  const sign = found[0] === first ? 1 : -1, [low, high] = sign > 0 ? [found[3], found[4]] : [-found[4], -found[3]];
  return { mean: sign * found[2], low, high, p: found[5], verdict: found[6], runs: found[7], remark: found[8] };
}

/* first − second of a column of a board: [mean, low, high]; null where the scorer has none. */
function difference(board, first, second, at = 0) {
  const [i, j] = [board.names.indexOf(first), board.names.indexOf(second)];
  const found = i < 0 || j < 0 ? null : board.pairs[`${Math.min(i, j)},${Math.max(i, j)}`]?.[at];
  if (!found || i < j) return found || null;
  const [mean, low, high] = found;
  return [-mean, low === null ? null : -high, low === null ? null : -low];
}

const title = (name) => (index.titles[name].length > 40 ? `${[...index.titles[name]].slice(0, 39).join("")}\u2026` : index.titles[name]);

const VERDICTS = { separated: "significant difference", open: "no significant difference" };
const link = (text, href) => make("a", { href }, text);

function answer(first, second, boards) {
  const list = make("div", { className: "answers" });
  for (const [metric, more, less, what] of [["final_performance", "keeps more", "keeps less", "final performance"],
    ["forgetting", "forgets more", "forgets less", "forgetting"]]) {
    const found = verdict(index.core[metric], first, second);
    if (!found) continue;
    const words = VERDICTS[found.verdict] ?? found.verdict, remark = found.remark ? ` (${found.remark})` : "";
    const is = found.verdict === "separated" ? `${found.mean > 0 ? more : less} than ${title(second)}, a ${words}${remark} in `
      : `and ${title(second)}: ${words} in `;
    list.append(make("p", {}, make("strong", {}, title(first)), ` ${is}`, link(what, `metrics.html#${metric}`),
      `: ${fixed(found.mean)} (${range(found.low, found.high)}), `, link(found.p, "metrics.html#core"),
      `, over the core, runs 0 to ${found.runs - 1} of both.`));
  }
  if (!list.children.length) {
    const whys = [first, second].filter((name) => index.unranked[name]).map((name) => ` ${title(name)}: ${index.unranked[name]}`);
    list.append(make("p", {}, `${title(first)} and ${title(second)} are not compared over the `, link("core", "core.html"), `, because only ranked submissions are.${whys.join("")}`));
  }
  if (!boards.length) list.append(make("p", {}, `${title(first)} and ${title(second)} share no group with the same protocol and budget, so there is nothing to compare.`));
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
  const [kept, lost] = ["final_performance", "forgetting"].map((metric) => verdict(index.core[metric], first, second));
  const interval = (found) => found && [found.mean, found.low, found.high];
  const rows = boards.map((board) => {
    const data = loaded[board.id], value = (at) => data && (at < 0 ? null : difference(data, first, second, at));
    return { page: board.page, group: board.group, label: board.label, runs: `${board.submissions[first]}, ${board.submissions[second]}`,
      kept: value(0), lost: value(data && data.columns.indexOf("forgetting")) };
  });
  if (kept) rows.unshift({ page: "core.html", group: "Core suite", label: "mean over its groups; interval for all pairs together",
    runs: `${kept.runs}, ${kept.runs}`, kept: interval(kept), lost: interval(lost) });
  const reach = Math.max(0.1, ...rows.flatMap(({ kept }) => (kept ? kept.map(Math.abs) : [])));
  const named = (name, td) => { td.dataset.label = name; return td; };
  const number = (name, found) => named(name, make("td", { className: "num" },
    make("span", { className: "value strong" }, found ? fixed(found[0]) : found === null ? "\u2013" : "\u2026"), " ",
    make("span", { className: "ends" }, found ? (found[1] === null ? "one run" : range(found[1], found[2])) : "")));
  const lines = rows.map(({ page, group, label, runs, kept, lost }) => make("tr", {},
    make("th", { scope: "row" }, link(group, page), " ", make("span", { className: "tags" }, label)),
    make("td", { className: "drawn" }, ...(kept ? [bar(kept, reach)] : [])), number("Kept", kept), number("Forgotten", lost),
    named("Runs", make("td", { className: "num" }, runs))));
  const heads = [["Group"], ["\u2190 other \u00b7 first better \u2192", "", "drawn"], ["Kept", "final_performance", "num"],
    ["Forgotten", "forgetting", "num"], ["Runs", "intervals", "num"]].map(([name, anchor, side = ""]) =>
    make("th", { className: side, scope: "col" }, anchor ? link(name, `metrics.html#${anchor}`) : name));
  return make("table", { className: "submissions narrow" },
    make("caption", {}, `${title(first)} minus ${title(second)}, with 95\u202f% intervals. Kept is the metric that sorts the board. \u2013: no value, or not among the submissions that its board compares`),
    make("thead", {}, make("tr", {}, ...heads)), make("tbody", {}, ...lines));
}

/* Rank and inactive share of the networks on the groups that at least two of the submissions have, after the first and the last task. */
function networks(names) {
  const known = names.filter((name) => Object.hasOwn(index.networks, name));
  const groups = [...new Set(known.flatMap((name) => Object.keys(index.networks[name])))]
    .filter((group) => known.filter((name) => index.networks[name][group]).length > 1);
  if (!groups.length) return [];
  const text = (found) => (found ? found.map(([first, last]) => `${fixed(first)} \u2192 ${fixed(last)}`).join("; ") : "\u2013");
  const rows = groups.map((group) => make("tr", {}, make("th", { scope: "row" }, group), ...known.map((name) => make("td", { className: "num" }, text(index.networks[name][group])))));
  const heads = ["Group", ...known.map(title)].map((name, i) => make("th", { className: i ? "num" : "", scope: "col" }, name));
  return [make("table", { className: "plain" },
    make("caption", {}, link("Networks", "metrics.html#networks"), ": rank; inactive share of the last hidden layer, after the first \u2192 after the last task"),
    make("thead", {}, make("tr", {}, ...heads)), make("tbody", {}, ...rows))];
}

let unknown = []; // names in the address that are no submission here
let render; // shows the submissions that were chosen last, also when a script of differences comes late

function show(first, others) {
  const [place, region] = ["compared", "differences"].map((id) => document.getElementById(id));
  const shared = others.map((other) => index.boards.filter(({ submissions }) => [first, other].every((name) => Object.hasOwn(submissions, name))));
  render = () => {
    if (!others.length) {
      place.replaceChildren(make("p", {}, "Choose two different submissions."));
      return region.replaceChildren();
    }
    place.replaceChildren(...others.map((other, i) => answer(first, other, shared[i])));
    if (unknown.length) {
      place.prepend(make("p", { className: "note" }, `This site compares no submission ${unknown.map((name) => `“${name}”`).join(" or ")}; shown are others. `,
        link("All submissions", "submissions.html")));
    }
    const failed = shared.flat().filter(({ id }) => loaded[id] === undefined).map(({ group }) => group);
    if (failed.length) place.append(make("p", { className: "note" }, `Differences (\u2026) could not be loaded: ${[...new Set(failed)].join(", ")}. Reload the page to try again.`));
    region.replaceChildren(...others.flatMap((other, i) => (shared[i].length ? [table(shared[i], first, other)] : [])), ...networks([first, ...others]));
  };
  for (const board of shared.flat()) {
    if (loaded[board.id] !== undefined) continue;
    loaded[board.id] = false;
    const onerror = () => { delete loaded[board.id]; render(); };
    document.head.append(make("script", { src: board.pairs, onload: () => render(), onerror }));
  }
  render();
}

function start() {
  const sides = ["first", "second", "third", "fourth"], selects = sides.map((id) => document.getElementById(id));
  const names = Object.keys(index.titles).sort();
  if (names.length < 2) return;
  selects.forEach((select, i) => {
    if (i > 1) select.add(new Option("\u2013", ""));
    for (const name of names) select.add(new Option(title(name) === name ? name : `${title(name)} (${name})`, name));
  });
  const best = index.core.final_performance?.[0] || [names.find((name) => name !== "trpo"), names.includes("trpo") ? "trpo" : names[1]];
  const chosen = () => {
    const [first, ...others] = selects.map((select) => select.value).filter(Boolean);
    show(first, [...new Set(others)].filter((name) => name !== first));
  };
  const read = () => {
    const given = sides.map(page.read(location.hash));
    unknown = given.filter((name) => name && !names.includes(name));
    const [first, second, ...more] = given.map((name) => (names.includes(name) ? name : ""));
    selects[0].value = first || best.find((name) => name !== second);
    selects[1].value = second || best.find((name) => name !== selects[0].value);
    more.forEach((name, i) => { selects[i + 2].value = name; });
    chosen();
  };
  const changed = () => {
    unknown = [];
    history.replaceState(null, "", page.write(Object.fromEntries(sides.map((side, i) => [side, selects[i].value]))));
    chosen();
  };
  for (const select of selects) select.onchange = changed;
  addEventListener("hashchange", () => { if (location.hash.startsWith("#?") || !location.hash) read(); });
  document.getElementById("compare").hidden = false;
  read();
}

if (typeof module !== "undefined") module.exports = { difference };
