#include "render/light_places.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "render/matrix_scale.h"

namespace kinora::render {

namespace {

constexpr double kStretch = 1e-3;  // of a length: more than what interpolated keys of a rotation make
constexpr double kMiss = 1e-4;     // of a length, of the poses' interpolation

scene::Matrix toRenderAt(const scene::Transform& toWorld, double time, const CameraState& camera) {
  scene::Matrix m = toWorld.at(time);
  for (int k = 0; k < 3; ++k) m[3][k] -= camera.origin[k];
  return m;
}

struct Rigid {
  Imath::M33d turn;  // row vectors: x turn
  Imath::V3d shift;  // of the pivot
  double stretch;    // largest entry of what is left beside the turn
};

// Polar decomposition by Higham's iteration; nothing where the matrix is singular or mirrors.
std::optional<Rigid> rigidPart(const scene::Matrix& m, const Imath::V3d& pivot) {
  Imath::M33d a;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) a[i][j] = m[i][j];
  if (!(a.determinant() > 1e-12)) return {};
  Rigid r{a, pivot * m - pivot, 0};
  for (int step = 0; step < 40; ++step) {
    const Imath::M33d other = r.turn.inverse().transposed();
    double change = 0;
    for (int i = 0; i < 9; ++i) {
      double& x = r.turn[i / 3][i % 3];
      const double mean = 0.5 * (x + other[i / 3][i % 3]);
      change = std::fmax(change, std::fabs(mean - x));
      x = mean;
    }
    if (!std::isfinite(change)) return {};
    if (change < 1e-14) break;
  }
  for (int i = 0; i < 9; ++i) r.stretch = std::fmax(r.stretch, std::fabs(a[i / 3][i % 3] - r.turn[i / 3][i % 3]));
  return r;
}

// Unit quaternion of a turn of row vectors, on the same side as the one before.
void quaternionOf(const Imath::M33d& m, const float before[4], float q[4]) {
  // of column vectors: the transpose
  const auto e = [&](int i, int j) { return m[j][i]; };
  const double squares[4] = {1 + e(0, 0) + e(1, 1) + e(2, 2), 1 + e(0, 0) - e(1, 1) - e(2, 2),
                             1 - e(0, 0) + e(1, 1) - e(2, 2), 1 - e(0, 0) - e(1, 1) + e(2, 2)};
  int k = 0;
  for (int i = 1; i < 4; ++i)
    if (squares[i] > squares[k]) k = i;
  const double most = std::sqrt(squares[k]) / 2, part = 0.25 / most;
  double x[4];
  const double odd[3] = {e(2, 1) - e(1, 2), e(0, 2) - e(2, 0), e(1, 0) - e(0, 1)};
  x[k] = most;
  for (int i = 0; i < 3; ++i) {
    if (k == 0)
      x[i + 1] = odd[i] * part;
    else if (i + 1 != k)
      x[i + 1] = (e(i, k - 1) + e(k - 1, i)) * part;
  }
  if (k != 0) x[0] = odd[k - 1] * part;
  double along = 0;
  for (int i = 0; i < 4; ++i) along += x[i] * before[i];
  for (int i = 0; i < 4; ++i) q[i] = float(along < 0 ? -x[i] : x[i]);
}

}  // namespace

Placement placementOf(const scene::Transform& toWorld, const CameraState& camera) {
  Placement p{};
  scene::Matrix m = toRenderAt(toWorld, camera.middle(), camera);
  if (!isFinite(m)) m = toRenderAt(scene::Transform{}, camera.middle(), camera);
  for (int k = 0; k < 3; ++k) p.worldOrigin[k] = camera.origin[k];
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) p.localToRender[4 * i + j] = m[i][j];
  p.isStatic = toWorld.isStatic();
  return p;
}

LightMoves movesOf(const scene::Transform& toWorld, const CameraState& camera) {
  const double open = camera.shutterOpen, length = camera.shutterClose - open;
  if (toWorld.isStatic() || !(length > 0)) return {};
  const scene::Matrix middle = toRenderAt(toWorld, camera.middle(), camera);
  const Imath::V3d pivot(middle[3][0], middle[3][1], middle[3][2]);
  const auto matrixAt = [&](double part) { return toRenderAt(toWorld, open + part * length, camera); };
  std::vector<double> parts;
  for (const double t : toWorld.times)
    if (t > open && t < open + length) parts.push_back((t - open) / length);
  parts.insert(parts.end(), {0, 1});
  if (std::none_of(parts.begin(), parts.end(), [&](double part) { return matrixAt(part) != middle; })) return {};
  if (!isFinite(middle) || !(std::fabs(middle.determinant()) > 1e-30)) return {nullptr, false};
  const scene::Matrix back = middle.inverse();

  LightMoves out;
  auto motion = std::make_shared<light::LightMotion>();
  for (int c = 0; c < 3; ++c) motion->pivot[c] = float(pivot[c]);
  // of what carries it from the middle to a part of the shutter
  const auto rigidAt = [&](double part) { return rigidPart(back * matrixAt(part), pivot); };
  constexpr uint32_t kMost = 65;
  for (uint32_t n = 2; n <= kMost; n = 2 * n - 1) {
    motion->poses.assign(n, {});
    float before[4] = {1, 0, 0, 0};
    for (uint32_t k = 0; k < n; ++k) {
      const std::optional<Rigid> r = rigidAt(double(k) / (n - 1));
      if (!r) return {nullptr, false};
      out.isWhole = out.isWhole && r->stretch < kStretch;
      light::LightMotion::Pose& p = motion->poses[k];
      quaternionOf(r->turn, before, p.turn);
      for (int c = 0; c < 3; ++c) {
        p.shift[c] = float(r->shift[c]);
        if (!std::isfinite(p.shift[c])) return {nullptr, false};
      }
      std::copy_n(p.turn, 4, before);
    }
    double most = 0, miss = 0, missTurn = 0;
    const auto look = [&](double part) {
      const std::optional<Rigid> r = rigidAt(part);
      if (!r) return;
      out.isWhole = out.isWhole && r->stretch < kStretch;
      const light::LightMotion::Pose p = motion->at(float(part));
      float q[4];
      quaternionOf(r->turn, p.turn, q);
      for (int i = 0; i < 4; ++i) missTurn = std::fmax(missTurn, std::fabs(double(q[i]) - p.turn[i]));
      for (int c = 0; c < 3; ++c) {
        most = std::fmax(most, std::fabs(r->shift[c]));
        miss = std::fmax(miss, std::fabs(r->shift[c] - p.shift[c]));
      }
    };
    for (const double p : parts) look(p);
    for (uint32_t i = 1; i < 4 * (n - 1); ++i) look(double(i) / (4 * (n - 1)));
    if (missTurn <= kMiss && miss <= kMiss * most) break;
  }
  out.motion = std::move(motion);
  return out;
}

void warnOfShape(const scene::Light& l, const LightMoves& moves, Diagnostics& diagnostics) {
  if (moves.isWhole) return;
  diagnostics.warning(
      "LIGHT-MOTION", l.node->pos,
      l.node->plugin + " '" + l.node->handle + "' changes its size or shape while the shutter is open",
      moves.motion ? "it keeps those of the middle of that time, and moves and turns as it should"
                   : "it stands where it is at the middle of that time",
      "an object that glows (PxrConstant, glowGain) changes");
}

}  // namespace kinora::render
