// What tables and Compare share: the state in the address, as #?q=trpo&all=1, so that it works from a file, too; numbers; elements.
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

  make(tag, properties = {}, ...children) {
    const element = Object.assign(document.createElement(tag), properties);
    element.append(...children);
    return element;
  },
};
