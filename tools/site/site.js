"use strict";
/* What the theme leaves without a name for those who hear the page, and what scrolls for those who
   have a keyboard only. */
document.querySelector(".md-search")?.setAttribute("aria-label", "Search");
// A heading may be called as a part of the site is.
for (const part of document.querySelectorAll(".md-nav--secondary nav[aria-label]"))
  part.setAttribute("aria-label", `${part.getAttribute("aria-label")} on this page`);

function reachScrolled() {
  for (const box of document.querySelectorAll(".md-typeset__scrollwrap, .md-typeset pre > code"))
    if (box.scrollWidth > box.clientWidth) box.tabIndex = 0;
}
addEventListener("load", () => requestAnimationFrame(reachScrolled));
addEventListener("resize", reachScrolled);
