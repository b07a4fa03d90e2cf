// Many lights: what a sample takes and how good it is.
#include "lights.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <string>

#include "base/arena.h"
#include "light/light_set.h"
#include "plugin/registry.h"
#include "simd/dispatch.h"

namespace kinora::bench {

namespace {

using light::LightSet;

float uniform(std::mt19937& r, float a, float b) { return a + (b - a) * float(r() >> 8) * 0x1p-24f; }

// Small sphere lights over a floor z = 0, as many on each unit of it whatever their number; powers of two magnitudes.
struct Lamps {
  float side = 0;
  std::vector<double> power, center;  // closed forms need no more: irradiance of a small sphere is I cos / d^2
  std::unique_ptr<LightSet> set;
  double buildSeconds = 0;
};

const Descriptor& sphereLight() {
  for (const Descriptor* d : stockPlugins())
    if (std::string(d->name) == "PxrSphereLight") return *d;
  throw std::runtime_error("no PxrSphereLight");
}

Lamps lamps(uint32_t count, uint32_t seed) {
  const Descriptor& d = sphereLight();
  Lamps out;
  out.side = std::sqrt(float(count));
  std::mt19937 r(seed);
  light::LightKind kind;
  for (uint32_t w : {1u, 4u, 8u, 16u}) kind.byWidth[w] = static_cast<const LightFunctions*>(functionsFor(d, w));
  std::vector<light::LightEntry> entries(count);
  std::vector<uint32_t> all(count);
  std::vector<ParamValue> values(d.paramCount);
  std::vector<const char*> texts(d.paramCount);
  for (uint32_t i = 0; i < d.paramCount; ++i) {
    const Param& p = d.params[i];
    texts[i] = p.text;
    values[i].floats = p.value;
    values[i].strings = &texts[i];
    values[i].count = p.type == Type::Float || p.type == Type::Int || p.type == Type::String ? 1 : 3;
  }
  Host host{};
  host.warn = [](void*, const char*, const char*, const char*) {};
  host.image = [](void*, const char*, int) -> const HostImage* { return nullptr; };
  for (uint32_t i = 0; i < count; ++i) {
    const float x = uniform(r, 0, out.side), y = uniform(r, 0, out.side), z = uniform(r, 0.3f, 1.5f);
    const float intensity = std::exp(uniform(r, 0, 4.6f));
    Placement placement{};
    const double size = 0.02;
    const double m[16] = {size, 0, 0, 0, 0, size, 0, 0, 0, 0, size, 0, x, y, z, 1};
    std::copy(m, m + 16, placement.localToRender);
    placement.isStatic = 1;
    for (uint32_t k = 0; k < d.paramCount; ++k)
      if (std::string(d.params[k].name) == "intensity") {
        values[k].floats = &intensity;
        values[k].given = 1;
      }
    const CreateInfo info{&host, "lamp", values.data(), d.paramCount, &placement, nullptr};
    ErrorText error{};
    void* data = d.create(&info, &error);
    if (!data) throw std::runtime_error(error.text);
    entries[i].owner = std::shared_ptr<void>(data, d.destroy);
    entries[i].instance = data;
    static_cast<const LightTraits*>(d.traits)->describe(data, &entries[i].description);
    out.power.push_back(entries[i].description.power);
    out.center.insert(out.center.end(), {x, y, z});
    all[i] = i;
  }
  const float center[3] = {out.side / 2, out.side / 2, 0};
  const double start = threadSeconds();
  out.set = std::make_unique<LightSet>(std::vector<light::LightKind>{kind}, std::move(entries),
                                       std::vector<std::vector<uint32_t>>{all}, center, out.side);
  out.buildSeconds = threadSeconds() - start;
  return out;
}

// Neighbours on the floor, as a group's are: `count` points about one place.
struct Spot {
  explicit Spot(uint32_t count) : n(count) {
    for (auto* v : {&p[0], &p[1], &p[2], &N[0], &N[1], &N[2], &u[0], &u[1], &u[2], &u[3], &time})
      v->assign(padded(n) + kPad, 0.f);
  }
  void place(float x, float y, float width, std::mt19937& r) {
    for (uint32_t i = 0; i < padded(n); ++i) {
      p[0][i] = x + uniform(r, 0, width);
      p[1][i] = y + uniform(r, 0, width);
      N[2][i] = 1;
      for (auto& v : u) v[i] = uniform(r, 0, 1);
    }
  }
  LightSet::Points points() const {
    LightSet::Points x;
    x.count = n;
    x.padded = padded(n);
    for (size_t c = 0; c < 3; ++c) {
      x.P[c] = p[c].data();
      x.N[c] = N[c].data();
    }
    x.time = time.data();
    for (size_t k = 0; k < 2; ++k) {
      x.uChoice[k] = u[k].data();
      x.u[k] = u[2 + k].data();
    }
    return x;
  }
  uint32_t n;
  std::vector<float> p[3], N[3], u[4], time;
};

// Nanoseconds a light sample, at groups all over the floor.
double sampleTime(const Lamps& lamps, bool quick) {
  constexpr uint32_t kGroup = 256;
  const uint32_t groups = quick ? 8 : 4000;
  std::mt19937 r(5);
  Arena arena;
  std::vector<Spot> spots(64, Spot(kGroup));
  double best = 1e30;
  for (int repeat = 0; repeat < 3; ++repeat) {
    double seconds = 0;
    for (uint32_t g = 0; g < groups; g += uint32_t(spots.size())) {
      for (Spot& s : spots)
        s.place(uniform(r, 0, lamps.side), uniform(r, 0, lamps.side), 0.05f * std::min(lamps.side, 20.f), r);
      const double start = threadSeconds();
      for (const Spot& s : spots) {
        arena.reset();
        LightSamples out;
        lamps.set->sample(bestWidth(), arena, s.points(), &out);
      }
      seconds += threadSeconds() - start;
    }
    best = std::min(best, seconds);
  }
  const uint32_t rounds = (groups + uint32_t(spots.size()) - 1) / uint32_t(spots.size());
  return best / (double(rounds) * double(spots.size()) * kGroup) * 1e9;
}

// Mean relative squared error of one sample a point, by the tree and by power; in closed form over all lights.
void measureNoise(const Options& options, Figures& figures) {
  const Lamps many = lamps(options.quick ? 500 : 10000, 3);
  const auto n = uint32_t(many.power.size());
  std::mt19937 r(9);
  std::vector<double> gain, byTree;
  double power = 0;
  for (const double p : many.power) power += p;
  double tree = 0, plain = 0;
  const int places = options.quick ? 10 : 200;
  Spot spot(n);
  std::vector<uint32_t> light(padded(n));
  std::vector<float> probability(padded(n));
  for (uint32_t i = 0; i < padded(n); ++i) light[i] = std::min(i, n - 1);
  for (int k = 0; k < places; ++k) {
    spot.place(uniform(r, 0, many.side), uniform(r, 0, many.side), 0, r);
    many.set->probabilities(bestWidth(), spot.points(), light.data(), probability.data());
    double sum = 0, secondTree = 0, secondPower = 0;
    for (uint32_t i = 0; i < n; ++i) {
      const double v[3] = {many.center[3 * i] - spot.p[0][0], many.center[3 * i + 1] - spot.p[1][0],
                           many.center[3 * i + 2]};
      const double d2 = v[0] * v[0] + v[1] * v[1] + v[2] * v[2], e = many.power[i] * v[2] / (d2 * std::sqrt(d2));
      sum += e;
      secondTree += e * e / double(probability[i]);
      secondPower += e * e / (many.power[i] / power);
    }
    tree += secondTree / (sum * sum) - 1;
    plain += secondPower / (sum * sum) - 1;
  }
  figures.add("light_noise_vs_power", {plain / tree},
              "variance of one light sample among 10,000 lamps when chosen by power alone, over what it is");
  figures.add("light_noise", {tree / places}, "its relative variance");
}

}  // namespace

void measureLights(const Options& options, Figures& figures) {
  std::vector<double> ten, thousand, million;
  const uint32_t most = options.quick ? 2000 : 1000000;
  const Lamps two = lamps(2, 1), four = lamps(4, 1), a = lamps(10, 1), b = lamps(1000, 1), c = lamps(most, 1);
  std::vector<double> amongTwo, amongFour;
  for (int k = 0; k < options.repeat; ++k) {
    amongTwo.push_back(sampleTime(two, options.quick));
    amongFour.push_back(sampleTime(four, options.quick));
    ten.push_back(sampleTime(a, options.quick));
    thousand.push_back(sampleTime(b, options.quick));
    million.push_back(sampleTime(c, options.quick));
  }
  std::vector<double> by1000, byMillion;
  for (size_t k = 0; k < ten.size(); ++k) {
    by1000.push_back(thousand[k] / ten[k]);
    byMillion.push_back(million[k] / ten[k]);
  }
  figures.add("ns_light_sample_2", amongTwo, "a light sample among two small lights");
  figures.add("ns_light_sample_4", amongFour, "among four");
  figures.add("ns_light_sample_10", ten, "among 10");
  figures.add("light_growth_1000", by1000, "among 1,000, over that");
  figures.add("light_growth_1000000", byMillion, "and among 1,000,000");
  figures.add("bytes_per_light", {double(c.set->bytes()) / double(c.power.size())},
              "what a light costs beside its plug-in's data");
  const Lamps d = lamps(options.quick ? 1000 : 100000, 2);
  figures.add("light_build_seconds", {d.buildSeconds}, "trees over 100,000 lights");
  measureNoise(options, figures);
}

}  // namespace kinora::bench
