// Proves: which texel a lit point gets, through the plane and all around, for PxrCookieLightFilter and
// PxrGoboLightFilter; placing, repeating and what is outside; interpolation; alpha, grading and inversion by formula;
// strength by distance; that a missing or unusable image leaves the light alone; blur against averages of the picture and
// what surrounds it.
#include "plugins/lightfilter/filter_testing.h"

namespace kinora {
namespace {
using namespace filterTesting;

// 4 x 2 texels, each its own colour; top row first.
struct Quilt {
  std::vector<float> texels;
  HostImage image;
  explicit Quilt(uint32_t channels = 3) {
    for (int y = 0; y < 2; ++y)
      for (int x = 0; x < 4; ++x)
        for (uint32_t c = 0; c < channels; ++c) texels.push_back(value(x, y, c));
    image = {texels.data(), 4, 2, channels};
  }
  static float value(int x, int y, uint32_t c) {
    return c == 0 ? 0.1f * float(x + 1) : c == 1 ? 0.4f + 0.3f * float(y) : c == 2 ? 0.9f : 0.5f;
  }
  static V at(int x, int y) { return {value(x, y, 0), value(x, y, 1), value(x, y, 2)}; }
};

TEST(PxrCookieLightFilter, LinesToTheLightMeetTheTexels) {
  const Quilt q;
  for (const char* name : {"PxrCookieLightFilter", "PxrGoboLightFilter"}) {
    const TestFilter f(name, {{"width", {8}}, {"height", {4}}, {"fillColor", {0, 0.5f, 1}}}, {}, {0, 0, 0}, 1,
                       &q.image);
    const Vec light{1, -2, -3};
    for (int y = 0; y < 2; ++y)
      for (int x = 0; x < 4; ++x) {
        // the texel's centre, upright: x to the right, top row at +y
        const Vec c{-3 + 2.0 * x, 1 - 2.0 * y, 0};
        const Vec P{c[0] + (c[0] - light[0]) * 0.7, c[1] + (c[1] - light[1]) * 0.7, 2.1};
        expectNear(f.at(P, light), Quilt::at(x, y), 2e-6, name);
      }
    const V fill{0, 0.5f, 1};
    EXPECT_EQ(f.from({4.1, 0, 1}, {0, 0, -1}, 9), fill);
    EXPECT_EQ(f.from({0, -2.1, 1}, {0, 0, -1}, 9), fill);
    EXPECT_EQ(f.from({0, 0, -1}, {0, 0, -1}, 9), fill) << "before the plane";
    EXPECT_EQ(f.from({0, 0, 1}, {0, 0, 1}, 9), fill) << "light from the same side";
    // halfway between four texels
    expectNear(f.from({0, 0, 1}, {0, 0, -1}, 9), {0.25f, 0.55f, 0.9f}, 2e-6, "bilinear");
  }
}

TEST(PxrCookieLightFilter, PlacesRepeatsAndMirrors) {
  const Quilt q;
  const auto at = [&](Numbers n, double x, double y) {
    n["width"] = {4};
    n["height"] = {2};
    return TestFilter("PxrCookieLightFilter", n, {}, {0, 0, 0}, 1, &q.image).from({x, y, 1}, {0, 0, -1}, 9);
  };
  expectNear(at({}, -1.5, 0.5), Quilt::at(0, 0), 2e-6);
  expectNear(at({{"offsetU", {0.25f}}}, -0.5, 0.5), Quilt::at(0, 0), 2e-6, "moved to the right");
  expectNear(at({{"offsetV", {0.5f}}}, -1.5, 0.5), Quilt::at(0, 1), 2e-6, "moved up");
  expectNear(at({{"scaleU", {2}}}, 1, 0.5), Quilt::at(2, 0), 2e-6, "wider");
  expectNear(at({{"invertU", {1}}}, -1.5, 0.5), Quilt::at(3, 0), 2e-6);
  expectNear(at({{"invertV", {1}}}, -1.5, 0.5), Quilt::at(0, 1), 2e-6);
  expectNear(at({{"tileMode", {1}}}, 9, 0.5), Quilt::at(3, 0), 2e-6, "its edge goes on");
  for (const double k : {-2.0, 1.0, 3.0}) {
    expectNear(at({{"tileMode", {2}}}, -0.5 + 4 * k, -0.5 + 2 * k), Quilt::at(1, 1), 5e-6, "repeated");
    // both seams: between the last and the first column, the last and the first row
    expectNear(at({{"tileMode", {2}}}, 2 + 4 * k, 1 + 2 * k), {0.25f, 0.55f, 0.9f}, 5e-6, "seams");
  }
}

// Averages over rectangles of the picture and of what surrounds it, by sums.
TEST(PxrCookieLightFilter, Blurs) {
  constexpr int kWide = 24, kHigh = 16;
  std::vector<float> texels;
  for (int y = 0; y < kHigh; ++y)
    for (int x = 0; x < kWide; ++x)
      for (int c = 0; c < 3; ++c) texels.push_back((x / 3 * 7 + y / 2 * 5 + c) % 4 * 0.25f);
  const HostImage image{texels.data(), kWide, kHigh, 3};
  const float fill = 0.4f;
  const auto texel = [&](int tile, int x, int y, int c) {
    if (tile == 0 && (x < 0 || x >= kWide || y < 0 || y >= kHigh)) return fill;
    if (tile == 1) x = std::clamp(x, 0, kWide - 1), y = std::clamp(y, 0, kHigh - 1);
    if (tile == 2) x = ((x % kWide) + kWide) % kWide, y = ((y % kHigh) + kHigh) % kHigh;
    return texels[size_t((y * kWide + x) * 3 + c)];
  };
  // of a rectangle of 2 a x 2 b texels about a texel's middle
  const auto average = [&](int tile, int x, int y, int c, double a, double b) {
    const auto share = [](int i, double half) {
      return std::max(0.0, std::min(i + 0.5, half) - std::max(i - 0.5, -half)) / (2 * half);
    };
    double sum = 0;
    for (int j = -40; j <= 40; ++j)
      for (int i = -40; i <= 40; ++i) sum += share(i, a) * share(j, b) * texel(tile, x + i, y + j, c);
    return sum;
  };
  for (int tile : {0, 1, 2}) {
    Numbers n{{"width", {kWide}},          {"height", {kHigh}}, {"fillColor", {fill, fill, fill}},
              {"tileMode", {float(tile)}}, {"blur", {0.2f}},    {"sBlurMult", {0.5f}}};
    const TestFilter f("PxrCookieLightFilter", n, {}, {0, 0, 0}, 1, &image);
    // wide enough to be held coarsely, which is straight between its texels
    n["blur"] = {0.8f};
    n["sBlurMult"] = {1};
    const TestFilter wide("PxrCookieLightFilter", n, {}, {0, 0, 0}, 1, &image);
    // a quarter and half of it, by distance
    n["blur"] = {0.1f};
    n["blurNearVal"] = {0};
    n["blurMidVal"] = {1};
    n["blurMidpoint"] = {0.5f};
    n["blurFarVal"] = {2};
    const TestFilter grows("PxrCookieLightFilter", n, {}, {0, 0, 0}, 1, &image);
    for (int y : {-5, -1, 0, 3, 8, 15, 17})
      for (int x : {-4, -1, 0, 5, 11, 23, 25}) {
        const auto at = [&](const TestFilter& g, double z) {
          return g.from({x + 0.5 - kWide / 2, kHigh / 2 - y - 0.5, z}, {0, 0, -1}, 99);
        };
        V narrow(3), broad(3), quarter(3), plain(3);
        for (int c = 0; c < 3; ++c) {
          narrow[size_t(c)] = float(average(tile, x, y, c, 0.05 * kWide, 0.1 * kHigh));
          broad[size_t(c)] = float(average(tile, x, y, c, 0.4 * kWide, 0.4 * kHigh));
          quarter[size_t(c)] = float(average(tile, x, y, c, 0.025 * kWide, 0.025 * kHigh));
          plain[size_t(c)] = texel(tile, x, y, c);
        }
        expectNear(at(f, 1), narrow, 1e-5, "narrow");
        expectNear(at(wide, 1), broad, 0.02f, "wide");
        expectNear(at(grows, 2.5), quarter, 1e-5, "grows");
        expectNear(at(grows, 0), plain, 1e-5, "not yet");
      }
  }
}

TEST(PxrCookieLightFilter, AllAround) {
  const Quilt q;
  const TestFilter f("PxrCookieLightFilter", {{"spherical", {1}}}, {}, {1, 1, 1}, 1, &q.image);
  for (int y = 0; y < 2; ++y)
    for (int x = 0; x < 4; ++x) {
      const double longitude = (x + 0.5 - 2) * M_PI / 2, latitude = (y == 0 ? 1 : -1) * M_PI / 4;
      expectNear(f.at({1 + 3 * std::sin(longitude) * std::cos(latitude), 1 + 3 * std::sin(latitude),
                       1 + 3 * std::cos(longitude) * std::cos(latitude)}),
                 Quilt::at(x, y), 5e-6);
    }
}

TEST(PxrCookieLightFilter, GradesOnce) {
  const Quilt q(4);
  const auto at = [&](Numbers n) {
    return TestFilter("PxrCookieLightFilter", n, {}, {0, 0, 0}, 1, &q.image)
        .from({-0.375, 0.25, 1}, {0, 0, -1}, 9);  // the first texel, alpha .5
  };
  const V c = Quilt::at(0, 0);
  const auto expected = [&](auto&& of) { return V{of(c[0], 0), of(c[1], 1), of(c[2], 2)}; };
  expectNear(at({{"fillColor", {0, 0, 0}}}), c, 2e-6, "premultiplied");
  expectNear(at({}), expected([](float x, int) { return x + 0.5f; }), 2e-6, "over white");
  expectNear(at({{"useAlpha", {0}}}), c, 2e-6);
  expectNear(at({{"premultipliedAlpha", {0}}, {"fillColor", {0, 0, 0}}}),
             expected([](float x, int) { return x / 2; }), 2e-6);
  const float tint[3] = {1, 0.5f, 0.25f};
  expectNear(at({{"useAlpha", {0}},
                 {"whitepoint", {2}},
                 {"contrast", {1.5f}},
                 {"midpoint", {0.2f}},
                 {"invert", {1}},
                 {"tint", {1, 0.5f, 0.25f}},
                 {"intensity", {3}}}),
             expected([&](float x, int i) { return 3 * tint[i] * (1 - 0.2f * std::pow(x / 2 / 0.2f, 1.5f)); }), 3e-6);
}

TEST(PxrCookieLightFilter, StrengthByDistance) {
  const float black[3] = {0, 0, 0};
  const HostImage image{black, 1, 1, 3};
  const TestFilter f("PxrCookieLightFilter",
                     {{"densityNearDist", {1}},
                      {"densityNearVal", {0}},
                      {"densityMidpoint", {0.25f}},
                      {"densityMidVal", {0.8f}},
                      {"densityFarDist", {5}},
                      {"densityFarVal", {0.4f}}},
                     {}, {0, 0, 0}, 1, &image);
  const double z[] = {0.5, 1.5, 2, 3.5, 9}, strength[] = {0, 0.4, 0.8, 0.6, 0.4};
  for (int i = 0; i < 5; ++i) expectGrey(f.from({0, 0, z[i]}, {0, 0, -1}, 20), 1 - strength[i], 1e-6);
}

TEST(PxrCookieLightFilter, WithoutAnImageTheLightIsUnfiltered) {
  for (const char* name : {"PxrCookieLightFilter", "PxrGoboLightFilter"}) {
    const TestFilter missing(name, {});
    expectGrey(missing.at({0, 0, 1}), 1);
    const TestFilter none(name, {}, {{"map", ""}});
    expectGrey(none.at({0, 0, 1}), 1);
    EXPECT_EQ(none.warnings.size(), 1u);
    const float texel[3] = {0, 0, 0};
    for (const HostImage& bad :
         {HostImage{texel, 0, 4, 3}, HostImage{texel, 1u << 20, 1u << 20, 3}, HostImage{texel, 1, 1, 0}}) {
      const TestFilter f(name, {}, {}, {0, 0, 0}, 1, &bad);
      expectGrey(f.at({0, 0, 1}), 1);
      EXPECT_EQ(f.warnings.size(), 1u) << name;
    }
    const float odd[3] = {NAN, INFINITY, -1};
    const HostImage poor{odd, 1, 1, 3};
    const TestFilter f(name, {}, {}, {0, 0, 0}, 1, &poor);
    expectGrey(f.at({0, 0, 1}, {0, 0, -1}), 0);
  }
}

}  // namespace
}  // namespace kinora
