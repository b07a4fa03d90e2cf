#include "scalar_surface.h"

#include <cmath>
#include <cstring>

// The instruction set of the wide kernels of width 1.
#pragma GCC push_options
#pragma GCC target("avx2,fma,bmi,bmi2,f16c")

namespace kinora::bench {

namespace {

#define KB_INLINE inline __attribute__((always_inline))

constexpr float kPi = 3.14159265358979324f, kInvPi = 0.318309886183790672f, kInvTwoPi = 0.159154943091895336f,
                kMirrorAlpha = 1e-3f;
constexpr float kMeanCos0 = 0.355051026f, kMeanCos1 = 0.844948974f, kMeanWeight0 = 0.363917103f,
                kMeanWeight1 = 0.636082897f;
constexpr int kTableMu = 32, kTableRough = 32;

KB_INLINE float fma(float a, float b, float c) { return __builtin_fmaf(a, b, c); }
KB_INLINE float min(float a, float b) { return a < b ? a : b; }
KB_INLINE float max(float a, float b) { return a > b ? a : b; }
KB_INLINE float clamp(float x, float lo, float hi) { return min(max(x, lo), hi); }
KB_INLINE float safeSqrt(float x) { return __builtin_sqrtf(max(x, 0.f)); }
KB_INLINE float lerp(float a, float b, float t) { return fma(t, b - a, a); }

struct V3 {
  float x, y, z;
};
KB_INLINE V3 operator+(V3 a, V3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
KB_INLINE V3 operator*(V3 a, V3 b) { return {a.x * b.x, a.y * b.y, a.z * b.z}; }
KB_INLINE V3 operator*(V3 a, float s) { return {a.x * s, a.y * s, a.z * s}; }
KB_INLINE float dot(V3 a, V3 b) { return fma(a.x, b.x, fma(a.y, b.y, a.z * b.z)); }
KB_INLINE V3 normalize(V3 a) { return a * (1.f / __builtin_sqrtf(dot(a, a))); }
KB_INLINE float average(V3 a) { return (a.x + a.y + a.z) * (1.f / 3.f); }
KB_INLINE V3 lerp(V3 a, V3 b, float t) { return {lerp(a.x, b.x, t), lerp(a.y, b.y, t), lerp(a.z, b.z, t)}; }
KB_INLINE V3 load(const float* const p[3], uint32_t i) { return {p[0][i], p[1][i], p[2][i]}; }
KB_INLINE V3 vec(const float v[3]) { return {v[0], v[1], v[2]}; }

KB_INLINE float fromBits(int32_t i) {
  float f;
  std::memcpy(&f, &i, 4);
  return f;
}
KB_INLINE int32_t toBits(float f) {
  int32_t i;
  std::memcpy(&i, &f, 4);
  return i;
}
// kinora/math/elementary.h's, for arguments that stay in range here
KB_INLINE float exp(float x) {
  const float y = clamp(x, -87.33654f, 88.72283f);
  const float k = __builtin_nearbyintf(y * 1.44269504088896341f);
  const int32_t n = int32_t(k);
  float r = fma(-k, 0.693359375f, y);
  r = fma(k, 2.12194440e-4f, r);
  float p = fma(r, 1.9875691500e-4f, 1.3981999507e-3f);
  p = fma(p, r, 8.3334519073e-3f);
  p = fma(p, r, 4.1665795894e-2f);
  p = fma(p, r, 1.6666665459e-1f);
  p = fma(p, r, 5.0000001201e-1f);
  p = fma(p, r * r, r + 1.f);
  const int32_t h = n >> 1;
  const float e = p * fromBits((h + 127) << 23) * fromBits((n - h + 127) << 23);
  return x < -87.33654f ? 0.f : x > 88.72283f ? __builtin_inff() : e;
}
KB_INLINE float log(float x) {
  const bool tiny = x < 1.17549435e-38f;
  const int32_t bits = toBits(tiny ? x * 8388608.f : x);
  int32_t e = int32_t(uint32_t(bits) >> 23) - 126;
  float m = fromBits((bits & 0x007fffff) | 0x3f000000);
  if (m < 0.707106781186547524f) {
    --e;
    m = m + m;
  }
  m -= 1.f;
  const float z = m * m;
  float p = fma(m, 7.0376836292e-2f, -1.1514610310e-1f);
  p = fma(p, m, 1.1676998740e-1f);
  p = fma(p, m, -1.2420140846e-1f);
  p = fma(p, m, 1.4249322787e-1f);
  p = fma(p, m, -1.6668057665e-1f);
  p = fma(p, m, 2.0000714765e-1f);
  p = fma(p, m, -2.4999993993e-1f);
  p = fma(p, m, 3.3333331174e-1f);
  p = p * m * z;
  const float k = float(e) - (tiny ? 23.f : 0.f);
  p = fma(k, -2.12194440e-4f, p);
  p = fma(-0.5f, z, p);
  const float r = fma(k, 0.693359375f, m + p);
  return x == 0 ? -__builtin_inff() : r;
}
KB_INLINE float pow(float x, float y) {
  const float r = exp(y * log(x));
  if (y == 0 || x == 1) return 1;
  return x == 0 && y > 0 ? 0.f : r;
}

struct Frame {
  V3 x, y, z;
};
KB_INLINE Frame frameOf(V3 n) {
  const float sign = __builtin_copysignf(1.f, n.z), a = -1.f / (sign + n.z), b = n.x * n.y * a;
  return {{fma(sign * n.x * n.x, a, 1.f), sign * b, -sign * n.x}, {b, fma(n.y * n.y, a, sign), -n.y}, n};
}
KB_INLINE V3 toLocal(const Frame& f, V3 v) { return {dot(v, f.x), dot(v, f.y), dot(v, f.z)}; }

KB_INLINE float microfacetD(V3 h, float ax, float ay) {
  const float x = h.x / ax, y = h.y / ay, s = fma(x, x, y * y), t = s + h.z * h.z;
  return 1.f / max(kPi * ax * ay * t * t, 1e-30f);
}
KB_INLINE float smithLambda(V3 w, float ax, float ay) {
  const float x = w.x * ax, y = w.y * ay, t2 = fma(x, x, y * y) / max(w.z * w.z, 1e-14f);
  return fma(__builtin_sqrtf(t2 + 1.f), 0.5f, -0.5f);
}
KB_INLINE float fresnelConductor(float cosI, float eta, float k) {
  const float c2 = cosI * cosI, s2 = max(1.f - c2, 0.f);
  const float t0 = fma(eta, eta, -fma(k, k, s2)), ek = (eta + eta) * k;
  const float ab = __builtin_sqrtf(fma(t0, t0, ek * ek));
  const float a = safeSqrt(0.5f * (ab + t0)), ac = (a + a) * cosI;
  const float t1 = ab + c2, rs = (t1 - ac) / max(t1 + ac, 1e-20f);
  const float t3 = fma(c2, ab, s2 * s2), t4 = ac * s2;
  const float rp = rs * (t3 - t4) / max(t3 + t4, 1e-20f);
  return min(max(0.5f * (rs + rp), 0.f), 1.f);
}
struct Axis {
  int cell;
  float t;
};
KB_INLINE Axis axisAt(float x, int n) {
  const float y = clamp(x, 0.f, 1.f) * float(n - 1), f = min(__builtin_floorf(y), float(n - 2));
  return {int(f), y - f};
}

struct Lobe {
  const ScalarSpecular* k;
  const float *table, *tableMean;
  Frame frame;
  V3 wo, multiple, face, edge, extinction;
  float ax, ay, lambdaO, eMean, shape, f0, f90, multipleMean;
  bool smooth;
  Axis rough;

  KB_INLINE float several(float mean) const {
    const float f = clamp(mean, 0.f, 1.f);
    return f * f * eMean / max(fma(-f, 1.f - eMean, 1.f), 1e-6f);
  }
  KB_INLINE float power(float cosine) const {
    const float x = clamp(1.f - cosine, 0.f, 1.f), x2 = x * x;
    return shape != 5.f ? pow(x, shape) : x2 * x2 * x;
  }
  KB_INLINE V3 fresnel(float cosine) const {
    if (k->physical)
      return edge * V3{fresnelConductor(cosine, face.x, extinction.x), fresnelConductor(cosine, face.y, extinction.y),
                       fresnelConductor(cosine, face.z, extinction.z)};
    return lerp(face, edge, power(cosine));
  }
  KB_INLINE void set(const ScalarSpecular& closure, const ScalarSurface& surface, V3 normal, V3 woRender) {
    k = &closure;
    table = surface.energy;
    tableMean = surface.energyMean;
    const float roughness = clamp(k->roughness, 0.f, 1.f), alpha = roughness * roughness;
    smooth = alpha < kMirrorAlpha;
    rough = axisAt(roughness, kTableRough);
    frame = frameOf(normal);
    ax = ay = max(alpha, kMirrorAlpha);
    wo = toLocal(frame, woRender);
    wo.z = max(wo.z, 1e-5f);
    lambdaO = smithLambda(wo, ax, ay);
    edge = vec(k->edge);
    V3 mean;
    if (k->physical) {
      face = vec(k->ior);
      extinction = vec(k->extinction);
      shape = 5;
      f0 = average(fresnel(1.f));
      mean = fresnel(kMeanCos0) * kMeanWeight0 + fresnel(kMeanCos1) * kMeanWeight1;
    } else {
      face = vec(k->face);
      shape = max(k->shape, 0.01f);
      f0 = average(face);
      mean = lerp(face, edge, 2.f / ((shape + 1.f) * (shape + 2.f)));
    }
    f90 = average(edge);
    eMean = lerp(tableMean[rough.cell], tableMean[rough.cell + 1], rough.t);
    multiple = {several(mean.x), several(mean.y), several(mean.z)};
    multipleMean = average(multiple);
  }
  KB_INLINE float energy(float mu) const {
    if (smooth) return 1;
    const Axis a = axisAt(safeSqrt(mu), kTableMu);
    const float *p = table + rough.cell * kTableMu, *q = p + kTableMu;
    return lerp(lerp(p[a.cell], p[a.cell + 1], a.t), lerp(q[a.cell], q[a.cell + 1], a.t), rough.t);
  }
  KB_INLINE float ior() const { return k->physical ? average(face) : 1.5f; }
  KB_INLINE V3 albedo(float mu, float e) const { return lerp(multiple, fresnel(mu), e); }
  KB_INLINE float weightSingle(float mu, float e) const { return e * max(lerp(f0, f90, power(mu)), 0.f); }
  KB_INLINE float weightMultiple(float e) const { return max(1.f - e, 0.f) * multipleMean; }
  KB_INLINE V3 evaluate(V3 wi, float eO, float eI, float& pdf, float& pdfReverse) const {
    const V3 h = normalize(wo + wi);
    const float cosI = max(wi.z, 1e-7f), d = microfacetD(h, ax, ay);
    const float lambdaI = smithLambda(wi, ax, ay), quarter = 0.25f / wo.z;
    pdf = d * quarter / (1.f + lambdaO);
    pdfReverse = d * 0.25f / (cosI * (1.f + lambdaI));
    const float single = d * quarter / (1.f + lambdaO + lambdaI);
    const float lost = max(1.f - eO, 0.f) * max(1.f - eI, 0.f) / max(1.f - eMean, 1e-6f);
    const V3 f = fresnel(min(dot(wo, h), 1.f)), m = multiple * (lost * kInvPi * wi.z);
    return {fma(f.x, single, m.x), fma(f.y, single, m.y), fma(f.z, single, m.z)};
  }
};

struct Seen {
  bool outside;
  float mu[3], energy[3], muFuzz;
};
struct Choice {
  float diffuse, single[3], multiple[3], fuzz, scale;
};
struct Layers {
  V3 depth{0, 0, 0}, coat{0, 0, 0}, specular{0, 0, 0};
};
KB_INLINE V3 remaining(V3 a, V3 b) {
  return {clamp(1.f - max(a.x, b.x), 0.f, 1.f), clamp(1.f - max(a.y, b.y), 0.f, 1.f),
          clamp(1.f - max(a.z, b.z), 0.f, 1.f)};
}

struct Point {
  const ScalarSurface& k;
  Lobe lobe[3];
  V3 normal, Ng, wo, reflectance, fuzzColor, coatDepth;
  float muO, front, back, scale, mean, fuzzMean, muFuzzO, inverse2s2, range, fuzzScale;
  Frame fuzzFrame;
  bool coats, covers;
  Seen seenO;
  Choice choiceO;
  Layers layersO;

  KB_INLINE void see(V3 d, Seen& x) const {
    for (int i = 0; i < 3; ++i)
      if (k.specular[i].on) {
        x.mu[i] = min(__builtin_fabsf(dot(lobe[i].frame.z, d)), 1.f);
        x.energy[i] = lobe[i].energy(x.mu[i]);
      }
    if (k.fuzzGain != 0) x.muFuzz = min(__builtin_fabsf(dot(fuzzFrame.z, d)), 1.f);
  }
  KB_INLINE float fuzzBound(float mu) const { return exp(-(mu * mu * inverse2s2)); }
  KB_INLINE void choose(const Seen& x, Choice& c) const {
    float sum = c.diffuse = x.outside ? front : back;
    for (int i = 0; i < 3; ++i) {
      if (!k.specular[i].on) continue;
      const bool here = k.specular[i].doubleSided || x.outside;
      c.single[i] = here ? lobe[i].weightSingle(x.mu[i], x.energy[i]) : 0.f;
      c.multiple[i] = here ? lobe[i].weightMultiple(x.energy[i]) : 0.f;
      sum += c.single[i] + c.multiple[i];
    }
    c.fuzz = 0;
    if (k.fuzzGain != 0) sum += c.fuzz = k.fuzzDoubleSided || x.outside ? fuzzMean * fuzzBound(x.muFuzz) : 0.f;
    c.scale = sum > 0 ? 1.f / max(sum, 1e-30f) : 0.f;
  }
  KB_INLINE void layer(const Seen& x, Layers& y) const {
    if (coats && (k.specular[2].doubleSided || x.outside)) {
      const float ior = max(lobe[2].ior(), 1.f), mu = x.mu[2];
      const float inside = __builtin_sqrtf(max(1.f - fma(-mu, mu, 1.f) / (ior * ior), 1e-4f));
      y.depth = coatDepth * (1.f / inside);
      y.coat = lobe[2].albedo(mu, x.energy[2]) * k.coatCompensation;
    }
    if (covers) {
      V3 sum{0, 0, 0};
      for (int i = 0; i < 2; ++i)
        if (k.specular[i].on && (k.specular[i].doubleSided || x.outside))
          sum = sum + lobe[i].albedo(x.mu[i], x.energy[i]);
      y.specular = sum * k.specularCompensation;
    }
  }
  KB_INLINE float roughEnergy(float mu) const {
    const float c = 1.f - mu;
    float g = fma(c, 0.0714429953f, -0.332181442f);
    g = fma(c, g, 0.491881867f);
    g = c * fma(c, g, 0.0571085289f);
    return scale * fma(k.diffuseRoughness, g, 1.f);
  }
  KB_INLINE float tint(float c, float lost) const { return c * c * mean / max(fma(-c, lost, 1.f), 1e-6f); }
  KB_INLINE V3 diffuse(float muI, float cosBetween) const {
    const float s = fma(-muI, muO, cosBetween), t = s > 0 ? s / max(max(muI, muO), 1e-7f) : s;
    const float single = scale * fma(k.diffuseRoughness, t, 1.f) * kInvPi, lost = 1.f - mean;
    const float more =
        max(1.f - roughEnergy(muO), 0.f) * max(1.f - roughEnergy(muI), 0.f) / max(lost, 1e-7f) * kInvPi;
    return reflectance * single +
           V3{tint(reflectance.x, lost), tint(reflectance.y, lost), tint(reflectance.z, lost)} * more;
  }
  KB_INLINE float minnaert(float mI) const {
    const float e = max(k.diffuseExponent, 1.f);
    return pow(muO * mI, e - 1.f) * 0.5f * (e + 1.f);
  }

  KB_INLINE Point(const ScalarSurface& surface, V3 N, V3 Ngeo, V3 woRender, bool outside)
      : k(surface), normal(N), Ng(Ngeo), wo(woRender) {
    seenO.outside = outside;
    muO = max(dot(normal, wo), 0.f);
    const V3 color = vec(k.diffuseColor) * k.diffuseGain;
    reflectance = outside || k.diffuseDoubleSided ? color : V3{0, 0, 0};
    front = max(average(color), 0.f);
    back = k.diffuseDoubleSided ? front : 0.f;
    scale = 1.f / fma(k.diffuseRoughness, 0.5f - 2.f / (3.f * kPi), 1.f);
    mean = scale * fma(k.diffuseRoughness, 2.f / 3.f - 28.f / (15.f * kPi), 1.f);
    for (int i = 0; i < 3; ++i)
      if (k.specular[i].on) lobe[i].set(k.specular[i], k, N, wo);
    if (k.fuzzGain != 0) {
      fuzzFrame = frameOf(N);
      const float sigma = clamp(k.fuzzConeAngle, 0.5f, 90.f) * (kPi / 180.f);
      inverse2s2 = 0.5f / (sigma * sigma);
      range = 1.f - exp(-inverse2s2);
      fuzzScale = inverse2s2 / (kPi * range);
      fuzzColor = vec(k.fuzzColor) * k.fuzzGain;
      fuzzMean = max(average(fuzzColor), 0.f);
      muFuzzO = max(dot(fuzzFrame.z, wo), 0.f);
    }
    coats = k.specular[2].on && ((k.coatThickness != 0 && average(vec(k.coatTint)) != 0) || k.coatCompensation != 0);
    covers = (k.specular[0].on || k.specular[1].on) && k.specularCompensation != 0;
    if (coats) coatDepth = vec(k.coatTint) * k.coatThickness;
    see(wo, seenO);
    choose(seenO, choiceO);
    if (coats || covers) layer(seenO, layersO);
  }

  KB_INLINE V3 evaluate(V3 wi, float& pdf, float& reverse) const {
    const float side = dot(Ng, wi);
    const bool above = side > 0;
    Seen seenI;
    seenI.outside = seenO.outside != (side < 0);
    see(wi, seenI);
    Choice choiceI;
    choose(seenI, choiceI);
    V3 upper{1, 1, 1}, lower{1, 1, 1}, sum{0, 0, 0};
    if (coats || covers) {
      Layers layersI;
      layer(seenI, layersI);
      if (coats) {
        const V3 depth = layersO.depth + layersI.depth;
        upper = V3{exp(-depth.x), exp(-depth.y), exp(-depth.z)} * remaining(layersO.coat, layersI.coat);
      }
      lower = covers ? upper * remaining(layersO.specular, layersI.specular) : upper;
    }
    pdf = reverse = 0;
    const float muI = dot(normal, wi);
    if (above && muI > 0) {
      sum = diffuse(muI, dot(wo, wi)) * lower * (muI * minnaert(muI));
      pdf += choiceO.diffuse * muI * kInvPi;
      reverse += choiceI.diffuse * muO * kInvPi;
    }
    for (int i = 0; i < 3; ++i) {
      if (!k.specular[i].on) continue;
      const V3 w = toLocal(lobe[i].frame, wi);
      if (!above || !(w.z > 0) || !(k.specular[i].doubleSided || seenO.outside) || lobe[i].smooth) continue;
      float p, r;
      const V3 f = lobe[i].evaluate(w, seenO.energy[i], seenI.energy[i], p, r);
      sum = sum + (i == 2 ? f : f * upper);
      pdf += choiceO.single[i] * p;
      reverse += choiceI.single[i] * r;
      pdf += choiceO.multiple[i] * kInvTwoPi;
      reverse += choiceI.multiple[i] * kInvTwoPi;
    }
    if (k.fuzzGain != 0) {
      const float mu = dot(fuzzFrame.z, wi);
      if (above && mu > 0 && (k.fuzzDoubleSided || seenO.outside)) {
        const float c = muFuzzO + mu;
        sum = sum + fuzzColor * (fuzzScale * exp(-(c * c * inverse2s2)) * mu);
        pdf += choiceO.fuzz * (fuzzScale * mu * exp(-(mu * mu * inverse2s2)));
        reverse += choiceI.fuzz * (fuzzScale * muFuzzO * exp(-(muFuzzO * muFuzzO * inverse2s2)));
      }
    }
    pdf *= choiceO.scale;
    reverse *= choiceI.scale;
    return sum;
  }
};

}  // namespace

void evaluateScalar(const ScalarSurface& surface, const ScalarPoints& a) {
  for (uint32_t i = 0; i < a.n; ++i) {
    const Point point(surface, load(a.N, i), load(a.Ng, i), load(a.wo, i), a.entering[i] != 0);
    float pdf, reverse;
    const V3 w = point.evaluate(load(a.wi, i), pdf, reverse);
    a.weight[0][i] = w.x;
    a.weight[1][i] = w.y;
    a.weight[2][i] = w.z;
    a.pdf[i] = pdf;
    if (a.pdfReverse) a.pdfReverse[i] = reverse;
  }
}

}  // namespace kinora::bench
#pragma GCC pop_options
