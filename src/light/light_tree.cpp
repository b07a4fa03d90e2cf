#include "light/light_tree.h"

#include <sys/mman.h>

#include <algorithm>
#include <bit>
#include <cmath>

namespace kinora::light {

void useLargePages(void* memory, size_t bytes) {
  constexpr size_t kPage = 2 << 20;
  madvise(memory, bytes / kPage * kPage, MADV_HUGEPAGE);
}

namespace {

constexpr float kPi = 3.14159265f;
constexpr int kBuckets = 12;
constexpr uint32_t kMostDepth = 30;  // below the top, of a path's 32 bits

// Directions within an angle of an axis; axis 0: all.
struct Cone {
  float axis[3] = {0, 0, 0};
  float cosine = -1;
};

// Cosine of the sum of two angles up to pi, -1 where it is larger.
float cosOfSum(float a, float b) {
  if (a <= -b) return -1;
  const float s = (1 - a * a) * (1 - b * b);
  return a * b - std::sqrt(std::max(0.f, s));
}

float dot(const float* a, const float* b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

// A cone about both; w: how much each draws the axis its way.
Cone merged(const Cone& a, float wa, const Cone& b, float wb) {
  if (a.cosine <= -1 || b.cosine <= -1) return {};
  Cone c;
  for (int i = 0; i < 3; ++i) c.axis[i] = wa * a.axis[i] + wb * b.axis[i];
  const float l2 = dot(c.axis, c.axis);
  if (!(l2 > 1e-12f * (wa + wb) * (wa + wb))) return {};
  for (float& x : c.axis) x /= std::sqrt(l2);
  const auto about = [&](const Cone& k) { return cosOfSum(std::clamp(dot(c.axis, k.axis), -1.f, 1.f), k.cosine); };
  c.cosine = std::min(about(a), about(b));
  return c.cosine <= -1 ? Cone{} : c;
}

// What a node says, while the tree is built.
struct Bounds {
  float low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
  Cone normals;
  float cosEmission = 1, weight = 0;
  float mean[3] = {0, 0, 0};  // of infinite lights: times the weight
  bool isTwoSided = false;
  bool areAllSided = true, areBroad = true;  // every one emits to all sides; to all of a half space at least

  void add(const Bounds& b) {
    if (!(b.weight > 0)) return;
    normals = weight > 0 ? merged(normals, weight, b.normals, b.weight) : b.normals;
    cosEmission = weight > 0 ? std::min(cosEmission, b.cosEmission) : b.cosEmission;
    isTwoSided = isTwoSided || b.isTwoSided;
    areAllSided = areAllSided && b.areAllSided;
    areBroad = areBroad && b.areBroad;
    weight += b.weight;
    for (int c = 0; c < 3; ++c) {
      low[c] = std::min(low[c], b.low[c]);
      high[c] = std::max(high[c], b.high[c]);
      mean[c] += b.mean[c];
    }
  }
  bool isUniform() const {
    constexpr float kAlike = 0.8f;  // cosine of an angle of normals
    return areAllSided || (areBroad && normals.cosine >= kAlike);
  }
  float area() const {
    const float x = high[0] - low[0], y = high[1] - low[1], z = high[2] - low[2];
    return x * y + y * z + z * x;
  }
};

// Solid angle of a cone of emission, directions weighted by the falloff: pi for a flat surface, 4 pi for a sphere.
// The rim's part is a fit within a tenth of the integral.
float emissionMeasure(const Cone& normals, float cosEmission, bool isTwoSided) {
  const float t = (1 - normals.cosine) / 2, s = cosEmission <= 0 ? 1 : 1 - cosEmission * cosEmission;
  const float rim = kPi * std::max(0.f, 1 + 3.28f * t - 4.28f * t * t);
  const float all = std::max(4 * kPi * t + rim * s, 1e-6f);
  return isTwoSided ? std::min(2 * all, 4 * kPi) : all;
}

struct Item {
  Bounds bounds;
  uint32_t light;
  float center(int c) const { return 0.5f * (bounds.low[c] + bounds.high[c]); }
};

float finiteOr(float x, float otherwise) { return std::isfinite(x) ? x : otherwise; }

Item itemOf(const LightDescription& d, uint32_t light) {
  Item it;
  it.light = light;
  Bounds& b = it.bounds;
  const float share = d.sampledShare > 0 && d.sampledShare < 1 ? d.sampledShare : 1;
  const float power = std::isfinite(d.power) ? std::clamp(d.power * share, 1e-24f, 1e24f) : 0;
  const float l2 = dot(d.axis, d.axis), length = std::sqrt(l2);
  if (d.isInfinite) {
    const float scale = std::isfinite(length) ? (length > 1 ? 1 / length : 1) : 0;
    b.weight = power;
    for (int c = 0; c < 3; ++c) {
      const float m = scale > 0 ? d.axis[c] * scale : 0;
      b.low[c] = b.high[c] = m;
      b.mean[c] = m * power;
    }
    return it;
  }
  const float radius = std::max(0.f, finiteOr(d.radius, 0));
  bool isBoxed = false;
  for (int c = 0; c < 3; ++c) isBoxed = isBoxed || d.low[c] != 0 || d.high[c] != 0;
  for (int c = 0; c < 3; ++c) {
    const float center = finiteOr(d.center[c], 0);
    b.low[c] = center - radius;
    b.high[c] = center + radius;
    if (isBoxed && d.low[c] <= d.high[c]) {
      b.low[c] = std::min(std::max(b.low[c], d.low[c]), b.high[c]);
      b.high[c] = std::max(std::min(b.high[c], d.high[c]), b.low[c]);
    }
  }
  if (l2 > 0.25f && std::isfinite(length)) {
    for (int c = 0; c < 3; ++c) b.normals.axis[c] = d.axis[c] / length;
    b.normals.cosine = std::clamp(finiteOr(d.cosNormals, -1), -1.f, 1.f);
    b.cosEmission = std::clamp(finiteOr(d.cosEmission, -1), -1.f, 1.f);
    b.isTwoSided = d.isTwoSided != 0;
    if (b.normals.cosine <= -1) b.normals = {};
  } else {
    b.cosEmission = 0;
  }
  b.areAllSided = b.normals.cosine <= -1 && b.cosEmission <= 0;
  b.areBroad = cosOfSum(b.normals.cosine, b.cosEmission) <= 0.01f;
  b.weight = power / emissionMeasure(b.normals, b.cosEmission, b.isTwoSided);
  return it;
}

int32_t floorOf(float x) { return int32_t(std::floor(x)); }

// A length of at least this as 14 bits.
uint32_t roundedUp(float x) {
  constexpr uint32_t kDropped = 31 - kExtentBits;
  return std::min((std::bit_cast<uint32_t>(std::min(x, 1e30f)) + (1u << kDropped) - 1) >> kDropped, kExtentMask);
}
float lengthOf(uint32_t bits) { return std::bit_cast<float>((bits & kExtentMask) << (31 - kExtentBits)); }

TreeNode nodeOf(const Bounds& b, bool isInfinite, float scale) {
  TreeNode n{};
  n.weight = std::max(b.weight * scale, 1e-30f);
  if (isInfinite) {
    for (int c = 0; c < 3; ++c) n.center[c] = b.mean[c] / b.weight;
    n.extent = kNodeInfinite;
    return n;
  }
  uint32_t half[3];
  for (int c = 0; c < 3; ++c) {
    n.center[c] = 0.5f * (b.low[c] + b.high[c]);
    half[c] = roundedUp(std::max({b.high[c] - n.center[c], n.center[c] - b.low[c], 0.f}));
  }
  n.extent = half[0] | half[1] << kExtentBits | (b.isTwoSided ? uint32_t(kNodeTwoSided) : 0u);
  n.extentZ = half[2] | (b.isUniform() ? kNodeUniform : 0u) | (b.areAllSided ? kNodeAround : 0u) |
              uint32_t(floorOf(b.normals.cosine * 32767)) << 16;
  for (int c = 0; c < 3; ++c) n.axis |= (uint32_t(int32_t(std::lround(b.normals.axis[c] * 127))) & 255u) << (8 * c);
  n.axis |= uint32_t(floorOf(b.cosEmission * 127)) << 24;
  return n;
}

}  // namespace

class TreeBuilder {
 public:
  TreeBuilder(LightTree& tree, bool isInfinite, float scale, uint32_t position, std::vector<Item> items)
      : tree_(tree), items_(std::move(items)), isInfinite_(isInfinite), scale_(scale), position_(position) {}
  // Fills node `at`.
  void build(uint32_t at) { fill(at, 0, uint32_t(items_.size()), 0); }
  Bounds all() const {
    Bounds b;
    for (const Item& i : items_) b.add(i.bounds);
    return b;
  }

 private:
  void fill(uint32_t at, uint32_t from, uint32_t to, uint32_t depth) {
    Bounds b;
    for (uint32_t i = from; i < to; ++i) b.add(items_[i].bounds);
    TreeNode n = nodeOf(b, isInfinite_, scale_);
    if (to - from == 1) {
      n.child = kLeaf | items_[from].light;
      tree_.places_[items_[from].light].leaf = at;
      tree_.places_[items_[from].light].position = position_ + from;
      tree_.nodes_[at] = n;
      return;
    }
    const uint32_t middle = split(from, to, depth, b);
    n.child = uint32_t(tree_.nodes_.size());
    tree_.nodes_[at] = n;
    tree_.nodes_.resize(n.child + 2);
    fill(n.child, from, middle, depth + 1);
    fill(n.child + 1, middle, to, depth + 1);
  }

  // Brings the items in two parts; where the second begins.
  uint32_t split(uint32_t from, uint32_t to, uint32_t depth, const Bounds& all) {
    const uint32_t n = to - from;
    float low[3], extent[3];
    int longest = 0;
    for (int c = 0; c < 3; ++c) {
      low[c] = INFINITY;
      float high = -INFINITY;
      for (uint32_t i = from; i < to; ++i) {
        low[c] = std::min(low[c], items_[i].center(c));
        high = std::max(high, items_[i].center(c));
      }
      extent[c] = high - low[c];
      if (extent[c] > extent[longest]) longest = c;
    }
    uint32_t levels = 0;
    while ((1ull << levels) < n) ++levels;
    // all in one place, or beyond what a path holds: by number
    if (!(extent[longest] > 0) || depth + levels >= kMostDepth || n == 2) return from + n / 2;
    float best = INFINITY;
    int bestAxis = -1, bestBucket = 0;
    for (int c = 0; c < 3; ++c) {
      if (!(extent[c] > 0)) continue;
      if (n > 8192 && c != longest) continue;  // far from the leaves any good cut will do
      Bounds buckets[kBuckets];
      for (uint32_t i = from; i < to; ++i) buckets[bucketOf(items_[i], c, low[c], extent[c])].add(items_[i].bounds);
      Bounds above[kBuckets];
      for (int k = kBuckets - 1; k > 0; --k) {
        above[k] = buckets[k];
        if (k + 1 < kBuckets) above[k].add(above[k + 1]);
      }
      Bounds below;
      for (int k = 0; k + 1 < kBuckets; ++k) {
        below.add(buckets[k]);
        if (!(below.weight > 0) || !(above[k + 1].weight > 0)) continue;
        // long thin nodes are cut across first
        const float cost = (costOf(below) + costOf(above[k + 1])) * (extent[longest] / extent[c]);
        if (cost < best) {
          best = cost;
          bestAxis = c;
          bestBucket = k;
        }
      }
    }
    if (bestAxis < 0) return from + n / 2;
    Item* const first = items_.data() + from;
    Item* const last = items_.data() + to;
    const int axis = bestAxis;
    Item* const cut = std::stable_partition(
        first, last, [&](const Item& i) { return bucketOf(i, axis, low[axis], extent[axis]) <= bestBucket; });
    const uint32_t middle = from + uint32_t(cut - first);
    (void)all;
    return middle > from && middle < to ? middle : from + n / 2;
  }
  static int bucketOf(const Item& i, int axis, float low, float extent) {
    return std::clamp(int((i.center(axis) - low) / extent * kBuckets), 0, kBuckets - 1);
  }
  float costOf(const Bounds& b) const {
    if (isInfinite_) return b.weight * (b.area() + 1e-6f);
    const float x = b.high[0] - b.low[0], y = b.high[1] - b.low[1], z = b.high[2] - b.low[2];
    return b.weight * emissionMeasure(b.normals, b.cosEmission, b.isTwoSided) *
           (b.area() + 1e-6f * (x * x + y * y + z * z));
  }

  LightTree& tree_;
  std::vector<Item> items_;
  bool isInfinite_;
  float scale_;
  uint32_t position_;  // of its first light
};

LightTree::LightTree(std::span<const LightDescription> lights) : places_(lights.size()) {
  std::vector<Item> finite, infinite;
  for (uint32_t i = 0; i < lights.size(); ++i) {
    if (!(lights[i].power > 0)) continue;
    Item it = itemOf(lights[i], i);
    if (!(it.bounds.weight > 0)) continue;
    (lights[i].isInfinite ? infinite : finite).push_back(it);
  }
  if (finite.empty() && infinite.empty()) return;
  double total = 0;
  for (const auto* list : {&finite, &infinite})
    for (const Item& i : *list) total += i.bounds.weight;
  const float scale = float(1 / total);
  nodes_.reserve(2 * (finite.size() + infinite.size()) + 2);
  const uint32_t finiteCount = uint32_t(finite.size());
  TreeBuilder f(*this, false, scale, 0, std::move(finite));
  TreeBuilder g(*this, true, scale, finiteCount, std::move(infinite));
  nodes_.resize(2);
  const bool hasFinite = f.all().weight > 0, hasInfinite = g.all().weight > 0;
  if (hasFinite) f.build(0);
  const uint32_t finiteEnd = uint32_t(nodes_.size());
  if (hasInfinite) g.build(1);
  top_[0].node = hasFinite ? 0 : 1;
  top_[1].node = 1;
  topCount_ = hasFinite && hasInfinite ? 2 : 1;
  nodes_.shrink_to_fit();
  chooseTop(finiteEnd);
  if (isDeep_) sumPowers(finiteCount);
}

// Opens the largest nodes until there are kMostTop.
void LightTree::chooseTop(uint32_t finiteEnd) {
  std::vector<uint32_t> open, ends;
  for (uint32_t i = 0; i < topCount_; ++i) {
    open.push_back(top_[i].node);
    ends.push_back(top_[i].node ? nodeCount() : finiteEnd);
  }
  const auto size = [&](uint32_t k) {
    const TreeNode& n = nodes_[k];
    if (n.child & kLeaf) return -1.f;
    const float x = lengthOf(n.extent), y = lengthOf(n.extent >> kExtentBits), z = lengthOf(n.extentZ);
    return n.extent & kNodeInfinite ? n.weight : n.weight * (x * x + y * y + z * z);
  };
  while (open.size() < kMostTop) {
    size_t best = 0;
    for (size_t i = 1; i < open.size(); ++i)
      if (size(open[i]) > size(open[best])) best = i;
    if (size(open[best]) < 0) {
      // nodes without extent may be open still
      best = open.size();
      for (size_t i = 0; i < open.size() && best == open.size(); ++i)
        if (!(nodes_[open[i]].child & kLeaf)) best = i;
      if (best == open.size()) break;
    }
    const uint32_t child = nodes_[open[best]].child;
    open[best] = child;
    open.insert(open.begin() + long(best) + 1, child + 1);
    const uint32_t second = nodes_[child + 1].child, end = ends[best];
    if (!(second & kLeaf)) ends[best] = second;
    ends.insert(ends.begin() + long(best) + 1, end);
  }
  topCount_ = uint32_t(open.size());
  isDeep_ = false;
  for (uint32_t k = 0; k < topCount_; ++k) {
    const TreeNode& n = nodes_[open[k]];
    TopNode& t = top_[k];
    t = {};
    t.node = open[k];
    t.end = ends[k];
    t.start = kNone;
    isDeep_ = isDeep_ || !(n.child & kLeaf);
    t.isInfinite = (n.extent & kNodeInfinite) != 0;
    t.isTwoSided = (n.extent & kNodeTwoSided) != 0;
    t.isUniform = (n.extentZ & kNodeUniform) != 0;
    t.isAround = (n.extentZ & kNodeAround) != 0;
    t.half[0] = lengthOf(n.extent);
    t.half[1] = lengthOf(n.extent >> kExtentBits);
    t.half[2] = lengthOf(n.extentZ);
    t.weight = n.weight;
    for (int c = 0; c < 3; ++c) {
      t.center[c] = n.center[c];
      t.axis[c] = float(int32_t(n.axis << (24 - 8 * c)) >> 24) * (1 / 127.f);
    }
    t.concentration = std::sqrt(dot(t.center, t.center));
    t.cosNormals = float(int16_t(n.extentZ >> 16)) * (1 / 32767.f);
    t.sinNormals = std::sqrt(std::max(0.f, 1 - t.cosNormals * t.cosNormals));
    t.cosEmission = float(int32_t(n.axis) >> 24) * (1 / 127.f);
    // paths of the lights below
    struct Step {
      uint32_t node, path, depth;
    };
    std::vector<Step> stack{{t.node, 0, 0}};
    while (!stack.empty()) {
      const Step s = stack.back();
      stack.pop_back();
      const uint32_t child = nodes_[s.node].child;
      if (child & kLeaf) {
        Place& p = places_[child & ~kLeaf];
        p.path = s.path;
        t.start = std::min(t.start, p.position);
      } else {
        stack.push_back({child, s.path, s.depth + 1});
        stack.push_back({child + 1, s.path | 1u << s.depth, s.depth + 1});
      }
    }
  }
}

void LightTree::sumPowers(uint32_t finiteCount) {
  uint32_t count = 0;
  for (const Place& p : places_) count += p.leaf != kNone;
  powers_.resize(size_t(count) + 1);
  for (uint32_t i = 0; i < places_.size(); ++i)
    if (places_[i].leaf != kNone) powers_[places_[i].position].light = i;
  const auto weightAt = [&](uint32_t k) { return double(nodes_[places_[powers_[k].light].leaf].weight); };
  double total = 0;
  for (uint32_t k = 0; k < finiteCount; ++k) total += weightAt(k);
  const double units = total > 0 ? (2147483647.0 - finiteCount) * 0.999999 / total : 0;
  uint32_t sum = 0;
  for (uint32_t k = 0; k < count; ++k) {
    powers_[k].sum = sum;
    if (k < finiteCount) sum += 1 + uint32_t(weightAt(k) * units);
  }
  powers_[count] = {sum, kNone};
  guideShift_ = 31;
  while (guideShift_ > 0 && (count >> (31 - guideShift_)) > 2) --guideShift_;
  const uint32_t buckets = (sum >> guideShift_) + 2;
  guide_.reserve(buckets);
  for (uint32_t g = 0, k = 0; g < buckets; ++g) {
    while (k + 1 < count && powers_[k + 1].sum <= (uint64_t(g) << guideShift_)) ++k;
    guide_.push_back(k);
  }
}

}  // namespace kinora::light
