// Proves: the values of grade, filmic curve, white point, copy, shadow and background in closed form, for the sample
// filters and the display filters alike; bad numbers are refused. That they act at their places in a render is tested
// in tests/filters.
#include <gtest/gtest.h>
#include <kinora/channel_filter.h>
#include <kinora/light_setup.h>

#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <string>
#include <vector>

#include "plugin/registry.h"

namespace kinora {
namespace {
using V = std::vector<float>;

// Channels of a filter after it; given are those that it asks for, in order. Empty: refused.
// The pixel is (3, line) of a picture of 8 x 4.
std::vector<V> run(const char* name, const std::map<std::string, V>& numbers, std::vector<V> channels,
                   const std::map<std::string, std::string>& texts = {}, int32_t line = 0) {
  const Descriptor* d = nullptr;
  for (const Descriptor* k : stockPlugins())
    if (!std::strcmp(k->name, name)) d = k;
  if (!d) throw std::string("no filter ") + name;
  std::vector<ParamValue> values(d->paramCount);
  std::vector<const char*> text(d->paramCount);
  for (uint32_t i = 0; i < d->paramCount; ++i) {
    const auto n = numbers.find(d->params[i].name);
    const auto t = texts.find(d->params[i].name);
    text[i] = t == texts.end() ? d->params[i].text : t->second.c_str();
    values[i].strings = &text[i];
    values[i].floats = n == numbers.end() ? d->params[i].value : n->second.data();
    values[i].count = d->params[i].type == Type::Color ? 3 : 1;
  }
  Host host{nullptr, [](void*, const char*, const char*, const char*) {}, nullptr};
  const ChannelFilterInfo picture{{8, 4}, 1};
  const CreateInfo info{&host, "f", values.data(), d->paramCount, nullptr, &picture};
  ErrorText error{};
  void* f = d->create(&info, &error);
  if (!f) return {};
  const auto* traits = static_cast<const ChannelFilterTraits*>(d->traits);
  std::vector<std::array<std::array<float, 16>, 3>> data(channels.size());
  std::vector<FilterChannel> list(channels.size());
  for (size_t c = 0; c < channels.size(); ++c) {
    EXPECT_NE(traits->channel(f, uint32_t(c)), nullptr);
    list[c].name = traits->channel(f, uint32_t(c));
    list[c].components = uint32_t(channels[c].size());
    for (size_t q = 0; q < 3; ++q) {
      data[c][q].fill(q < channels[c].size() ? channels[c][q] : 0);
      list[c].data[q] = data[c][q].data();
    }
  }
  EXPECT_EQ(traits->channel(f, uint32_t(channels.size())), nullptr);
  std::array<int32_t, 16> x, y;
  x.fill(3);
  y.fill(line);
  const ChannelFilterArgs a{3, x.data(), y.data(), list.data(), uint32_t(list.size())};
  if (d->kind == Kind::SampleFilter)
    static_cast<const SampleFilterFunctions*>(functionsFor(*d, 8))->filter(f, &a);
  else
    static_cast<const DisplayFilterFunctions*>(functionsFor(*d, 8))->filter(f, &a);
  d->destroy(f);
  for (size_t c = 0; c < channels.size(); ++c)
    for (size_t q = 0; q < channels[c].size(); ++q) channels[c][q] = data[c][q][1];
  return channels;
}
void expectNear(const V& a, const V& b, const char* name, double tolerance = 2e-6) {
  ASSERT_EQ(a.size(), b.size());
  for (size_t c = 0; c < a.size(); ++c) EXPECT_NEAR(a[c], b[c], tolerance) << name << " " << c;
}

TEST(ChannelFilters, Filmic) {
  const auto hable = [](double x) {
    const double A = 0.22, B = 0.3, C = 0.1, D = 0.2, E = 0.01, F = 0.3;
    return (x * (A * x + C * B) + D * E) / (x * (A * x + B) + D * F) - E / F;
  };
  for (const char* name : {"PxrFilmicTonemapperSampleFilter", "PxrFilmicTonemapperDisplayFilter"}) {
    for (double x : {0.0, 0.18, 1.0, 4.0, 11.2})
      for (double exposure : {1.0, 2.0})
        expectNear(run(name, {{"exposureAdjust", {float(exposure)}}}, {{float(x), float(x / 2), 0}})[0],
                   {float(hable(x * exposure) / hable(11.2)), float(hable(x * exposure / 2) / hable(11.2)), 0}, name);
    expectNear(run(name, {}, {{11.2f, -3, 1e30f}})[0], {1, 0, float((1 - 0.01 / 0.3) / hable(11.2))}, name, 1e-4);
    EXPECT_TRUE(run(name, {{"F", {0}}}, {{1, 1, 1}}).empty());
    EXPECT_TRUE(run(name, {{"linearWhitePoint", {-1}}}, {{1, 1, 1}}).empty());
  }
}

TEST(ChannelFilters, WhitePoint) {
  for (const char* name : {"PxrWhitePointSampleFilter", "PxrWhitePointDisplayFilter"}) {
    expectNear(run(name, {}, {{0.2f, 3, 0.5f}})[0], {0.2f, 3, 0.5f}, name);
    // what a lamp of that temperature lights becomes as neutral as one of 6500 does
    const auto lamp = blackbody(3200), day = blackbody(6500);
    const V out = run(name, {{"temperature", {3200}}}, {{float(lamp[0]), float(lamp[1]), float(lamp[2])}})[0];
    expectNear({out[0] / out[1], out[2] / out[1]}, {float(day[0] / day[1]), float(day[2] / day[1])}, name, 1e-5);
    const V manual =
        run(name, {{"useManualWhitePoint", {1}}, {"manualWhitePoint", {1, 0.5f, 0.25f}}}, {{2, 1, 0.5f}})[0];
    const float grey = 2 * float(0.2126 + 0.7152 * 0.5 + 0.0722 * 0.25);
    expectNear(manual, {grey, grey, grey}, name);
    EXPECT_TRUE(run(name, {{"useManualWhitePoint", {1}}, {"manualWhitePoint", {1, 0, 1}}}, {{1, 1, 1}}).empty());
  }
}

TEST(ChannelFilters, Grade) {
  for (const char* name : {"PxrGradeSampleFilter", "PxrGradeDisplayFilter"}) {
    const std::map<std::string, V> n = {{"blackPoint", {0.1f, 0.1f, 0.1f}},
                                        {"whitePoint", {0.6f, 0.6f, 0.6f}},
                                        {"gain", {2, 2, 2}},
                                        {"lift", {0.05f, 0, 0}},
                                        {"gamma", {2, 2, 2}},
                                        {"mask", {1, 1, 0.5f}}};
    const auto graded = [](double x, double lift) { return std::sqrt((x - 0.1) / 0.5 * 2 + lift); };
    expectNear(run(name, n, {{0.3f, 0.2f, 0.5f}})[0],
               {float(graded(0.3, 0.05)), float(graded(0.2, 0)), float((graded(0.5, 0) + 0.5) / 2)}, name);
  }
}

TEST(ChannelFilters, CopyShadowAndBackground) {
  for (const char* name : {"PxrCopyAOVSampleFilter", "PxrCopyAOVDisplayFilter"}) {
    const std::map<std::string, std::string> t = {{"readAov", "other"}};
    expectNear(run(name, {}, {{1, 2, 3}, {4, 5, 6}}, t)[1], {1, 2, 3}, name);
    expectNear(run(name, {}, {{7}, {4, 5, 6}}, t)[1], {7, 7, 7}, name);
    expectNear(run(name, {}, {{}, {4, 5, 6}}, t)[1], {4, 5, 6}, name);
  }
  for (const char* name : {"PxrShadowFilter", "PxrShadowDisplayFilter"}) {
    const auto out = run(name, {}, {{1, 0, 3}, {4, 2, 3}, {9, 9, 9}});
    expectNear(out[2], {0.75f, 1, 0}, name);
    expectNear(run(name, {}, {{0, 0, 0}, {0, 0, 0}, {9, 9, 9}})[2], {0, 0, 0}, name);
  }
  expectNear(run("PxrShadowDisplayFilter", {{"shadowThreshold", {1}}}, {{0, 0, 1}, {0.9f, 1, 2}, {9, 9, 9}})[2],
             {0, 1, 0.5f}, "threshold");
  for (const char* name : {"PxrBackgroundSampleFilter", "PxrBackgroundDisplayFilter"})
    expectNear(run(name, {{"backgroundColor", {1, 2, 4}}}, {{0.5f, 0.5f, 0.5f}, {0.75f}})[0], {0.75f, 1, 1.5f}, name);
}

TEST(ChannelFilters, BackgroundsMayCover) {
  const V half = {0.5f, 0.5f, 0.5f};
  for (const auto& [opacity, alpha] : {std::pair{0.f, 0.75f}, {1.f, 1.f}, {0.5f, 0.875f}})
    expectNear(run("PxrBackgroundDisplayFilter", {{"backgroundAlpha", {opacity}}}, {half, {0.75f}})[1], {alpha},
               "background");
}

TEST(ChannelFilters, Clamp) {
  const char* name = "ClampDisplayFilter";
  expectNear(run(name, {}, {{2, -1, 0.5f}, {1.5f}})[0], {1, 0, 0.5f}, name);
  expectNear(run(name, {}, {{2, -1, 0.5f}, {1.5f}})[1], {1}, name);
  expectNear(run(name, {{"mode", {1}}}, {{2, -1, 0.2f}, {0.25f}})[0], {0.25f, 0, 0.2f}, name);
  expectNear(run(name, {{"mode", {1}}}, {{2, -1, 0.5f}, {}})[0], {1, 0, 0.5f}, name);
}

TEST(ChannelFilters, LightSaturation) {
  const char* name = "PxrLightSaturation";
  const V color = {0.8f, 0.4f, 0.2f}, lit = {1, 1, 1}, dark = {0.2f, 0.2f, 0.2f};
  const double grey = 0.2126 * 0.8 + 0.7152 * 0.4 + 0.0722 * 0.2;
  const auto shifted = [&](double by) {
    V v;
    for (const float x : color) v.push_back(float(grey + (x - grey) * std::exp2(by)));
    return v;
  };
  for (float shift : {1.f, -2.f}) {
    expectNear(run(name, {{"threshold", {0.5f}}, {"shift", {shift}}}, {color, lit})[0], shifted(shift), name);
    expectNear(run(name, {{"threshold", {0.5f}}, {"shift", {shift}}}, {color, dark})[0], color, name);
    expectNear(run(name, {{"threshold", {0.5f}}, {"shift", {shift}}, {"invert", {1}}}, {color, dark})[0],
               shifted(shift), name);
    expectNear(run(name, {{"threshold", {0.5f}}, {"shift", {shift}}, {"invert", {1}}}, {color, lit})[0], color, name);
  }
}

TEST(ChannelFilters, HalfBufferError) {
  const char* name = "PxrHalfBufferErrorFilter";
  const auto out = run(name, {}, {{1, 2, 3}, {1.5f, 2, 1}, {9}});
  expectNear(out[2], {float((0.25 + 0 + 4) / 3 / 4)}, name);
  expectNear(run(name, {}, {{4}, {2}, {9, 9, 9}})[2], {1, 1, 1}, "of single floats");
}

TEST(ChannelFilters, Gradient) {
  const char* name = "GradientDisplayFilter";
  const std::map<std::string, V> colors = {{"topColor", {1, 0, 0}}, {"bottomColor", {0, 1, 0.5f}}};
  const auto with = [&](std::map<std::string, V> more) {
    more.insert(colors.begin(), colors.end());
    return more;
  };
  for (int32_t line = 0; line < 4; ++line) {
    const double down = (line + 0.5) / 4;
    const auto at = [&](double share) { return V{float(1 - share), float(share), float(share / 2)}; };
    expectNear(run(name, colors, {{0, 0, 0}, {0}}, {}, line)[0], at(down), name);
    expectNear(run(name, colors, {{0, 0, 0}, {0.5f}}, {}, line)[0],
               {float(1 - down) / 2, float(down) / 2, float(down) / 4}, name);
    // the middle of the change is pushed down: bias(down, 0.25) is its square
    expectNear(run(name, with({{"midPoint", {0.75f}}}), {{0, 0, 0}, {0}}, {}, line)[0], at(down * down), name);
    expectNear(run(name, with({{"frequency", {2}}}), {{0, 0, 0}, {0}}, {}, line)[0],
               at(2 * down - std::floor(2 * down)), name);
    expectNear(run(name, with({{"sharpness", {1}}}), {{0, 0, 0}, {0}}, {}, line)[0], at(down > 0.5), name);
    // turned by 90 degrees it runs from left to right, in pixels as high as before: column 3 of 4
    expectNear(run(name, with({{"angle", {90}}}), {{0, 0, 0}, {0}}, {}, line)[0], at(3.5 / 4), name);
    expectNear(run(name, with({{"backgroundAlpha", {0}}}), {{0, 0, 0}, {0.25f}}, {}, line)[1], {0.25f}, name);
  }
}

}  // namespace
}  // namespace kinora
