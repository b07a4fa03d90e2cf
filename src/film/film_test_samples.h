// Sample records for the tests of film/: owns the arrays of a span and deals with order and subsets.
#pragma once
#include <algorithm>
#include <cstring>
#include <random>
#include <vector>

#include "film/film.h"

namespace kinora::film::test {

struct Samples {
  explicit Samples(int floats) : values(size_t(floats)) {}
  std::vector<int32_t> x, y;
  std::vector<uint32_t> index;
  std::vector<float> weight;
  std::vector<std::vector<float>> values;

  void add(int px, int py, uint32_t sampleIndex, float w, const std::vector<float>& record) {
    x.push_back(px);
    y.push_back(py);
    index.push_back(sampleIndex);
    weight.push_back(w);
    for (size_t f = 0; f < values.size(); ++f) values[f].push_back(record[f]);
  }
  int size() const { return int(x.size()); }
  // The samples order[begin..end) as one span each call.
  void addTo(Film& film, const std::vector<int>& order, size_t begin, size_t end) const {
    Samples part(int(values.size()));
    for (size_t i = begin; i < end; ++i) {
      const size_t s = size_t(order[i]);
      part.x.push_back(x[s]);
      part.y.push_back(y[s]);
      part.index.push_back(index[s]);
      part.weight.push_back(weight[s]);
      for (size_t f = 0; f < values.size(); ++f) part.values[f].push_back(values[f][s]);
    }
    part.addTo(film);
  }
  void addTo(Film& film) const {
    std::vector<const float*> arrays;
    for (const auto& v : values) arrays.push_back(v.data());
    film.addSamples({size(), x.data(), y.data(), index.data(), weight.data(), arrays.data()});
  }
  std::vector<int> inOrder() const {
    std::vector<int> order(x.size());
    for (size_t i = 0; i < order.size(); ++i) order[i] = int(i);
    return order;
  }
};

// Every reducer, both halves, an odd number of summed floats, splats.
inline ChannelLayout everyReducer() {
  ChannelLayout layout;
  Channel ci = colorChannel("Ci");
  ci.splats = true;
  layout.add(ci);
  layout.add(floatChannel("a"));
  layout.add(positionChannel("P"));
  layout.add(depthChannel("z"));
  Channel even = colorChannel("Ci_even", "Ci"), odd = colorChannel("Ci_odd", "Ci");
  even.half = Half::Even;
  odd.half = Half::Odd;
  layout.add(even);
  layout.add(odd);
  Channel c = floatChannel("id");
  c.isData = true;
  c.reducer = Reducer::ZMin;
  layout.add(c);
  c.name = "Pnear";
  c.source = "P";
  c.width = 3;
  layout.add(c);
  c.name = "Pfar";
  c.reducer = Reducer::ZMax;
  layout.add(c);
  c.name = "Pmax";
  c.reducer = Reducer::Max;
  layout.add(c);
  c = floatChannel("time", "cpuTime");
  c.reducer = Reducer::Total;
  layout.add(c);
  c = floatChannel("aPlain", "a");
  c.reducer = Reducer::Average;
  layout.add(c);
  return layout;
}

// Random records, with equal depths, misses (z = infinity) and negative weights among them.
inline Samples randomSamples(const ChannelLayout& layout, const Window& w, int perPixel, uint32_t seed) {
  std::mt19937 rng(seed);
  std::uniform_real_distribution<float> uniform(0.0f, 4.0f);
  Samples s(layout.recordFloats());
  for (int y = w.y0; y < w.y1; ++y)
    for (int x = w.x0; x < w.x1; ++x)
      for (int i = 0; i < perPixel; ++i) {
        std::vector<float> record(size_t(layout.recordFloats()));
        for (float& v : record) v = uniform(rng);
        if (const int d = layout.depthOffset(); d >= 0)
          record[size_t(d)] = rng() % 4 == 0 ? INFINITY : float(rng() % 3);
        s.add(x, y, uint32_t(i), rng() % 8 == 0 ? -0.25f : 1.0625f, record);
      }
  return s;
}

inline bool sameState(const Film& a, const Film& b) {
  if (!(a.window() == b.window()) || a.slots() != b.slots()) return false;
  for (int y = a.window().y0; y < a.window().y1; ++y)
    for (int x = a.window().x0; x < a.window().x1; ++x)
      if (std::memcmp(a.pixel(x, y), b.pixel(x, y), size_t(a.slots()) * sizeof(int64_t))) return false;
  return a.splatPasses() == b.splatPasses();
}

inline std::unique_ptr<Film> makeFilm(int width, int height, const ChannelLayout& layout, Window window = {}) {
  Status status;
  if (window.empty()) window = {0, 0, width, height};
  return Film::create(width, height, window, layout, status);
}

}  // namespace kinora::film::test
