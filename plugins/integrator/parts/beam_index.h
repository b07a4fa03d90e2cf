// Beams of light paths by place: the ways that they came through media, and the points where these ended them. A binary
// hierarchy of boxes over pieces of beams, built at the barrier behind the stage of light paths from its records alone,
// and read by all threads. A pass has some hundred or thousand beams (vcm_neighbourhoods.h): one thread builds it in
// less time than others would take to start.
#pragma once
#include <kinora/integrator.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace kinora::vcm {

// A stretch of a light path's ray in media on which the factor on the path is constant, or a point where a medium
// scattered it.
struct Beam {
  float o[3], d[3];     // the ray
  float from, to;       // distances along it; of points both are theirs
  float throughput[3];  // of points with the extinction there
  float absorption[3];  // by unit of length from o on, besides; of points 0
  float last, before;   // PathSums: of beams those of a ray that left, of points at them, the first where edges count
  float time;
  uint32_t light;
  uint32_t verticesBefore;  // those of the path before a vertex on it
  uint32_t medium;          // of points; kNoMedium: a beam
  float factor[2];          // as of PathVertex
  uint32_t tail;            // of the events at these vertices, see PathStates
  static constexpr uint32_t kNoMedium = 0xffffffffu;
  bool isPoint() const { return medium != kNoMedium; }
  float factorOf(uint32_t event) const { return factor[event & 1]; }
};

struct BeamIndex {
  struct Box {
    float low[3], high[3];
  };
  struct Piece {
    Box box;
    uint32_t beam;  // record
    float from, to;
  };
  struct Node {
    Box box;
    uint32_t first, count;  // count 0: its children are first and first + 1
  };
  const Beam* beams = nullptr;
  const Node* nodes = nullptr;
  const Piece* pieces = nullptr;
  uint32_t pieceCount = 0;

  static constexpr uint32_t kInLeaf = 4;
  static constexpr float kPiece = 0.125f;  // longest piece, of the radius of all beams' box

  // Calls visit(piece) for pieces whose boxes come as near as r to a ray between two distances, each once.
  template <class Visit>
  void near(const float o[3], const float d[3], float from, float to, float r, const Visit& visit) const {
    if (!pieceCount) return;
    float inverse[3];
    for (int k = 0; k < 3; ++k) inverse[k] = 1 / (std::fabs(d[k]) > 1e-18f ? d[k] : std::copysign(1e-18f, d[k]));
    const auto meets = [&](const Box& b) {
      float t0 = from, t1 = to;
      for (int k = 0; k < 3; ++k) {
        const float a = (b.low[k] - r - o[k]) * inverse[k], c = (b.high[k] + r - o[k]) * inverse[k];
        t0 = std::max(t0, std::min(a, c));
        t1 = std::min(t1, std::max(a, c));
      }
      return t0 <= t1;
    };
    uint32_t stack[64], depth = 0;
    stack[depth++] = 0;
    while (depth) {
      const Node& n = nodes[stack[--depth]];
      if (!meets(n.box)) continue;
      if (!n.count) {
        stack[depth++] = n.first + 1;
        stack[depth++] = n.first;
        continue;
      }
      for (uint32_t i = n.first; i < n.first + n.count; ++i)
        if (meets(pieces[i].box)) visit(pieces[i]);
    }
  }

  // Null where there is no memory for it.
  static const BeamIndex* build(const CommitServices& services, uint64_t count, const Beam* beams) {
    const auto make = [&]<class T>(T*& to, uint64_t n) {
      to = static_cast<T*>(services.allocate(&services, (n + 1) * sizeof(T)));
      return to != nullptr;
    };
    BeamIndex* index;
    if (!make(index, 1)) return nullptr;
    *index = {beams, nullptr, nullptr, 0};
    if (!count) return index;
    Box all = emptyBox();
    for (uint64_t i = 0; i < count; ++i) grow(all, boxOf(beams[i], beams[i].from, beams[i].to));
    float longest = 0;
    for (int k = 0; k < 3; ++k) longest = std::max(longest, 0.5f * kPiece * (all.high[k] - all.low[k]));
    const auto parts = [&](const Beam& b) {
      const float n = longest > 0 ? (b.to - b.from) / longest : 1;
      return uint32_t(std::clamp(std::ceil(n), 1.f, 64.f));
    };
    uint64_t pieces = 0;
    for (uint64_t i = 0; i < count; ++i) pieces += parts(beams[i]);
    Piece* piece;
    Node* node;
    if (!make(piece, pieces) || !make(node, 2 * pieces)) return nullptr;
    uint32_t n = 0;
    for (uint64_t i = 0; i < count; ++i) {
      const Beam& b = beams[i];
      const uint32_t m = parts(b);
      const auto border = [&](uint32_t k) {
        return k == m ? b.to : b.from + (b.to - b.from) * (float(k) / float(m));
      };
      for (uint32_t k = 0; k < m; ++k)
        piece[n++] = {boxOf(b, border(k), border(k + 1)), uint32_t(i), border(k), border(k + 1)};
    }
    uint32_t nodes = 1;
    split(piece, node, 0, 0, n, nodes);
    index->nodes = node;
    index->pieces = piece;
    index->pieceCount = n;
    return index;
  }

 private:
  static Box emptyBox() { return {{1e30f, 1e30f, 1e30f}, {-1e30f, -1e30f, -1e30f}}; }
  static void grow(Box& b, const Box& x) {
    for (int k = 0; k < 3; ++k) {
      b.low[k] = std::min(b.low[k], x.low[k]);
      b.high[k] = std::max(b.high[k], x.high[k]);
    }
  }
  static Box boxOf(const Beam& b, float from, float to) {
    Box x;
    for (int k = 0; k < 3; ++k) {
      const float p = b.o[k] + b.d[k] * from, q = b.o[k] + b.d[k] * to;
      x.low[k] = std::min(p, q);
      x.high[k] = std::max(p, q);
    }
    return x;
  }
  // By the middle piece along the longest side of their centres; equal ones stay in the order of the records.
  static void split(Piece* piece, Node* node, uint32_t at, uint32_t first, uint32_t end, uint32_t& nodes) {
    Box box = emptyBox(), centres = emptyBox();
    const auto centre = [](const Piece& p, int k) { return p.box.low[k] + p.box.high[k]; };
    for (uint32_t i = first; i < end; ++i) {
      grow(box, piece[i].box);
      for (int k = 0; k < 3; ++k) {
        centres.low[k] = std::min(centres.low[k], centre(piece[i], k));
        centres.high[k] = std::max(centres.high[k], centre(piece[i], k));
      }
    }
    if (end - first <= kInLeaf) {
      node[at] = {box, first, end - first};
      return;
    }
    int axis = 0;
    for (int k = 1; k < 3; ++k)
      if (centres.high[k] - centres.low[k] > centres.high[axis] - centres.low[axis]) axis = k;
    const uint32_t middle = first + (end - first) / 2;
    std::nth_element(piece + first, piece + middle, piece + end, [&](const Piece& a, const Piece& b) {
      const float x = centre(a, axis), y = centre(b, axis);
      return x != y ? x < y : a.beam != b.beam ? a.beam < b.beam : a.from < b.from;
    });
    const uint32_t left = nodes;
    nodes += 2;
    node[at] = {box, left, 0};
    split(piece, node, left, first, middle, nodes);
    split(piece, node, left + 1, middle, end, nodes);
  }
};

}  // namespace kinora::vcm
