// Placements that no ray can reach, and moments at which a moving one has no volume: Embree ends the program on rays
// that meet either.
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "trace/world.h"

namespace kinora::trace {

namespace {

// Embree divides by the determinant, in floats. `far`: how far away
// rays begin.
bool isInReach(const Affine& a, double far) {
  const float determinant = std::fabs(a.determinant());
  if (!(determinant > 1e-37f && determinant < 1e37f)) return false;
  for (int i = 0; i < 3; ++i) {
    double length = 0;
    for (int j = 0; j < 3; ++j) {
      const int r[2] = {(j + 1) % 3, (j + 2) % 3}, c[2] = {(i + 1) % 3, (i + 2) % 3};
      const double minor = double(a.m[r[0]][c[0]]) * a.m[r[1]][c[1]] - double(a.m[r[0]][c[1]]) * a.m[r[1]][c[0]];
      length += std::fabs(minor) / determinant * (far + std::fabs(a.t[j]));
    }
    if (!(length < World::kMostInSpace) || !(std::fabs(a.t[i]) < World::kMostInSpace)) return false;
  }
  return true;
}

Affine between(const Affine& a, const Affine& b, float f) {
  Affine r;
  for (int c = 0; c < 3; ++c) {
    for (int d = 0; d < 3; ++d) r.m[c][d] = (1 - f) * a.m[c][d] + f * b.m[c][d];
    r.t[c] = (1 - f) * a.t[c] + f * b.t[c];
  }
  return r;
}

// Where between two keys the volume is nothing, as 0..1: what turns inside out passes such a moment, what turns by half
// a circle touches one. The determinant of a straight way between matrices is a cubic.
std::vector<double> flatMomentsBetween(const Affine& a, const Affine& b) {
  const auto exact = [&](double f) {
    double m[3][3];
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) m[i][j] = (1 - f) * a.m[i][j] + f * b.m[i][j];
    return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
           m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
  };
  const double d0 = exact(0), d1 = exact(1), low = exact(1. / 3), high = exact(2. / 3);
  const double size = std::max({std::fabs(d0), std::fabs(d1), std::fabs(low), std::fabs(high)});
  const double c1 = -5.5 * d0 + 9 * low - 4.5 * high + d1, c2 = 9 * d0 - 22.5 * low + 18 * high - 4.5 * d1,
               c3 = -4.5 * d0 + 13.5 * low - 13.5 * high + 4.5 * d1;
  std::vector<double> turns = {0};  // it rises or falls throughout from each to the next
  const double root = c2 * c2 - 3 * c1 * c3;
  if (root > 0 && std::fabs(c3) > 1e-12 * size) {
    double x[2] = {(-c2 - std::sqrt(root)) / (3 * c3), (-c2 + std::sqrt(root)) / (3 * c3)};
    if (x[0] > x[1]) std::swap(x[0], x[1]);
    for (const double t : x)
      if (t > 0 && t < 1) turns.push_back(t);
  } else if (c2 != 0 && -c1 / (2 * c2) > 0 && -c1 / (2 * c2) < 1) {
    turns.push_back(-c1 / (2 * c2));
  }
  turns.push_back(1);
  std::vector<double> found;
  for (size_t i = 0; i < turns.size(); ++i) {
    if (std::fabs(exact(turns[i])) <= 1e-10 * size) found.push_back(turns[i]);
    if (i + 1 == turns.size() || (exact(turns[i]) > 0) == (exact(turns[i + 1]) > 0)) continue;
    double from = turns[i], to = turns[i + 1];
    for (int k = 0; k < 60; ++k) {
      const double middle = (from + to) / 2;
      ((exact(middle) > 0) == (exact(from) > 0) ? from : to) = middle;
    }
    found.push_back(from);
  }
  return found;
}

}  // namespace

void World::findLost() {
  constexpr double kBeside = 1e-6;  // of the shutter
  const double far = 4 * (std::fabs(center_[0]) + std::fabs(center_[1]) + std::fabs(center_[2]) + radius_) + 1;
  std::vector<std::pair<float, float>> all;
  for (uint32_t i = 0; i < instances_->size(); ++i) {
    const Instance& inst = (*instances_)[i];
    if (inst.baked) continue;
    const Affine* k = keys(inst);
    bool isLost = inst.keyCount == 1 && !isInReach(*k, far);
    for (uint32_t s = 0; s + 1 < inst.keyCount && !isLost; ++s) {
      std::vector<double> moments = flatMomentsBetween(k[s], k[s + 1]);
      for (const int end : {0, 1})
        if (!isInReach(k[s + uint32_t(end)], far)) moments.push_back(end);
      const double segments = inst.keyCount - 1;
      for (const double m : moments) {
        const double t = (s + m) / segments;
        all.emplace_back(float(std::max(0., t - kBeside)), float(std::min(1., t + kBeside)));
      }
      // anywhere else rays must come through
      const double beside = std::min(kBeside * segments, .2);
      for (const double f : {beside, .25, .5 - beside, .5 + beside, .75, 1 - beside}) {
        bool isAvoided = false;
        for (const double m : moments) isAvoided |= std::fabs(f - m) < beside;
        isLost |= !isAvoided && !isInReach(between(k[s], k[s + 1], float(f)), far);
      }
    }
    if (!isLost) continue;
    isLost_.resize(instances_->size());
    isLost_[i] = true;
    lost_.push_back(inst.user);
  }
  std::sort(all.begin(), all.end());
  for (const auto& m : all) {
    if (!flatMoments_.empty() && m.first <= flatMoments_.back().second)
      flatMoments_.back().second = std::max(flatMoments_.back().second, m.second);
    else
      flatMoments_.push_back(m);
  }
}

float World::besideFlatMoments(float time) const {
  const auto next = std::upper_bound(flatMoments_.begin(), flatMoments_.end(), time,
                                     [](float t, const std::pair<float, float>& m) { return t < m.first; });
  if (next == flatMoments_.begin()) return time;
  const auto& [from, to] = *std::prev(next);
  if (time > to) return time;
  // the shutter's own ends are no way out
  if (from <= 0) return to;
  if (to >= 1) return from;
  return time - from < to - time ? from : to;
}

}  // namespace kinora::trace
