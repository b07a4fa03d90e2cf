// Proves: the factor in a direction equals bilinear interpolation of the tables, computed here in double precision,
// for the three types of webs, symmetric or not; axes whatever the placement's scales; widening; normalisation against
// closed-form integrals; nothing beyond the tables; bad tables are refused. Files are tested in src/light.
#include "plugins/lightfilter/filter_testing.h"

namespace kinora {
namespace {
using namespace filterTesting;
constexpr const char* kName = "IesLightFilter";
constexpr double kDegree = M_PI / 180;

const V kVertical = {0, 10, 45, 90, 120}, kAround = {0, 60, 200, 360};
V candela(size_t columns, size_t rows) {
  V c;
  for (size_t i = 0; i < columns * rows; ++i) c.push_back(float(1 + (i * 7) % 11) / 11);
  return c;
}
double between(const V& list, const V& table, size_t column, double x) {
  size_t i = 0;
  while (i + 2 < list.size() && x >= list[i + 1]) ++i;
  const double t = (x - list[i]) / (list[i + 1] - list[i]);
  return table[column * list.size() + i] * (1 - t) + table[column * list.size() + i + 1] * t;
}
double bilinear(const V& vertical, const V& horizontal, const V& table, double v, double h) {
  size_t i = 0;
  while (i + 2 < horizontal.size() && h >= horizontal[i + 1]) ++i;
  const double t = (h - horizontal[i]) / (horizontal[i + 1] - horizontal[i]);
  return between(vertical, table, i, v) * (1 - t) + between(vertical, table, i + 1, v) * t;
}
// What a point gets that lies in this direction of the light.
V towards(const TestFilter& f, Vec d) { return f.from({5 * d[0], 5 * d[1], 5 * d[2]}, {-d[0], -d[1], -d[2]}, 5); }
Vec polar(double v, double h) {
  return {std::sin(v * kDegree) * std::cos(h * kDegree), std::sin(v * kDegree) * std::sin(h * kDegree),
          std::cos(v * kDegree)};
}

TEST(IesLightFilter, TypeCIsInterpolatedByBothAngles) {
  const V table = candela(4, 5);
  const TestFilter f(kName, {{"verticalAngles", kVertical}, {"horizontalAngles", kAround}, {"candela", table}});
  ASSERT_TRUE(f.made()) << f.error;
  for (double v : {0.5, 10.0, 30.0, 77.0, 119.5})
    for (double h : {0.5, 59.0, 61.0, 150.0, 200.0, 333.0, 359.5})
      expectGrey(towards(f, polar(v, h)), bilinear(kVertical, kAround, table, v, h), 3e-5,
                 std::to_string(v) + " " + std::to_string(h));
  for (double h : {0.0, 77.0, 300.0}) {
    expectGrey(towards(f, polar(121, h)), 0);
    expectGrey(towards(f, polar(180, h)), 0);
  }
}

TEST(IesLightFilter, TypesAAndBTurnAboutAxesAcross) {
  const V vertical = {-60, 0, 30, 90}, horizontal = {-90, -20, 50};
  const V table = candela(3, 4);
  for (int type : {1, 2}) {
    const TestFilter f(kName, {{"webType", {float(type)}},
                               {"verticalAngles", vertical},
                               {"horizontalAngles", horizontal},
                               {"candela", table}});
    for (double v : {-59.0, -10.0, 12.0, 80.0})
      for (double h : {-80.0, -15.0, 49.0}) {
        const double cv = std::cos(v * kDegree), sv = std::sin(v * kDegree), ch = std::cos(h * kDegree),
                     sh = std::sin(h * kDegree);
        const Vec d = type == 1 ? Vec{sh, ch * sv, ch * cv} : Vec{cv * sh, sv, cv * ch};
        expectGrey(towards(f, d), bilinear(vertical, horizontal, table, v, h), 5e-5,
                   std::to_string(type) + ": " + std::to_string(v) + " " + std::to_string(h));
      }
    expectGrey(towards(f, {0.9, 0.1, std::sqrt(0.18)}), 0, 1e-6, "beyond 50 degrees");
  }
}

TEST(IesLightFilter, ScalesOfThePlacementDoNotBendAngles) {
  const Numbers n = {{"verticalAngles", {0, 90}}, {"candela", {1, 0}}};
  const TestFilter one(kName, n), large(kName, n, {}, {3, 2, 1}, 40);
  expectGrey(towards(one, polar(36, 20)), 0.6, 1e-5);
  expectGrey(towards(large, polar(36, 20)), 0.6, 1e-5);
}

TEST(IesLightFilter, WidensNormalisesAndBlends) {
  const Numbers n = {{"verticalAngles", {0, 90}}, {"candela", {8, 0}}};
  const auto with = [&](const char* name, float x) {
    Numbers m = n;
    m[name] = {x};
    return m;
  };
  expectGrey(towards(TestFilter(kName, with("scale", 0.5f)), polar(90, 0)), 1 - 60.0 / 90, 1e-5);
  expectGrey(towards(TestFilter(kName, with("scale", -0.5f)), polar(20, 0)), 1 - 40.0 / 90, 1e-5);
  expectGrey(towards(TestFilter(kName, with("scale", -0.5f)), polar(120, 0)), 0);
  expectGrey(towards(TestFilter(kName, with("density", 0.25f)), polar(45, 0)), 0.75 + 0.125, 1e-5);
  // the mean of 1 - theta / (pi / 2) over the sphere: (1 / 2) integral of it times sine = (1 - 2 / pi) / 2
  expectGrey(towards(TestFilter(kName, with("normalize", 1)), polar(45, 0)), 0.5 / ((1 - 2 / M_PI) / 2), 1e-4);
  // wider: theta up to 135 degrees, integral of (1 - theta / a) sine = 1 - sin(a) / a
  Numbers wide = with("normalize", 1);
  wide["scale"] = {0.5f};
  const double a = 135 * kDegree;
  expectGrey(towards(TestFilter(kName, wide), polar(67.5, 0)), 0.5 / ((1 - std::sin(a) / a) / 2), 1e-4);
  // by both angles: half of all directions
  const TestFilter half(kName, {{"verticalAngles", {0, 180}},
                                {"horizontalAngles", {0, 90, 180, 270, 360}},
                                {"candela", {1, 1, 0, 0, 1, 1, 0, 0, 1, 1}},
                                {"normalize", {1}}});
  expectGrey(towards(half, polar(50, 180)), 2, 1e-3);
}

TEST(IesLightFilter, BadTablesAreRefused) {
  for (const Numbers& n : {Numbers{{"candela", {1, 2, 3}}}, Numbers{{"verticalAngles", {90, 0}}},
                           Numbers{{"verticalAngles", {0}}, {"candela", {1}}}, Numbers{{"candela", {0, -1}}},
                           Numbers{{"candela", {NAN, 1}}}, Numbers{{"horizontalAngles", {}}, {"candela", {}}}}) {
    const TestFilter f(kName, n);
    EXPECT_FALSE(f.made());
    EXPECT_FALSE(f.error.empty());
  }
}

}  // namespace
}  // namespace kinora
