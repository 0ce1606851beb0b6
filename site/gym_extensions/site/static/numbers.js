// A number opens: its runs, interval and test, the files behind it, and the command that prints it. A script of the submission
// has them, so that it works from a file, too. Where there is none, and without this script, a number is a link.
"use strict";
(() => {
  const { make } = page, site = new URL("..", document.currentScript.src), texts = {};
  const dialog = make("dialog", { className: "number", ariaLabel: "A number and what is behind it" });
  let wanted; // the link that was followed last
  dialog.addEventListener("click", ({ target }) => { if (target === dialog || target.matches(".close")) dialog.close(); });
  document.body.append(dialog);

  // What the number is called in the table of the dialog.
  function nameOf(link) {
    const cell = link.closest("td"), head = cell?.closest("table").tHead?.rows[0].cells[cell.cellIndex];
    return link.dataset.of ?? cell?.dataset.label ?? head?.querySelector("a, button")?.textContent;
  }

  function show(link, file) {
    dialog.innerHTML = `<button type="button" class="more close">Close</button>${texts[file]}`;
    for (const each of dialog.querySelectorAll("a")) each.href = new URL(each.getAttribute("href"), new URL(file, site));
    dialog.showModal();
    const chosen = [...dialog.querySelectorAll("[data-number-of]")].find((row) => row.dataset.numberOf === nameOf(link));
    chosen?.classList.add("chosen");
    chosen?.scrollIntoView({ block: "nearest" });
  }

  globalThis.openNumber = (file, markup) => { texts[file] = markup; };
  document.addEventListener("click", (event) => {
    const link = event.target.closest("a.n"), file = link?.closest("[data-number]")?.dataset.number;
    if (!file || event.ctrlKey || event.metaKey || event.shiftKey || event.altKey) return;
    event.preventDefault();
    wanted = link;
    if (texts[file]) return show(link, file);
    const onload = () => { if (wanted === link) show(link, file); }, onerror = () => { location.href = link.href; };
    document.head.append(make("script", { src: new URL(file, site), onload, onerror }));
  });
})();
