// Makes every mechanism on the page movable: see mechlib/moving.py.
// The picture is always one of the frames that were computed there. Nothing is solved or interpolated here.
"use strict";

(() => {
  const SLACK = 0.05; // SVG units: less than the eye sees, more than the rounding of the frames
  const TOUCH = 44; // CSS pixels: what a finger hits
  const CALM = 100; // ms a frame at least, for a reader who asked for less motion

  /**
   * Where the mechanism goes when a joint is pulled to a place: downhill in the distance between them, frame by frame,
   * so that it never jumps to another branch. It keeps its direction if it can. At a dead point, where both directions
   * lead downhill, it keeps it in any case, like a mechanism with inertia.
   */
  function pull(path, [x, y], from, direction, cyclic) {
    const n = path.length;
    const distance = (k) => Math.hypot(path[k][0] - x, path[k][1] - y);
    const beside = (k, steps) => (cyclic ? (k + steps + n) % n : k + steps); // beyond an end there is no path

    const isDeadPoint = (k) => {
      const [before, here, after] = [-1, 0, 1].map((steps) => path[beside(k, steps)]);
      if (!before || !after) return false;
      const [a, b, c, d] = [before, after].flatMap(([u, v]) => [u - here[0], v - here[1]]);
      return a * c + b * d > 0.5 * Math.hypot(a, b) * Math.hypot(c, d); // less than 60 degrees between the neighbours
    };

    const descend = (way) => {
      let best = from;
      for (let i = 1; i < n; i++) {
        const k = beside(from, i * way);
        if (!path[k] || distance(k) > distance(best) + SLACK) break;
        if (distance(k) < distance(best)) best = k;
        if (isDeadPoint(k)) break; // what lies behind it is for the next pull
      }
      return best;
    };

    const onward = descend(direction);
    if (onward !== from || isDeadPoint(from)) return [onward, direction];
    const back = descend(-direction);
    return back === from ? [from, direction] : [back, -direction];
  }

  /** The frame some steps later: round and round, or there and back again. */
  function advance(frame, direction, steps, n, cyclic) {
    if (cyclic) return [(frame + steps) % n, 1];
    const there = n - 1;
    const phase = ((direction > 0 ? frame : 2 * there - frame) + steps) % (2 * there);
    return phase < there ? [phase, 1] : [2 * there - phase, -1];
  }

  /** The path of an arrow: a shaft and two barbs. */
  function arrow([x, y], [u, v]) {
    const length = Math.hypot(u, v);
    if (length < 1) return "";
    const [a, b] = [u, v].map((w) => (w * Math.min(10, length)) / length);
    return `M${x} ${y}l${u} ${v}m${-a - b / 2} ${-b + a / 2}l${a + b / 2} ${b - a / 2}l${-a + b / 2} ${-b - a / 2}`;
  }

  const html = (tag, properties) => Object.assign(document.createElement(tag), properties);

  function svgElement(tag, className) {
    const element = document.createElementNS("http://www.w3.org/2000/svg", tag);
    element.setAttribute("class", className);
    return element;
  }

  function enhance(figure) {
    const { joints, symbol, values, arrows, start, cyclic, seconds, autoplay, words } = JSON.parse(
      figure.querySelector("script").textContent,
    );
    const svg = figure.querySelector("svg");
    const texts = [...figure.querySelectorAll("dd")];
    const bodies = [...svg.querySelectorAll("[data-chain]")];
    const n = values[0].length;
    const calm = matchMedia("(prefers-reduced-motion: reduce)");

    let frame = start;
    let direction = 1;
    let playing = false;
    let seen = false; // whether the figure is on the screen
    let clock = 0; // ms, when the frame that is shown was due
    let request = 0;
    let waiting = autoplay && !calm.matches;
    let held = null; // the joint that is dragged

    const button = html("button", { type: "button", textContent: words.play });
    const range = html("input", { type: "range", min: 0, max: n - 1, step: 1, value: start });
    range.setAttribute("aria-label", `${words.position}, ${symbol}`);
    const controls = html("div", { className: "controls" });
    controls.append(button, range);
    figure.append(controls);

    const vectors = arrows.map(({ label, vectors }) => {
      const box = html("input", { type: "checkbox" });
      const line = html("label", {});
      line.append(box, label);
      controls.append(line);
      box.addEventListener("change", draw);
      return { box, vectors, path: svg.appendChild(svgElement("path", "arrow")) };
    });

    const handles = [...svg.querySelectorAll(".movable")].map(({ dataset }) => {
      const handle = svg.appendChild(svgElement("circle", "handle"));
      handle.dataset.joint = dataset.joint;
      return handle;
    });
    const placed = [...svg.querySelectorAll("[data-joint]")];

    texts.forEach((text, i) => {
      text.style.minWidth = `${Math.max(...values[i].map((value) => value.length))}ch`; // no number moves another
    });

    function draw() {
      const here = (name) => joints[name][frame] ?? joints[name][0]; // a fixed joint has one place
      for (const each of placed) each.setAttribute("transform", `translate(${here(each.dataset.joint)})`);
      for (const each of bodies) each.setAttribute("points", each.dataset.chain.split(" ").map(here).join(" "));
      for (const { box, vectors: all, path } of vectors) {
        const shown = box.checked ? Object.keys(all) : [];
        path.setAttribute("d", shown.map((name) => arrow(here(name), all[name][frame])).join(""));
      }
      texts.forEach((text, i) => (text.textContent = values[i][frame]));
      range.value = frame;
      range.setAttribute("aria-valuetext", `${symbol} = ${values[0][frame]}`);
    }

    function tick(now) {
      const due = Math.max((1000 * seconds) / n, calm.matches ? CALM : 0);
      clock = Math.max(clock, now - 250); // no time passes in a hidden tab
      const steps = Math.floor((now - clock) / due);
      if (steps > 0) {
        clock += steps * due;
        [frame, direction] = advance(frame, direction, steps, n, cyclic);
        draw();
      }
      request = requestAnimationFrame(tick);
    }

    function run() {
      cancelAnimationFrame(request);
      clock = performance.now();
      if (playing && seen) request = requestAnimationFrame(tick);
    }

    function play(on) {
      playing = on;
      waiting = false;
      button.textContent = on ? words.pause : words.play;
      run();
    }

    const pointer = (event) => new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM().inverse());

    svg.addEventListener("pointerdown", (event) => {
      if (event.button !== 0 || held || !event.target.matches(".handle")) return;
      play(false);
      const { x, y } = pointer(event);
      const near = handles.map(({ dataset: { joint } }) => {
        const [u, v] = joints[joint][frame];
        return { path: joints[joint], pointer: event.pointerId, dx: u - x, dy: v - y };
      });
      [held] = near.sort((a, b) => Math.hypot(a.dx, a.dy) - Math.hypot(b.dx, b.dy)); // the areas to touch overlap
      event.target.setPointerCapture(event.pointerId);
    });

    svg.addEventListener("pointermove", (event) => {
      if (event.pointerId !== held?.pointer) return;
      const { x, y } = pointer(event);
      [frame, direction] = pull(held.path, [x + held.dx, y + held.dy], frame, direction, cyclic);
      draw();
    });

    svg.addEventListener("lostpointercapture", () => (held = null));

    range.addEventListener("input", () => {
      play(false);
      direction = Math.sign(range.valueAsNumber - frame) || direction;
      frame = range.valueAsNumber;
      draw();
    });

    button.addEventListener("click", () => play(!playing));

    new ResizeObserver(() => {
      const scale = svg.getScreenCTM()?.a || 1;
      for (const handle of handles) handle.setAttribute("r", TOUCH / 2 / scale);
    }).observe(svg);

    new IntersectionObserver((entries) => {
      seen = entries.at(-1).isIntersecting;
      if (seen && waiting) play(true);
      else run();
    }).observe(figure);

    draw();
  }

  document.addEventListener("DOMContentLoaded", () => document.querySelectorAll(".mechanism").forEach(enhance));
})();
