// Path guiding in kernels: what guiding_state.h holds, looked up and sampled for W points, the choice of directions by
// it, and the lessons that paths leave. Called by path_loop.h where directions are made; an integrator of one's own does
// the same. Included per target.
//
// A direction is chosen by resampling (Talbot et al., "Importance Resampling for Global Illumination", 2005) of two
// candidates, one of the bxdf and one of what was learned: in proportion to bxdf times radiance, so that their product is
// followed. A candidate x of density p has the weight m f(x) g(x) / p, where g is the learned radiance and the shares m
// of both techniques sum to one at each x (balance heuristic; directions of discrete lobes and those below the surface
// are the bxdf's alone). The sum of the weights over f g of the one chosen stands for one over its density, whatever g is, as
// long as it is above 0: a wrong g makes noise, no bias.
#include <kinora/guiding_state.h>
#include <kinora/integrator.h>
#include <kinora/math/sampling.h>
#include <kinora/random.h>

#if defined(KINORA_GUIDING_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_GUIDING_H_TARGET
#undef KINORA_GUIDING_H_TARGET
#else
#define KINORA_GUIDING_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {

// Distributions over directions, by region.
template <int W>
class Guides {
  using F = Float<W>;
  using I = Int<W>;

 public:
  explicit Guides(const guiding::State* state)
      : s_(state),
        tree_(state->at(state->tree)),
        splits_(state->at(state->splits)),
        density_(state->floats(state->density)),
        sums_(state->floats(state->sums)),
        frames_(state->floats(state->frames)) {}

  // Entries of the octree at places: the region in the bits of kRegion, kIsOn where it guides.
  KN_INLINE I find(Vec3<W> P) const {
    const F scale(s_->scale), most(float((1u << guiding::kDepth) - 1));
    I g[3];
    const F at[3] = {P.x, P.y, P.z};
    for (int c = 0; c < 3; ++c) g[c] = toInt(min(max((at[c] - F(s_->low[c])) * scale, F(0.f)), most));
    I e = gather(tree_, I(0));
    for (uint32_t k = guiding::kDepth; k-- > 0;) {
      const Mask<W> inner = e >= I(0);  // no leaf: its highest bit is clear
      if (inner.none()) break;
      const I bit(1u << k);
      const auto isSet = [&](I x) { return (x & bit) != I(0); };
      I child = select(isSet(g[0]), I(1), I(0));
      child = child + select(isSet(g[1]), I(2), I(0));
      child = child + select(isSet(g[2]), I(4), I(0));
      e = select(inner, gather(tree_, select(inner, e + child, I(0))), e);
    }
    return e;
  }
  static KN_INLINE Mask<W> isOn(I entry) { return (entry & I(guiding::kIsOn)) != I(0); }
  // Where lessons tell what arrives, whether directions follow it or not.
  static KN_INLINE Mask<W> isKnown(I entry) { return (entry & I(guiding::kIsKnown)) != I(0); }
  static KN_INLINE I regionOf(I entry) { return entry & I(guiding::kRegion); }
  // Asks for what density() in these cells and sample() read first.
  KN_INLINE void fetch(I region, I cell) const {
    alignas(64) uint32_t regions[W], cells[W];
    region.store(regions);
    cell.store(cells);
    for (int k = 0; k < W; ++k) {
      __builtin_prefetch(density_ + regions[k] * guiding::kCells + cells[k]);
      __builtin_prefetch(splits_ + regions[k] * guiding::kSplitWords);
    }
  }
  // Radiance that arrives at known regions over density() of its direction, at least about the mean; what a path whose
  // first vertex is there brings to its pixel.
  KN_INLINE F radiance(I region) const { return sum(region, guiding::State::kRadiance); }
  KN_INLINE F reference(I region) const { return sum(region, guiding::State::kReference); }

  // Places in the frames of their regions, as guiding::placeIn().
  KN_INLINE Vec3<W> placeIn(I region, Vec3<W> P) const {
    const I at = region.template shl<2>();
    const F r = gather(frames_ + 3, at);
    const Vec3<W> e((P.x - gather(frames_, at)) * r, (P.y - gather(frames_ + 1, at)) * r,
                    (P.z - gather(frames_ + 2, at)) * r);
    const Mask<W> inside = dot(e, e) < F(guiding::kFarthestInside);
    return {zeroUnless(inside, e.x), zeroUnless(inside, e.y), zeroUnless(inside, e.z)};
  }
  // Where on the unit sphere rays leave it that start inside, at e; solid angle at the centre over that at e.
  static KN_INLINE Vec3<W> throughSphere(Vec3<W> e, Vec3<W> w, F& ratio) {
    const F b = dot(e, w), cosine = sqrt(fma(b, b, F(1.f) - dot(e, e))), t = cosine - b;
    ratio = t * t / cosine;
    return e + w * t;
  }
  // The cell of the place on the unit sphere; of a direction for a place at the centre.
  static KN_INLINE I cellOf(Vec3<W> d) {
    return placeOnMap<guiding::kSide>(d, [](I x, I y) HWY_ATTR { return spread(x).template shl<1>() | spread(y); });
  }
  // A direction as lessons have it.
  static KN_INLINE I packed(Vec3<W> d) {
    return placeOnMap<1 << guiding::kDirectionBits>(
        d, [](I x, I y) HWY_ATTR { return x.template shl<int(guiding::kDirectionBits)>() | y; });
  }
  // Per solid angle at e, of sample() making w.
  KN_INLINE F density(I region, Vec3<W> e, Vec3<W> w) const {
    F ratio;
    const Vec3<W> d = throughSphere(e, w, ratio);
    const F l = abs(d.x) + abs(d.y) + abs(d.z);
    return gather(density_, region * I(guiding::kCells) + cellOf(d)) * ratio / (l * l * l);
  }
  // A direction at e, a place in the frame of the region.
  KN_INLINE Vec3<W> sample(I region, Vec3<W> e, F u, F v, F& pdf) const {
    F p;
    const Vec3<W> d = sampleSphere(region, u, v, p), w = d - e;
    const F l2 = dot(w, w), l = sqrt(l2);
    pdf = p * l2 * l / dot(d, w);
    return w * (F(1.f) / l);
  }

 private:
  template <uint32_t kSide, class Join>
  static KN_INLINE I placeOnMap(Vec3<W> d, Join&& join) {
    const F l = F(1.f) / (abs(d.x) + abs(d.y) + abs(d.z));
    F a = d.x * l, b = d.y * l;
    const Mask<W> below = d.z < F(0.f);
    const F p = F(1.f) - abs(b), q = F(1.f) - abs(a);
    const F a2 = copySign(p, a), b2 = copySign(q, b);
    a = select(below, a2, a);
    b = select(below, b2, b);
    const F half(kSide * 0.5f), most(float(kSide - 1));
    return join(toInt(clamp(fma(a, half, half), F(0.f), most)), toInt(clamp(fma(b, half, half), F(0.f), most)));
  }
  KN_INLINE Vec3<W> sampleSphere(I region, F u, F v, F& pdf) const {
    I line = region * I(int32_t(2 * guiding::kSplitWords)), node(1), x(0), y(0);
    F chance(guiding::kCells / 4.f);
    for (uint32_t k = 0; k < guiding::kLevels; ++k) {
      x = x + x + half(line, node, u, chance);
      toLine(k * 2 + 1, line, node);
      y = y + y + half(line, node, v, chance);
      toLine(k * 2 + 2, line, node);
    }
    const F size(2.f / guiding::kSide), inside(0.99999994f);
    F a = fma(toFloat(x) + min(u, inside), size, F(-1.f)), b = fma(toFloat(y) + min(v, inside), size, F(-1.f));
    const F r = F(1.f) - abs(a) - abs(b);
    const Mask<W> below = r < F(0.f);
    const F p = F(1.f) - abs(b), q = F(1.f) - abs(a);
    const F a2 = copySign(p, a), b2 = copySign(q, b);
    const Vec3<W> onOctahedron(select(below, a2, a), select(below, b2, b), r);
    const F l2 = dot(onOctahedron, onOctahedron), l = sqrt(l2);
    pdf = chance * l * l2;
    return onOctahedron * (F(1.f) / l);
  }
  // One step down from a node of a line: which half u falls to, and where in it.
  KN_INLINE I half(I line, I& node, F& u, F& chance) const {
    const I at = line + node, two = gather(splits_, at.template shr<1>());
    const I number = select((at & I(1)) != I(0), two.template shr<16>(), two & I(0xffff));
    const F p = fma(toFloat(number), F(guiding::kSplitUnit), F(0.5f * guiding::kSplitUnit));
    const Mask<W> second = u >= p;
    const F share = select(second, F(1.f) - p, p);
    u = select(second, u - p, u) / share;
    chance = chance * share;
    const I bit = select(second, I(1), I(0));
    node = node + node + bit;
    return bit;
  }
  // After so many steps nodes stand in the next line.
  static KN_INLINE void toLine(uint32_t steps, I& line, I& node) {
    if (steps != guiding::kLevels) return;
    line = line + (node - I(int32_t(guiding::kLine - 1))) * I(int32_t(guiding::kLine));
    node = I(1);
  }
  KN_INLINE F sum(I region, uint32_t which) const {
    return gather(sums_, region * I(guiding::State::kSums) + I(which));
  }
  // Zeros between the bits.
  static KN_INLINE I spread(I x) {
    x = (x | x.template shl<4>()) & I(0x10f);
    x = (x | x.template shl<2>()) & I(0x133);
    return (x | x.template shl<1>()) & I(0x155);
  }

  const guiding::State* s_;
  const uint32_t *tree_, *splits_;
  const float *density_, *sums_, *frames_;
};

// Of the directions that a context's points go on in: one over the density with which they were chosen (a number
// that has this expectation), and where they were guided.
template <int W>
struct ChosenDirections {
  float* inverse = nullptr;    // null: one over the pdf
  uint32_t* guided = nullptr;  // 1: resampled
  float* radiance = nullptr;  // behind the first vertex: expected from there; below 0: not known. Null: nowhere known
  float* reference = nullptr;  // at the first vertex: see Guides. Null: nowhere known
  // Whether what is expected may end a path that its throughput would not. Not in the first samples, before it is known
  // where guiding pays: there it only keeps paths.
  bool endsPaths = false;
  KN_INLINE Float<W> at(uint32_t i, Float<W> pdf) const {
    return inverse ? Float<W>::load(inverse + i) : Float<W>(1.f) / max(pdf, Float<W>(1e-38f));
  }
  KN_INLINE Mask<W> isGuided(uint32_t i) const {
    return guided ? Int<W>::load(guided + i) != Int<W>(0) : Mask<W>(false);
  }
};

// How much of what was learned counts; the rest is even over all directions, so that none is left out.
inline constexpr float kGuideShare = 0.5f;

// Resamples the directions in `made` (generate()'s, of points of the context). Where it chooses the other candidate it
// writes direction, weight, slot and flags; pdf stays that of the bxdf making the direction, which is what weights
// beside light samples reckon with, and weight / pdf stands for bxdf over density.
template <int W>
ChosenDirections<W> guideDirections(Group* group, const Services* services, const guiding::State& state,
                                    const Context& c, const GenerateArgs& made, uint32_t depth, uint32_t part,
                                    uint32_t parts) {
  using F = Float<W>;
  using I = Int<W>;
  const Guides<W> guides(&state);
  const auto floats = [&] { return static_cast<float*>(services->alloc(group, c.padded * sizeof(float))); };
  const auto words = [&] { return static_cast<uint32_t*>(services->alloc(group, c.padded * sizeof(uint32_t))); };
  uint32_t* entry = words();
  const auto isThere = [&](uint32_t i) HWY_ATTR {
    return (F::load(made.pdf + i) > F(0.f)) & (I::load(made.slot + i) != I(kNoLobe));
  };
  const auto isBelow = [&](uint32_t i)
                           HWY_ATTR { return (I::load(made.flags + i) & I(uint32_t(kSampleBelow))) != I(0); };
  // of the bxdf, N where it has none above the surface
  const auto direction = [&](uint32_t i) HWY_ATTR {
    return select(isThere(i) & !isBelow(i), Vec3<W>::load(made.wi, i), Vec3<W>::load(c.N, i));
  };
  Mask<W> any(false), known(false);
  for (uint32_t i = 0; i < c.padded; i += W) {
    const I e = guides.find(Vec3<W>::load(c.P, i));
    e.store(entry + i);
    const Mask<W> here = Guides<W>::isKnown(e);
    if (depth || state.isTried) any = any | Guides<W>::isOn(e);
    known = known | here;
    if (here.none()) continue;
    const I region = select(here, Guides<W>::regionOf(e), I(0));
    F ratio;
    guides.fetch(region, Guides<W>::cellOf(Guides<W>::throughSphere(guides.placeIn(region, Vec3<W>::load(c.P, i)),
                                                                    direction(i), ratio)));
  }
  if (known.none()) return {};
  // roulette begins behind the first vertex
  ChosenDirections<W> out;
  out.endsPaths = state.isTried;
  (depth ? out.radiance : out.reference) = floats();
  float* learned = floats();  // density() of the bxdf's direction
  for (uint32_t i = 0; i < c.padded; i += W) {
    const I e = I::load(entry + i);
    const Mask<W> here = Guides<W>::isKnown(e);
    const I region = select(here, Guides<W>::regionOf(e), I(0));
    const F q = guides.density(region, guides.placeIn(region, Vec3<W>::load(c.P, i)), direction(i));
    q.store(learned + i);
    if (out.reference) {
      select(here, guides.reference(region), F(state.seen)).store(out.reference + i);
      continue;
    }
    const Mask<W> tells =
        here & isThere(i) & !isBelow(i) & ((I::load(made.flags + i) & I(uint32_t(kSampleDiscrete))) == I(0));
    select(tells, guides.radiance(region) * q, F(-1.f)).store(out.radiance + i);
  }
  if (any.none()) return out;
  float *wi[3], *pdf = floats(), *own = floats();
  for (float*& x : wi) x = floats();
  for (uint32_t i = 0; i < c.padded; i += W) {
    const I e = I::load(entry + i);
    F u, v, p;
    draw2(services->samples, I::load(c.sampleSeed + i), I::load(c.sampleIndex + i) * I(parts) + I(part),
          subSampled(dimensionAt(depth) + kDimGuide, part, parts), u, v);
    const Mask<W> on = Guides<W>::isOn(e);
    const I region = select(on, Guides<W>::regionOf(e), I(0));
    const Vec3<W> d = guides.sample(region, guides.placeIn(region, Vec3<W>::load(c.P, i)), u, v, p);
    select(on, d, Vec3<W>::load(c.N, i)).store(wi, i);
    zeroUnless(on, p).store(own + i);
  }
  EvaluateArgs e{};
  for (int k = 0; k < 3; ++k) e.wi[k] = wi[k];
  for (uint32_t l = 0; l < c.slotCount; ++l)
    for (float*& x : e.weight[l]) x = floats();
  e.pdf = pdf;
  c.bxdf->evaluate(&c, c.closure, &e);
  out.inverse = floats();
  out.guided = words();
  const F all(1.f / 3.f), uniform(1.f - kGuideShare), scale(kGuideShare * 12.5663706f);
  const auto level = [&](Vec3<W> x) { return (abs(x.x) + abs(x.y) + abs(x.z)) * all; };
  for (uint32_t i = 0; i < c.padded; i += W) {
    const I place = I::load(entry + i), region = Guides<W>::regionOf(place);
    const Mask<W> on = Guides<W>::isOn(place);
    const F p1 = F::load(made.pdf + i);
    (F(1.f) / max(p1, F(1e-38f))).store(out.inverse + i);
    select(on, I(1), I(0)).store(out.guided + i);
    if (on.none()) continue;
    // that of the bxdf
    const Vec3<W> d1 = Vec3<W>::load(made.wi, i), f1 = Vec3<W>::load(made.weight, i);
    const I flags = I::load(made.flags + i);
    const Mask<W> is = isThere(i), below = isBelow(i);
    const Mask<W> alone = below | ((flags & I(uint32_t(kSampleDiscrete))) != I(0));
    const F q1 = F::load(learned + i);
    const F g1 = select(below, F(1.f), fma(q1, scale, uniform));
    const F t1 = level(f1) * g1;
    const F w1 = zeroUnless(on & is, select(alone, t1 / max(p1, F(1e-38f)), t1 / max(p1 + q1, F(1e-38f))));
    // the learned one
    const F p2 = F::load(pdf + i), q2 = F::load(own + i);
    const Vec3<W> d2 = Vec3<W>::load(wi, i);
    Vec3<W> sum(0.f);
    for (uint32_t l = 0; l < c.slotCount; ++l) sum += Vec3<W>::load(e.weight[l], i);
    F f2(0.f);
    for (uint32_t l = 0; l < c.slotCount; ++l) f2 = f2 + level(Vec3<W>::load(e.weight[l], i));
    const F g2 = fma(q2, scale, uniform);
    const F w2 = zeroUnless(on & (p2 > F(0.f)) & (f2 > F(0.f)), f2 * g2 / max(p2 + q2, F(1e-38f)));
    const F total = w1 + w2;
    F choice, lobe;
    draw2(services->samples, I::load(c.sampleSeed + i), I::load(c.sampleIndex + i) * I(parts) + I(part),
          subSampled(dimensionAt(depth) + kDimGuideChoice, part, parts), choice, lobe);
    const Mask<W> second = on & (choice * total >= w1) & (w2 > F(0.f));
    const F inverse = total / max(select(second, f2 * g2, t1), F(1e-38f));
    const F p = select(second, p2, p1);
    // a slot in proportion to what it scatters
    Vec3<W> f(0.f);
    I slot(0);
    F passed(0.f);
    const F goal = lobe * f2;
    Mask<W> open(true);
    for (uint32_t l = 0; l < c.slotCount; ++l) {
      const Vec3<W> x = Vec3<W>::load(e.weight[l], i);
      const F own2 = level(x);
      passed = passed + own2;
      const Mask<W> take = open & (own2 > F(0.f));
      f = select(take, x * (f2 / max(own2, F(1e-38f))), f);
      slot = select(take, I(l), slot);
      open = open & !(take & (goal < passed));
    }
    const F by = select(on & (total > F(0.f)), inverse * p, F(1.f));
    (select(second, f, f1) * by).store(made.weight, i);
    select(second, d2, d1).store(made.wi, i);
    if (out.radiance)
      select(second, guides.radiance(select(on, region, I(0))) * q2, F::load(out.radiance + i))
          .store(out.radiance + i);
    select(second, p, p1).store(made.pdf + i);
    select(second, slot, I::load(made.slot + i)).store(made.slot + i);
    const I through = select(dot(Vec3<W>::load(c.Ng, i), d2) < F(0.f), I(uint32_t(kSampleTransmit)), I(0));
    select(second, through, flags).store(made.flags + i);
    select(on & (total > F(0.f)), inverse, F::load(out.inverse + i)).store(out.inverse + i);
  }
  return out;
}

// The lessons of a group's paths. Lives in the group's memory, from the first direction of a path to its end.
template <int W>
class Lessons {
  using F = Float<W>;
  using I = Int<W>;

 public:
  static constexpr uint32_t kVertices = 8;  // of a path, the first ones

  Lessons(Group* group, const Services* services) : g_(group), sv_(services) {
    capacity_ = g_->padded * kVertices;
    const auto floats = [&](uint32_t n) { return static_cast<float*>(sv_->alloc(g_, (n + kPad) * sizeof(float))); };
    for (float*& x : P_) x = floats(capacity_);
    for (float** x : {&inverse_, &throughput_, &before_, &ratio_, &survival_, &near_}) *x = floats(capacity_);
    slot_ = reinterpret_cast<uint32_t*>(floats(capacity_));
    cell_ = reinterpret_cast<uint32_t*>(floats(capacity_));
    found_ = floats(g_->padded);
    last_ = reinterpret_cast<uint32_t*>(floats(g_->padded));
    taught_ = reinterpret_cast<uint32_t*>(floats(g_->padded));
    std::memset(found_, 0, g_->padded * sizeof(float));
    std::memset(taught_, 0, g_->padded * sizeof(uint32_t));
    std::memset(last_, 0, g_->padded * sizeof(uint32_t));
  }

  // Light that the paths have found.
  void collect(const Contributions& c) {
    if (c.kind == LightKind::Unshadowed) return;
    for (uint32_t i = 0; i < c.count; ++i)
      found_[c.slot[i]] += (c.value[0][i] + c.value[1][i] + c.value[2][i]) * (1.f / 3.f);
  }

  // Directions that W points of a context go on in, from i on: the throughput of their paths from there, and the chance
  // with which these survived that is in it; the density of the bxdf, and one over that of the choice. share: of what
  // the paths find what counts for each direction, one of several of a vertex. isFirst: the last of those of a
  // path's first vertex.
  KN_INLINE void add(Mask<W> on, const Context& c, uint32_t i, const Slots<W>& s, Vec3<W> d, Vec3<W> throughput,
                     F survival, F pdf, F inverse, Mask<W> guided, float share, bool isFirst) {
    on = on & (s.get(g_->teaches) != I(0)) & (s.get(taught_) < I(kVertices));
    if (on.none() || count_ >= capacity_) return;
    const Packer<W> pack(on);
    Vec3<W>::load(c.P, i).pack(pack, P_, count_);
    pack.put(inverse / survival, inverse_ + count_);
    pack.put((throughput.x + throughput.y + throughput.z) * F(share / 3.f), throughput_ + count_);
    pack.put(s.get(found_), before_ + count_);
    pack.put(F(1.f) / max(inverse * pdf, F(1e-30f)), ratio_ + count_);
    pack.put(survival, survival_ + count_);
    pack.put(s.s, slot_ + count_);
    F(0.f).store(near_ + count_);
    for (uint32_t k = 0; k < uint32_t(pack.count); ++k) {
      last_[slot_[count_ + k]] = count_ + k + 1;
      ++taught_[slot_[count_ + k]];
    }
    const I first(isFirst ? uint32_t(kIsFirst) : 0u);
    pack.put(Guides<W>::packed(d) | select(guided, I(guiding::kWasGuided), I(0)) | first, cell_ + count_);
    count_ += uint32_t(pack.count);
  }

  // Rays in the directions added last have met what they meet.
  void arrive(uint32_t n, const uint32_t* live) {
    for (uint32_t i = 0; i < n; ++i) {
      uint32_t& last = last_[live[i]];
      const float t = g_->paths.hits.t[live[i]];
      if (last && t > 0 && t < 3e38f) near_[last - 1] = 1 / t;
      last = 0;
    }
  }

  // The paths have ended.
  void end() {
    if (!count_) return;
    const MemoryMark mark = sv_->markMemory(g_);
    auto* lessons = static_cast<guiding::Lesson*>(sv_->alloc(g_, (count_ + kPad) * sizeof(guiding::Lesson)));
    uint32_t n = 0;
    for (uint32_t i = 0; i < count_; ++i) {
      const float light = found_[slot_[i]] - before_[i], radiance = light / throughput_[i];
      const float weight = std::min(inverse_[i], guiding::kLargestWeight), arriving = radiance * radiance * weight;
      const float guided = std::fabs(light), plain = guided * std::min(ratio_[i], 8.f);
      if (!(arriving < 1e30f) || !(guided < 1e30f) || !(plain < 1e30f)) continue;  // no number either
      // as if roulette had not been played there
      const float seen = cell_[i] & kIsFirst ? std::max(before_[i] + light * survival_[i], 0.f) : -1.f;
      if (!(seen < 1e30f)) continue;
      lessons[n] = {{P_[0][i], P_[1][i], P_[2][i]},
                    cell_[i] & ~kIsFirst,
                    arriving,
                    guided,
                    plain,
                    1 / survival_[i],
                    near_[i],
                    seen};
      slot_[n++] = slot_[i];
    }
    sv_->teach(g_, n, slot_, lessons);
    sv_->releaseMemory(g_, mark);
    count_ = 0;
  }

 private:
  Group* g_;
  const Services* sv_;
  uint32_t capacity_ = 0, count_ = 0;
  static constexpr uint32_t kIsFirst = 0x40000000u;  // beside a direction and kWasGuided
  float *P_[3], *inverse_, *throughput_, *before_, *ratio_, *survival_, *found_, *near_;
  uint32_t *slot_, *cell_;
  uint32_t *last_, *taught_;  // by path: 1 + the lesson whose ray is on its way; lessons so far
};

// From now on the group's points choose lights by what was learned of them, through weighLights(); null where that is
// nothing yet. Once a group, before its first vertex.
inline const guiding::State* chooseLearnedLights(Group* group, const Services* services) {
  if (services->lightCount <= 1) return nullptr;
  static constexpr float kOnes[kLightClusters] = {1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1};
  const auto* state = static_cast<const guiding::State*>(services->learned(group));
  group->lightWeights = state ? state->floats(state->lightWeights) : kOnes;
  return state;
}

// Regions of a context's points, by which they choose lights.
template <int W>
void weighLights(Group* group, const Services* services, const guiding::State* state, const Context& c) {
  auto* rows = static_cast<uint32_t*>(services->alloc(group, c.padded * sizeof(uint32_t)));
  if (!state) {
    std::memset(rows, 0, c.padded * sizeof(uint32_t));
  } else {
    const Guides<W> guides(state);
    for (uint32_t i = 0; i < c.padded; i += W)
      Guides<W>::regionOf(guides.find(Vec3<W>::load(c.P, i))).store(rows + i);
  }
  services->weighLights(group, &c, rows);
}

// The lessons of light samples: one for each point of contexts, with what its shadow ray lets through.
template <int W>
class LightLessons {
 public:
  LightLessons(Group* group, const Services* services, uint32_t points) : g_(group), sv_(services) {
    const auto words = [&](uint32_t n) { return static_cast<uint32_t*>(sv_->alloc(g_, n * sizeof(uint32_t))); };
    slot_ = words(points);
    ofRay_ = words(points + kPad);
    brought_ = reinterpret_cast<float*>(words(points));
    factor_ = reinterpret_cast<float*>(words(points + kPad));
    lessons_ = static_cast<guiding::Lesson*>(sv_->alloc(g_, points * sizeof(guiding::Lesson)));
  }
  // The points of a context, before its rays: throughput of their paths; how many samples they take.
  void add(const Context& c, const LightSamples& samples, const float* const throughput[3], uint32_t parts) {
    first_ = count_;
    for (uint32_t i = 0; i < c.count; ++i, ++count_) {
      const uint32_t s = c.path[i];
      slot_[count_] = s;
      brought_[count_] = 0;
      factor_[count_] = 1;
      const float t = (throughput[0][s] + throughput[1][s] + throughput[2][s]) * (1.f / 3.f);
      const bool isTaught =
          g_->teaches[s] && samples.light[i] != kNoLight && samples.cluster && samples.chance[i] > 0;
      lessons_[count_] = {{c.P[0][i], c.P[1][i], c.P[2][i]},
                          isTaught ? guiding::kOfLight | samples.cluster[i] : 0u,
                          t > 0 ? float(parts) / t : 0.f,
                          0,
                          0,
                          isTaught ? samples.chance[i] : 1.f,
                          0,
                          -1};
    }
  }
  // By point of the context that was added last: what its ray brings, to be added up as the mean of the channels.
  float* brought() { return brought_ + first_; }
  // What their rays bring counts so many times, where it has been weighed against techniques that choose no lights.
  void scale(Mask<W> on, uint32_t i, Float<W> factor) {
    float* at = factor_ + first_ + i;
    select(on, factor, Float<W>::load(at)).store(at);
  }
  // Rays of some of W of its points, from i on.
  void addRays(const Packer<W>& pack, uint32_t i, uint32_t ray) {
    pack.put(Int<W>::lanes(int32_t(first_ + i)), ofRay_ + ray);
  }
  // What they have brought, by entry: its ray, value before and transmittance (by ray).
  void end(uint32_t entries, const uint32_t* ray, const float* const value[3], const float* const T[3]) {
    for (uint32_t e = 0; e < entries; ++e) {
      float v = 0;
      for (int c = 0; c < 3; ++c) v += value[c][e] * T[c][ray[e]];
      brought_[ofRay_[ray[e]]] += v * (1.f / 3.f);
    }
    end();
  }
  // The same where others have added that up.
  void end() {
    uint32_t n = 0;
    for (uint32_t i = 0; i < count_; ++i) {
      guiding::Lesson l = lessons_[i];
      if (!(l.cell & guiding::kOfLight)) continue;
      const float v = brought_[i] * factor_[i] * l.light;
      l.light = v * v * l.visits;
      l.visits = 1 / l.visits;
      if (!(l.light < 1e30f) || !(l.visits < 1e30f)) continue;  // no number either
      slot_[n] = slot_[i];
      lessons_[n++] = l;
    }
    if (n) sv_->teach(g_, n, slot_, lessons_);
  }

 private:
  Group* g_;
  const Services* sv_;
  uint32_t *slot_, *ofRay_, first_ = 0, count_ = 0;
  float *brought_, *factor_;
  guiding::Lesson* lessons_;
};

}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
