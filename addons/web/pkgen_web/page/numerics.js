"use strict";
/* Numerical methods of the panels: FFT, eigenvalues, normal modes. */
const Numerics = (() => {
  /* Transforms in place (radix 2); the length is a power of two. */
  function fft(re, im) {
    const n = re.length;
    for (let i = 1, j = 0; i < n; i++) {
      let bit = n >> 1;
      for (; j & bit; bit >>= 1) j ^= bit;
      j ^= bit;
      if (i < j) {
        [re[i], re[j]] = [re[j], re[i]];
        [im[i], im[j]] = [im[j], im[i]];
      }
    }
    for (let size = 2; size <= n; size <<= 1) {
      const angle = (-2 * Math.PI) / size;
      for (let k = 0; k < size / 2; k++) {
        const [c, s] = [Math.cos(angle * k), Math.sin(angle * k)];
        for (let i = k; i < n; i += size) {
          const j = i + size / 2;
          const [x, y] = [re[j] * c - im[j] * s, re[j] * s + im[j] * c];
          re[j] = re[i] - x;
          im[j] = im[i] - y;
          re[i] += x;
          im[i] += y;
        }
      }
    }
  }

  /* Returns the spectrum of the last 2^k samples: amplitudes over frequency. Samples are first
   * interpolated linearly to equidistant times; then their mean is subtracted, and a Hann window
   * applied. */
  function spectrum(t, x) {
    const n = 2 ** Math.floor(Math.log2(Math.min(t.length, 4096)));
    if (n < 32) return null;
    const from = t.length - n;
    const dt = (t[t.length - 1] - t[from]) / (n - 1);
    if (!(dt > 0)) return null;
    const re = new Float64Array(n);
    const im = new Float64Array(n);
    let mean = 0;
    for (let k = 0, at = from; k < n; k++) {
      const now = t[from] + k * dt;
      while (at + 2 < t.length && t[at + 1] < now) at++;
      const s = (now - t[at]) / (t[at + 1] - t[at] || 1);
      re[k] = x[at] + s * (x[at + 1] - x[at]);
      mean += re[k] / n;
    }
    for (let k = 0; k < n; k++)
      re[k] = (re[k] - mean) * (0.5 - 0.5 * Math.cos((2 * Math.PI * k) / (n - 1)));
    fft(re, im);
    const f = [];
    const a = [];
    for (let k = 1; k < n / 2; k++) {
      f.push(k / (n * dt));
      a.push((4 * Math.hypot(re[k], im[k])) / n);
    }
    return { f, a };
  }

  /* Returns L with L Lᵀ = M, or null if M is not positive definite. */
  function cholesky(M) {
    const n = M.length;
    const L = M.map(() => new Float64Array(n));
    for (let i = 0; i < n; i++)
      for (let j = 0; j <= i; j++) {
        let sum = M[i][j];
        for (let k = 0; k < j; k++) sum -= L[i][k] * L[j][k];
        if (i === j) {
          if (!(sum > 0)) return null;
          L[i][i] = Math.sqrt(sum);
        } else L[i][j] = sum / L[j][j];
      }
    return L;
  }

  /* Returns ascending eigenvalues, and eigenvectors as rows, of a symmetric matrix (Jacobi). */
  function eigen(matrix) {
    const n = matrix.length;
    const A = matrix.map((row) => Float64Array.from(row));
    const V = A.map((_, i) => Float64Array.from({ length: n }, (__, j) => Number(i === j)));
    for (let sweep = 0; sweep < 30; sweep++) {
      let off = 0;
      let all = 0;
      for (let i = 0; i < n; i++)
        for (let j = 0; j < n; j++) {
          all += A[i][j] ** 2;
          if (i !== j) off += A[i][j] ** 2;
        }
      if (off <= 1e-24 * all) break;
      for (let p = 0; p < n; p++)
        for (let r = p + 1; r < n; r++) {
          if (Math.abs(A[p][r]) < 1e-300) continue;
          const theta = (A[r][r] - A[p][p]) / (2 * A[p][r]);
          const t = (theta >= 0 ? 1 : -1) / (Math.abs(theta) + Math.sqrt(theta * theta + 1));
          const c = 1 / Math.sqrt(t * t + 1);
          const s = t * c;
          for (let k = 0; k < n; k++) {
            const [x, y] = [A[k][p], A[k][r]];
            A[k][p] = c * x - s * y;
            A[k][r] = s * x + c * y;
          }
          for (let k = 0; k < n; k++) {
            const [x, y] = [A[p][k], A[r][k]];
            A[p][k] = c * x - s * y;
            A[r][k] = s * x + c * y;
            const [v, w] = [V[p][k], V[r][k]];
            V[p][k] = c * v - s * w;
            V[r][k] = s * v + c * w;
          }
        }
    }
    const order = A.map((_, i) => i).sort((i, j) => A[i][i] - A[j][j]);
    return { values: order.map((i) => A[i][i]), vectors: order.map((i) => V[i]) };
  }

  /* Returns the normal modes of small oscillations about q0, a minimum of the potential energy, as
   * [{w2: ω², row}]. With dq = q − q0, the energy of a mode is ((row·q')² + ω² (row·dq)²)/2. The
   * mass matrix M and the stiffness matrix K are computed from second differences of the energy. */
  function modes(energy, q0, scale) {
    const n = q0.length;
    const zero = new Float64Array(n);
    const h = scale * 1e-3;
    const at = (base, moves) => {
      const out = Float64Array.from(base);
      for (const [k, d] of moves) out[k] += d;
      return out;
    };
    const second = (f, i, j, step) =>
      i === j
        ? (f([[i, step]]) - 2 * f([]) + f([[i, -step]])) / step ** 2
        : (f([
            [i, step],
            [j, step],
          ]) -
            f([
              [i, step],
              [j, -step],
            ]) -
            f([
              [i, -step],
              [j, step],
            ]) +
            f([
              [i, -step],
              [j, -step],
            ])) /
          (4 * step ** 2);
    const V = (moves) => energy(at(q0, moves), zero);
    const T = (moves) => energy(q0, at(zero, moves));
    const fill = (f, step) => {
      const out = zero.length ? Array.from({ length: n }, () => new Float64Array(n)) : [];
      for (let i = 0; i < n; i++)
        for (let j = 0; j <= i; j++) out[i][j] = out[j][i] = second(f, i, j, step);
      return out;
    };
    const M = fill(T, 1);
    const K = fill(V, h);
    const L = cholesky(M);
    if (!L) return null;
    /* With M = L Lᵀ, the eigenvalues of the symmetric matrix L⁻¹ K L⁻ᵀ are the ω². */
    const half = solveRows(L, K);
    const S = solveRows(L, transpose(half));
    const { values, vectors } = eigen(S);
    const most = Math.max(...values.map(Math.abs));
    if (values[0] < -1e-3 * most) return null;
    /* For y = Lᵀ dq the mass matrix is the identity; so the amplitude of a mode is vector · Lᵀ
     * dq. */
    return values.map((w2, k) => ({
      w2: Math.max(w2, 0),
      row: zero.map((_, j) => {
        let sum = 0;
        for (let i = 0; i <= j; i++) sum += L[j][i] * vectors[k][i];
        return sum;
      }),
    }));
  }

  const transpose = (A) => A.map((_, i) => Float64Array.from(A, (row) => row[i]));
  /* Returns X with L X = B. */
  function solveRows(L, B) {
    const n = L.length;
    const X = B.map((row) => Float64Array.from(row));
    for (let i = 0; i < n; i++)
      for (let c = 0; c < n; c++) {
        let sum = X[i][c];
        for (let k = 0; k < i; k++) sum -= L[i][k] * X[k][c];
        X[i][c] = sum / L[i][i];
      }
    return X;
  }

  /* Returns the area of a polygon: half the sum of the cross products of successive vertices. */
  function area(xs, ys) {
    let sum = 0;
    for (let k = 0, n = xs.length; k < n; k++) {
      const j = k + 1 < n ? k + 1 : 0;
      sum += xs[k] * ys[j] - xs[j] * ys[k];
    }
    return sum / 2;
  }

  return { spectrum, modes, eigen, cholesky, area, fft };
})();
