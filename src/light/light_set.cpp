#include "light/light_set.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "light/near_rays.h"

namespace kinora::light {

namespace {

// Multiplies radiance by the light's filters: the same numbers for a sample and for a ray that met the light.
void filterRadiance(const LightEntry& l, uint32_t width, Arena& arena, uint32_t count, const float* const P[3],
                    const float* const wi[3], const float* distance, const float* time, float* const radiance[3],
                    bool uniformOnly = false) {
  if (l.filters.empty() || !count) return;
  const uint32_t n = padded(count);
  float* factor[3];
  for (float*& f : factor) f = arena.make<float>(n);
  for (const LightFilterEntry& f : l.filters) {
    if (uniformOnly && !f.isUniform) continue;
    const LightFilterArgs a{
        count, {P[0], P[1], P[2]}, {wi[0], wi[1], wi[2]}, distance, time, {factor[0], factor[1], factor[2]}};
    f.byWidth[width]->factor(f.instance, &a);
    for (int c = 0; c < 3; ++c)
      for (uint32_t i = 0; i < count; ++i) radiance[c][i] *= factor[c][i];
  }
}

}  // namespace

LightSet::LightSet(std::vector<LightEntry> lights, std::vector<std::vector<uint32_t>> linkSets,
                   const float worldCenter[3], float worldRadius)
    : lights_(std::move(lights)), center_{worldCenter[0], worldCenter[1], worldCenter[2]}, radius_(worldRadius) {
  if (linkSets.empty()) linkSets.push_back({});
  for (auto& list : linkSets) {
    LinkSet s;
    s.lights = std::move(list);
    s.pdfOfLight.assign(lights_.size(), 0.f);
    double total = 0;
    for (uint32_t i : s.lights) total += std::max(0.f, lights_[i].description.power);
    // half by power, half evenly: a light of little power may still be the one next to the point
    double sum = 0;
    for (uint32_t i : s.lights) {
      const double even = 1.0 / double(s.lights.size());
      const double share = total > 0 ? std::max(0.f, lights_[i].description.power) / total : even;
      const double p = 0.5 * share + 0.5 * even;
      sum += p;
      s.cdf.push_back(float(sum));
      s.pdfOfLight[i] = float(p);
    }
    if (!s.cdf.empty()) s.cdf.back() = 1.f;
    sets_.push_back(std::move(s));
  }
}

uint32_t LightSet::choose(const LinkSet& s, float u, float* pdf, float* rest) const {
  const size_t k =
      std::min<size_t>(std::upper_bound(s.cdf.begin(), s.cdf.end(), u) - s.cdf.begin(), s.cdf.size() - 1);
  const float below = k ? s.cdf[k - 1] : 0.f;
  *pdf = s.pdfOfLight[s.lights[k]];
  *rest = std::min((u - below) / std::max(s.cdf[k] - below, 1e-20f), 0.99999994f);
  return s.lights[k];
}

bool LightSet::hasChoice() const { return sets_.size() > 1 || sets_[0].lights.size() > 1; }

float LightSet::choicePdf(uint32_t linkSet, uint32_t light) const { return sets_[linkSet].pdfOfLight[light]; }

void LightSet::sample(uint32_t width, Arena& arena, const Points& p, LightSamples* out) const {
  const uint32_t n = p.padded;
  float* wi[3];
  float* radiance[3];
  for (int c = 0; c < 3; ++c) {
    wi[c] = arena.make<float>(n);
    radiance[c] = arena.make<float>(n);
  }
  float* distance = arena.make<float>(n);
  float* pdf = arena.make<float>(n);
  float* diffuse = arena.make<float>(n);
  float* specular = arena.make<float>(n);
  uint32_t* flags = arena.make<uint32_t>(n);
  uint32_t* light = arena.make<uint32_t>(n);
  for (int c = 0; c < 3; ++c) {
    out->wi[c] = wi[c];
    out->radiance[c] = radiance[c];
  }
  out->distance = distance;
  out->pdf = pdf;
  out->diffuse = diffuse;
  out->specular = specular;
  out->flags = flags;
  out->light = light;

  LightSampleArgs a{};
  for (int c = 0; c < 3; ++c) a.worldCenter[c] = center_[c];
  a.worldRadius = radius_;
  if (!hasChoice() && !sets_[0].lights.empty()) {
    // the common case of few lights: no regrouping
    const uint32_t index = sets_[0].lights[0];
    const LightEntry& l = lights_[index];
    a.count = p.count;
    for (int c = 0; c < 3; ++c) {
      a.P[c] = p.P[c];
      a.wi[c] = wi[c];
      a.radiance[c] = radiance[c];
    }
    a.time = p.time;
    a.u[0] = p.u[0];
    a.u[1] = p.u[1];
    a.distance = distance;
    a.pdf = pdf;
    a.flags = flags;
    l.byWidth[width]->sample(l.instance, &a);
    filterRadiance(l, width, arena, a.count, a.P, wi, distance, a.time, radiance);
    if (!l.castsShadow) std::fill_n(distance, n, 0.f);
    std::fill_n(diffuse, n, l.description.diffuse);
    std::fill_n(specular, n, l.description.specular);
    std::fill_n(light, n, index);
    return;
  }

  // Choose a light for each point, then ask each light for all its points at once (counting sort by light).
  const Arena::Mark mark = arena.mark();
  float* choice = arena.make<float>(n);
  uint32_t* count = arena.make<uint32_t>(lights_.size() + 1);
  std::memset(count, 0, (lights_.size() + 1) * sizeof(uint32_t));
  for (uint32_t i = 0; i < p.count; ++i) {
    const LinkSet& s = sets_[p.linkSet ? p.linkSet[i] : 0];
    if (s.lights.empty()) {
      light[i] = kNoLight;
      continue;
    }
    float rest;
    light[i] = choose(s, p.uChoice[i], &choice[i], &rest);
    ++count[light[i] + 1];
  }
  for (size_t l = 0; l < lights_.size(); ++l) count[l + 1] += count[l];
  uint32_t* order = arena.make<uint32_t>(n);
  uint32_t* cursor = arena.make<uint32_t>(lights_.size() + 1);
  std::memcpy(cursor, count, (lights_.size() + 1) * sizeof(uint32_t));
  for (uint32_t i = 0; i < p.count; ++i)
    if (light[i] != kNoLight)
      order[cursor[light[i]]++] = i;
    else
      pdf[i] = 0, flags[i] = 0, distance[i] = 0, wi[0][i] = 0, wi[1][i] = 0, wi[2][i] = 1,
      diffuse[i] = specular[i] = 0, radiance[0][i] = radiance[1][i] = radiance[2][i] = 0;
  float* t[13];
  for (float*& x : t) x = arena.make<float>(n + kPad);
  uint32_t* f = arena.make<uint32_t>(n + kPad);
  for (size_t l = 0; l < lights_.size(); ++l) {
    const uint32_t first = count[l], m = count[l + 1] - first;
    if (!m) continue;
    const uint32_t np = padded(m);
    for (uint32_t i = 0; i < np; ++i) {
      const uint32_t j = order[first + std::min(i, m - 1)];
      for (int c = 0; c < 3; ++c) t[c][i] = p.P[c][j];
      t[3][i] = p.time[j];
      t[4][i] = p.u[0][j];
      t[5][i] = p.u[1][j];
    }
    a.count = m;
    for (int c = 0; c < 3; ++c) {
      a.P[c] = t[c];
      a.wi[c] = t[6 + c];
      a.radiance[c] = t[9 + c];
    }
    a.time = t[3];
    a.u[0] = t[4];
    a.u[1] = t[5];
    a.distance = t[12];
    a.flags = f;
    float* pdfs = arena.make<float>(np);
    a.pdf = pdfs;
    const LightEntry& entry = lights_[l];
    entry.byWidth[width]->sample(entry.instance, &a);
    filterRadiance(entry, width, arena, m, a.P, a.wi, a.distance, a.time, a.radiance);
    for (uint32_t i = 0; i < m; ++i) {
      const uint32_t j = order[first + i];
      for (int c = 0; c < 3; ++c) {
        wi[c][j] = t[6 + c][i];
        radiance[c][j] = t[9 + c][i];
      }
      distance[j] = entry.castsShadow ? t[12][i] : 0.f;
      // the choice's probability divides the estimate: discrete lights carry it in pdf too
      pdf[j] = pdfs[i] * choice[j];
      flags[j] = f[i];
      diffuse[j] = entry.description.diffuse;
      specular[j] = entry.description.specular;
    }
  }
  arena.release(mark);
  for (uint32_t i = p.count; i < n && p.count; ++i) {
    const uint32_t j = p.count - 1;
    for (int c = 0; c < 3; ++c) {
      wi[c][i] = wi[c][j];
      radiance[c][i] = radiance[c][j];
    }
    distance[i] = distance[j];
    pdf[i] = pdf[j];
    flags[i] = flags[j];
    light[i] = light[j];
    diffuse[i] = diffuse[j];
    specular[i] = specular[j];
  }
}

// How far each ray of the list looks for the light, by slot.
const float* LightSet::reachOf(const LightEntry& light, Arena& arena, const RayList& list) const {
  const bool inMirrors = light.visibility & 2;
  if (light.castsShadow && inMirrors) return list.tHit;
  uint32_t slots = 0;
  for (uint32_t i = 0; i < list.count; ++i) slots = std::max(slots, list.slots[i] + 1);
  float* reach = arena.make<float>(padded(slots));
  for (uint32_t i = 0; i < list.count; ++i) {
    const uint32_t s = list.slots[i];
    if (list.origin[s] & kFromDiscrete)
      reach[s] = inMirrors ? list.tHit[s] : 0.f;
    else
      reach[s] = light.castsShadow ? list.tHit[s] : INFINITY;
  }
  return reach;
}

void LightSet::hits(uint32_t width, Arena& arena, bool camera, const RayList& list, LightHits* out) const {
  *out = LightHits{};
  if (!list.count || lights_.empty()) return;
  const uint32_t n = list.count, np = padded(n) + kPad;
  // most entries possible: each ray meets each light
  uint32_t able = 0;
  for (const LightEntry& l : lights_) able += !l.description.isDelta && (!camera || (l.visibility & 1));
  if (!able) return;
  const uint64_t most = uint64_t(able) * n;
  uint32_t* slot = arena.make<uint32_t>(most);
  float* radiance[3];
  for (float*& r : radiance) r = arena.make<float>(most);
  float* pdf = arena.make<float>(most);
  float* tOut = arena.make<float>(most);
  float* diffuse = arena.make<float>(most);
  float* specular = arena.make<float>(most);
  uint32_t* light = arena.make<uint32_t>(most);
  uint32_t* blocks = arena.make<uint32_t>(most);
  uint32_t* rayOf = arena.make<uint32_t>(most);
  uint32_t m = 0;

  float* o[3];
  float* d[3];
  for (int c = 0; c < 3; ++c) {
    o[c] = arena.make<float>(np);
    d[c] = arena.make<float>(np);
  }
  float* time = arena.make<float>(np);
  float* t = arena.make<float>(np);
  uint32_t* met = arena.make<uint32_t>(np);
  uint32_t* who = arena.make<uint32_t>(np);
  float* answer[4];
  for (float*& x : answer) x = arena.make<float>(np);
  uint32_t* nearest = nullptr;
  if (camera) {
    nearest = arena.make<uint32_t>(n);
    std::fill_n(nearest, n, kNoLight);
  }

  for (uint32_t l = 0; l < lights_.size(); ++l) {
    const LightEntry& entry = lights_[l];
    if (entry.description.isDelta || (camera && !(entry.visibility & 1))) continue;
    const LightDescription& shape = entry.description;
    const NearRaysArgs near{n,
                            list.slots,
                            list.rays,
                            camera ? list.tHit : reachOf(entry, arena, list),
                            shape.isInfinite != 0,
                            {shape.center[0], shape.center[1], shape.center[2]},
                            shape.radius * shape.radius * 1.0001f,
                            {o[0], o[1], o[2]},
                            {d[0], d[1], d[2]},
                            time,
                            t,
                            who};
    const uint32_t k = nearRaysKernel(width)(near);
    if (!k) continue;
    const uint32_t kp = padded(k);
    for (uint32_t i = k; i < kp; ++i) {
      for (int c = 0; c < 3; ++c) {
        o[c][i] = o[c][k - 1];
        d[c][i] = d[c][k - 1];
      }
      time[i] = time[k - 1];
      t[i] = t[k - 1];
    }
    LightRayArgs a{};
    a.count = k;
    for (int c = 0; c < 3; ++c) {
      a.o[c] = o[c];
      a.d[c] = d[c];
      a.worldCenter[c] = center_[c];
      a.radiance[c] = answer[c];
    }
    a.worldRadius = radius_;
    a.time = time;
    a.t = t;
    a.hit = met;
    a.pdf = answer[3];
    if (entry.description.isInfinite) {
      std::fill_n(met, kp, 1u);
    } else {
      entry.byWidth[width]->intersect(entry.instance, &a);
    }
    uint32_t found = 0;
    for (uint32_t i = 0; i < k; ++i) {
      if (!met[i]) continue;
      if (found != i) {
        for (int c = 0; c < 3; ++c) {
          o[c][found] = o[c][i];
          d[c][found] = d[c][i];
        }
        time[found] = time[i];
        t[found] = t[i];
        who[found] = who[i];
      }
      ++found;
    }
    if (!found) continue;
    for (uint32_t i = found; i < padded(found); ++i) {
      for (int c = 0; c < 3; ++c) {
        o[c][i] = o[c][found - 1];
        d[c][i] = d[c][found - 1];
      }
      time[i] = time[found - 1];
      t[i] = t[found - 1];
    }
    a.count = found;
    entry.byWidth[width]->evaluate(entry.instance, &a);
    if (!entry.filters.empty()) {
      // as sample() says it: infinite lights are infinitely far
      float* far = arena.make<float>(padded(found));
      for (uint32_t i = 0; i < padded(found); ++i) far[i] = entry.description.isInfinite ? INFINITY : t[i];
      filterRadiance(entry, width, arena, found, a.o, a.d, far, a.time, a.radiance);
    }
    for (uint32_t i = 0; i < found; ++i) {
      const uint32_t ray = who[i], s = list.slots[ray];
      const float choice = sets_[list.linkSet ? list.linkSet[s] : 0].pdfOfLight[l];
      // a light that is not linked to the surface which the ray left does not light it, however it is found
      if (!camera && !(choice > 0)) continue;
      uint32_t e = m;
      if (camera && !entry.description.isInfinite) {
        // only the nearest light is seen
        if (nearest[ray] != kNoLight) {
          if (tOut[nearest[ray]] <= t[i]) continue;
          e = nearest[ray];
        }
        nearest[ray] = e;
      }
      slot[e] = s;
      rayOf[e] = ray;
      for (int c = 0; c < 3; ++c) radiance[c][e] = answer[c][i];
      tOut[e] = t[i];
      pdf[e] = answer[3][i] * choice;
      diffuse[e] = entry.description.diffuse;
      specular[e] = entry.description.specular;
      light[e] = l;
      blocks[e] = camera && !entry.description.isInfinite;
      if (e == m) ++m;
    }
  }
  if (camera) {
    // a light in front hides the surface and whatever infinite light was taken for escaped rays (none then)
    for (uint32_t i = 0; i < n; ++i)
      if (nearest[i] != kNoLight) list.tHit[list.slots[i]] = INFINITY;
    uint32_t kept = 0;
    for (uint32_t e = 0; e < m; ++e) {
      if (!blocks[e] && nearest[rayOf[e]] != kNoLight) continue;
      if (kept != e) {
        slot[kept] = slot[e];
        for (int c = 0; c < 3; ++c) radiance[c][kept] = radiance[c][e];
        pdf[kept] = pdf[e];
        tOut[kept] = tOut[e];
        diffuse[kept] = diffuse[e];
        specular[kept] = specular[e];
        light[kept] = light[e];
        blocks[kept] = blocks[e];
      }
      ++kept;
    }
    m = kept;
  }
  out->count = m;
  out->slot = slot;
  for (int c = 0; c < 3; ++c) out->radiance[c] = radiance[c];
  out->pdf = pdf;
  out->t = tOut;
  out->diffuse = diffuse;
  out->specular = specular;
  out->light = light;
  out->blocks = blocks;
}

void LightSet::emit(uint32_t width, Arena& arena, uint32_t n, const float* uChoice, const float* const u[4],
                    const float* time, float* const o[3], float* const d[3], float* const throughput[3],
                    uint32_t* light) const {
  // light paths come from all lights: link set 0 holds them all
  const LinkSet& all = sets_[0];
  if (all.lights.empty()) {
    for (int c = 0; c < 3; ++c) std::fill_n(throughput[c], padded(n), 0.f);
    std::fill_n(light, padded(n), kNoLight);
    return;
  }
  float* choice = arena.make<float>(padded(n));
  for (uint32_t i = 0; i < n; ++i) {
    float rest;
    light[i] = choose(all, uChoice[i], &choice[i], &rest);
  }
  float* t[22];
  for (float*& x : t) x = arena.make<float>(padded(n));
  uint32_t* who = arena.make<uint32_t>(padded(n));
  for (uint32_t l = 0; l < lights_.size(); ++l) {
    uint32_t k = 0;
    for (uint32_t i = 0; i < n; ++i)
      if (light[i] == l) who[k++] = i;
    if (!k) continue;
    for (uint32_t i = 0; i < padded(k); ++i) {
      const uint32_t j = who[std::min(i, k - 1)];
      for (int c = 0; c < 4; ++c) t[c][i] = u[c][j];
      t[4][i] = time[j];
    }
    LightEmitArgs a{};
    a.count = k;
    for (int c = 0; c < 4; ++c) a.u[c] = t[c];
    a.time = t[4];
    for (int c = 0; c < 3; ++c) {
      a.o[c] = t[5 + c];
      a.d[c] = t[8 + c];
      a.N[c] = t[11 + c];
      a.radiance[c] = t[14 + c];
      a.worldCenter[c] = center_[c];
    }
    a.pdfPosition = t[17];
    a.pdfDirection = t[18];
    a.worldRadius = radius_;
    const LightEntry& entry = lights_[l];
    entry.byWidth[width]->emit(entry.instance, &a);
    // a factor that depends on the lit point is not known yet
    filterRadiance(entry, width, arena, k, a.o, a.d, t[4], a.time, a.radiance, true);
    for (uint32_t i = 0; i < k; ++i) {
      const uint32_t j = who[i];
      float cosine = 0;
      for (int c = 0; c < 3; ++c) {
        o[c][j] = t[5 + c][i];
        d[c][j] = t[8 + c][i];
        cosine += t[8 + c][i] * t[11 + c][i];
      }
      const float pdf = t[17][i] * t[18][i] * choice[j];
      const float scale = pdf > 0 && cosine > 0 ? cosine / pdf : 0.f;
      for (int c = 0; c < 3; ++c) throughput[c][j] = t[14 + c][i] * scale;
    }
  }
}

}  // namespace kinora::light
