/* table: rows of text that follow what they show: cells change only where their text does. Names and all else are text,
 * never markup. A column of names holds buttons, which select. */

export interface Column { title: string; number?: boolean; name?: boolean; state?: boolean; verdict?: boolean }
export interface Row { key: string; cells: readonly string[]; state?: string; selected?: boolean }

/** Rows that a table shows at most; the caption says how many there are. */
export const ROWS_MOST = 200;

export class Table {
  private readonly body: HTMLTableSectionElement;
  private readonly caption: HTMLTableCaptionElement;
  private readonly empty: HTMLParagraphElement;
  private readonly scroll: HTMLDivElement;
  private keys: string[] = [];

  constructor(into: HTMLElement, title: string, private readonly columns: readonly Column[], private readonly ifEmpty: string,
    private readonly onSelect?: (key: string) => void) {
    this.scroll = document.createElement("div");
    this.scroll.className = "scroll";
    this.scroll.tabIndex = 0;
    this.scroll.setAttribute("role", "region");
    this.scroll.setAttribute("aria-label", `${title}, table`);
    const table = document.createElement("table");
    this.caption = table.createCaption();
    const head = table.createTHead().insertRow();
    for (const c of columns) {
      const th = document.createElement("th");
      th.scope = "col";
      th.textContent = c.title;
      if (c.number) th.className = "number";
      head.append(th);
    }
    this.body = table.createTBody();
    this.scroll.append(table);
    this.empty = document.createElement("p");
    this.empty.className = "empty";
    this.empty.textContent = ifEmpty;
    into.append(this.scroll, this.empty);
  }

  private makeRow(at: number): HTMLTableRowElement {
    const tr = this.body.insertRow();
    for (const c of this.columns) {
      const td = tr.insertCell();
      td.className = [c.number ? "number" : "", c.state ? "state" : "", c.verdict ? "verdict" : ""].join(" ").trim();
      if (!c.name || !this.onSelect) continue;
      const button = document.createElement("button");
      button.type = "button";
      button.addEventListener("click", () => this.onSelect?.(this.keys[at] ?? ""));
      td.append(button);
    }
    return tr;
  }

  /** Shows these rows, of `total` that there are. */
  show(rows: readonly Row[], total = rows.length): void {
    const shown = Math.min(rows.length, ROWS_MOST), trs = this.body.rows;
    this.keys = rows.slice(0, shown).map((r) => r.key);
    while (trs.length < shown) this.makeRow(trs.length);
    while (trs.length > shown) this.body.deleteRow(-1);
    for (let i = 0; i < shown; i++) this.fill(trs[i]!, rows[i]!);
    const text = total > shown ? `${shown} of ${total}` : `${total}`;
    if (this.caption.textContent !== text) this.caption.textContent = text;
    this.scroll.hidden = shown === 0;
    this.empty.hidden = shown > 0;
    if (this.empty.textContent !== this.ifEmpty) this.empty.textContent = this.ifEmpty;
  }

  private fill(tr: HTMLTableRowElement, row: Row): void {
    const state = row.state ?? "", selected = row.selected ? "true" : "";
    if (tr.dataset["state"] !== state) tr.dataset["state"] = state;
    if (tr.getAttribute("data-selected") !== selected) tr.setAttribute("data-selected", selected);
    row.cells.forEach((text, i) => {
      const cell = tr.cells[i]!, holder = (cell.firstElementChild as HTMLElement | null) ?? cell;
      if (holder.textContent !== text) holder.textContent = text;
      if (this.columns[i]!.verdict && cell.dataset["verdict"] !== text) cell.dataset["verdict"] = text;
    });
  }
}
