"use strict";
/* A minimal WebGL renderer: lit solids, and lines as ribbons with a width in pixels. A library
 * would be five times as large as all other code of the page. */
const Gl = (() => {
  const SOLID = {
    vertex: `#version 300 es
      in vec3 position, normal;
      uniform mat4 eye, place;
      uniform mat3 turn;
      out vec3 n, here, own;
      void main() {
        vec4 p = place * vec4(position, 1.0);
        n = turn * normal;
        here = p.xyz;
        own = position;
        gl_Position = eye * p;
      }`,
    fragment: `#version 300 es
      precision highp float;
      in vec3 n, here, own;
      uniform vec4 colour;
      uniform vec3 from;
      uniform float striped;
      out vec4 shown;
      void main() {
        vec3 m = normalize(n);
        vec3 look = normalize(from - here);
        if (dot(m, look) < 0.0) m = -m;
        vec3 light = normalize(vec3(0.35, -0.5, 0.8));
        float sky = 0.5 + 0.5 * m.z;
        float lit = 0.55 + 0.2 * sky + 0.38 * max(dot(m, light), 0.0);
        float shine = pow(max(dot(m, normalize(light + look)), 0.0), 40.0);
        float sector = own.x * own.y > 0.0 ? 1.0 : 0.0;
        vec3 base = mix(colour.rgb, mix(colour.rgb, vec3(1.0), 0.42), striped * sector);
        shown = vec4(base * lit + 0.14 * shine, colour.a);
      }`,
  };
  const RIBBON = {
    vertex: `#version 300 es
      in vec4 position, tint;
      out vec4 t;
      void main() { gl_Position = position; t = tint; }`,
    fragment: `#version 300 es
      precision highp float;
      in vec4 t;
      out vec4 shown;
      void main() { shown = t; }`,
  };

  function program(gl, source) {
    const made = gl.createProgram();
    for (const [type, text] of [
      [gl.VERTEX_SHADER, source.vertex],
      [gl.FRAGMENT_SHADER, source.fragment],
    ]) {
      const shader = gl.createShader(type);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      gl.attachShader(made, shader);
    }
    gl.linkProgram(made);
    if (!gl.getProgramParameter(made, gl.LINK_STATUS))
      throw new Error("WebGL: " + gl.getProgramInfoLog(made));
    return made;
  }

  class Painter {
    constructor(canvas) {
      this.canvas = canvas;
      const gl = canvas.getContext("webgl2", { antialias: true, alpha: false });
      if (!gl) throw new Error("this browser shows no 3D (no WebGL 2)");
      this.gl = gl;
      this.solid = program(gl, SOLID);
      this.ribbon = program(gl, RIBBON);
      this.at = (name) => gl.getUniformLocation(this.solid, name);
      this.uniform = Object.fromEntries(
        ["eye", "place", "turn", "colour", "from", "striped"].map((name) => [name, this.at(name)]),
      );
      this.meshes = Object.fromEntries(
        Object.entries(Solids.all()).map(([name, mesh]) => [name, this.upload(mesh)]),
      );
      this.ribbons = gl.createBuffer();
      this.ribbonArray = gl.createVertexArray();
      gl.bindVertexArray(this.ribbonArray);
      gl.bindBuffer(gl.ARRAY_BUFFER, this.ribbons);
      for (const [name, offset] of [
        ["position", 0],
        ["tint", 16],
      ]) {
        const where = gl.getAttribLocation(this.ribbon, name);
        gl.enableVertexAttribArray(where);
        gl.vertexAttribPointer(where, 4, gl.FLOAT, false, 32, offset);
      }
      this.vertices = new Float32Array(1 << 14);
      this.count = 0;
    }

    upload({ position, normal }) {
      const { gl } = this;
      const array = gl.createVertexArray();
      gl.bindVertexArray(array);
      for (const [name, data] of [
        ["position", position],
        ["normal", normal],
      ]) {
        gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
        gl.bufferData(gl.ARRAY_BUFFER, data, gl.STATIC_DRAW);
        const where = gl.getAttribLocation(this.solid, name);
        gl.enableVertexAttribArray(where);
        gl.vertexAttribPointer(where, 3, gl.FLOAT, false, 0, 0);
      }
      return { array, count: position.length / 3 };
    }

    begin(camera, background) {
      const { gl, canvas } = this;
      this.camera = camera;
      this.matrix = camera.matrix();
      gl.viewport(0, 0, canvas.width, canvas.height);
      gl.clearColor(...background, 1);
      gl.enable(gl.DEPTH_TEST);
      gl.depthMask(true);
      gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
      gl.enable(gl.BLEND);
      gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
      gl.useProgram(this.solid);
      gl.uniformMatrix4fv(this.uniform.eye, false, this.matrix);
      gl.uniform3fv(this.uniform.from, camera.frame().eye);
      this.count = 0;
    }

    /* Draws a mesh. Its normals are transformed by the inverse transpose of the matrix, which has
     * the same columns, each divided by its squared length. */
    put(name, place, colour, alpha = 1, striped = 0) {
      const { gl } = this;
      const mesh = this.meshes[name];
      const turn = [];
      for (let k = 0; k < 3; k++) {
        const column = place.slice(4 * k, 4 * k + 3);
        const square = Camera.dot(column, column) || 1;
        turn.push(...column.map((x) => x / square));
      }
      gl.uniformMatrix4fv(this.uniform.place, false, place);
      gl.uniformMatrix3fv(this.uniform.turn, false, turn);
      gl.uniform4f(this.uniform.colour, ...colour, alpha);
      gl.uniform1f(this.uniform.striped, striped);
      gl.depthMask(alpha >= 1);
      gl.bindVertexArray(mesh.array);
      gl.drawArrays(gl.TRIANGLES, 0, mesh.count);
    }

    /* Draws a line of `width` pixels; fade(k) is the opacity at its k-th point. */
    line(points, width, colour, fade = () => 1) {
      const { camera, matrix: m } = this;
      const clip = (p) =>
        [0, 1, 2, 3].map((i) => m[i] * p[0] + m[4 + i] * p[1] + m[8 + i] * p[2] + m[12 + i]);
      let last = null;
      for (let k = 0; k < points.length; k++) {
        const c = clip(points[k]);
        if (c[3] <= 0) {
          last = null;
          continue;
        }
        const now = { x: c[0] / c[3], y: c[1] / c[3], z: c[2] / c[3], a: fade(k) };
        if (last) this.quad(last, now, width, colour, camera);
        last = now;
      }
    }

    quad(a, b, width, colour, { width: w, height: h }) {
      const [dx, dy] = [(b.x - a.x) * w, (b.y - a.y) * h];
      const length = Math.hypot(dx, dy) || 1;
      const [nx, ny] = [(-dy / length) * (width / w), (dx / length) * (width / h)];
      if (this.count * 8 + 48 > this.vertices.length) {
        const more = new Float32Array(this.vertices.length * 2);
        more.set(this.vertices);
        this.vertices = more;
      }
      for (const [p, side] of [
        [a, 1],
        [a, -1],
        [b, 1],
        [a, -1],
        [b, -1],
        [b, 1],
      ]) {
        this.vertices.set(
          [p.x + side * nx, p.y + side * ny, p.z, 1, ...colour, p.a],
          this.count * 8,
        );
        this.count++;
      }
    }

    end() {
      const { gl } = this;
      gl.depthMask(false);
      gl.useProgram(this.ribbon);
      gl.bindVertexArray(this.ribbonArray);
      gl.bindBuffer(gl.ARRAY_BUFFER, this.ribbons);
      gl.bufferData(gl.ARRAY_BUFFER, this.vertices.subarray(0, this.count * 8), gl.DYNAMIC_DRAW);
      gl.drawArrays(gl.TRIANGLES, 0, this.count);
    }
  }

  return { Painter };
})();
