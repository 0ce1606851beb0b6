// Tables that are wider than their region: a region is a tab stop only while it scrolls, and its cut side fades.
// Without this script every region is a tab stop, and its scroll bar alone shows that it is cut.
"use strict";
(() => {
  function update(region) {
    const hidden = region.scrollWidth - region.clientWidth, at = region.scrollLeft;
    region.classList.toggle("cut-left", hidden > 1 && at > 1);
    region.classList.toggle("cut-right", hidden > 1 && at < hidden - 1);
    region.style.setProperty("--caption", `${region.querySelector("caption")?.offsetHeight || 0}px`);
    if (hidden > 1 || region.scrollHeight > region.clientHeight + 1) region.tabIndex = 0;
    else region.removeAttribute("tabindex");
  }
  const observer = new ResizeObserver((changes) => changes.forEach(({ target }) => update(target.closest(".scroll"))));
  for (const region of document.querySelectorAll(".scroll")) {
    region.addEventListener("scroll", () => update(region), { passive: true });
    observer.observe(region);
    for (const content of region.children) observer.observe(content);
  }
})();
