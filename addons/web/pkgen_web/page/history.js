"use strict";
/* The recorded data of a run: the last samples of its state, the drifts since the start, trails. */
const History = (() => {
  /* A ring buffer of the last `most` rows, of `width` numbers each; row 0 is the oldest. */
  class Recent {
    constructor(width, most) {
      this.width = width;
      this.most = most;
      this.rows = new Float64Array(width * most);
      this.size = 0;
      this.first = 0;
    }
    push(row) {
      const at = (this.first + this.size) % this.most;
      this.rows.set(row, at * this.width);
      if (this.size < this.most) this.size++;
      else this.first = (this.first + 1) % this.most;
    }
    get(k, column) {
      return this.rows[((this.first + k) % this.most) * this.width + column];
    }
    column(column, from = 0) {
      const out = new Float64Array(this.size - from);
      for (let k = from; k < this.size; k++) out[k - from] = this.get(k, column);
      return out;
    }
    clear() {
      this.size = 0;
      this.first = 0;
    }
  }

  /* Records the maxima of quantities since the start. Each entry is the maximum over an interval of
   * time. When all entries are used, each two neighbours are merged, and the length of the
   * intervals doubles. */
  class Whole {
    constructor(width, most = 1024) {
      this.width = width;
      this.most = most;
      this.t = [];
      this.columns = Array.from({ length: width }, () => []);
      this.stretch = 0;
      this.until = -Infinity;
    }
    push(t, values) {
      this.now = [t, values];
      const last = this.t.length - 1;
      if (last >= 0 && t < this.until) {
        for (let j = 0; j < this.width; j++)
          if (!(values[j] <= this.columns[j][last])) this.columns[j][last] = values[j];
        return;
      }
      if (this.t.length === this.most) this.halve();
      this.until = t + this.stretch;
      this.t.push(t);
      for (let j = 0; j < this.width; j++) this.columns[j].push(values[j]);
    }
    halve() {
      const { t } = this;
      this.stretch = 2 * (this.stretch || (t[t.length - 1] - t[0]) / t.length);
      this.t = t.filter((_, k) => k % 2 === 0);
      this.columns = this.columns.map((column) =>
        this.t.map((_, k) =>
          Math.max(column[2 * k], 2 * k + 1 < column.length ? column[2 * k + 1] : -Infinity),
        ),
      );
    }
    /* Returns a column over time, with the latest value as last point. */
    line(column, size = 1) {
      const [t, values] = this.now;
      return {
        x: [...this.t, t],
        y: [...this.columns[column], values[column]].map((x) => x / size),
      };
    }
    last(column) {
      const list = this.columns[column];
      return list.length ? list[list.length - 1] : NaN;
    }
    most_(column) {
      return this.columns[column].reduce((a, b) => (b > a ? b : a), 0);
    }
  }

  /* The positions of a point during the last `lasting` units of time, with their times. */
  class Trail extends Recent {
    constructor(lasting) {
      super(4, 2400);
      this.lasting = lasting;
      this.every = Number.isFinite(lasting) ? lasting / 2300 : 0;
      this.next = -Infinity;
    }
    add(t, point) {
      if (t < this.next) return;
      this.next = t + this.every;
      this.push([t, ...point]);
      while (this.size > 2 && this.get(0, 0) < t - this.lasting) {
        this.first = (this.first + 1) % this.most;
        this.size--;
      }
    }
    clear() {
      super.clear();
      this.next = -Infinity;
    }
  }

  return { Recent, Whole, Trail };
})();
