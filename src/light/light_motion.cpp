#include "light/light_motion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace kinora::light {

namespace {

// v turned by the unit quaternion, or by its inverse (sign -1).
void turn(const float q[4], float sign, float v[3]) {
  const float w = sign * q[0], x = q[1], y = q[2], z = q[3];
  const float t[3] = {2 * (y * v[2] - z * v[1]), 2 * (z * v[0] - x * v[2]), 2 * (x * v[1] - y * v[0])};
  const float u[3] = {y * t[2] - z * t[1], z * t[0] - x * t[2], x * t[1] - y * t[0]};
  for (int c = 0; c < 3; ++c) v[c] += w * t[c] + u[c];
}

struct Reach {
  float low[3], high[3];  // of the shift of the pivot
  float cosTurn;          // of the largest angle from the middle
};

Reach reachOf(const LightMotion& m) {
  Reach r{};
  float least = 1;  // cosine of half the angle, which turns in between do not pass unless it changes its sign
  for (int c = 0; c < 3; ++c) r.low[c] = r.high[c] = 0;
  for (const LightMotion::Pose& p : m.poses) {
    for (int c = 0; c < 3; ++c) {
      r.low[c] = std::min(r.low[c], p.shift[c]);
      r.high[c] = std::max(r.high[c], p.shift[c]);
    }
    least = std::min(least, p.turn[0] * m.poses[0].turn[0] > 0 ? std::fabs(p.turn[0]) : 0.f);
  }
  r.cosTurn = std::clamp(2 * least * least - 1, -1.f, 1.f);
  return r;
}

}  // namespace

LightMotion::Pose LightMotion::at(float time) const {
  const auto last = uint32_t(poses.size() - 1);
  const float place = std::clamp(time, 0.f, 1.f) * float(last);
  const uint32_t k = std::min(uint32_t(place), last - 1);
  const float b = place - float(k), a = 1 - b;
  const Pose &from = poses[k], &to = poses[k + 1];
  Pose p;
  float length2 = 0;
  for (int i = 0; i < 4; ++i) {
    p.turn[i] = a * from.turn[i] + b * to.turn[i];
    length2 += p.turn[i] * p.turn[i];
  }
  const float scale = 1 / std::sqrt(length2);
  for (float& x : p.turn) x *= scale;
  for (int c = 0; c < 3; ++c) p.shift[c] = a * from.shift[c] + b * to.shift[c];
  return p;
}

void carryToRest(const LightMotion& motion, float time, LightVector kind, float x[3]) {
  const LightMotion::Pose p = motion.at(time);
  const bool isPoint = kind == LightVector::Point;
  for (int c = 0; c < 3 && isPoint; ++c) x[c] -= motion.pivot[c] + p.shift[c];
  turn(p.turn, -1, x);
  for (int c = 0; c < 3 && isPoint; ++c) x[c] += motion.pivot[c];
}

void carryFromRest(const LightMotion& motion, float time, LightVector kind, float x[3]) {
  const LightMotion::Pose p = motion.at(time);
  const bool isPoint = kind == LightVector::Point;
  for (int c = 0; c < 3 && isPoint; ++c) x[c] -= motion.pivot[c];
  turn(p.turn, 1, x);
  for (int c = 0; c < 3 && isPoint; ++c) x[c] += motion.pivot[c] + p.shift[c];
}

void widen(LightDescription& d, const LightMotion& m) {
  const Reach reach = reachOf(m);
  if (d.isInfinite) {
    if (reach.cosTurn == 1) return;
    // the mean over the shutter is shorter than each: less of it lies in one direction
    double mean[3] = {0, 0, 0}, length2 = 0;
    std::vector<std::array<float, 3>> axes(m.poses.size(), {d.axis[0], d.axis[1], d.axis[2]});
    for (size_t k = 0; k < axes.size(); ++k) {
      turn(m.poses[k].turn, 1, axes[k].data());
      for (int c = 0; c < 3; ++c) mean[c] += axes[k][c] / double(axes.size());
    }
    for (int c = 0; c < 3; ++c) length2 += mean[c] * mean[c];
    if (d.cosReach > 0) {
      // from the mean to where it is at any time
      double nearest = 1;
      for (const std::array<float, 3>& axis : axes) {
        double along = 0, own = 0;
        for (int c = 0; c < 3; ++c) {
          along += mean[c] * axis[c];
          own += double(axis[c]) * axis[c];
        }
        nearest = length2 > 0 && own > 0 ? std::min(nearest, along / std::sqrt(length2 * own)) : -1;
      }
      const double angle = std::acos(std::clamp(nearest, -1.0, 1.0)) + std::acos(std::min(1.0, double(d.cosReach)));
      d.cosReach = angle < 1.57 ? float(std::cos(angle) * (1 - 1e-5)) : 0.f;
    }
    for (int c = 0; c < 3; ++c) d.axis[c] = float(mean[c]);
    return;
  }
  // the ball that holds it about the pivot, wherever that goes
  double away2 = 0, most2 = 0;
  for (int c = 0; c < 3; ++c) {
    away2 += double(d.center[c] - m.pivot[c]) * (d.center[c] - m.pivot[c]);
    const double half = 0.5 * (double(reach.high[c]) - reach.low[c]);
    most2 += half * half;
  }
  const bool turns = reach.cosTurn < 1;
  const bool isBoxed = d.low[0] < d.high[0] || d.low[1] < d.high[1] || d.low[2] < d.high[2];
  const double own = d.radius + (turns ? std::sqrt(away2) : 0);
  for (int c = 0; c < 3; ++c) {
    const float from = turns ? m.pivot[c] : d.center[c];
    if (turns || !isBoxed) {
      d.low[c] = float(from - own);
      d.high[c] = float(from + own);
    }
    d.low[c] += reach.low[c];
    d.high[c] += reach.high[c];
    const float slack = 1e-5f * (std::fabs(d.low[c]) + std::fabs(d.high[c]));
    d.low[c] -= slack;
    d.high[c] += slack;
    d.center[c] = from + 0.5f * (reach.low[c] + reach.high[c]);
  }
  d.radius = float((own + std::sqrt(most2)) * (1 + 1e-5));
  if (turns) {
    const double cone = std::acos(std::clamp(double(d.cosNormals), -1.0, 1.0)) + std::acos(double(reach.cosTurn));
    d.cosNormals = float(std::cos(std::min(3.14159265358979, cone)));
  }
}

}  // namespace kinora::light
