"use strict";
for (const view of document.querySelectorAll(".compare")) {
  const [left, right] = view.querySelectorAll(".stack img");
  const [leftName, rightName] = view.querySelectorAll("select");
  const slider = view.querySelector("input");
  const edge = view.querySelector(".stack i");
  const show = () => {
    for (const [image, name] of [[left, leftName], [right, rightName]]) {
      const source = document.getElementById(name.value);
      image.src = source.src;
      image.alt = source.alt;
    }
  };
  const move = () => {
    right.style.clipPath = `inset(0 0 0 ${slider.value}%)`;
    edge.style.left = `${slider.value}%`;
    slider.setAttribute("aria-valuetext", `${slider.value} % ${leftName.selectedOptions[0].text}, the rest ${rightName.selectedOptions[0].text}`);
  };
  leftName.addEventListener("change", () => { show(); move(); });
  rightName.addEventListener("change", () => { show(); move(); });
  slider.addEventListener("input", move);
  view.hidden = false;
  show();
  move();
}
