// The page Play: says why it cannot run here, or loads the simulator on request and hands over to play/panel.js.
"use strict";
(() => {
  const root = document.getElementById("play"), button = document.getElementById("play-load");
  const base = document.currentScript.src;

  function problem(title, text) {
    const note = document.getElementById("play-problem");
    note.querySelector("strong").textContent = title;
    note.querySelector("span").textContent = text;
    note.hidden = false;
    button.hidden = true;
  }

  function fits() {
    if (location.protocol === "file:") {
      problem("Play needs a web server.", "Browsers load the simulator only from one. In the folder of the site, run "
        + "“python -m http.server” and open the address that it prints.");
    } else if (typeof WebAssembly !== "object" || typeof DecompressionStream !== "function") {
      problem("Play needs WebAssembly.", "This browser lacks it or has it switched off. A current version of Firefox, "
        + "Chrome, Edge or Safari has it.");
    } else return true;
    return false;
  }

  async function start() {
    button.disabled = true;
    button.textContent = "Loading …";
    try {
      const index = await (await fetch(root.dataset.index)).json();
      const { loadMujoco } = await import(new URL("play/world.js", base));
      const { startPanel } = await import(new URL("play/panel.js", base));
      const site = new URL("..", base), mujoco = await loadMujoco(index.mujoco, site);
      await startPanel(mujoco, index, site);
      button.hidden = true;
      document.documentElement.classList.add("playing"); // the bodies take the place of the introduction
      document.getElementById("play-run").focus({ preventScroll: true });
    } catch {
      document.getElementById("play-panel").hidden = true;
      problem("The simulator did not load.", "A file is missing, or is not the one that this site was built with. "
        + "Reload the page; if that does not help, the site has to be built again.");
      document.getElementById("play-problem").focus(); // the button, which had it, is gone
    }
  }

  const inPage = location.search === "?in-page"; // inside the first page, whose button asked for it
  document.documentElement.classList.toggle("in-page", inPage);
  if (fits()) {
    button.hidden = false;
    button.addEventListener("click", start);
    if (inPage) start();
  }
})();
