// What can be scrolled can be scrolled by the keyboard too, and has a name.
"use strict";
const PARTS = { pre: "code", ".table-wrapper": "table", "div.math": "formula" };

function reachable() {
  for (const [part, name] of Object.entries(PARTS)) {
    for (const element of document.querySelectorAll(part)) {
      if (element.scrollWidth > element.clientWidth) {
        element.tabIndex = 0;
        element.setAttribute("role", "group");
        element.setAttribute("aria-label", name);
      } else if (element.tabIndex === 0) {
        element.removeAttribute("tabindex");
      }
    }
  }
}

addEventListener("load", () => {
  document.querySelector(".sidebar-drawer")?.setAttribute("aria-label", "Site");
  document.querySelector(".toc-drawer")?.setAttribute("aria-label", "This page");
  for (const head of document.querySelectorAll("th")) {
    if (!head.textContent.trim()) head.replaceWith(document.createElement("td")); // it heads nothing
    else if (head.querySelector(".math")) head.setAttribute("aria-label", head.textContent.replace(/\\[()]/g, ""));
  }
  reachable();
  window.MathJax?.startup?.promise?.then(reachable);
  document.fonts.ready.then(reachable);
});
addEventListener("resize", reachable);
