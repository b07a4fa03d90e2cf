// Kernels of choose.h.
#define KINORA_KERNEL_FILE "light/choose.cpp"
#include "light/choose.h"
#include "simd/dispatch.h"
#include <kinora/simd/foreach_target.h>
#include <kinora/simd/wide.h>

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {
namespace {
using light::ChooseArgs;
using light::TopNode;
using light::TreeNode;

// A surface lit from behind its normal's plane: bumps lean over it, and leaves let light through.
constexpr float kLeastFacing = 0.03f, kLeastFacingThrough = 0.3f;

template <int W>
struct Receiver {
  Vec3<W> P, N;  // N: unit, or zero where light from all sides counts alike
  Float<W> least;
  Mask<W> hasN;
  KN_INLINE Receiver(const ChooseArgs& a, uint32_t i) {
    using F = Float<W>;
    P = Vec3<W>::load(a.P, i);
    N = Vec3<W>(F(0.f), F(0.f), F(0.f));
    least = F(1.f);
    hasN = Mask<W>(false);
    if (!a.N[0]) return;
    N = Vec3<W>::load(a.N, i);
    const F l2 = dot(N, N);
    hasN = l2 > F(0.f);
    const Mask<W> through = l2 < F(0.5f);
    N = select(through, N + N, N);
    least = select(hasN, select(through, F(kLeastFacingThrough), F(kLeastFacing)), F(1.f));
  }
};

template <int W>
struct WideNode {
  Vec3<W> center, half, axis;
  Float<W> weight, cosNormals, sinNormals, cosEmission;
  Mask<W> isTwoSided;
  KN_INLINE WideNode() {}
};

template <int W>
KN_INLINE Vec3<W> absolute(Vec3<W> a) {
  return {abs(a.x), abs(a.y), abs(a.z)};
}

// Infinite lights: light from one direction by its cosine, light from all around by a quarter.
template <int W>
KN_INLINE Float<W> farImportance(const Receiver<W>& r, Vec3<W> mean, Float<W> concentration, Float<W> weight) {
  using F = Float<W>;
  const F facing = max(dot(r.N, mean), r.least * concentration);
  const F f = fma(F(1.f) - concentration, F(0.25f), facing);
  return weight * select(r.hasN, f, F(1.f));
}

// About the irradiance that the lights below a node bring: intensity, falloff and cosine over the squared distance. 0
// only where none of them reaches the point; of falloff and cosine the mean of what the box's centre has and of the
// most that any place in the box could have: the greatest height of the box over the plane, and the least distance.
template <int W>
KN_INLINE Float<W> nearImportance(const Receiver<W>& r, const WideNode<W>& n) {
  using F = Float<W>;
  const F zero(0.f), one(1.f), half(0.5f), tiny(1e-30f);
  const Vec3<W> v = n.center - r.P, distance = absolute(v);
  const Vec3<W> beyond = distance - n.half, farthest = distance + n.half;
  const Vec3<W> nearest(max(beyond.x, zero), max(beyond.y, zero), max(beyond.z, zero));
  const F d2 = dot(v, v), inverse = one / sqrt(max(d2, tiny));
  const F least2 = dot(nearest, nearest), inverseLeast = one / sqrt(max(least2, tiny));
  const Mask<W> inside = least2 <= tiny;
  // to the axis of emission, and past the cone of normals
  const F towards = -dot(n.axis, v);
  const F height = select(n.isTwoSided, abs(towards), towards), rise = dot(absolute(n.axis), n.half);
  const F inverseMost = one / sqrt(max(dot(farthest, farthest), tiny));
  const F top = height + rise;
  const F most = min(fma(top, select(top > zero, inverseLeast, inverseMost), F(light::kAxisSlack)), one);
  const F mean = clamp(height * inverse, F(-1.f), one);
  const auto past = [&](F cosine) HWY_ATTR {
    const F sine = sqrt(max(fnma(cosine, cosine, one), zero));
    return select(cosine >= n.cosNormals, one, fma(cosine, n.cosNormals, sine * n.sinNormals));
  };
  const F mostEmitted = select(inside, one, past(max(most, F(-1.f))));
  const F emitted = zeroUnless(mostEmitted >= n.cosEmission,
                               max(half * (max(mostEmitted, zero) + max(past(mean), zero)), F(1e-3f)));
  // to the receiver's normal
  const F heightN = dot(r.N, v), topN = heightN + dot(absolute(r.N), n.half);
  const F mostN = select(inside, one, min(max(topN, zero) * inverseLeast, one));
  const F facing = select(r.hasN, max(half * (mostN + max(heightN * inverse, zero)), r.least), one);
  return n.weight * emitted * facing / max(max(d2, dot(n.half, n.half)), F(1e-20f));
}

template <int W>
KN_INLINE Float<W> usable(Float<W> x) {
  return zeroUnless((x > Float<W>(0.f)) & isFinite(x), x);
}

template <int W>
KN_INLINE Float<W> topImportance(const Receiver<W>& r, const TopNode& t) {
  using F = Float<W>;
  const Vec3<W> center(F(t.center[0]), F(t.center[1]), F(t.center[2]));
  if (t.isInfinite) return usable(farImportance<W>(r, center, F(t.concentration), F(t.weight)));
  WideNode<W> n;
  n.center = center;
  n.axis = Vec3<W>(F(t.axis[0]), F(t.axis[1]), F(t.axis[2]));
  n.half = Vec3<W>(F(t.half[0]), F(t.half[1]), F(t.half[2]));
  n.weight = F(t.weight);
  n.cosNormals = F(t.cosNormals);
  n.sinNormals = F(t.sinNormals);
  n.cosEmission = F(t.cosEmission);
  n.isTwoSided = Mask<W>(t.isTwoSided != 0);
  return usable(nearImportance<W>(r, n));
}

// `child` gets the node's own.
template <int W>
KN_INLINE Float<W> nodeImportance(const Receiver<W>& r, const TreeNode* nodes, Int<W> node, Int<W>& child) {
  using F = Float<W>;
  using I = Int<W>;
  const float* base = nodes->center;
  const I at = node.template shl<3>();
  const auto number = [&](int32_t k) HWY_ATTR { return gather(base, at + I(k)); };
  const I extent = asInt(number(4)), extentZ = asInt(number(5)), axis = asInt(number(6));
  child = asInt(number(7));
  WideNode<W> n;
  n.center = {number(0), number(1), number(2)};
  n.weight = number(3);
  constexpr int kDropped = 31 - int(light::kExtentBits), kBits = int(light::kExtentBits);
  const I mask(light::kExtentMask);
  n.half = {asFloat((extent & mask).template shl<kDropped>()),
            asFloat((extent.template shr<kBits>() & mask).template shl<kDropped>()),
            asFloat((extentZ & mask).template shl<kDropped>())};
  const F eighth(1 / 127.f), sixteenth(1 / 32767.f);
  n.axis = {toFloat(axis.template shl<24>().template sar<24>()) * eighth,
            toFloat(axis.template shl<16>().template sar<24>()) * eighth,
            toFloat(axis.template shl<8>().template sar<24>()) * eighth};
  n.cosNormals = toFloat(extentZ.template sar<16>()) * sixteenth;
  n.sinNormals = sqrt(max(fnma(n.cosNormals, n.cosNormals, F(1.f)), F(0.f)));
  n.cosEmission = toFloat(axis.template sar<24>()) * eighth;
  n.isTwoSided = extent < I(0);
  F importance = nearImportance<W>(r, n);
  const Mask<W> far = (extent & I(uint32_t(light::kNodeInfinite))) != I(0);
  if (far.any())
    importance = select(far, farImportance<W>(r, n.center, sqrt(dot(n.center, n.center)), n.weight), importance);
  return usable(importance);
}

// Which lanes' sets hold something of the node.
template <int W>
struct Links {
  const light::LinkSets& sets;
  bool all;
  Int<W> first;  // run of the lane's set
  KN_INLINE Links(const ChooseArgs& a, uint32_t i) : sets(*a.links), all(a.links->areAllWhole()), first(0) {
    if (!all && a.linkSet) first = Int<W>::load(a.linkSet + i) * Int<W>(sets.runsOfSet());
  }
  KN_INLINE Float<W> keep(Int<W> node, Float<W> importance) const {
    using I = Int<W>;
    if (all) return importance;
    alignas(64) static constexpr uint32_t kBit[32] = {
        1u << 0,  1u << 1,  1u << 2,  1u << 3,  1u << 4,  1u << 5,  1u << 6,  1u << 7,  1u << 8,  1u << 9,  1u << 10,
        1u << 11, 1u << 12, 1u << 13, 1u << 14, 1u << 15, 1u << 16, 1u << 17, 1u << 18, 1u << 19, 1u << 20, 1u << 21,
        1u << 22, 1u << 23, 1u << 24, 1u << 25, 1u << 26, 1u << 27, 1u << 28, 1u << 29, 1u << 30, 1u << 31};
    const I run = gather(sets.runs(), first + node.template shr<int(light::LinkSets::kRunBits)>());
    const I word = gather(sets.words(), run + (node & I((1u << light::LinkSets::kRunBits) - 1)).template shr<5>());
    return zeroUnless((word & gather(kBit, node & I(31))) != I(0), importance);
  }
};

// Probabilities of the top nodes.
template <int W>
struct Top {
  Float<W> p[light::kMostTop];
  KN_INLINE Top(const ChooseArgs& a, const Receiver<W>& r, const Links<W>& links) {
    using F = Float<W>;
    const light::LightTree& tree = *a.tree;
    const uint32_t count = tree.topCount();
    F total(0.f);
    for (uint32_t k = 0; k < count; ++k) {
      const TopNode& t = tree.top()[k];
      p[k] = links.keep(Int<W>(t.node), topImportance<W>(r, t));
      total += p[k];
    }
    F scale = F(1.f) / max(total, F(1e-37f));
    total = F(0.f);
    for (uint32_t k = 0; k < count; ++k) {
      const F share = p[k] * scale;
      p[k] = fma(sqrt(share), F(light::kRootShare), share);
      total += p[k];
    }
    scale = F(1.f) / max(total, F(1e-37f));
    for (uint32_t k = 0; k < count; ++k) p[k] = p[k] * scale;
  }
};

// Neither child that reaches the point is left without a chance by rounding.
template <int W>
KN_INLINE Float<W> shareOfFirst(Float<W> w0, Float<W> w1, Float<W> total) {
  using F = Float<W>;
  const F p = w0 / max(total, F(1e-37f)), least(1e-6f);
  return clamp(p, zeroUnless(w0 > F(0.f), least), F(1.f) - zeroUnless(w1 > F(0.f), least));
}

template <int W>
KN_INLINE Mask<W> isLeaf(Int<W> child) {
  return child < Int<W>(0);
}

template <int W>
void choose(const ChooseArgs& a) {
  using F = Float<W>;
  using I = Int<W>;
  const light::LightTree& tree = *a.tree;
  const TreeNode* nodes = tree.nodes().data();
  for (uint32_t i = 0; i < a.n; i += W) {
    const Receiver<W> r(a, i);
    const Links<W> links(a, i);
    const Top<W> top(a, r, links);
    F u = F::load(a.u[0] + i);
    F below(0.f), from(0.f), p(0.f);
    I node(0), child(-1);
    // the last that begins at or below u
    for (uint32_t k = 0; k < tree.topCount(); ++k) {
      const Mask<W> is = (top.p[k] > F(0.f)) & (below <= u);
      const uint32_t at = tree.top()[k].node;
      node = select(is, I(at), node);
      child = select(is, I(nodes[at].child), child);
      from = select(is, below, from);
      p = select(is, top.p[k], p);
      below += top.p[k];
    }
    if (tree.isDeep()) {
      const F most(0.99999994f), one(1.f), zero(0.f);
      u = min(max((u - from) / max(p, F(1e-37f)), zero), most);  // for the last steps
      F x = F::load(a.u[1] + i), spent(1.f);
      Mask<W> open = (p > zero) & !isLeaf<W>(child);
      while (open.any()) {
        const I first = select(open, child, I(0));
        I childOfFirst, childOfSecond;
        const F w0 = links.keep(first, nodeImportance<W>(r, nodes, first, childOfFirst));
        const F w1 = links.keep(first + I(1), nodeImportance<W>(r, nodes, first + I(1), childOfSecond));
        const F total = w0 + w1, p0 = shareOfFirst(w0, w1, total);
        const Mask<W> takesFirst = x < p0;
        const F share = select(takesFirst, p0, one - p0);
        x = select(takesFirst, x / max(p0, F(1e-37f)), (x - p0) / max(one - p0, F(1e-37f)));
        x = min(max(x, zero), most);
        p = select(open, zeroUnless(total > zero, p * share), p);
        child = select(open, select(takesFirst, childOfFirst, childOfSecond), child);
        // a number's digits are used up: the other one's remain
        spent = select(open, spent * share, spent);
        const Mask<W> change = spent < F(1.f / 4096);
        x = select(change, u, x);
        spent = select(change, F(1e30f), spent);
        open = open & !isLeaf<W>(child) & (p > zero);
      }
    }
    const Mask<W> some = p > F(0.f);
    select(some, child & I(uint32_t(~light::kLeaf)), I(uint32_t(light::kNone))).store(a.light + i);
    p.store(a.probability + i);
  }
}

template <int W>
void probability(const ChooseArgs& a) {
  using F = Float<W>;
  using I = Int<W>;
  const light::LightTree& tree = *a.tree;
  const TreeNode* nodes = tree.nodes().data();
  const uint32_t* places = &tree.places().data()->leaf;
  for (uint32_t i = 0; i < a.n; i += W) {
    const Receiver<W> r(a, i);
    const Links<W> links(a, i);
    const Top<W> top(a, r, links);
    const I place = I::load(a.light + i) * I(3);
    const I leaf = gather(places, place);
    I path = gather(places, place + I(1));
    const I which = gather(places, place + I(2));
    const Mask<W> lit = leaf != I(uint32_t(light::kNone));
    F p(0.f);
    I child(-1);
    for (uint32_t k = 0; k < tree.topCount(); ++k) {
      const Mask<W> is = lit & (which == I(k));
      p = select(is, top.p[k], p);
      child = select(is, I(nodes[tree.top()[k].node].child), child);
    }
    if (tree.isDeep()) {
      const F one(1.f), zero(0.f);
      Mask<W> open = (p > zero) & !isLeaf<W>(child);
      while (open.any()) {
        const I first = select(open, child, I(0));
        I childOfFirst, childOfSecond;
        const F w0 = links.keep(first, nodeImportance<W>(r, nodes, first, childOfFirst));
        const F w1 = links.keep(first + I(1), nodeImportance<W>(r, nodes, first + I(1), childOfSecond));
        const F total = w0 + w1, p0 = shareOfFirst(w0, w1, total);
        const Mask<W> takesFirst = (path & I(1)) == I(0);
        p = select(open, zeroUnless(total > zero, p * select(takesFirst, p0, one - p0)), p);
        child = select(open, select(takesFirst, childOfFirst, childOfSecond), child);
        path = path.template shr<1>();
        open = open & !isLeaf<W>(child) & (p > zero);
      }
    }
    p.store(a.probability + i);
  }
}

#if HWY_TARGET == HWY_AVX2
#define KN_CHOOSE(W)                                                     \
  [[maybe_unused]] void choose##W(const ChooseArgs& a) { choose<W>(a); } \
  [[maybe_unused]] void probability##W(const ChooseArgs& a) { probability<W>(a); }
KN_CHOOSE(1)
KN_CHOOSE(4)
KN_CHOOSE(8)
#else
[[maybe_unused]] void choose16(const ChooseArgs& a) { choose<16>(a); }
[[maybe_unused]] void probability16(const ChooseArgs& a) { probability<16>(a); }
#endif
}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kinora::light {
ChooseKernel chooseKernel(uint32_t width) {
  return kernelFor(width, &N_AVX2::choose1, &N_AVX2::choose4, &N_AVX2::choose8, &N_AVX3::choose16);
}
ChooseKernel probabilityKernel(uint32_t width) {
  return kernelFor(width, &N_AVX2::probability1, &N_AVX2::probability4, &N_AVX2::probability8,
                   &N_AVX3::probability16);
}
}  // namespace kinora::light
#endif
