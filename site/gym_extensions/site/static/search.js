/* The page Search: pages of the board first, then the documentation, then pages on the project itself.
   The index is a script, because a page that is opened as a file can read no JSON. */
"use strict";
const KINDS = ["Pages", "Documentation", "Decisions and the project"], MOST = 20, AROUND = 70;
const { make } = page;
let entries = [];
function searchIndex(rows) { entries = rows; }

const place = document.getElementById("found"), results = document.getElementById("results");
const field = document.querySelector("[role=search] input");
/* Names such as HopperWall are found as hopper wall, too. */
const plain = (text) => text.toLowerCase();
const spaced = (text) => plain(text.replace(/([a-z])(?=[A-Z])/g, "$1 "));

/* How well an entry fits: every word is in its title or text; the title counts more, and most as a whole. */
function score([, , title, text], words) {
  const heads = `${plain(title)} ${spaced(title)}`, body = plain(text);
  let total = 0;
  for (const word of words) {
    const starts = ` ${heads}`.includes(` ${word}`);
    if (!heads.includes(word) && !body.includes(word)) return 0;
    total += (starts ? 20 : heads.includes(word) ? 10 : 0) + Math.min(body.split(word).length - 1, 5);
  }
  return total + (plain(title) === words.join(" ") ? 100 : 0);
}

function excerpt(text, words) {
  const at = Math.max(Math.min(...words.map((word) => plain(text).indexOf(word)).filter((i) => i >= 0)), 0);
  const start = Number.isFinite(at) && at > AROUND ? text.indexOf(" ", at - AROUND) + 1 : 0; // with a whole word
  return `${start ? "… " : ""}${text.slice(start, start + 3 * AROUND)}${text.length > start + 3 * AROUND ? " …" : ""}`;
}

function show() {
  const words = plain(field.value).split(/\s+/).filter(Boolean);
  const found = words.length ? entries.map((entry) => [score(entry, words), entry]).filter(([fit]) => fit) : [];
  found.sort(([a], [b]) => b - a);
  place.textContent = !words.length ? "Type a word above."
    : found.length ? `${found.length === 1 ? "One place has" : `${found.length} places have`} all words of “${field.value.trim()}”.` : `No page has all words of “${field.value.trim()}”.`;
  results.replaceChildren(...KINDS.flatMap((name, kind) => {
    const rows = found.filter(([, entry]) => entry[0] === kind), more = rows.length > MOST ? `: the first ${MOST} of ${rows.length}` : "";
    if (!rows.length) return [];
    const items = rows.slice(0, MOST).map(([, [, address, title, text]]) => make("li", {}, make("a", { href: address }, title), " ",
      make("span", { className: "small" }, address.split("#")[0]), make("p", { className: "note" }, excerpt(text, words))));
    return [make("h2", {}, name + more), make("ul", { className: "found" }, ...items)];
  }));
}

field.value = new URLSearchParams(location.search).get("q") || "";
field.addEventListener("input", () => {
  history.replaceState(null, "", field.value ? `?${new URLSearchParams({ q: field.value })}` : location.pathname);
  show();
});
place.textContent = "Loading …";
document.head.append(make("script", {
  src: place.dataset.index,
  onload: show,
  onerror: () => { place.textContent = "This copy has no search: the documentation was not built. “make docsite” builds it."; },
}));
