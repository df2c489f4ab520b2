"use strict";
/* Draws the points of a swarm by WebGL, from the engine's memory; without WebGL on a 2D canvas. */
const Cloud = (() => {
  const VERTEX = `attribute vec2 at; uniform vec4 scale; uniform float size;
    void main() { gl_Position = vec4(at * scale.xy + scale.zw, 0.0, 1.0); gl_PointSize = size; }`;
  const FRAGMENT = `precision mediump float; uniform vec4 colour;
    void main() { gl_FragColor = colour; }`;

  class Cloud_ {
    constructor(canvas) {
      this.canvas = canvas;
      const gl = canvas.getContext("webgl", { alpha: true, antialias: false, depth: false });
      if (!gl) return;
      const program = gl.createProgram();
      for (const [kind, text] of [
        [gl.VERTEX_SHADER, VERTEX],
        [gl.FRAGMENT_SHADER, FRAGMENT],
      ]) {
        const shader = gl.createShader(kind);
        gl.shaderSource(shader, text);
        gl.compileShader(shader);
        gl.attachShader(program, shader);
      }
      gl.bindAttribLocation(program, 0, "at");
      gl.linkProgram(program);
      gl.useProgram(program);
      gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
      gl.enableVertexAttribArray(0);
      gl.vertexAttribPointer(0, 2, gl.FLOAT, false, 0, 0);
      gl.enable(gl.BLEND);
      gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
      this.place = (name) => gl.getUniformLocation(program, name);
      this.gl = gl;
    }

    /* A point (x, y) of the swarm is drawn a x + b pixels from the left and c y + d from the
     * top. */
    draw(pen, points, first, { a, b, c, d, width, height, size, colour, alpha }) {
      Dom.fitCanvas(this.canvas, width, height);
      const { gl } = this;
      if (!gl) {
        pen.fillStyle = colour;
        for (let k = 2 * first; k < points.length; k += 2)
          pen.fillRect(a * points[k] + b, c * points[k + 1] + d, size, size);
        return;
      }
      gl.viewport(0, 0, this.canvas.width, this.canvas.height);
      gl.clearColor(0, 0, 0, 0);
      gl.clear(gl.COLOR_BUFFER_BIT);
      gl.bufferData(gl.ARRAY_BUFFER, points, gl.STREAM_DRAW);
      const [x, y] = [2 / width, -2 / height];
      gl.uniform4f(this.place("scale"), a * x, c * y, b * x - 1, d * y + 1);
      gl.uniform1f(this.place("size"), (size * this.canvas.width) / width);
      gl.uniform4f(this.place("colour"), ...Theme.rgb(colour).map((v) => v * alpha), alpha);
      gl.drawArrays(gl.POINTS, first, points.length / 2 - first);
    }
  }

  return { make: (canvas) => new Cloud_(canvas) };
})();
