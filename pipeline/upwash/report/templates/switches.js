// The page's switches: least power or force, the paper's model or the limit. Style hides what is not true of both.
"use strict";
const root = document.documentElement;
const told = JSON.parse(document.getElementById("data").textContent);
const settings = () => `${root.dataset.cost} ${root.dataset.model}`;

for (const input of document.querySelectorAll(".switches input")) {
  // A browser may keep what was chosen before the page was loaded anew.
  input.checked = input.value === root.dataset[input.name];
  input.addEventListener("change", () => {
    root.dataset[input.name] = input.value;
    document.dispatchEvent(new Event("switched"));
  });
}

// On a narrow screen the contents begin folded.
if (!matchMedia("(min-width: 60rem)").matches) document.querySelector(".contents").open = false;
