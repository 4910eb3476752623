// Tables that people sort and filter, and commands that they copy. A page reads the same without this.
(() => {
  "use strict";
  // A link into what is folded opens it.
  const unfold = () => {
    let part = document.getElementById(location.hash.slice(1));
    for (; part; part = part.parentElement) if (part.tagName === "DETAILS") part.open = true;
  };
  addEventListener("hashchange", unfold);
  unfold();
  const number = (text) => {
    const found = /^(?:at (?:least|most) |± ?)?([+−-]?\d+(?:[.,]\d+)?(?:e[+-]?\d+)?)/i.exec(text.trim());
    return found ? Number(found[1].replace("−", "-").replace(",", ".")) : NaN;
  };
  const shown = (row, column) => {
    const cell = row.cells[column];
    return cell ? (cell.dataset.sort ?? cell.textContent).trim() : "";
  };
  const compare = (left, right) => {
    const [a, b] = [number(left), number(right)];
    if (!Number.isNaN(a) && !Number.isNaN(b) && a !== b) return a - b;
    return left.localeCompare(right, "en", { numeric: true });
  };
  const sortable = (table) => {
    const heads = [...table.tHead.rows[0].cells];
    heads.forEach((head, column) => {
      const button = document.createElement("button");
      button.type = "button";
      button.className = "sort";
      button.append(...head.childNodes);
      head.append(button);
      button.addEventListener("click", () => {
        const down = head.getAttribute("aria-sort") === "ascending";
        heads.forEach((other) => other.removeAttribute("aria-sort"));
        head.setAttribute("aria-sort", down ? "descending" : "ascending");
        const sign = down ? -1 : 1;
        for (const body of table.tBodies) {
          const rows = [...body.rows];
          rows.sort((a, b) => sign * compare(shown(a, column), shown(b, column)));
          body.append(...rows);
        }
      });
    });
  };
  const filterable = (table, place) => {
    const rows = [...table.tBodies].flatMap((body) => [...body.rows]);
    const box = document.createElement("label");
    box.className = "filter";
    const field = document.createElement("input");
    field.type = "search";
    const count = document.createElement("output");
    box.append(`Show only rows of “${table.dataset.name}” with `, field, " ", count);
    place.before(box);
    field.addEventListener("input", () => {
      const words = field.value.toLowerCase().split(/\s+/).filter(Boolean);
      let left = 0;
      for (const row of rows) {
        const text = row.textContent.toLowerCase();
        row.hidden = !words.every((word) => text.includes(word));
        left += row.hidden ? 0 : 1;
      }
      count.textContent = words.length ? `${left} of ${rows.length}` : "";
    });
  };
  const copied = async (text) => {
    try {
      await navigator.clipboard.writeText(text);
      return true;
    } catch {
      // A page that was opened as a file may have no clipboard.
      const field = document.createElement("textarea");
      field.value = text;
      document.body.append(field);
      field.select();
      const done = document.execCommand("copy");
      field.remove();
      return done;
    }
  };
  const copyable = (source) => {
    const button = document.createElement("button");
    button.type = "button";
    button.className = "copy";
    button.textContent = "Copy";
    button.setAttribute("aria-label", source.tagName === "PRE" ? `Copy: ${source.getAttribute("aria-label") ?? "text"}` : "Copy the command");
    const state = document.createElement("span");
    state.className = "small copy-state";
    state.setAttribute("role", "status");
    source.after(button, state);
    button.addEventListener("click", async () => {
      state.textContent = (await copied(source.textContent)) ? " copied" : " not copied: select the text";
      setTimeout(() => (state.textContent = ""), 2000);
    });
  };
  for (const source of document.querySelectorAll("code.command, pre[aria-label]")) copyable(source);
  for (const table of document.querySelectorAll("table[data-name]")) {
    sortable(table);
    if (table.tBodies[0].rows.length > 5 && table.dataset.filter !== "no") filterable(table, table.closest(".scroll") ?? table);
  }
})();
