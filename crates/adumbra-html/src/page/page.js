"use strict";
// Moves dividers with the range input below a pair or the pointer on it; opens folded sections for printing.
document.documentElement.classList.add("live");
for (const pair of document.querySelectorAll("figure.pair")) {
  const frame = pair.querySelector(".frame");
  const range = pair.querySelector("input");
  const show = () => frame.style.setProperty("--at", range.value + "%");
  range.addEventListener("input", show);
  const follow = (event) => {
    const box = frame.getBoundingClientRect();
    range.value = (100 * (event.clientX - box.left)) / box.width;
    show();
  };
  frame.addEventListener("pointerdown", (event) => {
    frame.setPointerCapture(event.pointerId);
    follow(event);
  });
  frame.addEventListener("pointermove", (event) => {
    if (frame.hasPointerCapture(event.pointerId)) follow(event);
  });
  show();
}
const folded = [];
addEventListener("beforeprint", () => {
  for (const part of document.querySelectorAll("details:not([open])")) {
    part.open = true;
    folded.push(part);
  }
});
addEventListener("afterprint", () => {
  while (folded.length) folded.pop().open = false;
});
