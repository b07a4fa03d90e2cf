// Proves, over a whole small picture: the filters that lay an image behind or over it (each fit, offset, scale, turn,
// reduction, alpha, shadow) and the edge filter, in closed form, for parts of a picture as for all of it, at every width.
// That images are found and neighbours are those before the filter in a render is tested in tests/filters.
#include <gtest/gtest.h>
#include <kinora/channel_filter.h>

#include <array>
#include <cmath>
#include <cstring>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "plugin/registry.h"

namespace kinora {
namespace {

struct Frame {  // of 12 x 8 pixels, the pixels of a window
  static constexpr int kWidth = 12, kHeight = 8;
  std::array<int, 4> window{0, 0, kWidth, kHeight};
  using Plane = std::vector<float>;  // of the whole frame
  std::vector<std::vector<Plane>> channels;
  std::vector<std::string> warnings;
  uint32_t width = 16;
  float pixelAspect = 1;

  static Plane plane(const std::function<float(int, int)>& f) {
    Plane p(kWidth * kHeight);
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) p[size_t(y * kWidth + x)] = f(x, y);
    return p;
  }
  float at(int channel, int component, int x, int y) const {
    return channels[size_t(channel)][size_t(component)][size_t(y * kWidth + x)];
  }
  // What the filter makes of the channels; false: it cannot be made.
  bool run(const char* name, const HostImage* image, const std::map<std::string, float>& numbers = {},
           const std::map<std::string, std::string>& texts = {}) {
    const Descriptor* d = nullptr;
    for (const Descriptor* k : stockPlugins())
      if (!std::strcmp(k->name, name)) d = k;
    if (!d) throw std::string("no filter ") + name;
    std::vector<ParamValue> values(d->paramCount);
    std::vector<std::array<float, 3>> floats(d->paramCount);
    std::vector<const char*> text(d->paramCount);
    for (uint32_t i = 0; i < d->paramCount; ++i) {
      const Param& p = d->params[i];
      const auto n = numbers.find(p.name);
      const auto t = texts.find(p.name);
      text[i] = t != texts.end() ? t->second.c_str() : !std::strcmp(p.name, "filename") ? "plate.exr" : p.text;
      for (size_t c = 0; c < 3; ++c) floats[i][c] = n == numbers.end() ? p.value[c] : n->second;
      values[i] = {floats[i].data(), &text[i], p.type == Type::Color ? 3u : 1u, 0, 0};
    }
    struct Self {
      const HostImage* image;
      std::vector<std::string>* warnings;
    } self{image, &warnings};
    const Host host{
        &self,
        [](void* s, const char* code, const char*, const char*) { static_cast<Self*>(s)->warnings->push_back(code); },
        [](void* s, const char*, int) { return static_cast<Self*>(s)->image; }};
    const ChannelFilterInfo picture{{kWidth, kHeight}, pixelAspect};
    const CreateInfo info{&host, "f", values.data(), d->paramCount, nullptr, &picture};
    ErrorText error{};
    void* f = d->create(&info, &error);
    if (!f) return false;
    const int w = window[2] - window[0], h = window[3] - window[1];
    const uint32_t n = uint32_t(w * h);
    std::vector<int32_t> x(padded(n)), y(padded(n));
    for (uint32_t i = 0; i < padded(n); ++i) {
      const int j = int(std::min(i, n - 1));
      x[i] = window[0] + j % w;
      y[i] = window[1] + j / w;
    }
    const auto* traits = static_cast<const ChannelFilterTraits*>(d->traits);
    std::vector<std::vector<Plane>> data = channels, before = channels;
    std::vector<FilterChannel> list;
    for (size_t c = 0; c < channels.size(); ++c) {
      FilterChannel k{traits->channel(f, uint32_t(c)), uint32_t(channels[c].size()), {}, {}};
      for (size_t q = 0; q < channels[c].size(); ++q) {
        data[c][q].resize(padded(n));
        for (uint32_t i = 0; i < padded(n); ++i) data[c][q][i] = at(int(c), int(q), x[i], y[i]);
        before[c][q].assign(data[c][q].begin(), data[c][q].begin() + n);
        k.data[q] = data[c][q].data();
        if (traits->seesPicture) k.before[q] = before[c][q].data();
      }
      list.push_back(k);
    }
    const ChannelFilterArgs a{
        n, x.data(), y.data(), list.data(), uint32_t(list.size()), {window[0], window[1], window[2], window[3]}};
    if (d->kind == Kind::SampleFilter)
      static_cast<const SampleFilterFunctions*>(functionsFor(*d, width))->filter(f, &a);
    else
      static_cast<const DisplayFilterFunctions*>(functionsFor(*d, width))->filter(f, &a);
    d->destroy(f);
    for (size_t c = 0; c < channels.size(); ++c)
      for (size_t q = 0; q < channels[c].size(); ++q)
        for (uint32_t i = 0; i < n; ++i) channels[c][q][size_t(y[i] * kWidth + x[i])] = data[c][q][i];
    return true;
  }
};

// Colour 0 and the given alpha everywhere.
Frame empty(float alpha = 0) {
  Frame f;
  const auto all = [](float v) { return Frame::plane([v](int, int) { return v; }); };
  f.channels = {{all(0), all(0), all(0)}, {all(alpha)}};
  return f;
}

struct Texels {
  std::vector<float> values;
  HostImage image;
  Texels(int w, int h, const std::function<std::array<float, 4>(int, int)>& f, uint32_t channels = 4) {
    for (int y = 0; y < h; ++y)
      for (int x = 0; x < w; ++x)
        for (uint32_t c = 0; c < channels; ++c) values.push_back(f(x, y)[c]);
    image = {values.data(), uint32_t(w), uint32_t(h), channels};
  }
};
std::array<float, 4> place(int x, int y) { return {float(x), float(y), float(x * y), 1}; }

// The frame is 3 x 2 in screen space, a pixel 1/4: a window of 4 x 2 pixels shows a picture of as many texels there,
// and one larger than the frame the part of it that the frame is.
TEST(ImageFilters, LieInTheFilmWindow) {
  const Texels small(4, 2, place), large(2 * Frame::kWidth, 2 * Frame::kHeight, place);
  for (const char* name : {"PxrImageDisplayFilter", "PxrImagePlaneFilter"})
    for (int fit : {0, 1, 2}) {
      // columns 7 to 10, rows 1 and 2
      Frame f = empty();
      ASSERT_TRUE(f.run(
          name, &small.image,
          {{"fit", float(fit)}, {"filmMinX", 0.25f}, {"filmMaxX", 1.25f}, {"filmMinY", 0.25f}, {"filmMaxY", 0.75f}}));
      for (int y = 0; y < Frame::kHeight; ++y)
        for (int x = 0; x < Frame::kWidth; ++x) {
          const bool isIn = x >= 7 && x < 11 && y >= 1 && y < 3;
          for (int c = 0; c < 3; ++c)
            ASSERT_NEAR(f.at(0, c, x, y), isIn ? place(x - 7, y - 1)[size_t(c)] : 0, 2e-4) << name << x << " " << y;
        }
      Frame g = empty();
      ASSERT_TRUE(
          g.run(name, &large.image,
                {{"fit", float(fit)}, {"filmMinX", -3.f}, {"filmMaxX", 3.f}, {"filmMinY", -2.f}, {"filmMaxY", 2.f}}));
      for (int y = 0; y < Frame::kHeight; ++y)
        for (int x = 0; x < Frame::kWidth; ++x)
          for (int c = 0; c < 3; ++c)
            ASSERT_NEAR(g.at(0, c, x, y), place(x + Frame::kWidth / 2, y + Frame::kHeight / 2)[size_t(c)], 2e-3);
      Frame h = empty();
      ASSERT_TRUE(h.run(name, &small.image, {{"filmMinX", 1.f}, {"filmMaxX", 0.5f}}));
      EXPECT_EQ(h.warnings, std::vector<std::string>{"FILTER-FILM"});
    }
}

TEST(ImageFilters, OfTheFramesSizeEachPixelIsATexel) {
  const Texels t(Frame::kWidth, Frame::kHeight, place);
  for (const char* name : {"PxrImageDisplayFilter", "PxrImagePlaneFilter", "PxrWatermarkFilter"})
    for (int fit = 0; fit < 5; ++fit)
      for (uint32_t width : {1u, 4u, 8u, 16u}) {
        Frame f = empty();
        f.width = width;
        if (!std::strcmp(name, "PxrWatermarkFilter")) f.channels.resize(1);
        ASSERT_TRUE(f.run(name, &t.image, {{"fit", float(fit)}}));
        for (int y = 0; y < Frame::kHeight; ++y)
          for (int x = 0; x < Frame::kWidth; ++x)
            for (int c = 0; c < 3; ++c)
              ASSERT_NEAR(f.at(0, c, x, y), place(x, y)[size_t(c)], 2e-4) << name << " " << x << " " << y;
      }
}

TEST(ImageFilters, FitsOfASquare) {
  // a square of 1 x 1 texels: where it is, is its shape
  const Texels t(1, 1, [](int, int) { return std::array<float, 4>{1, 1, 1, 1}; });
  const auto rect = [&](const std::map<std::string, float>& numbers, float pixelAspect = 1) {
    Frame f = empty();
    f.pixelAspect = pixelAspect;
    EXPECT_TRUE(f.run("PxrImageDisplayFilter", &t.image, numbers));
    std::array<int, 4> r{99, 99, -1, -1};
    for (int y = 0; y < Frame::kHeight; ++y)
      for (int x = 0; x < Frame::kWidth; ++x)
        if (f.at(0, 0, x, y) > 0.5f)
          r = {std::min(r[0], x), std::min(r[1], y), std::max(r[2], x + 1), std::max(r[3], y + 1)};
    return r;
  };
  using R = std::array<int, 4>;
  EXPECT_EQ(rect({{"fit", 0}}), (R{0, 0, 12, 8}));
  EXPECT_EQ(rect({{"fit", 1}}), (R{2, 0, 10, 8})) << "whole";
  EXPECT_EQ(rect({{"fit", 2}}), (R{0, 0, 12, 8})) << "covering";
  EXPECT_EQ(rect({{"fit", 3}, {"scaleY", 0.5f}}), (R{0, 1, 12, 7})) << "as wide: 12 pixels of which half";
  EXPECT_EQ(rect({{"fit", 4}, {"scaleX", 0.5f}}), (R{4, 0, 8, 8})) << "as high";
  EXPECT_EQ(rect({{"fit", 1}, {"scaleX", 0.5f}, {"scaleY", 0.5f}, {"offsetX", 0.5f}, {"offsetY", 0.25f}}),
            (R{6, 1, 10, 5}))
      << "half the height is 4 pixels: 2 to the right, 1 up";
  EXPECT_EQ(rect({{"fit", 1}}, 2), (R{4, 0, 8, 8})) << "pixels twice as wide as high";
}

TEST(ImageFilters, TurnsClockwise) {
  // a row of 4 x 1, red at its left, turned by 90 degrees: red is on top
  const Texels t(4, 1, [](int x, int) { return std::array<float, 4>{x == 0 ? 1.f : 0.f, 0, 0, 1}; });
  Frame f = empty();
  ASSERT_TRUE(
      f.run("PxrImageDisplayFilter", &t.image, {{"fit", 1}, {"rotate", 90}, {"scaleX", 0.5f}, {"scaleY", 2}}));
  EXPECT_NEAR(f.at(0, 0, 6, 1), 1, 0.3);
  EXPECT_NEAR(f.at(0, 0, 6, 6), 0, 0.01);
}

TEST(ImageFilters, LargeOnesAreAveraged) {
  // texels of 0 and 1 in turn, 5 by 3 of them a pixel
  const Texels t(Frame::kWidth * 5, Frame::kHeight * 3, [](int x, int y) {
    return std::array<float, 4>{float((x + y) % 2), 0.25f, float(x / 5), 1};
  });
  Frame f = empty();
  ASSERT_TRUE(f.run("PxrImageDisplayFilter", &t.image));
  for (int y = 0; y < Frame::kHeight; ++y)
    for (int x = 0; x < Frame::kWidth; ++x) {
      int ones = 0;
      for (int j = 0; j < 3; ++j)
        for (int i = 0; i < 5; ++i) ones += (5 * x + i + 3 * y + j) % 2;
      EXPECT_NEAR(f.at(0, 0, x, y), ones / 15.0, 1e-4);
      EXPECT_NEAR(f.at(0, 1, x, y), 0.25, 1e-5);
      EXPECT_NEAR(f.at(0, 2, x, y), x, 2e-4);
    }
}

TEST(ImageFilters, AlphaGainAndShadow) {
  const Texels t(1, 1, [](int, int) { return std::array<float, 4>{0.25f, 0.5f, 0, 0.5f}; });
  Frame f = empty(0.75f);
  ASSERT_TRUE(f.run("PxrImagePlaneFilter", &t.image, {{"colorGain", 2}, {"colorOffset", 0.125f}, {"useAlpha", 1}}));
  EXPECT_NEAR(f.at(0, 0, 3, 3), 0.25 * 0.625, 1e-6);
  EXPECT_NEAR(f.at(0, 1, 3, 3), 0.25 * 1.125, 1e-6);
  EXPECT_NEAR(f.at(1, 0, 3, 3), 0.75 + 0.25 * 0.5, 1e-6);
  f = empty(0.75f);
  f.channels.push_back({Frame::plane([](int x, int) { return x < 6 ? 0.f : 0.75f; })});
  ASSERT_TRUE(f.run("PxrImageDisplayFilter", &t.image, {}, {{"holdoutShadowAov", "shadow"}}));
  EXPECT_NEAR(f.at(0, 1, 3, 3), 0.125, 1e-6);
  EXPECT_NEAR(f.at(0, 1, 8, 3), 0.125 * 0.25, 1e-6);
  EXPECT_EQ(f.at(1, 0, 3, 3), 0.75f) << "alpha stays";
  // over: what the mark's alpha leaves, the mark's colour on top
  f = empty();
  f.channels = {{Frame::plane([](int, int) { return 0.8f; }), f.channels[0][1], f.channels[0][2]}};
  ASSERT_TRUE(f.run("PxrWatermarkFilter", &t.image, {{"transparency", 0.25f}, {"fit", 0}}));
  EXPECT_NEAR(f.at(0, 0, 3, 3), 0.8 * (1 - 0.5 * 0.75) + 0.25 * 0.75, 1e-6);
}

TEST(ImageFilters, WithoutAPictureNothingIsDone) {
  for (const char* name : {"PxrImageDisplayFilter", "PxrImagePlaneFilter"}) {
    Frame f = empty(0.5f), before = f;
    ASSERT_TRUE(f.run(name, nullptr));
    EXPECT_EQ(f.channels, before.channels);
    EXPECT_TRUE(f.warnings.empty()) << "the host has told of a missing file";
    ASSERT_TRUE(f.run(name, nullptr, {}, {{"filename", ""}}));
    EXPECT_EQ(f.warnings, std::vector<std::string>{"FILTER-PICTURE"});
  }
}

TEST(EdgeDetect, IsTheGradient) {
  Frame f = empty();
  f.channels = {{Frame::plane([](int x, int y) { return 0.3f * float(x) + 0.4f * float(y); }),
                 Frame::plane([](int x, int) { return x < 6 ? 0.f : 1.f; }),
                 Frame::plane([](int, int) { return 7.f; })}};
  const Frame all = f;
  ASSERT_TRUE(f.run("PxrEdgeDetect", nullptr));
  for (int y = 1; y < Frame::kHeight - 1; ++y)
    for (int x = 1; x < Frame::kWidth - 1; ++x) {
      EXPECT_NEAR(f.at(0, 0, x, y), 0.5, 1e-5);
      EXPECT_NEAR(f.at(0, 1, x, y), x == 5 || x == 6 ? 0.5 : 0, 1e-6);
      EXPECT_EQ(f.at(0, 2, x, y), 0);
    }
  // beyond the border there is what is at the border: half the slope across it
  EXPECT_NEAR(f.at(0, 0, 0, 3), std::hypot(0.15, 0.4), 1e-5);
  // a crop has a border of its own and nothing else
  Frame part = all;
  part.window = {2, 1, 9, 7};
  part.width = 4;
  ASSERT_TRUE(part.run("PxrEdgeDetect", nullptr));
  for (int y = 2; y < 6; ++y)
    for (int x = 3; x < 8; ++x) EXPECT_EQ(part.at(0, 1, x, y), f.at(0, 1, x, y));
  EXPECT_NEAR(part.at(0, 0, 2, 3), std::hypot(0.15, 0.4), 1e-5);
  EXPECT_EQ(part.at(0, 2, 0, 0), 7) << "outside";
}

}  // namespace
}  // namespace kinora
