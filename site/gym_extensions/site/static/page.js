// What scripts share: the state in the address, as #?q=trpo&all=1, so that it works from a file, too; numbers; rows; elements.
"use strict";
globalThis.page = {
  // A function of a name in the address to its value, which is empty where the address has none.
  read(hash) {
    const given = new URLSearchParams(hash.startsWith("#?") ? hash.slice(2) : "");
    return (name) => given.get(name) || "";
  },

  // The address of a state, without what is empty or false.
  write(state) {
    const given = new URLSearchParams(Object.entries(state).filter(([, value]) => value));
    return String(given) ? `#?${given}` : "#";
  },

  names: (text) => text.split(",").filter(Boolean),

  fixed(value, digits = 2) {
    const text = value.toFixed(digits);
    return text.startsWith("-") ? (/[1-9]/.test(text) ? "\u2212" : "") + text.slice(1) : text;
  },

  // The first number of a text that a page shows; null without one.
  number(text) {
    const found = text.replace(/\u202f/g, "").replace(/\u2212/g, "-").match(/-?\d+(\.\d+)?/);
    return found ? Number(found[0]) : null;
  },

  // Rows by their values of a key, which are texts or numbers; those without one last.
  sorted: (rows, key, up) => [...rows].sort((a, b) => {
    const [p, q] = [a.values[key] ?? null, b.values[key] ?? null];
    if (p === null || q === null) return (p === null) - (q === null);
    return (up ? 1 : -1) * (typeof p === "string" ? page.byText(p, q) : p - q);
  }),
  byText: new Intl.Collator("en").compare,

  make(tag, properties = {}, ...children) {
    const element = Object.assign(document.createElement(tag), properties);
    element.append(...children);
    return element;
  },
};
