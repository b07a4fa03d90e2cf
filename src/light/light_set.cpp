#include "light/light_set.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <map>

#include "light/choose.h"
#include "light/light_set_order.h"

namespace kinora::light {

namespace {

// As PathLoop's bounces have it (spreadAfter): what is smaller than a quarter of a penumbra is lost in it.
float spreadOf(float pdfSolidAngle) { return 0.25f / std::sqrt(std::max(pdfSolidAngle * 3.14159265f, 0.25f)); }

constexpr uint32_t kMostNear = 8;  // lights that are tried one by one

bool isUsable(const LightDescription& d) {
  bool is = std::isfinite(d.power) && (d.isInfinite || (d.radius >= 0 && std::isfinite(d.radius)));
  for (int c = 0; c < 3; ++c)
    is = is && std::isfinite(d.center[c]) && std::isfinite(d.low[c]) && std::isfinite(d.high[c]) &&
         std::isfinite(d.axis[c]);
  return is;
}

// Of the directions to an infinite light; false: all.
bool boxOfDirections(const LightDescription& d, LightBox3& b) {
  double l2 = 0;
  for (const float x : d.axis) l2 += double(x) * x;
  if (!(d.cosReach > 0) || !(l2 > 1e-6)) return false;
  // the cap within the angle lies in the ball about its rim's middle; a thousandth for what is rounded
  const double cosine = std::min(1.0, double(d.cosReach)), sine = std::sqrt(1 - cosine * cosine);
  const double reach = std::max(sine, 1 - cosine) + 1e-3;
  for (int c = 0; c < 3; ++c) {
    const double middle = d.axis[c] / std::sqrt(l2) * cosine;
    b.low[c] = float(middle - reach);
    b.high[c] = float(middle + reach);
  }
  return true;
}

// Sums of the shares of those lights that have a power (others: below 0). Half by power, half evenly: a light of little
// power may still be the one next to the point.
std::vector<float> sharesOf(const std::vector<double>& power) {
  double total = 0, lit = 0;
  for (const double p : power)
    if (p >= 0) {
      total += p;
      ++lit;
    }
  double sum = 0;
  std::vector<float> shares;
  shares.reserve(power.size());
  for (const double p : power) {
    if (p >= 0) sum += total > 0 ? 0.5 * p / total + 0.5 / lit : 1 / lit;
    shares.push_back(float(std::min(sum, 1.0)));
  }
  for (size_t i = shares.size(); lit > 0 && i-- > 0;) {  // the last that has one takes what rounding left
    shares[i] = 1;
    if (power[i] >= 0) break;
  }
  return shares;
}

// The sets, and where some lights ask for samples of their own each again without those.
std::vector<std::vector<uint32_t>> withoutOwn(const std::vector<LightEntry>& lights,
                                              std::vector<std::vector<uint32_t>> sets) {
  const auto asks = [&](uint32_t light) { return lights[light].ownSamples > 0; };
  if (std::none_of(lights.begin(), lights.end(), [](const LightEntry& l) { return l.ownSamples > 0; })) return sets;
  for (size_t i = 0, n = sets.size(); i < n; ++i) {
    std::vector<uint32_t> left = sets[i];
    left.erase(std::remove_if(left.begin(), left.end(), asks), left.end());
    sets.push_back(std::move(left));
  }
  return sets;
}

}  // namespace

LightSet::LightSet(std::vector<LightKind> kinds, std::vector<LightEntry> lights,
                   const std::vector<std::vector<uint32_t>>& linkSets, const float worldCenter[3], float worldRadius,
                   std::vector<uint64_t> filterLinks)
    : kinds_(std::move(kinds)),
      filterLinks_(std::move(filterLinks)),
      center_{worldCenter[0], worldCenter[1], worldCenter[2]},
      radius_(worldRadius) {
  held_.set(lights.size() *
            (sizeof(Light) + sizeof(std::shared_ptr<void>) + 2 * sizeof(TreeNode)));  // the rest is known at the end
  std::vector<LightDescription> descriptions;
  descriptions.reserve(lights.size());
  for (const LightEntry& l : lights) {
    descriptions.push_back(l.description);
    if (l.motion) widen(descriptions.back(), *l.motion);
    // a light that stands nowhere shines nowhere
    if (!isUsable(descriptions.back())) descriptions.back().power = 0;
  }
  tree_ = LightTree(descriptions);
  links_ = LinkSets(tree_, withoutOwn(lights, linkSets.empty() ? std::vector<std::vector<uint32_t>>(1) : linkSets));
  if (links_.count() > std::max<size_t>(1, linkSets.size())) setsWithoutOwn_ = links_.count() / 2;

  std::vector<LightBox3> boxes, cones;
  std::vector<uint32_t> boxed, coned;
  std::vector<double> power;
  std::vector<bool> emits;
  lights_.reserve(lights.size());
  owners_.reserve(lights.size());
  using Words = std::array<uint32_t, sizeof(Record) / sizeof(uint32_t)>;
  std::map<Words, uint32_t> known;
  for (uint32_t i = 0; i < lights.size(); ++i) {
    LightEntry& l = lights[i];
    const LightDescription& d = descriptions[i];
    const bool isLit = tree_.places()[i].leaf != LightTree::kNone;
    // Of a light from all around some part lies behind every caustic's focus: the variance of what a walk brings is
    // infinite there, and directions that the material draws find it at once.
    const bool isWide = d.isInfinite && !d.isDelta && !(d.cosReach > 0);
    Record r{d.diffuse, d.specular, l.group, kNone, kNone, kNone, uint16_t(l.kind), 0};
    const bool isControlled = l.castsShadow && l.shadows.areAny(), isPlain = l.castsShadow && !isControlled;
    // shadows that differ from what rays see alone do not keep paths from starting there
    const bool isOrdinary = l.castsShadow && !l.shadows.areSaid();
    r.flags = uint16_t((isPlain ? kCastsShadow : 0) | (l.castsShadow ? 0 : kShadowless) |
                       (l.glassBlocks ? kGlassBlocks : 0) | (l.visibility & kLightSeenByCamera ? kSeenByCamera : 0) |
                       (l.visibility & kLightSeenByMirrors ? kSeenByMirrors : 0) |
                       (l.visibility & kLightSeenByLenses ? kSeenByLenses : 0) | (d.isDelta ? kDelta : 0) |
                       (d.isInfinite ? kInfinite : 0) | (isLit ? 0 : kBlack) |
                       (l.isWalkedTo && isOrdinary && isLit && !isWide ? kWalkedTo : 0));
    if (l.ownSamples && isLit) {
      ownSamples_.push_back({i, l.ownSamples});
      ownShares_.resize(lights.size(), 0.f);
      ownShares_[i] = float(l.ownSamples);
    }
    if (isControlled) {
      r.shadows = uint32_t(shadows_.size());
      shadows_.push_back(l.shadows);
    }
    // Light paths know what is in their way, not these shadows, and no filter that depends on the lit point.
    const bool isEmitter =
        isOrdinary && std::all_of(l.filters.begin(), l.filters.end(), [](const LightFilterEntry& f) {
          return f.isUniform && f.link == f.kNoLink && f.diffuse == 1 && f.specular == 1;
        });
    for (const LightFilterEntry& f : l.filters) splitsFilters_ = splitsFilters_ || f.diffuse != f.specular;
    if (!l.filters.empty()) {
      r.filters = uint32_t(filters_.size());
      filters_.push_back(std::move(l.filters));
    }
    if (l.motion) {
      r.motion = uint32_t(motions_.size());
      motions_.push_back(*l.motion);
      // what comes from infinitely far turns about the world, as the disk that its rays start on
      for (int c = 0; c < 3 && d.isInfinite; ++c) {
        motions_.back().pivot[c] = center_[c];
        for (LightMotion::Pose& p : motions_.back().poses) p.shift[c] = 0;
      }
    }
    hasDistances_ = hasDistances_ || (r.flags & kShadowless);
    if (isLit && !d.isDelta) {
      isCameraSeen_ = isCameraSeen_ || (r.flags & kSeenByCamera);
      isShadowless_ = isShadowless_ || !(r.flags & kCastsShadow);
      if (LightBox3 b; d.isInfinite && boxOfDirections(d, b)) {
        cones.push_back(b);
        coned.push_back(i);
      } else if (d.isInfinite) {
        distant_.push_back(i);
      } else {
        LightBox3 b;
        const bool isBoxed = d.low[0] < d.high[0] || d.low[1] < d.high[1] || d.low[2] < d.high[2];
        for (int c = 0; c < 3; ++c) {
          b.low[c] = isBoxed ? d.low[c] : d.center[c] - d.radius * 1.0001f;
          b.high[c] = isBoxed ? d.high[c] : d.center[c] + d.radius * 1.0001f;
        }
        boxes.push_back(b);
        boxed.push_back(i);
      }
    }
    power.push_back(isLit ? std::min(double(descriptions[i].power), 1e24) *
                                (d.isInfinite ? 3.14159265358979 * double(radius_) * double(radius_) : 1)
                          : -1);
    emits.push_back(isEmitter);
    const auto [it, isNew] = known.try_emplace(std::bit_cast<Words>(r), uint32_t(records_.size()));
    if (isNew) records_.push_back(r);
    lights_.push_back({l.instance, it->second});
    owners_.push_back(std::move(l.owner));
  }
  if (boxed.size() <= kMostNear) {
    for (const uint32_t i : boxed) {
      const LightDescription& d = descriptions[i];
      near_.push_back({i, {d.center[0], d.center[1], d.center[2]}, d.radius * d.radius * 1.0001f});
    }
  } else {
    boxes_ = LightBoxes(boxes, boxed);
  }
  if (coned.size() <= kMostNear)
    distant_.insert(distant_.end(), coned.begin(), coned.end());
  else
    directions_ = LightBoxes(cones, coned);
  std::vector<double> emitted = power;
  for (size_t i = 0; i < power.size(); ++i)
    if (!emits[i]) emitted[i] = -1;
  emission_ = sharesOf(emitted);
  for (size_t i = 0; i < power.size(); ++i)
    if (!(recordOf(i).flags & kWalkedTo)) power[i] = -1;
  if (std::any_of(power.begin(), power.end(), [](double p) { return p >= 0; })) walkedTo_ = sharesOf(power);
  held_.set(bytes());
}

size_t LightSet::bytes() const {
  size_t n = lights_.size() * sizeof(Light) + records_.size() * sizeof(Record) +
             owners_.size() * sizeof(std::shared_ptr<void>) + tree_.nodeCount() * sizeof(TreeNode) +
             tree_.places().size() * sizeof(LightTree::Place) + tree_.powerBytes() + links_.bytes() + boxes_.bytes() +
             directions_.bytes() + near_.size() * sizeof(Sphere) +
             (distant_.size() + emission_.size() + walkedTo_.size()) * 4;
  for (const auto& f : filters_) n += sizeof f + f.size() * sizeof(LightFilterEntry);
  for (const LightMotion& m : motions_) n += sizeof m + m.poses.size() * sizeof(LightMotion::Pose);
  return n + shadows_.size() * sizeof(ShadowControls);
}

uint8_t LightSet::exceptionsOf(uint32_t light) const {
  const uint16_t flags = recordOf(light).flags;
  return uint8_t((flags & kGlassBlocks ? uint32_t(kLightBlockedByGlass) : 0u) |
                 (flags & kSeenByMirrors ? 0u : uint32_t(kLightUnseenByMirrors | kLightUnseenByLenses)) |
                 (flags & kSeenByLenses ? 0u : uint32_t(kLightUnseenByLenses)));
}

bool LightSet::hasChoice() const { return tree_.topCount() > 1 || tree_.isDeep() || !links_.areAllWhole(); }

bool LightSet::isLinked(uint32_t linkSet, uint32_t light) const {
  const uint32_t leaf = tree_.places()[light].leaf;
  return leaf != LightTree::kNone && links_.has(linkSet, leaf);
}

void LightSet::probabilities(uint32_t width, const Points& p, const uint32_t* light, float* out) const {
  if (!p.count) return;
  if (!hasChoice()) {
    for (uint32_t i = 0; i < p.count; ++i) out[i] = tree_.places()[light[i]].leaf != LightTree::kNone ? 1.f : 0.f;
    return;
  }
  ChooseArgs a{};
  a.tree = &tree_;
  a.links = &links_;
  a.n = p.count;
  for (int c = 0; c < 3; ++c) {
    a.P[c] = p.P[c];
    a.N[c] = p.N[c];
  }
  a.linkSet = p.linkSet;
  a.weights = p.row ? p.weights : nullptr;
  a.row = p.row;
  a.light = const_cast<uint32_t*>(light);
  a.probability = out;
  probabilityKernel(width)(a);
}

void LightSet::toRest(Arena& arena, uint32_t n, const uint32_t* light, const float* time, LightVector kind,
                      const float* const x[3], const float* rest[3]) const {
  for (int c = 0; c < 3; ++c) rest[c] = x[c];
  if (motions_.empty()) return;
  uint32_t first = 0;
  while (first < n && !motionOf(light[first])) ++first;
  if (first == n) return;
  float* moved[3];
  for (int c = 0; c < 3; ++c) {
    rest[c] = moved[c] = arena.make<float>(padded(n) + kPad);
    std::copy_n(x[c], n, moved[c]);
  }
  for (uint32_t i = first; i < n; ++i) {
    const LightMotion* m = motionOf(light[i]);
    if (!m) continue;
    float v[3] = {x[0][i], x[1][i], x[2][i]};
    carryToRest(*m, time ? time[i] : 0.5f, kind, v);
    for (int c = 0; c < 3; ++c) moved[c][i] = v[c];
  }
  for (float* v : moved) padFloats(v, n);
}

void LightSet::fromRest(uint32_t n, const uint32_t* light, const float* time, LightVector kind,
                        float* const x[3]) const {
  if (motions_.empty()) return;
  for (uint32_t i = 0; i < n; ++i) {
    const LightMotion* m = motionOf(light[i]);
    if (!m) continue;
    float v[3] = {x[0][i], x[1][i], x[2][i]};
    carryFromRest(*m, time ? time[i] : 0.5f, kind, v);
    for (int c = 0; c < 3; ++c) x[c][i] = v[c];
  }
}

// Multiplies radiance by the lights' filters: the same numbers for a sample and for a ray that met the light.
void LightSet::filterRadiance(uint32_t width, Arena& arena, uint32_t count, const uint32_t* light,
                              const float* const P[3], const float* const wi[3], const float* distance,
                              const float* time, const uint32_t* linkSet, float* const radiance[3], FilterUse::By by,
                              bool forSpecular) const {
  if (filters_.empty()) return;
  uint32_t* list = arena.make<uint32_t>(padded(count) + kPad);
  uint32_t n = 0;
  for (uint32_t i = 0; i < count; ++i)
    if (light[i] != kNoLight && recordOf(light[i]).filters != kNone) list[n++] = i;
  if (!n) return;
  const auto linksOf = [&](uint32_t e) {
    return filterLinks_.empty() || by == FilterUse::Camera ? ~0ull : filterLinks_[linkSet ? linkSet[e] : 0];
  };
  std::sort(list, list + n, [&](uint32_t a, uint32_t b) {
    if (light[a] != light[b]) return light[a] < light[b];
    const uint64_t of[2] = {linksOf(a), linksOf(b)};
    return of[0] != of[1] ? of[0] < of[1] : a < b;
  });
  const LightFilters of(arena, n);
  float* const* x = of.in;
  for (uint32_t from = 0, to; from < n; from = to) {
    const uint32_t l = light[list[from]];
    const FilterUse use{by, forSpecular, linksOf(list[from])};
    for (to = from; to < n && light[list[to]] == l && linksOf(list[to]) == use.links;) ++to;
    const uint32_t m = to - from;
    for (uint32_t i = 0; i < padded(m); ++i) {
      const uint32_t e = list[from + std::min(i, m - 1)];
      for (int c = 0; c < 3; ++c) {
        x[c][i] = P[c][e];
        x[3 + c][i] = wi[c][e];
      }
      x[6][i] = distance[e];
      x[7][i] = time ? time[e] : 0.f;
    }
    of.apply(width, filters_[recordOf(l).filters], m, list + from, radiance, use);
  }
}

void LightSet::askSamples(uint32_t width, Arena& arena, uint32_t n, const uint32_t* light, const float* const P[3],
                          const float* time, const float* const u[2], float* const outputs[8],
                          uint32_t* flags) const {
  const Order order(*this, width, arena, n, light);
  const float* rest[3];
  toRest(arena, n, light, time, LightVector::Point, P, rest);
  const float* const in[6] = {order.take(rest[0]), order.take(rest[1]), order.take(rest[2]),
                              order.take(time),    order.take(u[0]),    order.take(u[1])};
  float* ordered[8];
  for (int k = 0; k < 8; ++k) ordered[k] = order.room(outputs[k]);
  uint32_t* orderedFlags = order.room(flags);
  for (uint32_t r = 0; r < order.runCount(); ++r) {
    const LightOrder::Run& run = order.run(r);
    LightSampleArgs a{};
    order.setLights(a, run);
    setWorld(a);
    a.count = run.count;
    const uint32_t at = run.from;
    for (int c = 0; c < 3; ++c) {
      a.P[c] = in[c] + at;
      a.wi[c] = ordered[c] + at;
      a.radiance[c] = ordered[4 + c] + at;
    }
    a.time = in[3] + at;
    a.u[0] = in[4] + at;
    a.u[1] = in[5] + at;
    a.distance = ordered[3] + at;
    a.pdf = ordered[7] + at;
    a.flags = orderedFlags + at;
    kinds_[run.kind].byWidth[width]->sample(&a);
  }
  for (int k = 0; k < 8; ++k) order.put(ordered[k], outputs[k]);
  order.put(orderedFlags, flags);
  fromRest(n, light, time, LightVector::Direction, outputs);
}

// The sets that lights are chosen from where some are sampled by themselves.
const uint32_t* LightSet::setsBesideOwn(Arena& arena, uint32_t n, const uint32_t* linkSet) const {
  if (!setsWithoutOwn_) return linkSet;
  uint32_t* sets = arena.make<uint32_t>(n);
  for (uint32_t i = 0; i < n; ++i) sets[i] = (linkSet ? linkSet[i] : 0) + setsWithoutOwn_;
  return sets;
}

void LightSet::sample(uint32_t width, Arena& arena, const Points& p, LightSamples* out) const {
  const uint32_t n = p.padded;
  float* wi[3];
  float *radiance[3], *specularRadiance[3];
  for (int c = 0; c < 3; ++c) {
    out->wi[c] = wi[c] = arena.make<float>(n);
    out->radiance[c] = radiance[c] = arena.make<float>(n);
    out->specularRadiance[c] = specularRadiance[c] = splitsFilters_ ? arena.make<float>(n) : nullptr;
  }
  float* distance = arena.make<float>(n);
  float* t = hasDistances_ ? arena.make<float>(n) : distance;
  float* pdf = arena.make<float>(n);
  float* diffuse = arena.make<float>(n);
  float* specular = arena.make<float>(n);
  uint32_t* flags = arena.make<uint32_t>(n);
  uint32_t* light = arena.make<uint32_t>(n);
  out->distance = distance;
  out->t = t;
  out->pdf = pdf;
  out->diffuse = diffuse;
  out->specular = specular;
  out->flags = flags;
  out->light = light;
  float* spread = p.wantsSpread ? arena.make<float>(n) : nullptr;
  out->spread = spread;
  const float* weights = p.row && hasChoice() ? p.weights : nullptr;
  uint32_t* cluster = weights ? arena.make<uint32_t>(n) : nullptr;
  float* chance = weights ? arena.make<float>(n) : nullptr;
  out->cluster = cluster;
  out->chance = chance;
  if (!p.count) return;

  const Arena::Mark mark = arena.mark();
  float* choice = nullptr;
  if (p.light != kNoLight) {
    std::fill_n(light, n, p.light);
    choice = arena.make<float>(n);
    std::fill_n(choice, n, 0.f);
    for (uint32_t i = 0; i < p.count; ++i)
      if (!isLinked(p.linkSet ? p.linkSet[i] : 0, p.light)) light[i] = kNoLight;
    out->cluster = nullptr;
    out->chance = nullptr;
  } else if (tree_.topCount() && hasChoice()) {
    choice = arena.make<float>(n);
    ChooseScratch scratch{};
    if (tree_.isDeep()) {
      scratch.room = n + kPad;
      scratch.words = arena.make<float>(size_t(ChooseScratch::kLists) * ChooseScratch::kWords * scratch.room);
      scratch.parts = arena.make<uint32_t>(10 * n + kPad);
    }
    chooseKernel(width)({&tree_,
                         &links_,
                         n,
                         {p.P[0], p.P[1], p.P[2]},
                         {p.N[0], p.N[1], p.N[2]},
                         p.besideOwn ? setsBesideOwn(arena, n, p.linkSet) : p.linkSet,
                         weights,
                         p.row,
                         {p.uChoice[0], p.uChoice[1]},
                         light,
                         choice,
                         cluster,
                         chance,
                         scratch,
                         lights_.data(),
                         sizeof(Light)});
  } else {
    std::fill_n(light, n, tree_.topCount() ? tree_.nodes()[tree_.top()[0].node].child & ~kLeaf : kNoLight);
  }
  if (tree_.isDeep()) {
    // of many lights each is met seldom: what they are made of is on its way before it is read
    for (uint32_t i = 0; i < p.count; ++i)
      if (light[i] != kNoLight)
        for (uint32_t line = 0; line < 3; ++line)
          __builtin_prefetch(static_cast<const char*>(lights_[light[i]].instance) + 64 * line);
  }
  float* const outputs[8] = {wi[0], wi[1], wi[2], distance, radiance[0], radiance[1], radiance[2], pdf};
  askSamples(width, arena, p.count, light, p.P, p.time, p.u, outputs, flags);
  for (uint32_t i = 0; i < p.count; ++i) {
    if (light[i] != kNoLight) continue;
    for (float* x : outputs) x[i] = 0;
    wi[2][i] = 1;
    flags[i] = 0;
  }
  for (int c = 0; splitsFilters_ && c < 3; ++c) std::copy_n(radiance[c], p.count, specularRadiance[c]);
  filterRadiance(width, arena, p.count, light, p.P, wi, distance, p.time, p.linkSet, radiance);
  if (splitsFilters_)
    filterRadiance(width, arena, p.count, light, p.P, wi, distance, p.time, p.linkSet, specularRadiance,
                   FilterUse::LitPoints, true);
  if (t != distance) std::copy_n(distance, p.count, t);
  for (uint32_t i = 0; i < p.count; ++i) {
    const bool some = light[i] != kNoLight;
    diffuse[i] = some ? recordOf(light[i]).diffuse : 0.f;
    specular[i] = some ? recordOf(light[i]).specular : 0.f;
    if (some && recordOf(light[i]).flags & kShadowless) distance[i] = 0;
    if (spread) spread[i] = flags[i] & kSampleDelta ? 0.f : spreadOf(pdf[i]);
    // the choice's probability divides the estimate: discrete lights carry it in pdf too
    if (const float own = some ? ownShare(light[i], p.besideOwn) : 0.f; choice || own > 0)
      pdf[i] *= (choice ? choice[i] : 1.f) + own;
  }
  arena.release(mark);
  for (float* x : outputs) padFloats(x, p.count);
  for (int c = 0; splitsFilters_ && c < 3; ++c) padFloats(specularRadiance[c], p.count);
  if (t != distance) padFloats(t, p.count);
  padFloats(diffuse, p.count);
  padFloats(specular, p.count);
  if (spread) padFloats(spread, p.count);
  for (uint32_t i = p.count; i < n; ++i) {
    flags[i] = flags[p.count - 1];
    light[i] = light[p.count - 1];
  }
}

}  // namespace kinora::light
