#include "trace/solids.h"

#include <algorithm>
#include <cmath>

#include "trace/embree_device.h"
#include "trace/user_calls.h"

namespace kinora::trace {

// A set of leaves.
struct Solids::LeafSet {
  static constexpr uint32_t kMostWords = kMostSolidNodes / 64;  // a leaf is a node
  uint64_t words[kMostWords];
  explicit LeafSet(uint32_t count) { std::fill_n(words, count, uint64_t(0)); }
  void toggle(uint32_t leaf) { words[leaf / 64] ^= uint64_t(1) << (leaf % 64); }
};

// What one line crosses, by leaf: which an odd number of times.
struct Solids::Crossings {
  // Crossings up to `nearest` stand apart.
  Crossings(const Solid& of, float nearest, LeafSet* near, LeafSet* far, float tolerant)
      : solid(of), upTo(nearest), nearer(near), beyond(far), tolerance(tolerant) {}
  const Solid& solid;
  const float upTo;
  LeafSet *nearer, *beyond;
  const float tolerance;              // two triangles that share an edge are both met there: one crossing
  const uint32_t* counted = nullptr;  // a leaf whose crossings are counted as well
  uint32_t count = 0;

  struct Crossing {
    uint32_t leaf;
    bool isFront;
    float t;
  };
  static constexpr uint32_t kRecent = 16;
  Crossing recent[kRecent];
  uint32_t seen = 0;

  void add(const Crossing& c) {
    for (uint32_t i = 0; i < std::min(seen, kRecent); ++i)
      if (recent[i].leaf == c.leaf && recent[i].isFront == c.isFront && std::fabs(recent[i].t - c.t) <= tolerance)
        return;
    recent[seen++ % kRecent] = c;
    count += counted && *counted == c.leaf;
    (c.t <= upTo ? nearer : beyond)->toggle(c.leaf);
  }
};

Solids::Solids(const std::vector<SolidInput>& inputs) {
  for (const SolidInput& in : inputs) {
    Solid& s = solids_.emplace_back();
    s.nodes = in.nodes;
    s.words = (in.leaves + 63) / 64;
    s.scene = rtcNewScene(device());
    // a line that slips through between two triangles would be outside where it is inside
    rtcSetSceneFlags(s.scene, RTC_SCENE_FLAG_ROBUST);
  }
}

Solids::~Solids() {
  for (const Solid& s : solids_) rtcReleaseScene(s.scene);
}

void Solids::add(uint32_t top, const Member& member, RTCGeometry instance) {
  Solid& s = solids_[member.solid];
  rtcSetGeometryMask(instance, ~0u);  // what no ray sees cuts all the same
  rtcCommitGeometry(instance);
  rtcAttachGeometryByID(s.scene, instance, uint32_t(s.leafOf.size()));
  rtcReleaseGeometry(instance);
  s.leafOf.push_back(member.leaf);
  if (ofTop_.size() <= top) ofTop_.resize(top + 1);
  ofTop_[top] = member;
}

void Solids::commit() {
  for (const Solid& s : solids_) rtcCommitScene(s.scene);
}

void Solids::dissolve(uint32_t solid) {
  for (Member& m : ofTop_)
    if (m.solid == solid) m = Member();
}

void Solids::setFilters(RTCGeometry geometry) {
  rtcSetGeometryIntersectFilterFunction(geometry, &filter);
  rtcSetGeometryOccludedFilterFunction(geometry, &filter);
}

// Embree asks here about candidates, nearest or not: those that are refused leave their rays as they were.
void Solids::filter(const RTCFilterFunctionNArguments* a) {
  const QueryContext& query = *reinterpret_cast<const QueryContext*>(a->context);
  for (unsigned i = 0; i < a->N; ++i) {
    if (a->valid[i] != -1) continue;
    const uint32_t instance = RTCHitN_instID(a->hit, a->N, i, 0);
    const float t = RTCRayN_tfar(a->ray, a->N, i);
    if (query.crossings) {
      // both in the surface's own space, which is all that a sign needs
      const float side = RTCHitN_Ng_x(a->hit, a->N, i) * RTCRayN_dir_x(a->ray, a->N, i) +
                         RTCHitN_Ng_y(a->hit, a->N, i) * RTCRayN_dir_y(a->ray, a->N, i) +
                         RTCHitN_Ng_z(a->hit, a->N, i) * RTCRayN_dir_z(a->ray, a->N, i);
      auto& crossings = *static_cast<Crossings*>(query.crossings);
      crossings.add({crossings.solid.leafOf[instance], side < 0, t});
      a->valid[i] = 0;
      continue;
    }
    if (!query.solids) continue;
    const Member member = query.solids->memberOf(instance);
    if (member.solid == kNoSolid) continue;
    // the ray of render space: Embree's own is in the surface's
    const uint32_t ray = RTCRayN_id(a->ray, a->N, i);
    const float o[3] = {query.o[0][ray], query.o[1][ray], query.o[2][ray]};
    const float d[3] = {query.d[0][ray], query.d[1][ray], query.d[2][ray]};
    if (!query.solids->keeps(member, o, d, t, RTCRayN_time(a->ray, a->N, i))) a->valid[i] = 0;
  }
}

void Solids::cross(const Solid& solid, const float o[3], const float d[3], float time, Crossings& crossings) {
  QueryContext context(false, nullptr, nullptr, nullptr);
  context.crossings = &crossings;
  alignas(16) RTCRay r;
  r.org_x = o[0];
  r.org_y = o[1];
  r.org_z = o[2];
  r.dir_x = d[0];
  r.dir_y = d[1];
  r.dir_z = d[2];
  r.tnear = 0;
  r.tfar = INFINITY;
  r.time = time;
  r.mask = ~0u;
  r.flags = 0;
  r.id = 0;
  rtcOccluded1(solid.scene, &context.embree, &r);
}

bool Solids::isOdd(const Member& member, const float o[3], const float d[3], float time, bool* hits) const {
  const Solid& s = solids_[member.solid];
  LeafSet odd(s.words);
  const float tolerance = 1e-5f * std::max({std::fabs(o[0]), std::fabs(o[1]), std::fabs(o[2])});
  Crossings c(s, -1.f, nullptr, &odd, tolerance);
  c.counted = &member.leaf;
  cross(s, o, d, time, c);
  *hits = c.count > 0;
  return odd.words[member.leaf / 64] >> (member.leaf % 64) & 1;
}

bool Solids::contains(const Solid& solid, const uint64_t* leaves) {
  using Joins = SolidNode::Joins;
  uint8_t isIn[kMostSolidNodes];
  const size_t n = solid.nodes.size();
  for (size_t i = 0; i < n; ++i) {
    const SolidNode& node = solid.nodes[i];
    isIn[i] = node.isFull || (node.leaf != kNoSolid && (leaves[node.leaf / 64] >> (node.leaf % 64) & 1));
  }
  for (size_t i = n; i-- > 1;) {
    const SolidNode& node = solid.nodes[i];
    uint8_t& whole = isIn[node.parent];
    if (node.joins == Joins::Or)
      whole |= isIn[i];
    else
      whole &= isIn[i] ^ uint8_t(node.joins == Joins::AndNot);
  }
  return isIn[0];
}

// A leaf contains a point when a line from there crosses it an odd number of times. The ray's own line is asked both
// ways, just in front of the point; surfaces that lie in one plane with it (within the tolerance) are crossed with it,
// so that what two of them have in common is seen once or not at all. Where both ways disagree, the line has passed
// through a seam or run along a face: a third one, in another direction, decides.
bool Solids::keeps(const Member& member, const float o[3], const float d[3], float t, float time) const {
  const Solid& s = solids_[member.solid];
  float p[3], largest = t;
  for (int c = 0; c < 3; ++c) {
    p[c] = o[c] + d[c] * t;
    largest = std::max(largest, std::fabs(p[c]));
  }
  const float step = largest * 4e-6f + 1e-7f;
  float start[3], back[3];
  for (int c = 0; c < 3; ++c) {
    start[c] = p[c] - d[c] * step;
    back[c] = -d[c];
  }
  LeafSet here(s.words), behind(s.words), before(s.words);
  Crossings ahead(s, 2 * step, &here, &behind, step);
  cross(s, start, d, time, ahead);
  Crossings backward(s, -1.f, nullptr, &before, step);
  cross(s, start, back, time, backward);
  const uint64_t own = uint64_t(1) << (member.leaf % 64);
  uint64_t doubt = 0;
  for (uint32_t w = 0; w < s.words; ++w) {
    if (w == member.leaf / 64)
      here.words[w] |= own, behind.words[w] = (behind.words[w] & ~own) | (~before.words[w] & own);
    doubt |= before.words[w] ^ behind.words[w] ^ here.words[w];
  }
  if (doubt) {
    // not along any axis where d is, and never of no length
    const float other[3] = {d[1] + 0.31f, d[2] - 0.57f, d[0] + 0.43f};
    LeafSet third(s.words);
    Crossings aside(s, -1.f, nullptr, &third, step);
    cross(s, start, other, time, aside);
    for (uint32_t w = 0; w < s.words; ++w) {
      const uint64_t unsure = before.words[w] ^ behind.words[w] ^ here.words[w];
      before.words[w] = (before.words[w] & ~unsure) | (third.words[w] & unsure);
    }
  }
  // on the boundary, if crossing what is here leads in or out
  for (uint32_t w = 0; w < s.words; ++w) behind.words[w] = before.words[w] ^ here.words[w];
  return contains(s, before.words) != contains(s, behind.words);
}

}  // namespace kinora::trace
