// Links that save a figure as SVG or PNG, and a table as CSV. They stand below it, and only while scripts run.
"use strict";
(() => {
  const PROPERTIES = ["fill", "fill-opacity", "stroke", "stroke-width", "stroke-dasharray", "stroke-linecap", "stroke-linejoin",
    "stroke-opacity", "opacity", "vector-effect", "font-family", "font-size", "font-weight", "text-anchor", "paint-order", "display", "r"];
  const { make } = page, SCALE = 3; // pixels of a PNG per unit of the drawing
  const here = location.pathname.split("/").pop().replace(/\.html$/, "") || "index";

  function save(name, blob) {
    const link = make("a", { href: URL.createObjectURL(blob), download: name });
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  }

  // The drawing as a document of its own, with the style of the page as attributes. SVG 1.1 knows no color(), the form of a mixed colour.
  const known = (value) => value.replace(/color\(srgb ([\d. e-]+)\)/, (_, parts) => `rgb(${parts.split(" ").map((part) => Math.round(255 * part)).join(", ")})`);
  function drawn(svg) {
    const copy = svg.cloneNode(true), [, , width, height] = svg.getAttribute("viewBox").split(" ");
    const styled = (from, to) => {
      const style = getComputedStyle(from);
      for (const name of PROPERTIES) to.setAttribute(name, known(style.getPropertyValue(name)));
      if (style.transform !== "none") to.setAttribute("transform", style.transform);
      [...from.children].forEach((child, i) => styled(child, to.children[i]));
    };
    styled(svg, copy);
    copy.removeAttribute("display"); // it may be hidden while the episode is played
    copy.setAttribute("xmlns", "http://www.w3.org/2000/svg");
    copy.setAttribute("width", width);
    copy.setAttribute("height", height);
    const ground = document.createElementNS("http://www.w3.org/2000/svg", "rect");
    ground.setAttribute("width", "100%");
    ground.setAttribute("height", "100%");
    ground.setAttribute("fill", getComputedStyle(document.body).backgroundColor);
    copy.prepend(ground);
    return { text: new XMLSerializer().serializeToString(copy), width: Number(width), height: Number(height) };
  }

  function png(svg, name) {
    const { text, width, height } = drawn(svg), picture = new Image(width, height);
    picture.onload = () => {
      const canvas = make("canvas", { width: SCALE * width, height: SCALE * height });
      canvas.getContext("2d").drawImage(picture, 0, 0, canvas.width, canvas.height);
      canvas.toBlob((blob) => save(`${name}.png`, blob));
    };
    picture.src = `data:image/svg+xml;charset=utf-8,${encodeURIComponent(text)}`;
  }

  // Every row that is shown. A drawing in a cell is its label, and controls are left out.
  function csv(table) {
    const words = (node) => (node.nodeType === 3 ? node.data : node.nodeName === "svg" ? node.getAttribute("aria-label") ?? ""
      : /^(INPUT|SELECT)$/.test(node.nodeName) || node.className === "sort" || node.className === "tip" ? "" : [...node.childNodes].map(words).join(node.querySelector("wbr") ? "" : " "));
    const cells = (row) => [...row.cells].filter((cell) => !cell.hidden).flatMap((cell) => {
      const said = words(cell).replace(/(\d)\u202f(?=\d)/g, "$1").replace(/\u2212/g, "-").replace(/\s+/g, " ").trim();
      const value = /^-[\d.]/.test(said) && !/[^-\d. to±%]/.test(said) ? said : said.replace(/^(?=[=+@-])/, "'"); // no formula of a spreadsheet
      return [/[",]/.test(value) ? `"${value.replaceAll('"', '""')}"` : value, ...Array(cell.colSpan - 1).fill("")];
    });
    return [...table.rows].filter((row) => !row.hidden && !row.parentNode.hidden).map((row) => `${cells(row).join(",")}\r\n`).join("");
  }

  // What a figure or table is called: its caption, else its label, else the heading above it.
  function title(place) {
    const caption = place.querySelector("figcaption, caption"), label = (place.querySelector("svg[aria-label]") ?? place.closest("[aria-label]"))?.getAttribute("aria-label");
    const text = caption?.textContent ?? label ?? (place.closest("section")?.querySelector("h2, h3") ?? document.querySelector("h1")).textContent;
    const words = text.replace(/\s+/g, " ").trim();
    return words.length > 80 ? `${words.slice(0, 80)}…` : words;
  }

  function offer(place, below, kinds) {
    below.after(make("p", { className: "take" }, "Save: ", ...Object.entries(kinds).map(([kind, onclick]) =>
      make("button", { type: "button", onclick, ariaLabel: `Save “${title(place)}” as ${kind}` }, kind))));
  }

  document.querySelectorAll("main figure").forEach((figure, i) => {
    const svg = figure.querySelector("svg[viewBox]"), name = `${here}-figure-${i + 1}`;
    if (!svg || figure.closest(".maps")) return;
    offer(figure, figure.querySelector("figcaption") ?? svg, {
      SVG: () => save(`${name}.svg`, new Blob([drawn(svg).text], { type: "image/svg+xml" })),
      PNG: () => png(svg, name),
    });
  });
  document.querySelectorAll("main table, .scroll#differences").forEach((place, i) => { // those of the page Compare come later, and change
    const name = `${here}-table-${i + 1}`, tables = () => (place.matches("table") ? [place] : [...place.querySelectorAll("table")]);
    offer(place, place.closest(".scroll") ?? place, { CSV: () => save(`${name}.csv`, new Blob(["\ufeff", tables().map(csv).join("\r\n")], { type: "text/csv" })) });
  });
})();
