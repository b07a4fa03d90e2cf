#include "geometry/implicit.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kinora::geometry {

using Imath::V3d;
using Kind = ImplicitNode::Kind;

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// (1 - r^2)^3 of a squared distance over reach, and its derivative by r^2.
double falloff(double r2) {
  const double t = 1 - std::min(r2, 1.0);
  return t * t * t;
}
double falloffSlope(double r2) {
  const double t = 1 - std::min(r2, 1.0);
  return -3 * t * t;
}

// Squared distance of q (leaf space) to the leaf over the square of its reach, and half its gradient by q.
double distance2(const ImplicitNode& n, const V3d& q, V3d& halfGradient) {
  V3d from = q;
  double reach = 1;
  if (n.kind == Kind::Segment) {
    const V3d along = n.end - n.begin;
    const double length2 = along.length2();
    const double t = length2 > 0 ? std::clamp((q - n.begin).dot(along) / length2, 0.0, 1.0) : 0;
    from = q - (n.begin + along * t);
    reach = n.radius;
  }
  halfGradient = from / (reach * reach);
  return from.length2() / (reach * reach);
}

V3d toLeafSpace(const ImplicitNode& n, const V3d& p) {
  V3d q;
  n.toLeaf.multVecMatrix(p, q);
  return q;
}

bool isLeaf(Kind k) { return k == Kind::Ellipsoid || k == Kind::Segment; }

FieldBounds leafBounds(const ImplicitNode& n, const V3d& centre, const V3d& half) {
  const V3d q = toLeafSpace(n, centre);
  V3d extent;
  for (int j = 0; j < 3; ++j) {
    extent[j] = 0;
    for (int i = 0; i < 3; ++i) extent[j] += std::abs(n.toLeaf[i][j]) * half[i];
  }
  double least = 0, most = 0;
  if (n.kind == Kind::Ellipsoid) {
    for (int j = 0; j < 3; ++j) {
      const double a = std::max(std::abs(q[j]) - extent[j], 0.0), b = std::abs(q[j]) + extent[j];
      least += a * a;
      most += b * b;
    }
  } else {
    V3d ignored;
    const double d = std::sqrt(distance2(n, q, ignored)), e = extent.length() / n.radius;
    least = std::max(d - e, 0.0) * std::max(d - e, 0.0);
    most = (d + e) * (d + e);
  }
  // outwards by more than rounding can do
  const FieldBounds b{falloff(most * (1 + 1e-12)), falloff(least * (1 - 1e-12))};
  return {b.low * (1 - 1e-12), b.high * (1 + 1e-12)};
}

FieldBounds product(const FieldBounds& a, const FieldBounds& b) {
  const double c[4] = {a.low * b.low, a.low * b.high, a.high * b.low, a.high * b.high};
  FieldBounds out{kInfinity, -kInfinity};
  for (const double v : c) {
    if (std::isnan(v)) return {-kInfinity, kInfinity};
    out = {std::min(out.low, v), std::max(out.high, v)};
  }
  return out;
}

// A quotient by zero is zero, as in shading: nothing is there.
double quotient(double a, double b) {
  const double q = a / b;
  return std::isfinite(q) ? q : 0;
}

}  // namespace

double ImplicitField::valueAt(const V3d& p, Scratch& s) const {
  s.value.resize(nodes.size());
  for (size_t i = 0; i < nodes.size(); ++i) {
    const ImplicitNode& n = nodes[i];
    const auto operand = [&](size_t k) { return s.value[n.operands[k]]; };
    double v = 0;
    V3d ignored;
    switch (n.kind) {
      case Kind::Constant:
        v = n.constant;
        break;
      case Kind::Ellipsoid:
      case Kind::Segment:
        v = falloff(distance2(n, toLeafSpace(n, p), ignored));
        break;
      case Kind::Add:
        for (size_t k = 0; k < n.operands.size(); ++k) v += operand(k);
        break;
      case Kind::Multiply:
        v = 1;
        for (size_t k = 0; k < n.operands.size(); ++k) v *= operand(k);
        break;
      case Kind::Max:
        v = n.operands.empty() ? 0 : -kInfinity;
        for (size_t k = 0; k < n.operands.size(); ++k) v = std::max(v, operand(k));
        break;
      case Kind::Min:
        v = n.operands.empty() ? 0 : kInfinity;
        for (size_t k = 0; k < n.operands.size(); ++k) v = std::min(v, operand(k));
        break;
      case Kind::Subtract:
        v = operand(0) - operand(1);
        break;
      case Kind::Divide:
        v = quotient(operand(0), operand(1));
        break;
      case Kind::Negate:
        v = -operand(0);
        break;
    }
    s.value[i] = v;
  }
  return s.value.back();
}

V3d ImplicitField::gradientAt(const V3d& p, Scratch& s) const {
  (void)valueAt(p, s);
  s.gradient.resize(nodes.size());
  for (size_t i = 0; i < nodes.size(); ++i) {
    const ImplicitNode& n = nodes[i];
    const auto value = [&](size_t k) { return s.value[n.operands[k]]; };
    const auto gradient = [&](size_t k) { return s.gradient[n.operands[k]]; };
    V3d g(0);
    switch (n.kind) {
      case Kind::Constant:
        break;
      case Kind::Ellipsoid:
      case Kind::Segment: {
        V3d half;
        const double r2 = distance2(n, toLeafSpace(n, p), half);
        const V3d q = half * (2 * falloffSlope(r2));
        for (int k = 0; k < 3; ++k)
          for (int j = 0; j < 3; ++j) g[k] += n.toLeaf[k][j] * q[j];
        break;
      }
      case Kind::Add:
        for (size_t k = 0; k < n.operands.size(); ++k) g += gradient(k);
        break;
      case Kind::Multiply: {
        double rest = 1;  // of those that are not zero
        size_t zeros = 0;
        for (size_t k = 0; k < n.operands.size(); ++k) value(k) == 0 ? void(++zeros) : void(rest *= value(k));
        for (size_t k = 0; k < n.operands.size() && zeros < 2; ++k)
          if (zeros == 0 || value(k) == 0) g += gradient(k) * (zeros ? rest : rest / value(k));
        break;
      }
      case Kind::Max:
      case Kind::Min:
        for (size_t k = 0; k < n.operands.size(); ++k)
          if (value(k) == s.value[i]) {
            g = gradient(k);
            break;
          }
        break;
      case Kind::Subtract:
        g = gradient(0) - gradient(1);
        break;
      case Kind::Divide:
        for (int c = 0; c < 3; ++c)
          g[c] = quotient(gradient(0)[c] * value(1) - value(0) * gradient(1)[c], value(1) * value(1));
        break;
      case Kind::Negate:
        g = -gradient(0);
        break;
    }
    s.gradient[i] = g;
  }
  return s.gradient.back();
}

void ImplicitField::leafFields(const V3d& p, std::vector<double>& weights) const {
  for (const ImplicitNode& n : nodes) {
    V3d ignored;
    if (isLeaf(n.kind)) weights[n.leaf] += falloff(distance2(n, toLeafSpace(n, p), ignored));
  }
}

FieldBounds ImplicitField::boundsOver(const V3d& centre, const V3d& half, ImplicitField& pruned, Scratch& s) const {
  s.bounds.resize(nodes.size());
  for (size_t i = 0; i < nodes.size(); ++i) {
    const ImplicitNode& n = nodes[i];
    const auto operand = [&](size_t k) { return s.bounds[n.operands[k]]; };
    FieldBounds b{0, 0};
    switch (n.kind) {
      case Kind::Constant:
        b = {n.constant, n.constant};
        break;
      case Kind::Ellipsoid:
      case Kind::Segment:
        b = leafBounds(n, centre, half);
        break;
      case Kind::Add:
        for (size_t k = 0; k < n.operands.size(); ++k) b = {b.low + operand(k).low, b.high + operand(k).high};
        break;
      case Kind::Multiply:
        b = {1, 1};
        for (size_t k = 0; k < n.operands.size(); ++k) b = product(b, operand(k));
        break;
      case Kind::Max:
      case Kind::Min:
        for (size_t k = 0; k < n.operands.size(); ++k) {
          const FieldBounds o = operand(k);
          if (k == 0)
            b = o;
          else if (n.kind == Kind::Max)
            b = {std::max(b.low, o.low), std::max(b.high, o.high)};
          else
            b = {std::min(b.low, o.low), std::min(b.high, o.high)};
        }
        break;
      case Kind::Subtract:
        b = {operand(0).low - operand(1).high, operand(0).high - operand(1).low};
        break;
      case Kind::Divide:
        if (operand(1).low > 0 || operand(1).high < 0)
          b = product(operand(0), {1 / operand(1).high, 1 / operand(1).low});
        else
          b = {-kInfinity, kInfinity};
        break;
      case Kind::Negate:
        b = {-operand(0).high, -operand(0).low};
        break;
    }
    if (std::isnan(b.low) || std::isnan(b.high)) b = {-kInfinity, kInfinity};
    s.bounds[i] = b;
  }
  const FieldBounds root = s.bounds.back();
  if (root.high < kBlobbyThreshold || root.low > kBlobbyThreshold) return root;

  // who has a say: from the root down
  constexpr uint32_t kUnused = ~0u;
  s.newIndex.assign(nodes.size(), kUnused);
  s.newIndex.back() = 0;
  const auto matters = [&](const ImplicitNode& n, uint32_t child, const FieldBounds& whole) {
    const FieldBounds& b = s.bounds[child];
    if (n.kind == Kind::Add) return b.low != 0 || b.high != 0;  // x + 0 is x
    if (n.kind == Kind::Max) return b.high >= whole.low;
    if (n.kind == Kind::Min) return b.low <= whole.high;
    return true;
  };
  for (size_t i = nodes.size(); i-- > 0;) {
    if (s.newIndex[i] == kUnused) continue;
    for (const uint32_t child : nodes[i].operands)
      if (matters(nodes[i], child, s.bounds[i])) s.newIndex[child] = 0;
  }
  pruned.nodes.clear();
  for (size_t i = 0; i < nodes.size(); ++i) {
    if (s.newIndex[i] == kUnused) continue;
    s.newIndex[i] = uint32_t(pruned.nodes.size());
    ImplicitNode& n = pruned.nodes.emplace_back(nodes[i]);
    n.operands.clear();
    for (const uint32_t child : nodes[i].operands)
      if (matters(nodes[i], child, s.bounds[i])) n.operands.push_back(s.newIndex[child]);
  }
  return root;
}

Imath::Box3d ImplicitField::reach() const {
  Imath::Box3d box;
  for (const ImplicitNode& n : nodes) {
    if (!isLeaf(n.kind)) continue;
    const Imath::M44d toObject = n.toLeaf.inverse();
    for (int end = 0; end < (n.kind == Kind::Segment ? 2 : 1); ++end) {
      const V3d at = n.kind == Kind::Ellipsoid ? V3d(0) : end ? n.end : n.begin;
      const double r = n.kind == Kind::Ellipsoid ? 1 : n.radius;
      V3d centre;
      toObject.multVecMatrix(at, centre);
      V3d extent;  // of an affine ball: the lengths of the matrix's columns
      for (int j = 0; j < 3; ++j)
        extent[j] = r * std::sqrt(toObject[0][j] * toObject[0][j] + toObject[1][j] * toObject[1][j] +
                                  toObject[2][j] * toObject[2][j]);
      box.extendBy(centre - extent);
      box.extendBy(centre + extent);
    }
  }
  return box;
}

std::string readBlobby(const scene::ParameterList& args, ImplicitField& field, uint32_t& leafCount,
                       std::string& said) {
  const scene::Parameter *code = args.find("code"), *floats = args.find("floats"), *count = args.find("nleaf");
  if (!code || !floats || !count || count->ints.empty()) return "has no code";
  const std::vector<int>& c = code->ints;
  const std::vector<float>& f = floats->floats;
  leafCount = 0;
  size_t at = 0;
  uint64_t operands = 0;
  const auto numbers = [&](int index, size_t n, const float*& out) {
    if (index < 0 || size_t(index) + n > f.size()) return false;
    out = f.data() + index;
    for (size_t i = 0; i < n; ++i)
      if (!std::isfinite(out[i])) return false;
    return true;
  };
  const auto matrix = [](const float* v, Imath::M44d& toLeaf) {
    Imath::M44d m;
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 4; ++j) m[i][j] = v[4 * i + j];
    const double d = m.determinant();
    if (!(std::abs(d) > 1e-30) || !std::isfinite(d) || m[0][3] != 0 || m[1][3] != 0 || m[2][3] != 0 || m[3][3] == 0)
      return false;
    toLeaf = m.inverse();
    return true;
  };
  while (at < c.size()) {
    const int op = c[at++];
    const std::string which = "instruction " + std::to_string(field.nodes.size());
    const auto has = [&](size_t n) { return c.size() - at >= n; };
    ImplicitNode n;
    const float* v = nullptr;
    if (op >= 1000) {
      n.leaf = leafCount++;
      // a leaf that cannot be used is nothing at all
      if (op == 1000) {
        if (!has(1) || !numbers(c[at], 1, v)) return which + " (constant) has no number";
        n.constant = v[0];
        at += 1;
      } else if (op == 1001) {
        if (!has(1) || !numbers(c[at], 16, v)) return which + " (ellipsoid) has no matrix";
        if (matrix(v, n.toLeaf))
          n.kind = Kind::Ellipsoid;
        else
          said = which + " (ellipsoid) has no volume";
        at += 1;
      } else if (op == 1002) {
        if (!has(1) || !numbers(c[at], 23, v)) return which + " (segment) has no end points, radius and matrix";
        n.begin = V3d(v[0], v[1], v[2]);
        n.end = V3d(v[3], v[4], v[5]);
        n.radius = v[6];
        if (n.radius > 0 && matrix(v + 7, n.toLeaf))
          n.kind = Kind::Segment;
        else
          said = which + " (segment) has no volume";
        at += 1;
      } else if (op == 1003) {
        if (!has(2)) return which + " (repelling plane) is cut short";
        said = which + " repels from a depth map, which is not rendered";
        at += 2;
      } else if (op == 1004) {
        if (!has(5)) return which + " (field plug-in) is cut short";
        said = which + " asks for a field plug-in";
        at += 5;
      } else if (op > 1004 && has(1) && c[at] >= 0 && has(size_t(c[at]) + 1)) {
        // other renderers' fields say how many operands follow
        said = which + " has the code " + std::to_string(op) + " of a field that is not known";
        at += size_t(c[at]) + 1;
      } else {
        return which + " has the unknown code " + std::to_string(op);
      }
    } else {
      static constexpr Kind kKinds[] = {Kind::Add,      Kind::Multiply, Kind::Max,    Kind::Min,
                                        Kind::Subtract, Kind::Divide,   Kind::Negate, Kind::Add};
      if (op < 0 || op > 7) return which + " has the unknown code " + std::to_string(op);
      n.kind = kKinds[op];
      size_t count = op <= 3 ? 0 : op <= 5 ? 2 : 1;
      if (op <= 3) {
        if (!has(1) || c[at] < 0) return which + " has no operand count";
        count = size_t(c[at++]);
      }
      if (!has(count)) return which + " is cut short";
      operands += count;
      for (size_t k = 0; k < count; ++k) {
        const int operand = c[at++];
        if (operand < 0 || size_t(operand) >= field.nodes.size())
          return which + " takes the result of instruction " + std::to_string(operand) + ", which is not before it";
        n.operands.push_back(uint32_t(operand));
      }
    }
    field.nodes.push_back(std::move(n));
  }
  if (field.nodes.empty()) return "has no instructions";
  if (int64_t(leafCount) != int64_t(count->ints[0]))
    return "says it has " + std::to_string(count->ints[0]) + " leaves; its instructions have " +
           std::to_string(leafCount);
  return "";
}

}  // namespace kinora::geometry
