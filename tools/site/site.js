"use strict";
/* What the theme leaves without a name for those who hear the page, and what scrolls for those who
   have a keyboard only. */
document.querySelector(".md-search")?.setAttribute("aria-label", "Search");

function reachScrolled() {
  for (const box of document.querySelectorAll(".md-typeset__scrollwrap, .md-typeset pre > code"))
    if (box.scrollWidth > box.clientWidth) box.tabIndex = 0;
}
addEventListener("load", () => requestAnimationFrame(reachScrolled));
addEventListener("resize", reachScrolled);
