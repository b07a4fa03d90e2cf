#include "geometry/trim_curves.h"

#include <algorithm>
#include <cmath>

#include "geometry/dice.h"

namespace kinora::geometry {

using Imath::V2d;
using Imath::V3d;

namespace {

constexpr size_t kMostPoints = 200'000;  // of all loops
constexpr int kMostHalvings = 12;        // of a knot span
constexpr double kOpenGap = 1e-3;        // of the unit square: less is how exporters round

// Without a size on screen: how far the arc of a segment may leave it, in its lengths. Those of a circle cut into
// kCircleSegments.
constexpr double kArcOfSegment = 6.283185307179586 / kCircleSegments / 8;

class Flattener {
 public:
  Flattener(const TensorSurface& surface, const DiceRate& rate)
      : surface_(surface),
        rate_(rate),
        u0_(surface.u.spans().front().knot0),
        u1_(surface.u.spans().back().knot1),
        v0_(surface.v.spans().front().knot0),
        v1_(surface.v.spans().back().knot1) {}

  // Appends a curve with both its ends; false when it has places that are not finite.
  bool add(const Axis& axis, std::span<const float> u, std::span<const float> v, std::span<const float> w,
           std::vector<V2d>& loop) {
    axis_ = &axis;
    u_ = u, v_ = v, w_ = w;
    const bool straight = axis.order() == 2 && std::all_of(w.begin(), w.end(), [&](float x) { return x == w[0]; });
    for (const Axis::Span& span : axis.spans()) {
      const int parts = straight ? 1 : axis.order();
      V2d from = at(span, 0);
      if (&span == &axis.spans().front()) loop.push_back(from);
      for (int k = 1; k <= parts; ++k) {
        const double s0 = double(k - 1) / parts, s1 = k == parts ? 1.0 : double(k) / parts;
        const V2d to = at(span, s1);
        if (!straight) refine(span, s0, from, s1, to, 0, loop);
        loop.push_back(to);
        from = to;
      }
      if (loop.size() > kMostPoints) return true;  // the caller counts
    }
    return std::all_of(loop.begin(), loop.end(), [](const V2d& p) { return std::isfinite(p.x + p.y); });
  }

 private:
  V2d at(const Axis::Span& span, double s) const {
    double weights[64], unused[64], u = 0, v = 0, w = 0;
    axis_->weights(span, s, weights, unused);
    for (int k = 0; k < axis_->order(); ++k) {
      const size_t i = size_t(axis_->control(span, k));
      u += weights[k] * u_[i];
      v += weights[k] * v_[i];
      w += weights[k] * w_[i];
    }
    return V2d((u / w - u0_) / (u1_ - u0_), (v / w - v0_) / (v1_ - v0_));
  }
  V3d onSurface(const V2d& p) const {
    const auto find = [](const Axis& axis, double x, double& s) -> const Axis::Span& {
      x = std::clamp(x, 0.0, 1.0);
      const auto& spans = axis.spans();
      auto it = std::upper_bound(spans.begin(), spans.end(), x,
                                 [](double value, const Axis::Span& span) { return value < span.u1; });
      if (it == spans.end()) --it;
      s = std::clamp((x - it->u0) / (it->u1 - it->u0), 0.0, 1.0);
      return *it;
    };
    double s, t;
    const Axis::Span &a = find(surface_.u, p.x, s), &b = find(surface_.v, p.y, t);
    return surface_.at(0, a, s, b, t);
  }
  // Adds points between two of the curve until segments are as near to it as the rate asks for, as seen on the
  // surface.
  void refine(const Axis::Span& span, double s0, const V2d& from, double s1, const V2d& to, int depth,
              std::vector<V2d>& loop) const {
    if (depth == kMostHalvings || loop.size() > kMostPoints) return;
    const double s = (s0 + s1) / 2;
    const V2d middle = at(span, s), along = to - from;
    if (!std::isfinite(middle.x + middle.y)) return;
    const double length = along.length();
    const double part = length > 0 ? std::clamp((middle - from).dot(along) / (length * length), 0.0, 1.0) : 0.0;
    const V3d onCurve = onSurface(middle);
    const double miss = (onCurve - onSurface(from + along * part)).length();
    const double edge = rate_.at(onCurve);
    const double allowed =
        std::isfinite(edge) ? kSagittaLarge * edge : kArcOfSegment * (onSurface(to) - onSurface(from)).length();
    if (miss <= allowed) return;
    refine(span, s0, from, s, middle, depth + 1, loop);
    loop.push_back(middle);
    refine(span, s, middle, s1, to, depth + 1, loop);
  }

  const TensorSurface& surface_;
  const DiceRate& rate_;
  const double u0_, u1_, v0_, v1_;
  const Axis* axis_ = nullptr;
  std::span<const float> u_, v_, w_;
};

// The arrays of a TrimCurve request.
struct TrimArrays {
  std::vector<int> curvesOfLoop, order, n;
  std::vector<float> knot, min, max, u, v, w;

  // Whether their lengths fit together.
  bool read(const scene::ParameterList& list) {
    const auto ints = [&](const char* name, std::vector<int>& out) {
      const scene::Parameter* p = list.find(name);
      if (p) out = p->ints;
      return p != nullptr;
    };
    const auto floats = [&](const char* name, std::vector<float>& out) {
      const scene::Parameter* p = list.find(name);
      if (p) out = p->floats;
      return p != nullptr;
    };
    if (!ints("ncurves", curvesOfLoop) || !ints("order", order) || !ints("n", n) || !floats("knot", knot) ||
        !floats("min", min) || !floats("max", max) || !floats("u", u) || !floats("v", v) || !floats("w", w))
      return false;
    uint64_t curves = 0, points = 0, knots = 0;
    for (const int c : curvesOfLoop) {
      if (c < 1) return false;
      curves += uint64_t(c);
    }
    if (curves != order.size() || curves != n.size() || curves != min.size() || curves != max.size()) return false;
    for (size_t c = 0; c < n.size(); ++c) {
      if (n[c] < 1 || order[c] < 1) return false;
      points += uint64_t(n[c]);
      knots += uint64_t(n[c]) + uint64_t(order[c]);
    }
    return points == u.size() && points == v.size() && points == w.size() && knots == knot.size();
  }
};

}  // namespace

Trim readTrim(const scene::Primitive& primitive, const scene::NuPatch& patch, const TensorSurface& surface,
              const DiceRate& rate, Diagnostics& diagnostics) {
  Trim out;
  if (patch.trim.empty()) return out;
  const SourcePos& pos = patch.trim.begin()->pos.line ? patch.trim.begin()->pos : primitive.pos;
  const auto tell = [&](const char* code, const std::string& what, const char* done) {
    diagnostics.warning(code, pos, "trim curves of " + subject(primitive) + ": " + what, done);
  };
  if (primitive.attributes) {
    const std::string sense = primitive.attributes->named.getString("trimcurve:sense", "inside");
    out.keepInside = sense != "outside";
    if (sense != "inside" && sense != "outside")
      tell("GEOM-TRIM", "their sense '" + sense.substr(0, 40) + "' is neither inside nor outside", "inside is kept");
  }
  TrimArrays a;
  if (!a.read(patch.trim)) {
    tell("GEOM-TRIM", "their arrays do not fit together", "the whole surface is rendered");
    return out;
  }
  Flattener flattener(surface, rate);
  size_t curve = 0, point = 0, knot = 0, total = 0;
  for (size_t l = 0; l < a.curvesOfLoop.size(); ++l) {
    std::vector<V2d> loop;
    std::string wrong;
    double gap = 0;
    for (int c = 0; c < a.curvesOfLoop[l]; ++c, ++curve) {
      const size_t n = size_t(a.n[curve]), knots = n + size_t(a.order[curve]);
      if (wrong.empty()) {
        Axis axis;
        const std::vector<float> own(a.knot.begin() + std::ptrdiff_t(knot),
                                     a.knot.begin() + std::ptrdiff_t(knot + knots));
        wrong = Axis::nurbs(a.n[curve], a.order[curve], own, a.min[curve], a.max[curve], axis);
        const size_t before = loop.size();
        const auto part = [&](const std::vector<float>& v) { return std::span(v).subspan(point, n); };
        if (wrong.empty() && !flattener.add(axis, part(a.u), part(a.v), part(a.w), loop))
          wrong = "places that are not finite";
        if (before > 0 && loop.size() > before) gap = std::max(gap, (loop[before] - loop[before - 1]).length());
      }
      point += n;
      knot += knots;
    }
    if (!wrong.empty()) {
      tell("GEOM-TRIM", "a curve of loop " + std::to_string(l + 1) + " has " + wrong, "this loop is left out");
      continue;
    }
    total += loop.size();
    if (total > kMostPoints) {
      tell("GEOM-TRIM", "they need more than " + std::to_string(kMostPoints) + " segments",
           "the whole surface is rendered");
      out.loops.clear();
      return out;
    }
    if (std::max(gap, (loop.back() - loop.front()).length()) > kOpenGap)
      tell("GEOM-TRIM-OPEN", "loop " + std::to_string(l + 1) + " is not closed", "a straight line closes it");
    out.loops.push_back(std::move(loop));
  }
  return out;
}

}  // namespace kinora::geometry
