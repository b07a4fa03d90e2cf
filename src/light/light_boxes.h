// A hierarchy of boxes over the lights that rays can hit. It finds for a ray the lights whose boxes it passes; the
// lights themselves say whether they are hit. Internal to light/.
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

namespace kinora::light {

struct LightBox3 {
  float low[3], high[3];
};

class LightBoxes {
 public:
  static constexpr uint32_t kMostDepth = 64;

  LightBoxes() = default;
  // boxes[i] is that of lights[i].
  LightBoxes(const std::vector<LightBox3>& boxes, const std::vector<uint32_t>& lights);
  bool isEmpty() const { return nodes_.empty(); }
  size_t bytes() const { return nodes_.size() * sizeof(Node) + lights_.size() * sizeof(uint32_t); }

  // Calls found(light) for each light whose box the ray passes before tMax.
  template <class Found>
  void pass(const float o[3], const float d[3], float tMax, Found&& found) const {
    if (nodes_.empty()) return;
    float inverse[3];
    for (int c = 0; c < 3; ++c) {
      const float x = d[c] < 0 ? (d[c] < -1e-18f ? d[c] : -1e-18f) : (d[c] > 1e-18f ? d[c] : 1e-18f);
      inverse[c] = 1.f / x;
    }
    uint32_t stack[kMostDepth], depth = 0, at = 0;
    for (;;) {
      const Node& n = nodes_[at];
      if (meets(n, o, inverse, tMax)) {
        if (!n.count) {
          stack[depth++] = n.first + 1;
          at = n.first;
          continue;
        }
        for (uint32_t i = 0; i < n.count; ++i) found(lights_[n.first + i]);
      }
      if (!depth) return;
      at = stack[--depth];
    }
  }

 private:
  struct Node {
    float low[3], high[3];
    uint32_t first, count;  // lights, or with count 0 the first of two children
  };
  static float larger(float a, float b) { return a > b ? a : b; }
  static float smaller(float a, float b) { return a < b ? a : b; }
  static float size(float a) { return a < 0 ? -a : a; }
  static bool meets(const Node& n, const float o[3], const float inverse[3], float tMax) {
    float a[3], b[3], reach = 0;
    for (int c = 0; c < 3; ++c) {
      a[c] = n.low[c] - o[c];
      b[c] = n.high[c] - o[c];
      reach += larger(size(a[c]), size(b[c]));
    }
    // what rounding may take from a direction towards the light's edge, which grows with the distance
    const float slack = reach * 4e-6f;
    float from = 0, to = tMax;
    for (int c = 0; c < 3; ++c) {
      const float t0 = (a[c] - slack) * inverse[c], t1 = (b[c] + slack) * inverse[c];
      from = larger(from, smaller(t0, t1));
      to = smaller(to, larger(t0, t1));
    }
    return from <= to * 1.00001f;
  }
  void fill(uint32_t at, const std::vector<LightBox3>& boxes, std::vector<uint32_t>& order, uint32_t from,
            uint32_t to, uint32_t depth);
  std::vector<Node> nodes_;
  std::vector<uint32_t> lights_;
};

}  // namespace kinora::light
