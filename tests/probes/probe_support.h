// What the probes share: scenes from RIB text, renders into a film, statistics over renders with several seeds. Used
// by tests/probes only; it judges nothing itself.
#pragma once
#include <gtest/gtest.h>
#include <kinora/bxdf.h>
#include <kinora/integrator.h>
#include <kinora/testing/statistics.h>

#include <array>
#include <cmath>
#include <initializer_list>
#include <memory>
#include <string>
#include <vector>

#include "film/film.h"
#include "plugin/registry.h"
#include "render/renderer.h"
#include "rib/reader.h"

namespace kinora::probes {

inline scene::Scene readScene(rib::RibReader& reader, scene::Scene& out) {
  reader.finish();
  EXPECT_EQ(reader.worlds(), 1u);
  return std::move(out);
}
inline scene::Scene sceneOf(const std::string& text, Diagnostics& messages) {
  scene::Scene out;
  rib::RibReader reader(messages, {}, [&](scene::Scene&& s) { out = std::move(s); });
  EXPECT_TRUE(reader.readString("probe.rib", text));
  return readScene(reader, out);
}
inline scene::Scene sceneOfFile(const std::string& file, Diagnostics& messages) {
  scene::Scene out;
  rib::RibReader reader(messages, {}, [&](scene::Scene&& s) { out = std::move(s); });
  EXPECT_TRUE(reader.readFile(file));
  return readScene(reader, out);
}

// A registry with the test's own integrators, messages that a failing test shows, and renderers over both.
class Workshop {
 public:
  Workshop(std::initializer_list<const Descriptor*> plugins = {}) {
    for (const Descriptor* d : plugins) registry.add(*d);
  }
  Registry registry;
  std::string said;
  Diagnostics messages{[this](const std::string& line, Severity) { said += line + "\n"; }};

  std::unique_ptr<render::Renderer> load(scene::Scene scene, const render::Settings& settings) {
    auto r = std::make_unique<render::Renderer>(registry, messages, settings);
    EXPECT_TRUE(r->load(std::move(scene))) << said;
    return r;
  }
};

// IntegratorTraits::stages.
inline uint32_t cameraThenLightPaths(const void*, Stage* out, uint32_t capacity) {
  if (capacity < 2) return 0;
  out[0] = {StageKind::CameraPaths, 0};
  out[1] = {StageKind::LightPaths, 1};
  return 2;
}

// An integrator of a test's own that needs no data: what it says of itself, with the same functions for all widths.
template <const IntegratorFunctions& functions>
inline constexpr WidthTable kSameAtAllWidths[] = {
    {1, &functions}, {4, &functions}, {8, &functions}, {16, &functions}};
template <const IntegratorFunctions& functions>
constexpr Descriptor probeOf(const char* name, const char* help, const IntegratorTraits& traits,
                             const Param* params = nullptr, uint32_t paramCount = 0) {
  return {kAbiVersion,
          sizeof(Descriptor),
          Kind::Integrator,
          0,
          name,
          help,
          params,
          paramCount,
          kSameAtAllWidths<functions>,
          4,
          &traits,
          [](const CreateInfo*, ErrorText*) -> void* { return new int; },
          [](void* p) { delete static_cast<int*>(p); }};
}

// Directions that the bxdfs of a context choose, in memory of the group. Its user fills u before generate().
struct Generated {
  float *u[4], *wi[3], *weight[3], *pdf;
  uint32_t *slot, *flags;
  Generated(Group* g, const Services* s, const Context& c) {
    const auto floats = [&] { return static_cast<float*>(s->alloc(g, c.padded * sizeof(float))); };
    const auto words = [&] { return static_cast<uint32_t*>(s->alloc(g, c.padded * sizeof(uint32_t))); };
    for (float*& x : u) x = floats();
    for (float*& x : wi) x = floats();
    for (float*& x : weight) x = floats();
    pdf = floats();
    slot = words();
    flags = words();
  }
  void generate(const Context& c) const {
    const GenerateArgs args{{u[0], u[1], u[2], u[3]},
                            {wi[0], wi[1], wi[2]},
                            {weight[0], weight[1], weight[2]},
                            pdf,
                            nullptr,
                            slot,
                            flags};
    c.bxdf->generate(&c, c.closure, &args);
  }
};

inline image::Image pictureOf(render::Renderer& r, const char* channel = "Ci") {
  EXPECT_EQ(r.renderFilm(), render::Outcome::Complete);
  const int index = r.film().layout().find(channel);
  EXPECT_GE(index, 0) << channel;
  return r.film().resolve(index);
}

// A renderer of the scene for each of `seeds` seeds from `first` on, with settings that are the same but for that (threads:
// one where they say none). show(renderer) renders.
template <class Show>
void forSeeds(Workshop& stage, const std::string& text, render::Settings settings, uint32_t first, uint32_t seeds,
              Show&& show) {
  if (settings.threads == 0) settings.threads = 1;
  for (uint32_t k = 0; k < seeds; ++k) {
    settings.seed = first + k;
    show(*stage.load(sceneOf(text, stage.messages), settings));
  }
}

// All integers of the film: equal pictures in the strictest sense.
inline std::vector<int64_t> stateOf(const film::Film& f) {
  std::vector<int64_t> all;
  for (int y = f.window().y0; y < f.window().y1; ++y)
    for (int x = f.window().x0; x < f.window().x1; ++x)
      all.insert(all.end(), f.pixel(x, y), f.pixel(x, y) + f.slots());
  return all;
}

// The same film with any number of threads, width, size of groups, and in two parts.
inline void expectSameBits(std::initializer_list<const Descriptor*> plugins, const std::string& text,
                           const std::string& integrator) {
  const auto filmOf = [&](int threads, uint32_t width, uint32_t groupSize, int first = -1, int last = -1) {
    Workshop stage(plugins);
    render::Settings s;
    s.threads = threads;
    s.width = width;
    s.groupSize = groupSize;
    s.firstSample = first;
    s.lastSample = last;
    s.integrator = integrator;
    const auto r = stage.load(sceneOf(text, stage.messages), s);
    EXPECT_EQ(r->renderFilm(), render::Outcome::Complete) << stage.said;
    return stateOf(r->film());
  };
  const std::vector<int64_t> expected = filmOf(1, 8, 1024);
  for (const uint32_t width : {1u, 4u, 16u}) EXPECT_TRUE(filmOf(2, width, 1024) == expected) << "width " << width;
  for (const uint32_t size : {64u, 256u, 4096u}) EXPECT_TRUE(filmOf(2, 8, size) == expected) << "groups of " << size;
  // the film's numbers are sums
  std::vector<int64_t> parts = filmOf(2, 8, 1024, 0, 5);
  const std::vector<int64_t> rest = filmOf(1, 4, 256, 5, 16);
  ASSERT_EQ(parts.size(), rest.size());
  for (size_t i = 0; i < parts.size(); ++i) parts[i] += rest[i];
  EXPECT_TRUE(parts == expected) << "in two parts";
}

// The film with a parameter of the integrator as it is given.
inline std::vector<int64_t> stateWith(const std::string& text, const std::string& parameter,
                                      const std::string& value) {
  Workshop stage;
  render::Settings s;
  s.threads = 1;
  s.sets = {{"integrator." + parameter, value}};
  const auto r = stage.load(sceneOf(text, stage.messages), s);
  EXPECT_EQ(r->renderFilm(), render::Outcome::Complete);
  return stateOf(r->film());
}

// Rendered by itself, a part of a picture has the pixels of the whole.
inline void expectCropIsPartOfWhole(const std::string& text, std::array<float, 4> crop) {
  const auto render = [&](std::array<float, 4> window) {
    Workshop stage;
    render::Settings s;
    s.threads = 2;
    s.crop = window;
    const auto r = stage.load(sceneOf(text, stage.messages), s);
    return pictureOf(*r);
  };
  const image::Image whole = render({-1, -1, -1, -1}), part = render(crop);
  ASSERT_GT(part.width(), 4);
  ASSERT_LT(part.width(), whole.width());
  int compared = 0, differ = 0;
  for (int y = part.data.y0; y < part.data.y1; ++y)
    for (int x = part.data.x0; x < part.data.x1; ++x, ++compared)
      for (int k = 0; k < 3; ++k) differ += part.at(x, y)[k] != whole.at(x, y)[k];
  EXPECT_GT(compared, 40);
  EXPECT_EQ(differ, 0);
}

// Moments over renders of the mean of each tile of size x size pixels, all colours added.
struct TileMoments {
  std::vector<testing::Moments> tiles;
  int columns = 0;
  void add(const image::Image& img, int width, int height, int size) {
    columns = (width + size - 1) / size;
    tiles.resize(size_t(columns) * size_t((height + size - 1) / size));
    std::vector<double> sum(tiles.size(), 0);
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x)
        for (int k = 0; k < 3; ++k) sum[size_t(y / size) * size_t(columns) + size_t(x / size)] += img.at(x, y)[k];
    for (size_t i = 0; i < tiles.size(); ++i) tiles[i].add(sum[i] / (3.0 * size * size));
  }
  double mean() const {
    double s = 0;
    for (const auto& t : tiles) s += t.mean();
    return s / double(tiles.size());
  }
  // Of mean(), by the errors of its tiles.
  double meanVariance() const {
    double s = 0;
    for (const auto& t : tiles) s += t.standardError() * t.standardError();
    return s / double(tiles.size() * tiles.size());
  }
};

struct TileTest {
  double least = 1, level = 0;  // smallest p of the tiles; what it must reach
  double worstZ = 0;
  double meanError = 0;  // relative standard error of a tile, on average: how sharp the test is
  bool agrees() const { return least >= level; }
};

// Welch's test tile by tile, Sidak's level over all tiles. t becomes a normal deviate by Wallace's approximation.
inline TileTest compareTiles(const TileMoments& a, const TileMoments& b, double level = 0.001) {
  TileTest r;
  r.level = testing::sidakLevel(level, a.tiles.size());
  for (size_t i = 0; i < a.tiles.size(); ++i) {
    const double va = std::pow(a.tiles[i].standardError(), 2), vb = std::pow(b.tiles[i].standardError(), 2);
    const double difference = a.tiles[i].mean() - b.tiles[i].mean();
    if (!(va + vb > 0)) {
      if (difference != 0) r.least = 0;
      continue;
    }
    const double t = difference / std::sqrt(va + vb);
    const double freedom =
        (va + vb) * (va + vb) / (va * va / double(a.tiles[i].count() - 1) + vb * vb / double(b.tiles[i].count() - 1));
    const double z = std::sqrt(freedom * std::log1p(t * t / freedom)) * (1 - 2 / (8 * freedom + 1));
    r.least = std::min(r.least, testing::normalTail(z));
    r.worstZ = std::max(r.worstZ, z);
    r.meanError += std::sqrt(va + vb) / std::max(1e-9, std::fabs(b.tiles[i].mean())) / double(a.tiles.size());
  }
  return r;
}

}  // namespace kinora::probes
