// SPDX-License-Identifier: Apache-2.0
#include "report/cloud_canvas.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "report/png.hpp"
#include "report/text.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::report {
namespace {

/// One of each run of neighbours: even over the cloud, and without the stripes of every k-th pixel.
std::vector<std::size_t> drawn_points(const std::vector<Eigen::Vector3d>& points, std::size_t most) {
  std::vector<std::size_t> finite;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (points[i].allFinite()) finite.push_back(i);
  if (finite.size() <= most) return finite;
  std::mt19937 random(1);  // the same page every time
  std::vector<std::size_t> out;
  const double run = static_cast<double>(finite.size()) / static_cast<double>(most);
  for (std::size_t k = 0; k < most; ++k) {
    const double at = (static_cast<double>(k) + static_cast<double>(random()) / 4294967296.0) * run;
    out.push_back(finite[std::min(finite.size() - 1, static_cast<std::size_t>(at))]);
  }
  return out;
}

void put_int16(std::string& bytes, double value) {
  const auto v = static_cast<unsigned>(static_cast<int>(std::lround(value)));
  bytes += static_cast<char>(v & 0xffu);
  bytes += static_cast<char>((v >> 8u) & 0xffu);
}

/// The points as the script reads them: positions in steps of `step_mm` from a centre, a palette index each.
struct Packed {
  std::string positions, levels;
  double step_mm = 1.0;
};

Packed pack(const std::vector<Eigen::Vector3d>& points, const std::vector<float>& value,
            const std::vector<std::size_t>& drawn, const MapLimits& limits) {
  Packed out;
  Eigen::AlignedBox3d box;
  ImageF values(static_cast<int>(drawn.size()), 1);
  for (std::size_t k = 0; k < drawn.size(); ++k) {
    box.extend(points[drawn[k]]);
    values.data[k] = value[drawn[k]];
  }
  out.step_mm = std::max(0.5 * box.sizes().maxCoeff() / 32767.0, 1e-9);
  const Eigen::Vector3d center = box.center();
  for (const std::size_t i : drawn)
    for (int axis = 0; axis < 3; ++axis)
      put_int16(out.positions, (points[i][axis] - center[axis]) / out.step_mm);
  const ImageU8 levels = map_indices(values, limits);
  out.levels.assign(levels.data.begin(), levels.data.end());
  return out;
}

std::string palette_bytes(const MapStyle& style) {
  std::string out;
  for (const Rgb& c : map_palette(style.scale, style.nan_color))
    for (const std::uint8_t v : {c.r, c.g, c.b}) out += static_cast<char>(v);
  return out;
}

std::string view_numbers(const CloudView& view) {
  const Eigen::Matrix3d axes = view_axes(view);
  std::string out;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column)
      out += fmt::format("{}{:.9g}", out.empty() ? "" : " ", axes(row, column));
  return out;
}

}  // namespace

std::string cloud_canvas_html(const std::vector<Eigen::Vector3d>& p_world_mm, const std::vector<float>& value,
                              const CloudCanvas& canvas, const std::string& id) {
  const CloudPicture still = draw_cloud(p_world_mm, value, canvas.view);
  MapStyle bare = canvas.style;
  bare.show_bar = false;
  const std::string picture =
      map_html(still.value, bare) + scale_bar_html(still.mm_per_px, still.value.width);
  const std::vector<std::size_t> drawn = drawn_points(p_world_mm, canvas.max_points);
  if (drawn.empty()) return picture + color_bar_html(canvas.style);
  const Packed packed = pack(p_world_mm, value, drawn, canvas.style.limits);
  return fmt::format(
      "<div class=\"cloud\" id=\"{0}\" data-step=\"{1:.9g}\" data-view=\"{2}\" data-palette=\"{3}\" "
      "data-levels=\"{4}\" data-points=\"{5}\"><div class=\"still\">{6}</div><canvas width=\"720\" "
      "height=\"540\" tabindex=\"0\" role=\"img\" aria-label=\"{7}\" aria-describedby=\"{0}-keys\"></canvas>"
      "<p class=\"hint\" id=\"{0}-keys\">Drag or arrow keys to turn, wheel or + and − to zoom, double click "
      "or 0 to start again; {8} of {9} points.</p></div>{10}",
      safe_id(id), packed.step_mm, view_numbers(canvas.view), base64(palette_bytes(canvas.style)),
      base64(packed.levels), base64(packed.positions), picture, escape_html(canvas.label),
      count(drawn.size()), count(p_world_mm.size()), color_bar_html(canvas.style));
}

// Parallel projection, nearest point wins, like the still picture. Little-endian pixels, as on every machine
// that runs a browser.
const char* cloud_script() {
  return R"js((() => {
  const bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  const middle = (values) => {
    const v = Float32Array.from(values).sort(), at = (q) => v[Math.round(q * (v.length - 1))];
    return [at(0.001), at(0.999)];
  };
  function start(box) {
    const canvas = box.querySelector('canvas');
    const paint = canvas.getContext('2d', {willReadFrequently: true});  // single pixels: keep them in memory
    const w = canvas.width, h = canvas.height, step = Number(box.dataset.step);
    const level = bytes(box.dataset.levels), rgb = bytes(box.dataset.palette), n = level.length;
    const data = new DataView(bytes(box.dataset.points).buffer);
    const color = Uint32Array.from({length: 256},
      (_, i) => (255 << 24 | rgb[3 * i + 2] << 16 | rgb[3 * i + 1] << 8 | rgb[3 * i]) >>> 0);
    const first = box.dataset.view.split(' ').map(Number);
    const p = Float32Array.from({length: 3 * n}, (_, i) => step * data.getInt16(2 * i, true));
    // centre and size as seen at first: what the still picture shows
    const seen = [0, 1, 2].map((r) => middle(Array.from({length: n}, (_, i) =>
      first[3 * r] * p[3 * i] + first[3 * r + 1] * p[3 * i + 1] + first[3 * r + 2] * p[3 * i + 2])));
    const center = [0, 1, 2].map((c) =>
      seen.reduce((sum, s, r) => sum + first[3 * r + c] * (s[0] + s[1]) / 2, 0));
    for (let i = 0; i < 3 * n; ++i) p[i] -= center[i % 3];
    const [su, sv] = seen.map((s) => s[1] - s[0]);
    const mmPerPx = Math.max(su / (0.94 * w), sv / (0.94 * h), 1e-9);
    const spacing = 2 * Math.sqrt(su * sv / n) / mmPerPx;
    const image = paint.createImageData(w, h), pixel = new Uint32Array(image.data.buffer);
    const depth = new Float32Array(w * h);
    let view, zoom, waiting = false;
    function scaleBar(pxPerMm) {
      const most = 0.25 * w / pxPerMm, decade = 10 ** Math.floor(Math.log10(most));
      const length = (most >= 5 * decade ? 5 : most >= 2 * decade ? 2 : 1) * decade, x = 16, y = h - 16;
      paint.strokeStyle = paint.fillStyle = '#1d2329';
      paint.lineWidth = 2;
      paint.beginPath();
      paint.moveTo(x, y - 6); paint.lineTo(x, y); paint.lineTo(x + length * pxPerMm, y);
      paint.lineTo(x + length * pxPerMm, y - 6);
      paint.stroke();
      paint.fillText(`${Number(length.toPrecision(1))} mm`, x + length * pxPerMm + 8, y + 2);
    }
    function axes() {
      const x = w - 52, y = h - 52, size = 34;
      paint.lineWidth = 2;
      ['x', 'y', 'z'].forEach((name, c) => {
        const u = x + size * view[c], v = y + size * view[3 + c];
        paint.beginPath(); paint.moveTo(x, y); paint.lineTo(u, v); paint.stroke();
        paint.fillText(name, u + 5 * view[c] - 4, v + 5 * view[3 + c] + 5);
      });
    }
    function draw() {
      waiting = false;
      pixel.fill(color[0]);
      depth.fill(Infinity);
      const s = zoom / mmPerPx, same = 4 / s;
      const dot = Math.min(24, Math.max(2, Math.ceil(spacing * zoom))), half = dot >> 1;
      const [a, b, c, d, e, f, g, k, l] = view;
      for (let i = 0; i < n; ++i) {
        const x = p[3 * i], y = p[3 * i + 1], z = p[3 * i + 2], deep = g * x + k * y + l * z;
        const u = Math.round(w / 2 + s * (a * x + b * y + c * z)) - half;
        const v = Math.round(h / 2 + s * (d * x + e * y + f * z)) - half;
        for (let r = Math.max(0, v); r < Math.min(h, v + dot); ++r)
          for (let q = Math.max(0, u); q < Math.min(w, u + dot); ++q)
            if (deep < depth[r * w + q] - same) {
              depth[r * w + q] = deep;
              pixel[r * w + q] = color[level[i]];
            }
      }
      paint.putImageData(image, 0, 0);
      paint.font = '15px sans-serif';
      scaleBar(s);
      axes();
    }
    const later = () => { if (!waiting) { waiting = true; requestAnimationFrame(draw); } };
    const reset = () => { view = first.slice(); zoom = 1; later(); };
    function turn(alpha, beta) {
      const mix = (m, angle) => {  // rows m (right or down) and 2 (away from the eye)
        const c = Math.cos(angle), s = Math.sin(angle);
        for (let j = 0; j < 3; ++j) {
          const u = view[3 * m + j], away = view[6 + j];
          view[3 * m + j] = c * u - s * away;
          view[6 + j] = s * u + c * away;
        }
      };
      mix(0, alpha);
      mix(1, beta);
      later();
    }
    const closer = (factor) => { zoom = Math.min(60, Math.max(0.3, zoom * factor)); later(); };
    canvas.addEventListener('pointerdown', (event) => canvas.setPointerCapture(event.pointerId));
    canvas.addEventListener('pointermove', (event) => {
      if (event.buttons & 1) turn(0.008 * event.movementX, 0.008 * event.movementY);
    });
    canvas.addEventListener('wheel', (event) => {
      event.preventDefault();
      closer(Math.exp(-0.0015 * event.deltaY));
    }, {passive: false});
    canvas.addEventListener('dblclick', reset);
    const keys = {ArrowLeft: () => turn(-0.1, 0), ArrowRight: () => turn(0.1, 0), ArrowUp: () => turn(0, -0.1),
      ArrowDown: () => turn(0, 0.1), '+': () => closer(1.2), '-': () => closer(1 / 1.2), 0: reset};
    canvas.addEventListener('keydown', (event) => {
      if (keys[event.key]) { event.preventDefault(); keys[event.key](); }
    });
    box.classList.add('live');
    reset();
  }
  document.querySelectorAll('.cloud').forEach(start);
})();)js";
}

}  // namespace fringetwin::report
