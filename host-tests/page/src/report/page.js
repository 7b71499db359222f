// Rows sort by a click on a heading; without a script the tables stand as they are.
"use strict";
// The hint to scroll stands over tables that are wider than their place.
const hint = () => {
  for (const box of document.querySelectorAll(".scroll")) {
    const words = box.previousElementSibling;
    if (words?.matches(".more")) {
      words.style.display = box.scrollWidth > box.clientWidth ? "block" : "none";
    }
  }
};
hint();
addEventListener("resize", hint);
for (const table of document.querySelectorAll("table")) {
  const body = table.tBodies[0];
  const headings = [...table.tHead.rows[0].cells];
  const key = (row, column) => {
    const cell = row.cells[column];
    const number = cell.dataset.key;
    return number === undefined ? cell.textContent : Number(number);
  };
  // Numbers by size, before words.
  const order = (a, b) => {
    const numbers = [a, b].map((x) => typeof x === "number");
    if (numbers[0] && numbers[1]) return a - b;
    if (numbers[0] || numbers[1]) return numbers[0] ? -1 : 1;
    return a.localeCompare(b);
  };
  const sort = (column) => {
    const heading = headings[column];
    const up = heading.getAttribute("aria-sort") !== "ascending";
    headings.forEach((other) => other.setAttribute("aria-sort", "none"));
    heading.setAttribute("aria-sort", up ? "ascending" : "descending");
    const sign = up ? 1 : -1;
    const rows = [...body.rows];
    rows.sort((a, b) => sign * order(key(a, column), key(b, column)));
    body.append(...rows);
  };
  headings.forEach((heading, column) => {
    heading.setAttribute("aria-sort", "none");
    heading.tabIndex = 0;
    heading.title = "Sort";
    heading.addEventListener("click", () => sort(column));
    heading.addEventListener("keydown", (event) => {
      if (event.key === "Enter") sort(column);
    });
  });
}
