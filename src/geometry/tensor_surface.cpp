#include "geometry/tensor_surface.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/dice.h"

namespace kinora::geometry {

using Imath::V3d;
using Imath::V4d;

V3d TensorSurface::at(size_t key, const Axis::Span& a, double s, const Axis::Span& b, double t, V3d* du,
                      V3d* dv) const {
  double wu[64], wv[64], su[64], sv[64];
  u.weights(a, s, wu, su);
  v.weights(b, t, wv, sv);
  V4d p(0), pu(0), pv(0);
  for (int j = 0; j < v.order(); ++j) {
    const V4d* row = &keys[key][size_t(v.control(b, j)) * u.controls()];
    for (int i = 0; i < u.order(); ++i) {
      const V4d& c = row[u.control(a, i)];
      p += c * (wu[i] * wv[j]);
      pu += c * (su[i] * wv[j]);
      pv += c * (wu[i] * sv[j]);
    }
  }
  if (!rational[key]) {
    // the weights of a basis need not sum to one: tangents and coefficients are no points
    if (du) *du = V3d(pu.x, pu.y, pu.z);
    if (dv) *dv = V3d(pv.x, pv.y, pv.z);
    return V3d(p.x, p.y, p.z);
  }
  const V3d point = V3d(p.x, p.y, p.z) / p.w;
  if (du) *du = (V3d(pu.x, pu.y, pu.z) - point * pu.w) / p.w;
  if (dv) *dv = (V3d(pv.x, pv.y, pv.z) - point * pv.w) / p.w;
  return point;
}
V3d TensorSurface::normal(size_t key, const Axis::Span& a, double s, const Axis::Span& b, double t) const {
  for (double inward : {0.0, 1e-4, 1e-3, 1e-2, 0.1}) {
    V3d du, dv;
    at(key, a, s + (0.5 - s) * inward, b, t + (0.5 - t) * inward, &du, &dv);
    const V3d n = du.cross(dv);
    if (n.length() > 1e-9 * (du.length2() + dv.length2())) return n.normalized();
  }
  return V3d(0, 0, 1);
}

void interpolate(const TensorSurface& surface, const SourcePrimvar& source, const PiecePlace& place,
                 std::vector<float>& out) {
  const int width = int(source.parameter->elementFloats());
  const Axis &u = surface.u, &v = surface.v;
  auto value = [&](int element, int k) { return double(source.values[size_t(element) * width + k]); };
  if (source.storage == scene::StorageClass::Vertex) {
    double wu[64], wv[64], unused[64];
    u.weights(*place.a, place.s, wu, unused);
    v.weights(*place.b, place.t, wv, unused);
    for (int k = 0; k < width; ++k) {
      double sum = 0;
      for (int j = 0; j < v.order(); ++j)
        for (int i = 0; i < u.order(); ++i)
          sum += wu[i] * wv[j] * value(v.control(*place.b, j) * u.controls() + u.control(*place.a, i), k);
      out.push_back(float(sum));
    }
    return;
  }
  // Bilinear over the cell that the piece is a part of.
  const double x = place.a->cell0 + (place.a->cell1 - place.a->cell0) * place.s;
  const double y = place.b->cell0 + (place.b->cell1 - place.b->cell0) * place.t;
  int corner[4];
  for (int c = 0; c < 4; ++c)
    corner[c] = source.storage == scene::StorageClass::Varying
                    ? v.varying(place.b->cell, c / 2) * u.varyings() + u.varying(place.a->cell, c % 2)
                    : 4 * (place.b->cell * u.cells() + place.a->cell) + c;
  for (int k = 0; k < width; ++k)
    out.push_back(float((1 - y) * ((1 - x) * value(corner[0], k) + x * value(corner[1], k)) +
                        y * ((1 - x) * value(corner[2], k) + x * value(corner[3], k))));
}

namespace {

constexpr int kMostPatchSegments = 1024;  // a piece

// Points, normals and values along a line of a piece.
struct Sample {
  V3d p, n;
  std::vector<float> values;
};

// By how much they miss the straight way from the first to the last: see segmentsForPlace().
double missOf(const std::vector<const Sample*>& line, double length, const std::vector<double>& range) {
  double most = 0;
  const Sample &first = *line.front(), &last = *line.back();
  for (size_t a = 1; a + 1 < line.size(); ++a) {
    const double t = double(a) / double(line.size() - 1);
    V3d off = line[a]->p - (first.p * (1 - t) + last.p * t);
    off -= line[a]->n * off.dot(line[a]->n);
    if (length > 0) most = std::max(most, off.length() / length);
    for (size_t c = 0; c < line[a]->values.size(); ++c)
      if (range[c] > 0)
        most = std::max(most,
                        std::abs(line[a]->values[c] - (first.values[c] * (1 - t) + last.values[c] * t)) / range[c]);
  }
  return most;
}

}  // namespace

void chooseRates(const TensorSurface& s, const std::vector<SourcePrimvar>& primvars, const DiceRate& rate,
                 std::vector<int>& nu, std::vector<int>& nv) {
  // only those of class vertex follow the basis; others are bilinear anyway
  std::vector<const SourcePrimvar*> curved;
  std::vector<double> range;
  for (const SourcePrimvar& v : primvars) {
    if (v.storage != scene::StorageClass::Vertex || v.values.empty()) continue;
    curved.push_back(&v);
    const size_t width = v.parameter->elementFloats();
    for (size_t c = 0; c < width; ++c) {
      float low = v.values[c], high = low;
      for (size_t i = c; i < v.values.size(); i += width) {
        low = std::min(low, v.values[i]);
        high = std::max(high, v.values[i]);
      }
      range.push_back(double(high) - double(low));
    }
  }
  const bool displaced = rate.isDisplaced;
  const bool isWhole = s.u.spans().size() == 1 && s.v.spans().size() == 1;  // not a piece of something large
  std::vector<double> wantU(s.u.spans().size(), 1), wantV(s.v.spans().size(), 1);
  constexpr int kSamples = 4;
  for (size_t key = 0; key < s.keys.size(); key += std::max<size_t>(1, s.keys.size() - 1))  // first and last
    for (size_t j = 0; j < wantV.size(); ++j)
      for (size_t i = 0; i < wantU.size(); ++i) {
        Sample at[kSamples + 1][kSamples + 1];
        double edge = std::numeric_limits<double>::infinity();
        for (int b = 0; b <= kSamples; ++b)
          for (int a = 0; a <= kSamples; ++a) {
            const double x = double(a) / kSamples, y = double(b) / kSamples;
            Sample& here = at[b][a];
            here.p = s.at(key, s.u.spans()[i], x, s.v.spans()[j], y);
            here.n = s.normal(key, s.u.spans()[i], x, s.v.spans()[j], y);
            for (const SourcePrimvar* v : curved)
              interpolate(s, *v, {&s.u.spans()[i], &s.v.spans()[j], x, y}, here.values);
            if (a % 2 == 0 && b % 2 == 0) edge = std::min(edge, rate.at(here.p));
          }
        for (int b = 0; b <= kSamples; ++b) {
          double lengthU = 0, turnU = 0, lengthV = 0, turnV = 0;
          std::vector<const Sample*> alongU, alongV;
          for (int a = 0; a <= kSamples; ++a) {
            alongU.push_back(&at[b][a]);
            alongV.push_back(&at[a][b]);
            if (a == kSamples) break;
            lengthU += (at[b][a + 1].p - at[b][a].p).length();
            turnU += turnBetween(at[b][a].n, at[b][a + 1].n);
            lengthV += (at[a + 1][b].p - at[a][b].p).length();
            turnV += turnBetween(at[a][b].n, at[a + 1][b].n);
          }
          const auto wanted = [&](double length, double turn, const std::vector<const Sample*>& line) {
            if (isWhole && isSmall(length, edge, displaced)) return segmentsOfSmall(length, turn, edge);
            return std::max(segmentsFor(length, turn, edge, displaced),
                            segmentsForPlace(missOf(line, length, range), length, edge));
          };
          wantU[i] = std::max(wantU[i], wanted(lengthU, turnU, alongU));
          wantV[j] = std::max(wantV[j], wanted(lengthV, turnV, alongV));
        }
      }
  for (double scale = 1;; scale *= 0.8) {
    double u = 0, v = 0;
    bool least = true;
    auto round = [&](const std::vector<double>& want, std::vector<int>& out, double& sum) {
      out.clear();
      for (double w : want) {
        out.push_back(int(std::ceil(std::clamp(w * scale - 1e-6, 1.0, double(kMostPatchSegments)))));
        sum += out.back();
        least &= out.back() == 1;
      }
    };
    round(wantU, nu, u);
    round(wantV, nv, v);
    if (least || 2 * u * v <= rate.maxTriangles) return;
  }
}

}  // namespace kinora::geometry
