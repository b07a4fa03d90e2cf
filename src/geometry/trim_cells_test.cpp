// Proves what is left of a grid against point-in-polygon tests of its own and against areas; that neighbours share
// their corners; that loops which cross, touch, overlap or run along the grid, and far too many of them, end well.
#include "geometry/trim_cells.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <map>
#include <random>

namespace kinora::geometry {
namespace {

using Imath::V2d;

std::vector<double> lines(int cells) {
  std::vector<double> out;
  for (int i = 0; i <= cells; ++i) out.push_back(double(i) / cells);
  return out;
}
std::vector<V2d> polygon(int corners, double radius, V2d centre = V2d(0.5), double phase = 0.1, int step = 1) {
  std::vector<V2d> out;
  for (int i = 0; i < corners; ++i) {
    const double a = 2 * M_PI * i * step / corners + phase;
    out.push_back(centre + V2d(std::cos(a), std::sin(a)) * radius);
  }
  return out;
}
std::vector<V2d> rectangle(double u0, double v0, double u1, double v1) {
  return {{u0, v0}, {u1, v0}, {u1, v1}, {u0, v1}};
}

struct Grid {
  std::vector<double> u, v;
  TrimmedCells cells;

  Grid(const TrimLoops& loops, bool keepInside, std::vector<double> u, std::vector<double> v)
      : u(std::move(u)), v(std::move(v)), cells(trimCells(loops, keepInside, this->u, this->v)) {}

  // All triangles, those of whole cells too.
  std::vector<std::array<V2d, 3>> triangles() const {
    std::vector<std::array<V2d, 3>> out;
    const size_t columns = u.size() - 1;
    for (size_t c = 0; c < cells.kind.size(); ++c) {
      const size_t x = c % columns, y = c / columns;
      const V2d p(u[x], v[y]), q(u[x + 1], v[y]), r(u[x + 1], v[y + 1]), s(u[x], v[y + 1]);
      if (cells.kind[c] == TrimmedCells::Whole) out.insert(out.end(), {{p, q, r}, {p, r, s}});
      for (size_t t = cells.first[c]; t < cells.first[c + 1]; ++t)
        out.push_back({cells.triangles[3 * t], cells.triangles[3 * t + 1], cells.triangles[3 * t + 2]});
    }
    return out;
  }
};

double areaOf(const std::array<V2d, 3>& t) { return (t[1] - t[0]).cross(t[2] - t[0]) / 2; }
double areaOf(const Grid& grid) {
  double sum = 0;
  for (const auto& t : grid.triangles()) {
    EXPECT_GT(areaOf(t), 0);
    sum += areaOf(t);
  }
  return sum;
}

double distance(const V2d& p, const V2d& a, const V2d& b) {
  const V2d d = b - a;
  const double t = d.length2() > 0 ? std::clamp((p - a).dot(d) / d.length2(), 0.0, 1.0) : 0;
  return (p - a - d * t).length();
}
struct Nearness {
  bool inside = false;
  double distance = 1e9;
};
// By the angle of each edge as seen from the point: another way than the one on trial.
Nearness look(const TrimLoops& loops, const V2d& p) {
  Nearness out;
  for (const auto& loop : loops) {
    double turned = 0;
    for (size_t i = 0; i < loop.size(); ++i) {
      const V2d a = loop[i] - p, b = loop[(i + 1) % loop.size()] - p;
      turned += std::atan2(a.cross(b), a.dot(b));
      out.distance = std::min(out.distance, distance(p, loop[i], loop[(i + 1) % loop.size()]));
    }
    out.inside ^= std::lround(turned / (2 * M_PI)) % 2 != 0;
  }
  return out;
}

// Each point that is not next to a loop is covered once or not at all, as it should be; edges that only one triangle
// has lie on loops or on the border.
void expectTrimmed(const TrimLoops& loops, const Grid& grid, bool keepInside, unsigned seed) {
  const auto triangles = grid.triangles();
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  const double blur = 1.0 / 1000 / double(std::min(grid.u.size(), grid.v.size()) - 1);
  for (int i = 0; i < 400; ++i) {
    const V2d p(unit(random), unit(random));
    const Nearness near = look(loops, p);
    if (near.distance < blur) continue;
    int covered = 0;
    for (const auto& t : triangles)
      covered +=
          (t[1] - t[0]).cross(p - t[0]) > 0 && (t[2] - t[1]).cross(p - t[1]) > 0 && (t[0] - t[2]).cross(p - t[2]) > 0;
    ASSERT_EQ(covered, near.inside == keepInside ? 1 : 0) << p.x << " " << p.y;
  }
  using Key = std::array<double, 4>;
  std::map<Key, int> edges;
  for (const auto& t : triangles)
    for (int k = 0; k < 3; ++k) ++edges[Key{t[k].x, t[k].y, t[(k + 1) % 3].x, t[(k + 1) % 3].y}];
  for (const auto& [e, n] : edges) {
    ASSERT_EQ(n, 1);
    if (edges.contains(Key{e[2], e[3], e[0], e[1]})) continue;
    const V2d middle((e[0] + e[2]) / 2, (e[1] + e[3]) / 2);
    const double border = std::min({middle.x, middle.y, 1 - middle.x, 1 - middle.y});
    ASSERT_LT(std::min(border, look(loops, middle).distance), blur) << middle.x << " " << middle.y;
  }
}

TEST(TrimCells, PolygonsAndTheirComplement) {
  for (const int corners : {3, 7, 200}) {
    const TrimLoops loops{polygon(corners, 0.37)};
    const double expected = corners * 0.37 * 0.37 * std::sin(2 * M_PI / corners) / 2;
    for (const int cells : {1, 5, 40}) {
      const Grid inside(loops, true, lines(cells), lines(cells)), outside(loops, false, lines(cells), lines(cells));
      // places are off by half a step at most, along the whole outline
      const double rounding = 2 * M_PI * 0.37 / 8192 / cells;
      EXPECT_NEAR(areaOf(inside), expected, rounding);
      EXPECT_NEAR(areaOf(outside), 1 - expected, rounding);
      EXPECT_FALSE(inside.cells.crosses);
      expectTrimmed(loops, inside, true, 1);
      expectTrimmed(loops, outside, false, 2);
    }
  }
}

TEST(TrimCells, NestedTouchingOverlappingAndCrossing) {
  const struct {
    TrimLoops loops;
    bool crosses;
  } cases[] = {
      {{polygon(60, 0.4), polygon(50, 0.2), polygon(40, 0.1)}, false},              // a ring and an island
      {{rectangle(0, 0, 1, 1), polygon(30, 0.2)}, false},                           // a hole, as exporters say it
      {{rectangle(0.25, 0.25, 0.75, 0.75)}, false},                                 // along lines of the grid
      {{rectangle(0.25, 0.25, 0.75, 0.75), rectangle(0.5, 0.25, 1, 0.75)}, false},  // overlapping sides
      {{rectangle(0.1, 0.1, 0.5, 0.5), rectangle(0.5, 0.5, 0.9, 0.9)}, false},      // touching corners
      {{rectangle(0.1, 0.1, 0.5, 0.9), rectangle(0.5, 0.1, 0.9, 0.9)}, false},      // sharing a side
      {{polygon(5, 0.45, V2d(0.5), 0.3, 2)}, true},                                 // a star
      {{{{0.1, 0.1}, {0.9, 0.9}, {0.9, 0.1}, {0.1, 0.9}}}, true},                   // an hourglass
      {{polygon(40, 0.7)}, false},                                                  // partly beyond the square
      {{polygon(40, 0.3), polygon(40, 0.3)}, false},                                // twice the same: nothing
  };
  unsigned seed = 10;
  for (const auto& c : cases)
    for (const int cells : {4, 13}) {
      const Grid grid(c.loops, true, lines(cells), lines(cells + 3));
      EXPECT_EQ(grid.cells.crosses, c.crosses) << seed;
      areaOf(grid);
      expectTrimmed(c.loops, grid, true, ++seed);
    }
}

TEST(TrimCells, RandomTangles) {
  for (unsigned seed = 0; seed < 30; ++seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> place(-0.1, 1.1);
    std::uniform_int_distribution<int> eighths(0, 8);
    TrimLoops loops(1 + seed % 3);
    for (auto& loop : loops)
      for (unsigned i = 0; i < 4 + seed % 7; ++i)
        loop.push_back(seed % 2 ? V2d(place(random), place(random)) : V2d(eighths(random), eighths(random)) / 8.0);
    const int cells = 1 + int(seed % 16);
    expectTrimmed(loops, Grid(loops, true, lines(cells), lines(8)), true, seed);
  }
}

TEST(TrimCells, TooMuchEndsInTime) {
  const auto start = std::chrono::steady_clock::now();
  std::mt19937 random(5);
  std::uniform_real_distribution<double> place(0, 1);
  TrimLoops wild(1);
  for (int i = 0; i < 200'000; ++i) wild[0].push_back({place(random), place(random)});
  EXPECT_TRUE(trimCells(wild, true, lines(256), lines(256)).tooMuch);
  TrimLoops dense(1);  // all in one cell
  for (int i = 0; i < 100'000; ++i) dense[0].push_back(V2d(0.5) + V2d(place(random), place(random)) * 1e-3);
  EXPECT_TRUE(trimCells(dense, true, lines(16), lines(16)).tooMuch);
  EXPECT_LT(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(), 20);
}

}  // namespace
}  // namespace kinora::geometry
