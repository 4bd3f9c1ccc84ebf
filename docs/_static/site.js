// What axe finds on the theme's pages: parts without a name, and what scrolls and cannot be reached by keys.
"use strict";
const SCROLLED = { pre: "code", ".table-wrapper": "table", "div.math": "formula" };

function reach() {
  for (const [part, name] of Object.entries(SCROLLED)) {
    for (const element of document.querySelectorAll(part)) {
      if (element.scrollWidth > element.clientWidth) {
        element.tabIndex = 0;
        element.setAttribute("role", "group");
        element.setAttribute("aria-label", name);
      } else {
        element.removeAttribute("tabindex");
      }
    }
  }
}

function nameFormulas() {
  for (const formula of document.querySelectorAll("th mjx-container")) {
    formula.setAttribute("role", "math");
    formula.setAttribute("aria-label", formula.querySelector("math").textContent);
  }
  reach();
}

addEventListener("load", () => {
  document.querySelector(".sidebar-drawer")?.setAttribute("aria-label", "site");
  document.querySelector(".toc-drawer")?.setAttribute("aria-label", "page");
  for (const head of document.querySelectorAll("th")) {
    if (!head.textContent.trim()) head.replaceWith(document.createElement("td")); // it heads nothing
  }
  reach();
  window.MathJax?.startup?.promise?.then(nameFormulas);
});
addEventListener("resize", reach);
